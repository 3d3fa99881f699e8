//! Folded cells, and the worst of the others, each with its surroundings alone.
//!
//! A few hundred cells take so many iterations as they need, and no step is cut short by what happens elsewhere. Patches
//! without a common cell are worked on side by side; what does no cell good is not taken.
//!
//! ```text
//! ┌──┬──┬──┬──┬──┐
//! ├──┼──┼──┼──┼──┤     ▓ the cell; vertices on the rim of its patch stay
//! ├──┼──┼▓▓┼──┼──┤
//! ├──┼──┼──┼──┼──┤
//! └──┴──┴──┴──┴──┘
//! ```

use super::{Effort, Optimiser, Spring, VALID};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::hexes::{scaled_jacobian, uncertified};
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

/// Cells with a lower scaled Jacobian are worked on.
const POOR: f64 = 0.5;
/// But not those that are better by this than one that was given up: the least of the mesh would stay.
const MARGIN: f64 = 0.1;
/// The mean is raised where it is lower than this: where it is not, that would cost twice the time of all else for .005.
const DULL: f64 = 0.93;
/// Rings of cells around a poor one.
const RINGS: usize = 5;
/// Powers of the energy in turn, with the iterations of each.
const POWERS: [(i32, usize); 3] = [(4, 40), (8, 80), (16, 80)];
/// Shares of the way that a patch goes, until no cell is folded when all that is tied is in place.
const SHARES: [f64; 3] = [1.0, 0.5, 0.25];
/// Factors β of the least scaled Jacobian in turn, with the iterations of each.
const SHARPER: [(f64, usize); 3] = [(15.0, 40), (30.0, 40), (60.0, 40)];
/// Inside once more, when the boundary is where it belongs.
const INSIDE: (i32, usize) = (16, 60);
/// A patch is taken when what is worst of it is better by this share.
const GAIN: f64 = 0.01;
/// What the mean quality of the mesh loses counts so much against what its worst cell gains.
const LOSS: f64 = 2.0;
/// Rounds of patches side by side, and patches in all: of poor cells, and of vertices put in place.
const ROUNDS: usize = 60;
const PATCHES: usize = 400;
const SEATINGS: usize = 1500;
/// No more are tried when those in vain have had so many times as many cells as the mesh: where a patch is most of the mesh, all
/// are alike.
const MOST_IN_VAIN: usize = 10;
/// Where a patch has more than one of so many cells of the mesh, those beside a cell that is given up are, too: they are in the
/// same straits, and better.
const ALIKE: usize = 5;
/// Rings around vertices that are to be put in place, and powers of the energy with the iterations of each: what is tied
/// comes first. A cell may be as poor as this then, or as poor as before.
const SEATING: [usize; 3] = [2, 3, 5];
const SEATS: [(i32, usize); 3] = [(1, 60), (2, 60), (4, 60)];
const SEATED: f64 = 0.1;
/// Rings around folded cells, round after round.
const UNFOLDING: [usize; 4] = [2, 3, 4, 6];
/// Where more than one of so many cells is folded, they are no exceptions.
const EXCEPTIONS: usize = 10;
/// Folded cells are given up, for each number of rings, when patches in vain have had so many times as many cells as the mesh.
const IN_VAIN: usize = 1;

/// What vertices are tied to while cells are improved.
pub trait Ties: Sync {
    /// The springs of a vertex that is here.
    fn springs(&self, vertex: u32, at: DVec3) -> Vec<Spring>;
    /// Whether a vertex stays where it is.
    fn is_fixed(&self, vertex: u32) -> bool;
    /// Where a vertex has to be that was moved here, if it is not free.
    fn settled(&self, vertex: u32, at: DVec3) -> Option<DVec3>;
}

impl Ties for Optimiser<'_> {
    fn springs(&self, vertex: u32, _: DVec3) -> Vec<Spring> {
        let first = self.springs.partition_point(|s| s.vertex < vertex);
        self.springs[first..].iter().take_while(|s| s.vertex == vertex).copied().collect()
    }

    fn is_fixed(&self, vertex: u32) -> bool {
        self.fixed.get(vertex as usize) == Some(&true)
    }

    fn settled(&self, _: u32, _: DVec3) -> Option<DVec3> {
        None
    }
}

