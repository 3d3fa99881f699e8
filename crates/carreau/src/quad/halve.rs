//! Midpoint subdivision: every polygon of n sides becomes n quads, so that any conforming mesh becomes a conforming all-quad
//! one, with every edge in two halves.
//!
//! ```text
//!      c                  c
//!     ╱ ╲                ╱ ╲
//!    ╱   ╲      →      n───╳───m       a quad becomes four, a triangle three
//!   ╱     ╲            ╱   │   ╲
//!  a───────b          a────l────b
//! ```

use super::source::Source;
use super::work::{Place, Work};
use crate::mesh::{HalfEdges, Polygons};
use glam::DVec3;

/// Whether new vertices stay in the middle or go to the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Middle {
    Straight,
    OnSurface,
}

/// Divides every face. Vertices keep their numbers; those in the middle of edges come next, then those of faces.
pub fn halve(coarse: &Work, source: &Source, middle: Middle) -> Work {
    let half_edges = HalfEdges::new(&coarse.faces, coarse.points.len());
    let n = coarse.points.len();
    let mut features = coarse.features.clone();
    features.sort_unstable_by_key(|f| key(f.0));
    let curve_of = |e: [u32; 2]| features.binary_search_by_key(&key(e), |f| key(f.0)).ok().map(|k| features[k].1);
    let mut out = Work { points: coarse.points.clone(), place: coarse.place.clone(), ..Work::default() };
    let mut middle_of = vec![0u32; coarse.faces.corners().len()];
    let face_of = coarse.faces.face_of_corners();
    for edge in half_edges.groups() {
        let m = out.points.len() as u32;
        let mut region = 0;
        for c in edge.corners() {
            middle_of[c as usize] = m;
            region = coarse.region[face_of[c as usize] as usize];
        }
        let [a, b] = edge.ends;
        let place = match curve_of(edge.ends) {
            Some(curve) => {
                out.features.extend([([a, m], curve), ([m, b], curve)]);
                Place::Curve(curve)
            }
            None => Place::Region(region),
        };
        add(&mut out, source, middle, (out_point(coarse, a) + out_point(coarse, b)) / 2.0, place);
    }
    let mut faces = Polygons::new();
    for (f, face) in coarse.faces.iter().enumerate() {
        let first = coarse.faces.offsets()[f] as usize;
        let sides = face.len();
        let center = out.points.len() as u32;
        let mean = face.iter().map(|&v| out_point(coarse, v)).sum::<DVec3>() / sides as f64;
        add(&mut out, source, middle, mean, Place::Region(coarse.region[f]));
        for k in 0..sides {
            let before = middle_of[first + (k + sides - 1) % sides];
            faces.push(&[face[k], middle_of[first + k], center, before]);
            out.region.push(coarse.region[f]);
        }
    }
    debug_assert!(out.points.len() >= n);
    out.faces = faces;
    out
}

fn key([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn out_point(work: &Work, v: u32) -> DVec3 {
    work.points[v as usize]
}

fn add(out: &mut Work, source: &Source, middle: Middle, p: DVec3, place: Place) {
    let v = out.points.len() as u32;
    out.points.push(p);
    out.place.push(place);
    if middle == Middle::OnSurface {
        out.points[v as usize] = out.put_back(source, v, p);
    }
}
