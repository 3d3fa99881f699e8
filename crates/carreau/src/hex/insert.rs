//! Cells inserted where a branch grows thick (named as future work by the paper, after Livesu, Muntoni, Puppo,
//! Scateni, "Skeleton-driven adaptive hexahedral meshing of tubular shapes", 2016).
//!
//! Where the radius is more than k + 1 times the smallest one of its branch, the section gets 2 k more columns of cells in
//! either direction: a sheet about every half of the thick part, one after the other.
//!
//! ```text
//!   ──┬─────┬─────┬──      ──┬─────┬─────┬──       a branch seen from the side, thin on the left; its axis is the
//!     │     │     │          │╲────┼─────┼──       line in the middle. The sheet comes in along the axis and leaves
//!     │     │     │     →    │ │   │     │         through the wall: what is left of it keeps its two rows.
//!   ──┼─────┼─────┼──      ──┼─┴───┼─────┼──
//!     │     │     │          │ ╲───┼─────┼──
//!     │     │     │          │ │   │     │
//!   ──┴─────┴─────┴──      ──┴─┴───┴─────┴──
//! ```
//!
//! A sheet is a pillow (Mitchell and Tautges 1995): a set of cells shrinks, and every face between it and the others gets
//! a cell. That conforms whatever the set is; edges inside get three to six cells.

use super::Padding;
use super::refine::{CellPlace, TubeMesh};
use crate::mesh::{Chains, CurveNet, HEX_FACES, NONE};
use glam::DVec3;
use rustc_hash::FxHashMap;

/// Columns are added this often at most.
const MOST_LEVELS: u32 = 7;
/// How far the vertices of a set go towards those inside of it.
const SHRINK: f64 = 0.5;
/// The quarters of a section in its halves, in the order of the sheets.
const HALVES: [[u8; 2]; 4] = [[0, 1], [2, 3], [1, 2], [3, 0]];

/// How often columns are added along every segment. Not at the segments next to a branching, which keep the section that is
/// sewn there; from one segment to the next at most one time more.
pub fn levels(net: &CurveNet) -> Vec<u32> {
    let around = net.incidence();
    let all = Chains::new(net, &around);
    let mut levels = vec![0; net.edges.len()];
    for branch in 0..all.count() {
        let span = all.span(branch);
        let nodes = &all.nodes[span.clone()];
        let edges = &all.edges[span.start..span.end - 1];
        let radius = |v: u32| net.radii[v as usize];
        let least = nodes.iter().map(|&v| radius(v)).fold(f64::INFINITY, f64::min);
        if !(least > 0.0) {
            continue;
        }
        let wanted = |k: usize| {
            let times = radius(nodes[k]).min(radius(nodes[k + 1])) / least;
            // As a comparison, which holds for a ratio of two to the last bit.
            (1..=MOST_LEVELS).take_while(|&l| times > f64::from(l) + 1.0).count() as u32
        };
        let mut own: Vec<u32> = (0..edges.len()).map(wanted).collect();
        let is_end = |v: u32| around.valence(v) == 1;
        let (first, last) = (is_end(nodes[0]), is_end(nodes[nodes.len() - 1]));
        // Towards either end levels fall by one from segment to segment, to none where no end of a tube is.
        let mut most = if first { MOST_LEVELS } else { 0 };
        for level in &mut own {
            *level = (*level).min(most);
            most = *level + 1;
        }
        most = if last { MOST_LEVELS } else { 0 };
        for level in own.iter_mut().rev() {
            *level = (*level).min(most);
            most = *level + 1;
        }
        edges.iter().zip(own).for_each(|(&e, level)| levels[e as usize] = level);
    }
    levels
}

/// How often segments of a level are halved along, for cells about as long as they were.
fn halvings(level: u32) -> u32 {
    (level + 1).ilog2()
}

