//! Patches: a cell with its surroundings, optimised on its own.
//!
//! A few hundred cells get as many iterations as they need, and nothing that happens elsewhere cuts a step short. Patches
//! without a common cell are optimised side by side; a patch that improves no cell is not taken.
//!
//! ```text
//! ┌──┬──┬──┬──┬──┐
//! ├──┼──┼──┼──┼──┤     ▓ the cell; vertices on the rim of its patch stay
//! ├──┼──┼▓▓┼──┼──┤
//! ├──┼──┼──┼──┼──┤
//! └──┴──┴──┴──┴──┘
//! ```

use super::optimiser::{Optimiser, Spring};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::hexes::{scaled_jacobian, uncertified};
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

/// Shares of the way that a patch goes, until no cell is folded when all that is tied is in place.
const PATCH_WAYS: [f64; 3] = [1.0, 0.5, 0.25];
/// Factors β of the least scaled Jacobian in turn, with the iterations of each.
const SHARPER: [(f64, usize); 3] = [(15.0, 40), (30.0, 40), (60.0, 40)];
/// Inside once more, when the boundary is where it belongs.
const INSIDE_AGAIN: (i32, usize) = (16, 60);
/// What the mean quality of the mesh loses counts so much against what its worst cell gains.
const LOSS: f64 = 2.0;

/// What vertices are tied to while cells are improved.
pub trait Ties: Sync {
    /// The springs of a vertex that is here.
    fn springs(&self, vertex: u32, at: DVec3) -> Vec<Spring>;
    /// Whether a vertex stays where it is.
    fn is_fixed(&self, vertex: u32) -> bool;
    /// Where a vertex has to be that was moved here, if it is not free.
    fn tied_place(&self, vertex: u32, at: DVec3) -> Option<DVec3>;
}

impl Ties for Optimiser<'_> {
    fn springs(&self, vertex: u32, _: DVec3) -> Vec<Spring> {
        let first = self.springs.partition_point(|s| s.vertex < vertex);
        self.springs[first..].iter().take_while(|s| s.vertex == vertex).copied().collect()
    }

    fn is_fixed(&self, vertex: u32) -> bool {
        self.fixed.get(vertex as usize) == Some(&true)
    }

    fn tied_place(&self, _: u32, _: DVec3) -> Option<DVec3> {
        None
    }
}

/// A mesh with the cells at every vertex.
pub struct Mesh<'a> {
    hexes: &'a [[u32; 8]],
    offsets: Vec<u32>,
    cells: Vec<u32>,
}

impl<'a> Mesh<'a> {
    pub fn new(vertices: usize, hexes: &'a [[u32; 8]]) -> Self {
        let (offsets, corners) = super::optimiser::corners_at(vertices, hexes);
        Mesh { hexes, offsets, cells: corners.into_iter().map(|c| c / 8).collect() }
    }

    pub fn at(&self, vertex: u32) -> &[u32] {
        &self.cells[self.offsets[vertex as usize] as usize..self.offsets[vertex as usize + 1] as usize]
    }

    /// A cell and those around it, in rings.
    pub fn around(&self, cell: u32, rings: usize) -> Vec<u32> {
        let mut found = vec![cell];
        let mut known: FxHashSet<u32> = [cell].into_iter().collect();
        let mut start = 0;
        for _ in 0..rings {
            let end = found.len();
            for k in start..end {
                for &v in &self.hexes[found[k] as usize] {
                    found.extend(self.at(v).iter().copied().filter(|&c| known.insert(c)));
                }
            }
            start = end;
        }
        found
    }

    /// Patches around cells in turn, as far as they have no cell in common.
    pub fn disjoint(&self, cells: impl Iterator<Item = u32>, rings: usize, most: usize) -> Vec<Vec<u32>> {
        let mut taken = vec![false; self.hexes.len()];
        let mut patches = Vec::new();
        for cell in cells {
            if patches.len() >= most {
                break;
            }
            if taken[cell as usize] {
                continue;
            }
            let around = self.around(cell, rings);
            if around.iter().all(|&c| !taken[c as usize]) {
                around.iter().for_each(|&c| taken[c as usize] = true);
                patches.push(around);
            }
        }
        patches
    }
}

/// Cells with numbers of their own for their vertices.
pub struct Patch {
    pub vertices: Vec<u32>,
    pub places: Vec<DVec3>,
    pub hexes: Vec<[u32; 8]>,
    pub fixed: Vec<bool>,
    /// Cells of the mesh.
    of: usize,
}

