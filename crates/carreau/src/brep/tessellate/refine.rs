//! Points inside a face: a grid where the surface bends both ways, then the middles of edges that are too far from it.

use super::Fineness;
use super::chart::mean_lengths;
use super::face::Plane;
use crate::brep::Surface;
use crate::brep::boundary::Ring;
use crate::error::Result;
use glam::{DVec2, DVec3};
use spade::{Point2, Triangulation};

/// Most rounds of refinement. Every round halves the chords that are too long, so that a dozen is enough for any face of
/// ordinary proportions; the rest is for long thin triangles, which are halved in one direction at a time.
const ROUNDS: usize = 24;
/// Most points inside a face.
const MAX_POINTS: usize = 20_000;
/// Most grid lines in each direction.
const MAX_LINES: f64 = 128.0;
/// Number of places in each direction at which the curvature is measured.
const PROBES: u32 = 6;
/// Clearance of grid points from the border, as a share of the grid's step.
const CLEARANCE: f64 = 0.4;

/// The longest chord over a curvature.
pub(super) fn arc_step(curvature: f64, fineness: &Fineness) -> f64 {
    let k = curvature.abs();
    if k > 0.0 { (8.0 * fineness.chord / k).sqrt().min(fineness.angle / k) } else { f64::INFINITY }
}

/// Adds points inside the loops until the triangles follow the surface.
pub(super) fn fill(plane: &mut Plane, rings: &[Ring], fineness: &Fineness) -> Result<()> {
    if matches!(plane.surface, Surface::Plane { .. }) {
        return Ok(());
    }
    for uv in grid(plane.surface, mean_lengths(plane.surface, rings), rings, fineness) {
        plane.insert(uv, |p| p.add(p.surface.point(uv.x, uv.y)))?;
    }
    for _ in 0..ROUNDS {
        let missing = missing(plane, fineness);
        if missing.is_empty() || plane.inner.len() + missing.len() > MAX_POINTS {
            break;
        }
        for uv in missing {
            plane.insert(uv, |p| p.add(p.surface.point(uv.x, uv.y)))?;
        }
    }
    Ok(())
}

/// Middles of the edges inside that are too far from the surface, and of triangles whose middle is.
fn missing(plane: &Plane, fineness: &Fineness) -> Vec<DVec2> {
    let inside = plane.inside();
    let surface = plane.surface;
    let at = |uv: DVec2| surface.point(uv.x, uv.y);
    let place = |p: Point2<f64>| DVec2::new(p.x, p.y);
    // Every vertex is an end of six edges. A pole has another normal for each of them.
    let known = |v: Point2<f64>| {
        let uv = plane.chart.parameters(place(v));
        (at(uv), surface.normal(uv.x, uv.y))
    };
    let known: Vec<(DVec3, DVec3)> = plane.cdt.vertices().map(|v| known(v.position())).collect();
    let mut out = Vec::new();
    for edge in plane.cdt.undirected_edges().filter(|e| !e.is_constraint_edge()) {
        let directed = edge.as_directed();
        if !directed.face().as_inner().is_some_and(|f| inside[f.fix().index()]) {
            continue;
        }
        let ends = edge.vertices().map(|v| place(v.position()));
        let middle = 0.5 * (ends[0] + ends[1]);
        let [a, b] = edge.vertices().map(|v| known[v.fix().index()]);
        let normal = |k: usize, of: DVec3| {
            if !plane.chart.is_pole(ends[k]) {
                return of;
            }
            let uv = plane.uv(ends[k], middle);
            surface.normal(uv.x, uv.y)
        };
        let uv = plane.chart.parameters(middle);
        let far = at(uv).distance(0.5 * (a.0 + b.0)) > fineness.chord;
        // Normals vary along a chord by twice the tolerance at most, as between two triangles.
        if far || normal(0, a.1).angle_between(normal(1, b.1)) > 2.0 * fineness.angle {
            out.push(uv);
        }
    }
    for face in plane.cdt.inner_faces().filter(|f| inside[f.fix().index()]) {
        let [a, b, c] = face.vertices().map(|v| place(v.position()));
        let flat = face.vertices().map(|v| known[v.fix().index()].0);
        let uv = plane.chart.parameters((a + b + c) / 3.0);
        if at(uv).distance((flat[0] + flat[1] + flat[2]) / 3.0) > fineness.chord {
            out.push(uv);
        }
    }
    out
}

/// Nodes of a grid in the parameter plane inside the loops and clear of them; none where the surface is straight in some
/// direction, because chords from border to border follow it there.
fn grid(surface: &Surface, scale: DVec2, rings: &[Ring], fineness: &Fineness) -> Vec<DVec2> {
    let samples = || rings.iter().flat_map(|r| r.samples.iter().map(|s| s.uv));
    let low = samples().fold(DVec2::INFINITY, DVec2::min);
    let high = samples().fold(DVec2::NEG_INFINITY, DVec2::max);
    let size = high - low;
    let mut steps = DVec2::INFINITY;
    for i in 0..=PROBES {
        for j in 0..=PROBES {
            let uv = low + size * DVec2::new(f64::from(i), f64::from(j)) / f64::from(PROBES);
            let jet = surface.jet(uv.x, uv.y);
            let normal = surface.normal(uv.x, uv.y);
            let step = |first: DVec3, second: DVec3| {
                let l = first.length();
                if l > 0.0 { arc_step(second.dot(normal) / (l * l), fineness) / l } else { f64::INFINITY }
            };
            steps = steps.min(DVec2::new(step(jet.first[0], jet.second[0]), step(jet.first[1], jet.second[2])));
        }
    }
    let lines = (size / steps).ceil().min(DVec2::splat(MAX_LINES));
    if lines.min_element() < 2.0 {
        return Vec::new();
    }
    let step = size / lines;
    let clear = CLEARANCE * (step * scale).min_element();
    let mut out = Vec::new();
    for row in 1..lines.y as u32 {
        let v = low.y + step.y * f64::from(row);
        let crossings = crossings(rings, v);
        let near: Vec<DVec2> = samples().filter(|s| ((s.y - v) * scale.y).abs() < clear).collect();
        for column in 1..lines.x as u32 {
            let uv = DVec2::new(low.x + step.x * f64::from(column), v);
            let inside = crossings.partition_point(|&x| x < uv.x) % 2 == 1;
            if inside && near.iter().all(|s| ((s - uv) * scale).length() > clear) {
                out.push(uv);
            }
        }
    }
    out
}

/// Where the line of constant `v` crosses the loops, from left to right.
fn crossings(rings: &[Ring], v: f64) -> Vec<f64> {
    let pieces = rings.iter().flat_map(|r| r.samples.windows(2).map(|w| (w[0].uv, w[1].uv)));
    let mut out: Vec<f64> = pieces
        .filter(|(a, b)| (a.y <= v) != (b.y <= v))
        .map(|(a, b)| a.x + (b.x - a.x) * (v - a.y) / (b.y - a.y))
        .collect();
    out.sort_unstable_by(f64::total_cmp);
    out
}