/// Inserts the sheets. `places` says where every cell stands.
pub fn insert(tube: &mut TubeMesh, places: Vec<CellPlace>, levels: &[u32]) {
    let mut sheets = Sheets { tube, places };
    for level in 1..=levels.iter().copied().max().unwrap_or(0) {
        for half in HALVES {
            sheets.pillow(|place| {
                place.segment != NONE && levels[place.segment as usize] >= level && half.contains(&place.quarter)
            });
        }
    }
    for round in 1..=halvings(MOST_LEVELS) {
        if levels.iter().any(|&l| halvings(l) >= round) {
            tube.refine_along(|e| halvings(levels[e as usize]) >= round);
        }
    }
}

/// Cells that the sheets add: those that run along a segment, and those that do not.
pub fn count(net: &CurveNet, levels: &[u32], padding: Padding) -> [f64; 2] {
    let layer = if padding == Padding::None { 0.0 } else { 1.0 };
    let (mut along, mut ends) = (0.0, 0.0);
    // 2 k × 2 k cells and a layer of 8 k about them.
    let section = |k: f64| 4.0 * k * k + 8.0 * k * layer;
    for &level in levels {
        let k = f64::from(level) + 1.0;
        along += section(k) * f64::from(1 << halvings(level)) - section(1.0);
    }
    let around = net.incidence();
    for v in 0..net.points.len() as u32 {
        let at = around.of(v);
        let level = |s: &[u32; 2]| levels[s[0] as usize];
        match at {
            // Both sheets of a direction close in front of a section, and the later ones of them cross the earlier ones.
            [a, b] if level(a) != level(b) => {
                let k = f64::from(level(a).min(level(b))) + 1.0;
                ends += 2.0 * section(k) + 4.0 * (k + layer);
            }
            // The layer on an end has the columns of its section.
            [a] if padding == Padding::All => {
                let k = f64::from(level(a)) + 1.0;
                ends += 4.0 * (k * k - 1.0);
            }
            _ => {}
        }
    }
    [along, ends]
}

/// A mesh that sheets are inserted into.
struct Sheets<'a> {
    tube: &'a mut TubeMesh,
    places: Vec<CellPlace>,
}

