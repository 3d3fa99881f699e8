//! Vertices on features go to where these bend.
//!
//! The features of a coarse input are chains of long straight edges. Quads of about the same length that do not know of them
//! cut every bend off:
//!
//! ```text
//!     w             v→w
//!    ╱ ╲            ╱ ╲
//!   ╱ ──v──  →     ╱   ╲
//!  v╱     ╲       v     ╲
//! ```
//!
//! The vertex nearest to a bend moves there and stays; those beside it share what is left of the curve.

use super::source::Source;
use super::work::{Place, Work};
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Curves are straight where they turn by less, in degrees.
const BEND_DEG: f64 = 8.0;
/// A vertex goes no farther than this share of the shorter edge beside it: a little more than half, or bends between two would
/// be left out.
const REACH: f64 = 0.55;
/// Rounds in which the vertices between bends become evenly spaced.
const EVEN: usize = 8;

/// A vertex inside a curve, with its two neighbours there.
struct Bead {
    vertex: u32,
    beside: [u32; 2],
}

/// Moves vertices on curves to bends of the source.
pub fn follow(work: &mut Work, source: &Source) {
    let mut beads = beads(work);
    let bends = bends(source);
    for (curve, beads) in &mut beads {
        let Some(bends) = bends.get(curve) else { continue };
        let reach = |bead: &Bead| {
            let [v, a, b] = [bead.vertex, bead.beside[0], bead.beside[1]].map(|w| work.points[w as usize]);
            REACH * v.distance(a).min(v.distance(b))
        };
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (k, bead) in beads.iter().enumerate() {
            let (here, reach) = (work.points[bead.vertex as usize], reach(bead));
            let near = bends.iter().enumerate().map(|(b, p)| (p.distance(here), k, b));
            pairs.extend(near.filter(|pair| pair.0 <= reach));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut taken = vec![false; bends.len()];
        for (_, k, b) in pairs {
            let v = beads[k].vertex as usize;
            if !taken[b] && work.place[v] != Place::Fixed {
                taken[b] = true;
                work.points[v] = bends[b];
                work.place[v] = Place::Fixed;
            }
        }
        beads.retain(|bead| work.place[bead.vertex as usize] != Place::Fixed);
        for _ in 0..EVEN {
            for Bead { vertex, beside: [a, b] } in &*beads {
                let mean = (work.points[*a as usize] + work.points[*b as usize]) / 2.0;
                work.points[*vertex as usize] = work.put_back(source, *vertex, mean);
            }
        }
    }
}

/// The vertices inside of every curve, in their order.
fn beads(work: &Work) -> Vec<(u32, Vec<Bead>)> {
    let mut beside: Vec<Vec<u32>> = vec![Vec::new(); work.points.len()];
    for ([a, b], _) in &work.features {
        beside[*a as usize].push(*b);
        beside[*b as usize].push(*a);
    }
    let mut of_curve: BTreeMap<u32, Vec<Bead>> = BTreeMap::new();
    for (vertex, beside) in (0u32..).zip(&beside) {
        if let (Place::Curve(curve), [a, b]) = (work.place[vertex as usize], beside.as_slice()) {
            of_curve.entry(curve).or_default().push(Bead { vertex, beside: [*a, *b] });
        }
    }
    of_curve.into_iter().collect()
}

/// The points inside of every curve of the source where it bends.
fn bends(source: &Source) -> FxHashMap<u32, Vec<DVec3>> {
    let point = |v: u32| source.surface.mesh.points()[v as usize];
    let mut arms: FxHashMap<(u32, u32), Vec<u32>> = FxHashMap::default();
    let mut order = Vec::new();
    for (&[a, b], &curve) in source.edges.iter().zip(&source.curve) {
        for (v, w) in [(a, b), (b, a)] {
            let list = arms.entry((curve, v)).or_default();
            if list.is_empty() {
                order.push((curve, v));
            }
            list.push(w);
        }
    }
    let straight = PI - BEND_DEG.to_radians();
    let mut bends: FxHashMap<u32, Vec<DVec3>> = FxHashMap::default();
    for (curve, v) in order {
        if let [a, b] = arms[&(curve, v)].as_slice()
            && (point(*a) - point(v)).angle_between(point(*b) - point(v)) < straight
        {
            bends.entry(curve).or_default().push(point(v));
        }
    }
    bends
}
