//! Untangles folded cells, each with its surroundings only.

use super::effort::Effort;
use super::optimiser::Optimiser;
use super::patches::{Mesh, Patch};
use super::tuning::VALID;
use crate::context::Context;
use crate::error::Result;
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashSet;

/// Rings around folded cells, round after round.
const UNFOLDING: [usize; 4] = [2, 3, 4, 6];
/// If more than one cell of this many is folded, folded cells are no exceptions, and the whole mesh is untangled.
const EXCEPTIONS: usize = 10;
/// For each number of rings, folded cells are given up when the patches that failed have had this many times as many cells as the
/// mesh.
const IN_VAIN: usize = 1;

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

/// Unfolds patches of a number of rings around folded cells. Returns how many cells those patches had that stay folded.
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
    use super::super::effort::FINE;
    use super::super::patches::tests::{SIDE, block, held};
    use super::*;
    use crate::geometry::hexes::uncertified;
    use crate::mesh::test_models::bricks;

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
}