impl Patch {
    pub fn new(mesh: &Mesh, points: &[DVec3], cells: &[u32], ties: &impl Ties) -> Self {
        let mut local: FxHashMap<u32, u32> = FxHashMap::default();
        let mut vertices = Vec::new();
        let mut number = |v: u32| {
            *local.entry(v).or_insert_with(|| {
                vertices.push(v);
                vertices.len() as u32 - 1
            })
        };
        let hexes: Vec<[u32; 8]> = cells.iter().map(|&c| mesh.hexes[c as usize].map(&mut number)).collect();
        let mut used = vec![0; vertices.len()];
        hexes.as_flattened().iter().for_each(|&v| used[v as usize] += 1);
        let is_held = |(&v, used): (&u32, usize)| used < mesh.at(v).len() || ties.is_fixed(v);
        let fixed = vertices.iter().zip(used).map(is_held).collect();
        Patch {
            places: vertices.iter().map(|&v| points[v as usize]).collect(),
            vertices,
            hexes,
            fixed,
            of: mesh.hexes.len(),
        }
    }

    /// The springs of the vertices that may move.
    pub fn springs(&self, places: &[DVec3], ties: &impl Ties) -> Vec<Spring> {
        let own = |k: usize| {
            ties.springs(self.vertices[k], places[k]).into_iter().map(move |s| Spring { vertex: k as u32, ..s })
        };
        (0..self.vertices.len()).filter(|&k| !self.fixed[k]).flat_map(own).collect()
    }

    pub fn quality(&self, places: &[DVec3], cell: usize) -> f64 {
        scaled_jacobian(&self.hexes[cell].map(|v| places[v as usize]))
    }

    pub fn worst(&self, places: &[DVec3]) -> f64 {
        (0..self.hexes.len()).map(|h| self.quality(places, h)).fold(f64::INFINITY, f64::min)
    }

    /// What the patch adds to the mean quality of the mesh.
    pub fn mean(&self, places: &[DVec3]) -> f64 {
        (0..self.hexes.len()).map(|h| self.quality(places, h)).sum::<f64>() / self.of as f64
    }

    /// The least quality of the centre cell and of all cells that got worse. Cells that were already worse than the centre cell,
    /// and did not get worse, are ignored. An improvement is rejected if other cells pay for it, because where a patch is most
    /// of the mesh that may cost more than it gains.
    pub fn worth(&self, places: &[DVec3]) -> f64 {
        let worse = (1..self.hexes.len()).filter_map(|h| {
            let now = self.quality(places, h);
            (now < self.quality(&self.places, h)).then_some(now)
        });
        let lost = (self.mean(&self.places) - self.mean(places)).max(0.0);
        worse.fold(self.quality(places, 0), f64::min) - LOSS * lost
    }
}

/// How the cells of a patch are made better.
pub enum Descent<'a> {
    /// By the energy, with powers and the iterations of each.
    Energy(&'a [(i32, usize)]),
    /// By their least scaled Jacobian.
    Corners,
    /// By the mean of their scaled Jacobians.
    Mean,
}

impl Descent<'_> {
    fn run(
        &self,
        optimiser: &mut Optimiser,
        patch: &Patch,
        places: &mut Vec<DVec3>,
        ties: &impl Ties,
        context: &Context,
    ) -> Result<()> {
        match self {
            Descent::Energy(powers) => {
                for &(power, iterations) in *powers {
                    optimiser.tie(patch.springs(places, ties));
                    optimiser.descend(places, 0.0, power, iterations, context)?;
                    optimiser.retarget(places);
                }
            }
            Descent::Mean => {
                optimiser.tie(patch.springs(places, ties));
                optimiser.straighten(places, patch.worst(places), context)?;
            }
            Descent::Corners => {
                for (beta, iterations) in SHARPER {
                    optimiser.tie(patch.springs(places, ties));
                    optimiser.sharpen(places, beta, patch.quality(places, 0), iterations, context)?;
                }
            }
        }
        Ok(())
    }

    /// When what is tied is in its place.
    fn finish(&self, optimiser: &Optimiser, patch: &Patch, places: &mut Vec<DVec3>, context: &Context) -> Result<()> {
        match self {
            Descent::Energy(_) => optimiser.descend(places, 0.0, INSIDE_AGAIN.0, INSIDE_AGAIN.1, context),
            Descent::Mean => optimiser.straighten(places, patch.worst(places), context),
            Descent::Corners => {
                let (beta, iterations) = SHARPER[SHARPER.len() - 1];
                optimiser.sharpen(places, beta, patch.quality(places, 0), iterations, context)
            }
        }
    }
}