/// A mesh with the cells at every vertex.
struct Mesh<'a> {
    hexes: &'a [[u32; 8]],
    offsets: Vec<u32>,
    cells: Vec<u32>,
}

impl<'a> Mesh<'a> {
    fn new(vertices: usize, hexes: &'a [[u32; 8]]) -> Self {
        let (offsets, corners) = super::corners_at(vertices, hexes);
        Mesh { hexes, offsets, cells: corners.into_iter().map(|c| c / 8).collect() }
    }

    fn at(&self, vertex: u32) -> &[u32] {
        &self.cells[self.offsets[vertex as usize] as usize..self.offsets[vertex as usize + 1] as usize]
    }

    /// A cell and those around it, in rings.
    fn around(&self, cell: u32, rings: usize) -> Vec<u32> {
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
    fn disjoint(&self, cells: impl Iterator<Item = u32>, rings: usize, most: usize) -> Vec<Vec<u32>> {
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
struct Patch {
    vertices: Vec<u32>,
    places: Vec<DVec3>,
    hexes: Vec<[u32; 8]>,
    fixed: Vec<bool>,
    /// Cells of the mesh.
    of: usize,
}

impl Patch {
    fn new(mesh: &Mesh, points: &[DVec3], cells: &[u32], ties: &impl Ties) -> Self {
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
    fn springs(&self, places: &[DVec3], ties: &impl Ties) -> Vec<Spring> {
        let own = |k: usize| {
            ties.springs(self.vertices[k], places[k]).into_iter().map(move |s| Spring { vertex: k as u32, ..s })
        };
        (0..self.vertices.len()).filter(|&k| !self.fixed[k]).flat_map(own).collect()
    }

    fn quality(&self, places: &[DVec3], cell: usize) -> f64 {
        scaled_jacobian(&self.hexes[cell].map(|v| places[v as usize]))
    }

    fn worst(&self, places: &[DVec3]) -> f64 {
        (0..self.hexes.len()).map(|h| self.quality(places, h)).fold(f64::INFINITY, f64::min)
    }

    /// What the patch adds to the mean quality of the mesh.
    fn mean(&self, places: &[DVec3]) -> f64 {
        (0..self.hexes.len()).map(|h| self.quality(places, h)).sum::<f64>() / self.of as f64
    }

    /// The least quality of the first cell, which the patch is about, and of those that have become worse. What was and stays
    /// worse than the first cell keeps nothing from being better. It is not bought with the others': where a patch is most of
    /// the mesh, that may cost more than it gives.
    fn worth(&self, places: &[DVec3]) -> f64 {
        let worse = (1..self.hexes.len()).filter_map(|h| {
            let now = self.quality(places, h);
            (now < self.quality(&self.places, h)).then_some(now)
        });
        let lost = (self.mean(&self.places) - self.mean(places)).max(0.0);
        worse.fold(self.quality(places, 0), f64::min) - LOSS * lost
    }
}

/// How the cells of a patch are made better.
enum Descent<'a> {
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
            Descent::Energy(_) => optimiser.descend(places, 0.0, INSIDE.0, INSIDE.1, context),
            Descent::Mean => optimiser.straighten(places, patch.worst(places), context),
            Descent::Corners => {
                let (beta, iterations) = SHARPER[SHARPER.len() - 1];
                optimiser.sharpen(places, beta, patch.quality(places, 0), iterations, context)
            }
        }
    }
}

/// Improves the worst cells.
pub fn relieve(points: &mut [DVec3], hexes: &[[u32; 8]], ties: &impl Ties, context: &Context) -> Result<()> {
    let mesh = Mesh::new(points.len(), hexes);
    let mut given_up = vec![false; hexes.len()];
    let (mut better, mut tried, mut in_vain) = (0, 0, 0);
    for _ in 0..ROUNDS {
        let quality = |c: usize| scaled_jacobian(&hexes[c].map(|v| points[v as usize]));
        let stuck = (0..hexes.len()).filter(|&c| given_up[c]).map(quality).fold(f64::INFINITY, f64::min);
        let mut poor: Vec<(f64, u32)> = (0..hexes.len())
            .into_par_iter()
            .filter(|&c| !given_up[c])
            .map(|c| (quality(c), c as u32))
            .filter(|c| c.0 < POOR.min(stuck + MARGIN))
            .collect();
        poor.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let patches = mesh.disjoint(poor.into_iter().map(|c| c.1), RINGS, PATCHES - tried);
        if patches.is_empty() || in_vain > MOST_IN_VAIN * hexes.len() {
            break;
        }
        tried += patches.len();
        let here = &*points;
        let ease = |cells: &Vec<u32>| eased(Patch::new(&mesh, here, cells, ties), ties, context);
        let found: Vec<_> = patches.par_iter().map(ease).collect::<Result<_>>()?;
        for (cells, found) in patches.iter().zip(found) {
            match found {
                Some(moved) => {
                    better += 1;
                    // What did not help before may do now.
                    cells.iter().for_each(|&c| given_up[c as usize] = false);
                    moved.into_iter().for_each(|(v, p)| points[v as usize] = p);
                }
                None => {
                    in_vain += cells.len();
                    let is_large = ALIKE * cells.len() > hexes.len();
                    let alike = mesh.around(cells[0], usize::from(is_large));
                    alike.into_iter().for_each(|c| given_up[c as usize] = true);
                }
            }
        }
    }
    tracing::debug!(tried, better, "patches of poor cells");
    Ok(())
}

/// Improves the worst cells, and the mean quality of all before and after that.
pub fn polish(points: &mut [DVec3], hexes: &[[u32; 8]], ties: &impl Ties, context: &Context) -> Result<()> {
    straighten(points, hexes, ties, 0.0, context)?;
    relieve(points, hexes, ties, context)?;
    straighten(points, hexes, ties, POOR, context)
}

/// Raises the mean quality of all cells where it is low, if that costs none of the least. Cells whose quality is below `held` stay.
fn straighten(points: &mut [DVec3], hexes: &[[u32; 8]], ties: &impl Ties, held: f64, context: &Context) -> Result<()> {
    let quality = |h: &[u32; 8]| scaled_jacobian(&h.map(|v| points[v as usize]));
    let before = hexes.iter().map(quality).sum::<f64>() / hexes.len() as f64;
    if before >= DULL {
        return Ok(());
    }
    let mesh = Mesh::new(points.len(), hexes);
    let all: Vec<u32> = (0..hexes.len() as u32).collect();
    let mut patch = Patch::new(&mesh, points, &all, ties);
    let poor: Vec<usize> = (0..hexes.len()).filter(|&h| patch.quality(&patch.places, h) < held).collect();
    poor.iter().flat_map(|&h| patch.hexes[h]).for_each(|v| patch.fixed[v as usize] = true);
    let Some(places) = settled(&patch, &patch.places, ties, &Descent::Mean, context)? else { return Ok(()) };
    let after = patch.mean(&places);
    let (least, now) = (patch.worst(&patch.places), patch.worst(&places));
    tracing::debug!(before, after, least, now, "mean scaled Jacobian");
    if after > before && now >= least.min(POOR) {
        patch.vertices.iter().zip(places).for_each(|(&v, p)| points[v as usize] = p);
    }
    Ok(())
}

/// The vertices of a patch where its worst cell is better; `None` where none is found.
fn eased(patch: Patch, ties: &impl Ties, context: &Context) -> Result<Option<Vec<(u32, DVec3)>>> {
    let mut best = (1.0 + GAIN) * patch.quality(&patch.places, 0);
    let mut found: Option<Vec<DVec3>> = None;
    for descent in [Descent::Energy(&POWERS), Descent::Corners] {
        let from = found.as_ref().unwrap_or(&patch.places);
        let Some(places) = settled(&patch, from, ties, &descent, context)? else { continue };
        let worth = patch.worth(&places);
        if worth > best {
            (best, found) = (worth, Some(places));
        }
    }
    Ok(found.map(|places| patch.vertices.into_iter().zip(places).collect()))
}

/// The places of a patch's vertices after the descent from some places, on what they are tied to; `None` where a cell has no
/// certificate there.
fn settled(
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
    let found = SHARES.iter().find_map(|&share| put(patch, from, ties, &optimiser, &places, share));
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
        if let Some(to) = ties.settled(patch.vertices[k], there[k]) {
            (there[k], is_tied[k]) = (to, true);
        }
    }
    optimiser.is_valid(&there).then_some((there, is_tied))
}