impl Sheets<'_> {
    /// A layer of cells between some cells and the others; on the boundary of the mesh there is none.
    ///
    /// ```text
    ///   ┌──┬──┬──┐         ┌──┬──┬──┐
    ///   │  │▒▒│▒▒│         │  │╲─┼──┤      ▒ the set; b, the copy of a, belongs to it, a to the others
    ///   ├──a──┼──┤    →    │  │ b┼──┤
    ///   │  │  │  │         ├──a──┼──┤
    ///   └──┴──┴──┘         └──┴──┴──┘
    /// ```
    fn pillow(&mut self, is_in: impl Fn(CellPlace) -> bool) {
        let cells: Vec<u32> = (0..self.places.len() as u32).filter(|&c| is_in(self.places[c as usize])).collect();
        let faces = self.frontier(&cells);
        let inner = self.shrink(&cells, &faces);
        for &[cell, face] in &faces {
            let quad = HEX_FACES[face as usize].map(|k| self.tube.hexes[cell as usize][k]);
            let segment = self.tube.segments[cell as usize];
            let [a, b, c, d] = quad;
            let [i, j, k, l] = quad.map(|v| inner[&v]);
            // The first two faces of a cell are across its third axis; on the others that runs from a to d.
            let is_aside = segment != NONE && face > 1;
            self.tube.hexes.push(if is_aside { [i, a, b, j, l, d, c, k] } else { [i, j, k, l, a, b, c, d] });
            self.tube.segments.push(if is_aside { segment } else { NONE });
            self.places.push(self.places[cell as usize]);
        }
        for &cell in &cells {
            let corners = &mut self.tube.hexes[cell as usize];
            corners.iter_mut().for_each(|v| *v = inner.get(v).copied().unwrap_or(*v));
        }
    }

    /// The faces between some cells and the others, each as a cell of the set and the number of its face.
    fn frontier(&self, cells: &[u32]) -> Vec<[u32; 2]> {
        let key = |cell: u32, face: usize| {
            let mut key = HEX_FACES[face].map(|k| self.tube.hexes[cell as usize][k]);
            key.sort_unstable();
            key
        };
        let mut seen: FxHashMap<[u32; 4], u32> = FxHashMap::default();
        for cell in 0..self.places.len() as u32 {
            (0..6).for_each(|f| *seen.entry(key(cell, f)).or_default() += 1);
        }
        for &cell in cells {
            (0..6).for_each(|f| *seen.entry(key(cell, f)).or_default() += 2);
        }
        // Two cells have it, one of them in the set.
        let sides = cells.iter().flat_map(|&cell| (0..6).map(move |f| (cell, f)));
        sides.filter(|&(cell, f)| seen[&key(cell, f)] == 4).map(|(cell, f)| [cell, f as u32]).collect()
    }

    /// Copies of the vertices on a frontier, half way to the vertices of the set that are not on it: of those on the wall
    /// and on an end within these.
    fn shrink(&mut self, cells: &[u32], faces: &[[u32; 2]]) -> FxHashMap<u32, u32> {
        let tube = &mut *self.tube;
        let mut inner: FxHashMap<u32, u32> = FxHashMap::default();
        let mut order = Vec::new();
        for &[cell, face] in faces {
            for k in HEX_FACES[face as usize] {
                let v = tube.hexes[cell as usize][k];
                inner.entry(v).or_insert_with(|| {
                    order.push(v);
                    (tube.points.len() + order.len()) as u32 - 1
                });
            }
        }
        let mut around: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        for &cell in cells {
            for v in tube.hexes[cell as usize] {
                if inner.contains_key(&v) {
                    around.entry(v).or_default().push(cell);
                }
            }
        }
        let mut made = Vec::with_capacity(order.len());
        for &v in &order {
            let i = v as usize;
            let fits = |w: u32| {
                let w = w as usize;
                (tube.radii[i] == 0.0 || tube.radii[w] > 0.0) && (tube.caps[i] == 0 || tube.caps[w] == tube.caps[i])
            };
            let corners = || around[&v].iter().flat_map(|&c| tube.hexes[c as usize]).filter(|&w| fits(w));
            let mut targets: Vec<u32> = corners().filter(|w| !inner.contains_key(w)).collect();
            if targets.is_empty() {
                targets.extend(corners());
            }
            let share = SHRINK / targets.len() as f64;
            let mean = |list: &[DVec3]| {
                targets.iter().map(|&w| list[w as usize] * share).sum::<DVec3>() + list[i] * (1.0 - SHRINK)
            };
            let radius = targets.iter().map(|&w| tube.radii[w as usize] * share).sum::<f64>();
            let radius = if tube.radii[i] > 0.0 { radius + tube.radii[i] * (1.0 - SHRINK) } else { 0.0 };
            made.push((mean(&tube.points), mean(&tube.centres), radius, tube.caps[i]));
        }
        for (point, centre, radius, cap) in made {
            tube.points.push(point);
            tube.centres.push(centre);
            tube.radii.push(radius);
            tube.caps.push(cap);
        }
        inner
    }
}

#[cfg(test)]
mod tests {
    use super::super::refine::CORE;
    use super::super::tests::assert_conforming;
    use super::super::*;
    use super::*;

    /// A branch with these radii.
    fn cone(radii: &[f64]) -> CurveNet {
        let points = (0..radii.len()).map(|k| DVec3::new(0.2 * (k as f64).sin(), 0.0, 3.0 * k as f64)).collect();
        CurveNet::new(points, radii.to_vec(), (1..radii.len() as u32).map(|k| [k - 1, k]).collect())
    }

    /// A thick trunk with two thin branches, whose other ends are thick again.
    fn tree() -> CurveNet {
        let mut net = cone(&[3.3, 3.2, 2.5, 2.1, 1.0, 1.0]);
        for side in [-1.0, 1.0] {
            let mut from = 5;
            for k in 1..5 {
                net.points.push(DVec3::new(side * 3.0 * f64::from(k), 0.0, 15.0 + 2.0 * f64::from(k)));
                net.radii.push([1.0, 1.0, 1.0, 2.5, 2.6][k as usize]);
                net.ids.push(net.ids.len() as i64);
                let to = net.points.len() as u32 - 1;
                net.edges.push([from, to]);
                from = to;
            }
        }
        net
    }