/// The places of a patch's vertices after the descent from some places, on what they are tied to; `None` where a cell has no
/// certificate there.
pub fn descended(
    patch: &Patch,
    from: &[DVec3],
    ties: &impl Ties,
    descent: &Descent,
    context: &Context,
) -> Result<Option<Vec<DVec3>>> {
    let mut places = from.to_vec();
    let mut optimiser = Optimiser::new(&places, &patch.hexes);
    // Targets of its own make a cell that was barely valid for all seem not to be.
    if !(optimiser.least(&places) > 0.0) {
        return Ok(None);
    }
    optimiser.fix(patch.fixed.clone());
    descent.run(&mut optimiser, patch, &mut places, ties, context)?;
    let found = PATCH_WAYS.iter().find_map(|&share| put(patch, from, ties, &optimiser, &places, share));
    let Some((there, is_tied)) = found else { return Ok(None) };
    places = there;
    if is_tied.contains(&true) {
        optimiser.fix(patch.fixed.iter().zip(&is_tied).map(|(f, s)| *f || *s).collect());
        optimiser.tie(Vec::new());
        descent.finish(&optimiser, patch, &mut places, context)?;
    }
    Ok(uncertified(&places, &patch.hexes).is_empty().then_some(places))
}

/// The vertices of a patch a share of the way between two places, then on what they are tied to, and which of them are tied; `None`
/// where a cell is folded there.
fn put(
    patch: &Patch,
    from: &[DVec3],
    ties: &impl Ties,
    optimiser: &Optimiser,
    places: &[DVec3],
    share: f64,
) -> Option<(Vec<DVec3>, Vec<bool>)> {
    let mut there = from.to_vec();
    let mut is_tied = vec![false; there.len()];
    for k in (0..there.len()).filter(|&k| !patch.fixed[k]) {
        there[k] = there[k].lerp(places[k], share);
        if let Some(to) = ties.tied_place(patch.vertices[k], there[k]) {
            (there[k], is_tied[k]) = (to, true);
        }
    }
    optimiser.is_valid(&there).then_some((there, is_tied))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::mesh::test_models::bricks;

    pub const SIDE: u32 = 13;

    /// A block of cubes, its boundary held.
    pub fn block() -> (Vec<DVec3>, Vec<[u32; 8]>, Vec<bool>) {
        let (points, hexes) = bricks([SIDE; 3]);
        let is_held = |p: &DVec3| p.to_array().iter().any(|&x| x == 0.0 || x == f64::from(SIDE));
        let fixed = points.iter().map(is_held).collect();
        (points, hexes, fixed)
    }

    pub fn held<'a>(hexes: &'a [[u32; 8]], straight: &[DVec3], fixed: &[bool]) -> Optimiser<'a> {
        let mut optimiser = Optimiser::new(straight, hexes);
        optimiser.fix(fixed.to_vec());
        optimiser
    }

    /// What one cell gains does not count where all others lose more.
    #[test]
    fn a_poor_cell_is_not_mended_at_the_cost_of_all() {
        let (straight, hexes, fixed) = block();
        let optimiser = held(&hexes, &straight, &fixed);
        let mesh = Mesh::new(straight.len(), &hexes);
        let sheared = |by: f64| move |p: DVec3| DVec3::new(p.x + by * p.y, p.y, p.z);
        let mut points: Vec<DVec3> = straight.iter().map(|p| sheared(0.3)(*p)).collect();
        points[hexes[0][6] as usize] += DVec3::splat(-0.3);
        let all: Vec<u32> = (0..hexes.len() as u32).collect();
        let patch = Patch::new(&mesh, &points, &all, &optimiser);
        let places = |by| -> Vec<DVec3> { patch.vertices.iter().map(|&v| sheared(by)(straight[v as usize])).collect() };
        let (before, little, much) = (patch.worth(&patch.places), patch.worth(&places(0.3)), patch.worth(&places(1.5)));
        assert!(patch.quality(&places(1.5), 0) > before, "{before}");
        assert!(little > before && much < before, "{little} {before} {much}");
    }

    /// The corners alone do not tell that a cell is about to fold inside: the descent must not end there, for no other could go on.
    #[test]
    fn raising_the_least_corner_does_not_run_to_the_end_of_the_valid_set() {
        let (straight, hexes, fixed) = block();
        let mut points = straight.clone();
        for (v, p) in points.iter_mut().enumerate().filter(|(v, _)| !fixed[*v]) {
            let t = v as f64;
            *p += 0.34 * DVec3::new((1.7 * t).sin(), (2.3 * t).cos(), (0.9 * t).sin());
        }
        let optimiser = held(&hexes, &straight, &fixed);
        let worst = |points: &[DVec3]| optimiser.qualities(points).into_iter().fold(f64::INFINITY, f64::min);
        let start = [worst(&points), optimiser.least(&points)];
        for (beta, iterations) in SHARPER {
            let usual = worst(&points);
            optimiser.sharpen(&mut points, beta, usual, iterations, &Context::new()).unwrap();
        }
        assert!(
            worst(&points) > start[0] + 0.1 && optimiser.least(&points) > 0.1,
            "{start:?} {}",
            optimiser.least(&points)
        );
    }
}