/// Puts vertices onto what they are tied to, each with its surroundings alone, wider and wider ones; returns those that are
/// there now, with others that have come with them.
pub fn seat(
    points: &mut [DVec3],
    hexes: &[[u32; 8]],
    ties: &impl Ties,
    stuck: &[u32],
    context: &Context,
) -> Result<FxHashSet<u32>> {
    let mesh = Mesh::new(points.len(), hexes);
    let mut seated: FxHashSet<u32> = FxHashSet::default();
    let mut tried = 0;
    for rings in SEATING {
        let mut given_up = FxHashSet::default();
        loop {
            let open = stuck.iter().filter(|v| !seated.contains(v)).filter_map(|&v| mesh.at(v).first().copied());
            let patches = mesh.disjoint(open.filter(|c| !given_up.contains(c)), rings, SEATINGS - tried);
            if patches.is_empty() {
                break;
            }
            tried += patches.len();
            let here = &*points;
            let one = |cells: &Vec<u32>| {
                let patch = Patch::new(&mesh, here, cells, ties);
                let least = SEATED.min(patch.worst(&patch.places));
                let places = settled(&patch, &patch.places, ties, &Descent::Energy(&SEATS), context)?
                    .filter(|p| patch.worst(p) >= least);
                Ok(places.map(|p| (patch, p)))
            };
            let found: Vec<_> = patches.par_iter().map(one).collect::<Result<_>>()?;
            for (cells, found) in patches.iter().zip(found) {
                given_up.insert(cells[0]);
                let Some((patch, places)) = found else {
                    given_up.extend(mesh.around(cells[0], 1));
                    continue;
                };
                for (k, &v) in patch.vertices.iter().enumerate().filter(|(k, _)| !patch.fixed[*k]) {
                    points[v as usize] = places[k];
                    seated.insert(v);
                }
            }
        }
    }
    tracing::debug!(stuck = stuck.len(), tried, seated = seated.len(), "vertices put in place with their surroundings");
    Ok(seated)
}