    fn inserted(net: &CurveNet, padding: Padding) -> (usize, TubeMesh) {
        let base = assemble::base_mesh(net, true);
        let mut tube = refine::pad(net, &base, padding, CORE);
        let before = tube.hexes.len();
        let places = refine::places(net, &base, padding);
        assert_eq!(places.len(), before);
        insert(&mut tube, places, &levels(net));
        (before, tube)
    }

    #[test]
    fn levels_follow_the_radius_and_keep_off_branchings() {
        assert_eq!(levels(&cone(&[1.0, 1.5, 2.0, 2.5, 2.5])), [0, 0, 0, 1]);
        assert_eq!(levels(&cone(&[1.0, 9.0, 9.0, 9.0, 9.0])), [0, 1, 2, 3]);
        assert_eq!(levels(&cone(&[9.0, 9.0, 9.0, 1.0, 5.0, 5.0])), [2, 1, 0, 0, 1]);
        let net = tree();
        assert_eq!(levels(&net)[..5], [2, 1, 1, 0, 0]);
        assert_eq!(levels(&net).iter().filter(|l| **l > 0).count(), 5);
    }

    /// The cells that are counted beforehand are made, and they conform.
    #[test]
    fn sheets_conform_and_are_counted() {
        for net in [cone(&[1.0, 1.0, 2.5, 2.5]), cone(&[1.0, 3.5, 3.5, 3.5, 3.5, 1.0]), tree()] {
            for padding in [Padding::None, Padding::Sides, Padding::All] {
                let (before, tube) = inserted(&net, padding);
                let [along, ends] = count(&net, &levels(&net), padding);
                assert_eq!(tube.hexes.len() as f64, before as f64 + along + ends, "{padding:?}");
                assert_conforming(&tube.hexes, &tube.points, &[0]);
                let mut finer = tube.clone();
                finer.refine_across();
                finer.refine_along(|_| true);
                assert_conforming(&finer.hexes, &finer.points, &[0]);
            }
        }
    }

    /// Edges of the ends are in proportion to the radius; where cells were inserted they are not.
    #[test]
    fn cells_stay_about_as_large_as_they_are_where_the_branch_is_thin() {
        let net = cone(&[1.0, 1.0, 1.0, 2.4, 2.4, 2.4, 2.4]);
        let of = |adapt_radius| {
            let options = HexOptions { adapt_radius, edge_length: Some(3.0), ..HexOptions::default() };
            from_net(&net, &options, &Context::new()).unwrap()
        };
        let longest = |r: &HexResult| {
            let ends = r.mesh.quads.iter().zip(&r.mesh.tags).filter(|(_, tag)| **tag > 1);
            let sides = ends.flat_map(|(q, _)| (0..4).map(|k| [q[k], q[(k + 1) % 4]]));
            sides.map(|[a, b]| r.mesh.points[a as usize].distance(r.mesh.points[b as usize])).fold(0.0, f64::max)
        };
        let (with, without) = (of(true), of(false));
        assert!(longest(&with) < 0.75 * longest(&without), "{} {}", longest(&with), longest(&without));
        let quality = &with.figures.quality;
        assert!(quality.certified && quality.scaled_jacobian_min > 0.2, "{quality:?}");
        assert_conforming(&with.mesh.hexes, &with.mesh.points, &[0]);
    }

    #[test]
    fn where_nothing_grows_thick_nothing_is_inserted() {
        let options = HexOptions { adapt_radius: true, ..HexOptions::default() };
        let of = |options: &HexOptions| from_net(&cone(&[1.0; 5]), options, &Context::new());
        assert_eq!(of(&options).unwrap().mesh, of(&HexOptions::default()).unwrap().mesh);
        let base = HexOptions { stage: Stage::Base, ..options };
        assert_eq!(of(&base).map_err(|e| e.exit_code()).err(), Some(2));
    }
}
