//! Corners: the point next to all curves that end there, and where on them their edges end.

use super::curves::Track;
use super::draft::Draft;
use super::model::Obstacle;
use super::regions::{Map, Rung};
use super::topology::Graph;
use super::tuning::{BRANCH_DISTANCE, FREE_EIGENVALUE, NEWTON_STEPS};
use crate::brep::Curve;
use crate::mesh::NONE;
use crate::numeric::eigen3::{Eigen3, outer};
use glam::{DMat3, DVec3};

/// An end of a chain: the chain, and 0 for its beginning, 1 for its end.
type End = (usize, usize);

/// Makes a vertex of every corner, in their order, and moves the ends of the tracks to it.
pub fn place(map: &Map<'_>, graph: &Graph, tracks: &mut [Track], draft: &mut Draft) -> Vec<Obstacle> {
    let mut ends: Vec<Vec<End>> = vec![Vec::new(); graph.corners.len()];
    for (k, chain) in graph.chains.iter().enumerate().filter(|(_, c)| !c.closed) {
        for (side, v) in [chain.vertices[0], chain.vertices[chain.vertices.len() - 1]].into_iter().enumerate() {
            if let Ok(corner) = graph.corners.binary_search(&v) {
                ends[corner].push((k, side));
            }
        }
    }
    let mut obstacles = Vec::new();
    for (&vertex, ends) in graph.corners.iter().zip(&ends) {
        let start = map.t.points()[vertex as usize];
        let mut around: Vec<u32> =
            ends.iter().flat_map(|&(k, _)| graph.chains[k].sides).filter(|&s| s != NONE).collect();
        around.sort_unstable();
        around.dedup();
        let facets = around.iter().all(|&p| map.pieces[p as usize].rung >= Rung::Planes);
        let point = if facets { start } else { meeting(start, ends, tracks) };
        let mut off = 0.0f64;
        for &(k, side) in ends {
            let track = &mut tracks[k];
            let t = track.curve.project_near(point, track.range[side]);
            off = off.max(track.curve.point(t).distance(point));
            let closed = graph.chains[k].vertices[0] == graph.chains[k].vertices[graph.chains[k].vertices.len() - 1];
            match (closed, track.curve.period()) {
                (true, Some(_)) if matches!(track.curve, Curve::Spline(_)) => track.range = track.curve.domain(),
                (true, Some(period)) if side == 0 => track.range = [t, t + period],
                (true, Some(_)) => {}
                _ => track.range[side] = t,
            }
        }
        // Along a contact a corner of noisy data is anywhere; the validator sees whether faces follow the mesh.
        let branch = if map.is_noisy() { BRANCH_DISTANCE * map.diagonal } else { 0.0 };
        let room = (map.tolerance.max(map.gap()) * 10.0).max(branch);
        if !(off <= map.gap()) {
            let share = off / map.diagonal;
            obstacles.push(Obstacle {
                pieces: around,
                reason: format!("its edges miss a corner by {share:.0e} of the size"),
            });
        } else if !(point.distance(start) <= room) {
            obstacles.push(Obstacle { pieces: around, reason: "a corner is far from the mesh".into() });
        }
        draft.vertex(point, off);
    }
    for (track, chain) in tracks.iter().zip(&graph.chains) {
        if !(track.range[1] > track.range[0]) {
            let pieces = chain.sides.into_iter().filter(|&s| s != NONE).collect();
            obstacles.push(Obstacle { pieces, reason: "an edge runs backwards".into() });
        }
    }
    obstacles
}

/// The point with the least sum of squared distances from the curves, from a vertex of the mesh; free along a common tangent.
fn meeting(start: DVec3, ends: &[End], tracks: &[Track]) -> DVec3 {
    let mut p = start;
    let mut at: Vec<f64> = ends.iter().map(|&(k, side)| tracks[k].range[side]).collect();
    for _ in 0..NEWTON_STEPS {
        let (mut matrix, mut rhs) = (DMat3::ZERO, DVec3::ZERO);
        for (t, &(k, _)) in at.iter_mut().zip(ends) {
            let curve = &tracks[k].curve;
            *t = curve.project_near(p, *t);
            let [c, d, _] = curve.derivatives(*t);
            let across = DMat3::IDENTITY - outer(d.normalize_or_zero());
            matrix += across;
            rhs += across * (c - p);
        }
        let step = Eigen3::new(matrix).solve(rhs, FREE_EIGENVALUE);
        p += step;
        if !(step.length() > 1e-15 * p.length()) {
            break;
        }
    }
    if p.is_finite() { p } else { start }
}