/// Unfolds the folded cells where they are few; whether none is left.
pub fn unfold(all: &Optimiser, points: &mut [DVec3], effort: &Effort, context: &Context) -> Result<bool> {
    let mesh = Mesh::new(points.len(), all.hexes);
    let mut folded = all.folded(points);
    if folded.len() * EXCEPTIONS > all.hexes.len() {
        return Ok(false);
    }
    for rings in UNFOLDING {
        let in_vain = unfold_patches(&mesh, all, points, &mut folded, rings, effort, context)?;
        tracing::debug!(rings, in_vain, left = folded.len(), "folded cells by patches");
        if folded.is_empty() {
            break;
        }
    }
    Ok(folded.is_empty())
}

/// Unfolds patches of so many rings around folded cells; how many cells those had that stay folded.
fn unfold_patches(
    mesh: &Mesh,
    all: &Optimiser,
    points: &mut [DVec3],
    folded: &mut Vec<u32>,
    rings: usize,
    effort: &Effort,
    context: &Context,
) -> Result<usize> {
    let (mut given_up, mut in_vain) = (FxHashSet::default(), 0);
    while in_vain < IN_VAIN * all.hexes.len() {
        let open = folded.iter().copied().filter(|c| !given_up.contains(c));
        let mut patches = mesh.disjoint(open, rings, usize::MAX);
        // Most of the mesh is no patch of it: all of it has been tried, or will be.
        patches.retain(|cells| 2 * cells.len() <= all.hexes.len());
        if patches.is_empty() {
            break;
        }
        let here = &*points;
        let one = |cells: &Vec<u32>| unfolded(all, &Patch::new(mesh, here, cells, all), cells, effort, context);
        let found: Vec<_> = patches.par_iter().map(one).collect::<Result<_>>()?;
        for (cells, found) in patches.iter().zip(found) {
            match found {
                Some(moved) => moved.into_iter().for_each(|(v, p)| points[v as usize] = p),
                None => {
                    in_vain += cells.len();
                    given_up.insert(cells[0]);
                }
            }
        }
        *folded = all.folded(points);
    }
    Ok(in_vain)
}

