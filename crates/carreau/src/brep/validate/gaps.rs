//! Measures how far edges are from their surfaces and vertices from their edges, against the tolerances that the model
//! states.

use super::{Fault, Finding, Limits};
use crate::brep::{Brep, Curve, Edge, EdgeUse};
use crate::context::Context;
use crate::error::Result;
use glam::DVec3;
use rayon::prelude::*;

/// Places of an edge that are measured for each span of a spline.
const PER_SPAN: usize = 4;
/// Least number of places of an edge that are measured.
const LEAST: usize = 24;
/// Rounding, as a share of the model's size: what no tolerance need say.
const SIZE_ROUNDING: f64 = 1e-9;
/// Edges are longer than this many tolerances: shorter ones break what is done with the model later.
const SHORTEST: f64 = 10.0;

/// All gaps.
pub(super) fn gaps(brep: &Brep, limits: &Limits, context: &Context) -> Result<Vec<Finding>> {
    let [low, high] = brep.bounds();
    let rounding = SIZE_ROUNDING * low.distance(high).max(low.abs().max(high.abs()).max_element());
    let mut out = Vec::new();
    for (k, edge) in brep.edges.iter().enumerate() {
        for (&v, t) in edge.ends.iter().zip(edge.range) {
            let vertex = &brep.vertices[v as usize];
            let gap = edge.curve.point(t).distance(vertex.point);
            if gap > vertex.tolerance + rounding {
                let finding = Finding::new(Fault::VertexOffEdge, gap, vertex.tolerance, vertex.point);
                out.push(finding.of_vertex(v).of_edge(k as u32));
            }
        }
        if edge.tolerance > limits.tolerance {
            let at = edge.point_at(0.5);
            out.push(Finding::new(Fault::LargeTolerance, edge.tolerance, limits.tolerance, at).of_edge(k as u32));
        }
        let ends = edge.ends.iter().map(|&v| brep.vertices[v as usize].tolerance).fold(edge.tolerance, f64::max);
        let length = chord_length(edge);
        if length <= SHORTEST * ends {
            let at = edge.point_at(0.5);
            out.push(Finding::new(Fault::ShortEdge, length, SHORTEST * ends, at).of_edge(k as u32));
        }
    }
    for (k, vertex) in brep.vertices.iter().enumerate().filter(|(_, v)| v.tolerance > limits.tolerance) {
        let finding = Finding::new(Fault::LargeTolerance, vertex.tolerance, limits.tolerance, vertex.point);
        out.push(finding.of_vertex(k as u32));
    }
    let off: Vec<Vec<Finding>> = context.install(|| {
        let of_face = |f: usize| {
            context.check()?;
            Ok(off_surface(brep, f as u32, rounding))
        };
        (0..brep.faces.len()).into_par_iter().map(of_face).collect::<Result<_>>()
    })?;
    out.extend(off.into_iter().flatten());
    Ok(out)
}

/// Edges of a face that are not on its surface.
fn off_surface(brep: &Brep, f: u32, rounding: f64) -> Vec<Finding> {
    let face = &brep.faces[f as usize];
    let mut out = Vec::new();
    for of in face.uses() {
        let edge = &brep.edges[of.edge as usize];
        let (gap, at) = largest_gap(brep, f, edge, of, edge.tolerance + rounding);
        if gap > edge.tolerance + rounding {
            out.push(Finding::new(Fault::EdgeOffSurface, gap, edge.tolerance, at).of_face(f).of_edge(of.edge));
        }
    }
    out
}

/// The largest distance of samples of an edge from the surface of a face; exact where it is more than `allowed`.
fn largest_gap(brep: &Brep, f: u32, edge: &Edge, of: &EdgeUse, allowed: f64) -> (f64, DVec3) {
    let surface = brep.surface(&brep.faces[f as usize]);
    let spans = match &edge.curve {
        Curve::Spline(s) => s.knots().breaks().len() - 1,
        _ => 1,
    };
    let n = (PER_SPAN * spans).max(LEAST);
    let mut at = surface.project(edge.point_at(0.0));
    let mut worst = (0.0f64, edge.point_at(0.0));
    for k in 0..=n {
        let p = edge.point_at(k as f64 / n as f64);
        at = surface.project_near(p, at);
        let mut off = surface.point(at[0], at[1]).distance(p);
        if off > worst.0.max(allowed) {
            // A search from the place before may have stopped short, and so may one from all over a face whose cells are uneven: the
            // use knows about where it is.
            let known = of.at_share(k as f64 / n as f64);
            for anew in known.into_iter().chain([surface.project(p)]) {
                let other = surface.point(anew[0], anew[1]).distance(p);
                if other < off {
                    (off, at) = (other, surface.project_near(p, anew));
                }
            }
        }
        if off > worst.0 {
            worst = (off, p);
        }
    }
    worst
}

/// The length of a polygon through a few points of an edge: no longer than the edge.
fn chord_length(edge: &Edge) -> f64 {
    let points: Vec<DVec3> = (0..=8).map(|k| edge.point_at(f64::from(k) / 8.0)).collect();
    points.windows(2).map(|w| w[0].distance(w[1])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_use_knows_its_place_in_the_sense_of_the_edge() {
        let of = |reversed, parameters| EdgeUse { edge: 0, reversed, parameters };
        for reversed in [false, true] {
            let place = of(reversed, vec![[1.0, 4.0], [3.0, 8.0]]).at_share(0.25);
            assert_eq!(place, Some([1.5, 5.0]));
        }
        // One for each knot, or none.
        assert_eq!(of(false, vec![[0.0; 2]; 3]).at_share(0.5), None);
        assert_eq!(of(false, Vec::new()).at_share(0.5), None);
    }
}
