//! Creases of a scan that fade out are let go where no quad along them becomes good: they may be shorter than a quad is wide, or
//! bend within one.
//!
//! ```text
//!   ·────·────·         ·────·────·
//!   │   ╱│    │         │    │    │
//!   ·━━━·╲━━━━·    →    ·────·────·     ━ a crease with the same region on both sides
//!   │     ╲   │         │    │    │
//!   ·────·──╲─·         ·────·────·
//! ```
//!
//! Their vertices become those of the region around them. Creases between two regions stay, because the surface would have others
//! without them.

use super::source::Source;
use super::work::{Place, Work};
use rustc_hash::{FxHashMap, FxHashSet};

/// Lets the creases go that have a vertex of such quads. Returns the vertices that are free now.
pub fn release(work: &mut Work, source: &Source, bad: &[u32]) -> Vec<u32> {
    if !source.may_lose_creases {
        return Vec::new();
    }
    let near: FxHashSet<u32> = bad.iter().flat_map(|&q| work.faces.face(q as usize)).copied().collect();
    let is_near = |ends: &[u32; 2]| ends.iter().any(|v| near.contains(v));
    let gone: FxHashSet<u32> = work
        .features
        .iter()
        .filter(|(ends, curve)| source.is_seam(*curve) && !source.is_cut[*curve as usize] && is_near(ends))
        .map(|(_, curve)| *curve)
        .collect();
    let mut arms: FxHashMap<u32, usize> = FxHashMap::default();
    work.features
        .iter()
        .filter(|f| !gone.contains(&f.1))
        .flat_map(|f| f.0)
        .for_each(|v| *arms.entry(v).or_default() += 1);
    let mut free = Vec::new();
    for &(ends, curve) in work.features.iter().filter(|f| gone.contains(&f.1)) {
        for v in ends.into_iter().filter(|v| !arms.contains_key(v)) {
            work.place[v as usize] = Place::Region(source.sides[curve as usize][0]);
            free.push(v);
        }
    }
    work.features.retain(|f| !gone.contains(&f.1));
    free.sort_unstable();
    free.dedup();
    free
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::geometry::features::FeatureOptions;
    use crate::mesh::{TaggedEdge, VertexId, test_models::grid};

    /// A grid of four by four quads on a plate with a crease of two edges inside it.
    fn creased() -> (Work, Source) {
        let mut mesh = grid(4);
        let crease = [[6, 7], [7, 8]];
        mesh.tagged_edges = crease.iter().map(|e| TaggedEdge { ends: e.map(VertexId), tag: 1 }).collect();
        let mut source = Source::new(&mesh, &FeatureOptions::default(), &Context::new()).unwrap();
        source.may_lose_creases = true;
        let mut work = Work { points: mesh.points().to_vec(), region: vec![0; 16], ..Work::default() };
        for k in 0..16u32 {
            let at = |i: u32, j: u32| (k / 4 + i) * 5 + k % 4 + j;
            work.faces.push(&[at(0, 0), at(1, 0), at(1, 1), at(0, 1)]);
        }
        work.place = vec![Place::Region(0); work.points.len()];
        for (ends, &curve) in source.edges.iter().zip(&source.curve) {
            ends.iter().for_each(|&v| work.place[v as usize] = Place::Curve(curve));
            work.features.push((*ends, curve));
        }
        (work, source)
    }

    #[test]
    fn the_creases_beside_bad_quads_are_let_go_and_no_border() {
        let (mut work, source) = creased();
        let before = work.features.len();
        let beside = work.faces.iter().position(|f| f.contains(&7)).unwrap() as u32;
        assert_eq!(release(&mut work, &source, &[beside]), [6, 7, 8]);
        assert_eq!(work.features.len(), before - 2);
        assert!([6, 7, 8].iter().all(|&v| work.place[v] == Place::Region(0)));
        assert!(release(&mut work, &source, &[0]).is_empty(), "the border stays");
    }

    #[test]
    fn creases_that_are_asked_for_stay() {
        let (mut work, mut source) = creased();
        source.may_lose_creases = false;
        let all: Vec<u32> = (0..16).collect();
        assert!(release(&mut work, &source, &all).is_empty());
    }
}
