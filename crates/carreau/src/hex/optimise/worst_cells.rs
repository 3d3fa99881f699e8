//! Improves the worst cells, each with its surroundings only, and then the mean quality of all cells.

use super::patches::{Descent, Mesh, Patch, Ties, descended};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::hexes::scaled_jacobian;
use glam::DVec3;
use rayon::prelude::*;

/// Cells with a lower scaled Jacobian are worked on.
const POOR_CELL: f64 = 0.5;
/// But not those that are better by this than one that was given up: the least of the mesh would stay.
const MARGIN: f64 = 0.1;
/// The mean is raised where it is lower than this: where it is not, that would cost twice the time of all else for .005.
const DULL: f64 = 0.93;
/// Rings of cells around a poor one.
const POOR_RINGS: usize = 5;
/// Powers of the energy in turn, with the iterations of each.
const POWERS: [(i32, usize); 3] = [(4, 40), (8, 80), (16, 80)];
/// A patch is taken when what is worst of it is better by this share.
const GAIN: f64 = 0.01;
/// Most rounds of patches side by side.
const RELIEF_ROUNDS: usize = 60;
/// Most patches in all rounds together.
const PATCHES: usize = 400;
/// Work in vain ends when the patches tried have had this many times as many cells as the mesh.
const MOST_IN_VAIN: usize = 10;
/// On small meshes (a patch exceeds one over this of the mesh) the neighbours of a skipped cell are skipped as well:
/// they would fail the same way.
const ALIKE: usize = 5;

/// Improves the worst cells.
pub fn relieve(points: &mut [DVec3], hexes: &[[u32; 8]], ties: &impl Ties, context: &Context) -> Result<()> {
    let mesh = Mesh::new(points.len(), hexes);
    let mut given_up = vec![false; hexes.len()];
    let (mut better, mut tried, mut in_vain) = (0, 0, 0);
    for _ in 0..RELIEF_ROUNDS {
        let quality = |c: usize| scaled_jacobian(&hexes[c].map(|v| points[v as usize]));
        let stuck = (0..hexes.len()).filter(|&c| given_up[c]).map(quality).fold(f64::INFINITY, f64::min);
        let mut poor: Vec<(f64, u32)> = (0..hexes.len())
            .into_par_iter()
            .filter(|&c| !given_up[c])
            .map(|c| (quality(c), c as u32))
            .filter(|c| c.0 < POOR_CELL.min(stuck + MARGIN))
            .collect();
        poor.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let patches = mesh.disjoint(poor.into_iter().map(|c| c.1), POOR_RINGS, PATCHES - tried);
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
    straighten(points, hexes, ties, POOR_CELL, context)
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
    let Some(places) = descended(&patch, &patch.places, ties, &Descent::Mean, context)? else { return Ok(()) };
    let after = patch.mean(&places);
    let (least, now) = (patch.worst(&patch.places), patch.worst(&places));
    tracing::debug!(before, after, least, now, "mean scaled Jacobian");
    if after > before && now >= least.min(POOR_CELL) {
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
        let Some(places) = descended(&patch, from, ties, &descent, context)? else { continue };
        let worth = patch.worth(&places);
        if worth > best {
            (best, found) = (worth, Some(places));
        }
    }
    Ok(found.map(|places| patch.vertices.into_iter().zip(places).collect()))
}

#[cfg(test)]
mod tests {
    use super::super::patches::tests::{block, held};
    use super::*;
    use crate::geometry::hexes::uncertified;

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
        assert!(before < POOR_CELL);
        relieve(&mut points, &hexes, &optimiser, &Context::new()).unwrap();
        assert!(worst(&points) > before.max(0.25), "{before} {}", worst(&points));
        assert!((0..points.len()).filter(|&v| fixed[v]).all(|v| points[v] == start[v]));
        assert!(uncertified(&points, &hexes).is_empty());
    }
}
