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
            let known = known_place(of, k as f64 / n as f64);
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

/// The parameters that a use has at a share of its edge, where it has them in proportion.
fn known_place(of: &EdgeUse, share: f64) -> Option<[f64; 2]> {
    let &[a, b] = of.parameters.as_slice() else { return None };
    Some([0, 1].map(|k| a[k] + share * (b[k] - a[k])))
}

/// The length of a polygon through a few points of an edge: no longer than the edge.
fn chord_length(edge: &Edge) -> f64 {
    let points: Vec<DVec3> = (0..=8).map(|k| edge.point_at(f64::from(k) / 8.0)).collect();
    points.windows(2).map(|w| w[0].distance(w[1])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brep::{Face, Surface, Vertex};
    use crate::geometry::bspline::{BSplineSurface, Knots};

    #[test]
    fn an_edge_is_where_its_use_says_though_no_search_finds_it() {
        // A strip that is rolled up in coils closer to each other than the samples of a search are.
        let knots = [
            Knots::from_breaks(1, &(0..=1600).map(f64::from).collect::<Vec<_>>(), 1),
            Knots::from_breaks(1, &[0.0, 1.0], 1),
        ];
        let [u, v] = knots.map(Result::unwrap);
        let coil = |k: u32| {
            let angle = 0.1 * f64::from(k);
            DVec3::new(angle.cos(), angle.sin(), 0.0) * (1.0 + 1e-4 * angle)
        };
        let rows = [0.0, 1.0].map(|z| (0..=1600).map(move |k| coil(k) + z * DVec3::Z));
        let surface = BSplineSurface::new(u, v, rows.into_iter().flatten().collect()).unwrap();
        let curve = surface.sides().unwrap()[0].clone();
        let range = curve.knots().domain();
        let ends = curve.ends();
        let edge = Edge { curve: Curve::Spline(curve), range, ends: [0, 1], tolerance: 0.0 };
        let of = EdgeUse { edge: 0, reversed: false, parameters: vec![[0.0, 0.0], [1600.0, 0.0]] };
        let brep = Brep {
            vertices: ends.map(Vertex::exact).to_vec(),
            edges: vec![edge.clone()],
            faces: vec![Face::new(0, vec![vec![of.clone()]])],
            surfaces: vec![Surface::Spline(surface)],
            ..Brep::default()
        };
        assert!(largest_gap(&brep, 0, &edge, &EdgeUse::new(0, false), 1e-9).0 < 1e-2);
        assert!(largest_gap(&brep, 0, &edge, &of, 1e-9).0 < 1e-9);
    }
}