/// The vertices of a patch without a folded cell; `None` where that is not reached.
fn unfolded(
    all: &Optimiser,
    patch: &Patch,
    cells: &[u32],
    effort: &Effort,
    context: &Context,
) -> Result<Option<Vec<(u32, DVec3)>>> {
    let mut optimiser = Optimiser::new(&patch.places, &patch.hexes);
    optimiser.inverse = cells.iter().map(|&c| all.inverse[c as usize]).collect();
    optimiser.fix(patch.fixed.clone());
    optimiser.tie(patch.springs(&patch.places, all));
    let mut places = patch.places.clone();
    let is_valid = optimiser.untangle(&mut places, effort, context)? && optimiser.least(&places) > VALID;
    Ok(is_valid.then(|| patch.vertices.iter().copied().zip(places).collect()))
}

#[cfg(test)]
mod tests {
    use super::super::FINE;
    use super::*;
    use crate::mesh::test_models::bricks;

    const SIDE: u32 = 13;

    /// A block of cubes, its boundary held.
    fn block() -> (Vec<DVec3>, Vec<[u32; 8]>, Vec<bool>) {
        let (points, hexes) = bricks([SIDE; 3]);
        let is_held = |p: &DVec3| p.to_array().iter().any(|&x| x == 0.0 || x == f64::from(SIDE));
        let fixed = points.iter().map(is_held).collect();
        (points, hexes, fixed)
    }

    fn held<'a>(hexes: &'a [[u32; 8]], straight: &[DVec3], fixed: &[bool]) -> Optimiser<'a> {
        let mut optimiser = Optimiser::new(straight, hexes);
        optimiser.fix(fixed.to_vec());
        optimiser
    }

    #[test]
    fn a_fold_is_undone_where_it_is_and_nothing_else_moves() {
        let (straight, hexes, fixed) = block();
        let mut points = straight.clone();
        let n = (SIDE + 1) as usize;
        let middle = (6 * n + 6) * n + 6;
        points[middle] += DVec3::new(1.7, 0.2, -0.3);
        let optimiser = held(&hexes, &straight, &fixed);
        assert!(!optimiser.folded(&points).is_empty());
        assert!(unfold(&optimiser, &mut points, &FINE, &Context::new()).unwrap());
        assert!(optimiser.is_valid(&points) && uncertified(&points, &hexes).is_empty());
        let far = |v: &usize| straight[*v].distance(straight[middle]) > 12.0;
        assert!((0..points.len()).filter(far).all(|v| points[v] == straight[v]));
    }

    #[test]
    fn where_everything_is_folded_patches_are_no_help() {
        let (straight, hexes, fixed) = block();
        let mut points: Vec<DVec3> = straight.iter().map(|p| DVec3::new(-p.x, p.y, p.z)).collect();
        let before = points.clone();
        assert!(!unfold(&held(&hexes, &straight, &fixed), &mut points, &FINE, &Context::new()).unwrap());
        assert_eq!(points, before);
    }

    /// Every other cell of a bar is folded by vertices that are held: work in vain ends when it has been as much as the mesh, and
    /// where patches are most of the mesh there is none.
    #[test]
    fn what_cannot_be_unfolded_is_given_up() {
        for (length, most) in [(400u32, 2 * 400), (5, 0)] {
            let (straight, hexes) = bricks([length, 1, 1]);
            let mut points = straight.clone();
            (5..length - 5).step_by(12).for_each(|k| points[k as usize].x += 1.5);
            if most == 0 {
                points[2].x += 1.5;
            }
            let optimiser = held(&hexes, &straight, &vec![true; points.len()]);
            let mut folded = optimiser.folded(&points);
            assert!(!folded.is_empty());
            let before = points.clone();
            let mesh = Mesh::new(points.len(), &hexes);
            let in_vain =
                unfold_patches(&mesh, &optimiser, &mut points, &mut folded, 6, &FINE, &Context::new()).unwrap();
            assert!(in_vain <= most && (most == 0 || in_vain >= 400), "{in_vain}");
            assert_eq!(points, before);
        }
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

    /// The top of the block is tied to its plane, the rest of the boundary held.
    struct Top<'a>(&'a [DVec3], &'a [bool]);

    impl Top<'_> {
        fn has(&self, v: u32) -> bool {
            let p = self.0[v as usize];
            p.z == f64::from(SIDE) && [p.x, p.y].iter().all(|x| *x > 0.0 && *x < f64::from(SIDE))
        }
    }

    impl Ties for Top<'_> {
        fn springs(&self, vertex: u32, at: DVec3) -> Vec<Spring> {
            let to = self.settled(vertex, at);
            let spring = |to| Spring { vertex, to, normal: DVec3::Z, along: 1000.0, across: 1e-3 };
            to.map(spring).into_iter().collect()
        }

        fn is_fixed(&self, vertex: u32) -> bool {
            self.1[vertex as usize] && !self.has(vertex)
        }

        fn settled(&self, vertex: u32, at: DVec3) -> Option<DVec3> {
            self.has(vertex).then(|| DVec3::new(at.x, at.y, f64::from(SIDE)))
        }
    }

    #[test]
    fn a_vertex_off_its_plane_is_put_there_with_its_surroundings() {
        let (straight, hexes, fixed) = block();
        let top = Top(&straight, &fixed);
        let n = (SIDE + 1) as usize;
        let vertex = (SIDE as usize * n + 6) * n + 6;
        let mut points = straight.clone();
        points[vertex] += DVec3::new(0.1, 0.05, -0.4);
        let seated = seat(&mut points, &hexes, &top, &[vertex as u32], &Context::new()).unwrap();
        assert!(seated.contains(&(vertex as u32)) && points[vertex].z == f64::from(SIDE));
        assert!(uncertified(&points, &hexes).is_empty());
        let far = |v: &usize| straight[*v].distance(straight[vertex]) > 7.0;
        assert!((0..points.len()).filter(far).all(|v| points[v] == straight[v]));
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

    #[test]
    fn poor_cells_become_better_and_what_is_held_stays() {
        let (straight, hexes, fixed) = block();
        let mut points = straight.clone();
        for (v, p) in points.iter_mut().enumerate().filter(|(v, _)| !fixed[*v]) {
            // Waves without a common period shear some cells much, and most a little.
            let t = v as f64;
            *p += 0.34 * DVec3::new((1.7 * t).sin(), (2.3 * t).cos(), (0.9 * t).sin());
        }
        let optimiser = held(&hexes, &straight, &fixed);
        assert!(optimiser.is_valid(&points));
        let worst = |points: &[DVec3]| optimiser.qualities(points).into_iter().fold(f64::INFINITY, f64::min);
        let (before, start) = (worst(&points), points.clone());
        assert!(before < POOR);
        relieve(&mut points, &hexes, &optimiser, &Context::new()).unwrap();
        assert!(worst(&points) > before.max(0.25), "{before} {}", worst(&points));
        assert!((0..points.len()).filter(|&v| fixed[v]).all(|v| points[v] == start[v]));
        assert!(uncertified(&points, &hexes).is_empty());
    }
}
