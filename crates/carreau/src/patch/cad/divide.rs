//! Curved cells of the patches as blocks without bends: divided along grid lines, down to single cells where needed.
//!
//! Programs integrate over a face as if it were smooth. A surface of degree (1, 1) with a kink inside therefore weighs
//! wrong, and so it is divided there:
//!
//! ```text
//!   ┌──┬──┬──┬──┐      ┌──┬──┐ ┌──┬──┐
//!   │  │  ║  │  │  →   │  │  │ │  │  │     ║ a bend
//!   └──┴──┴──┴──┘      └──┴──┘ └──┴──┘
//! ```

use super::exact;
use super::piece::Block;
use super::scene::Scene;
use super::weigh;
use crate::brep::Surface;
use crate::error::Result;
use crate::geometry::bspline::{BSplineSurface, Knots};
use glam::DVec3;

/// Largest angle inside a face by which it may bend from cell to cell, by its cosine (half a degree). The rule of
/// [`weigh`] is checked besides.
const CELL_BEND: f64 = 0.999_962;

/// Cells of a bicubic face meet at less than this, by the cosine (30°).
const CELL_CREASE: f64 = 0.866;

/// Cuts a patch into blocks of curved cells of one kind that do not bend and that weigh right; `kind` says `None` of cells
/// that are no part of any.
pub fn divide(scene: &Scene, patch: u32, kind: &dyn Fn(u32, u32) -> Option<u32>) -> Result<Vec<Block>> {
    let whole = &scene.patches[patch as usize];
    let mut open = vec![Block { patch, from: [0, 0], size: [whole.rows, whole.cols] }];
    let mut out = Vec::new();
    while let Some(block) = open.pop() {
        let [m, n] = block.size;
        let kind = |r: u32, c: u32| kind(block.from[0] + r, block.from[1] + c);
        let bends = |axis: usize, at: u32, along: u32| bends(scene, &block, [axis as u32, at, along], CELL_BEND);
        let bad = |axis: usize, at: u32| {
            (0..block.size[1 - axis]).any(|along| {
                let [before, behind] = [at - 1, at].map(|k| if axis == 0 { kind(k, along) } else { kind(along, k) });
                before != behind || before.is_some() && bends(axis, at, along)
            })
        };
        let [rows, columns] =
            [0, 1].map(|axis| (1..block.size[axis]).filter(|&at| bad(axis, at)).collect::<Vec<u32>>());
        let share = |lines: &[u32], of: u32| lines.len() as f64 / f64::from(of);
        if rows.is_empty() && columns.is_empty() {
            if kind(0, 0).is_none() {
                continue;
            }
            if m * n == 1 || weighs_right(scene, block)? {
                out.push(block);
            } else {
                let axis = usize::from(n > m);
                open.extend(block.cut(axis, block.size[axis] / 2).into_iter().rev());
            }
        } else if share(&rows, m) >= share(&columns, n) {
            open.extend(cut_at(block, 0, &rows).into_iter().rev());
        } else {
            open.extend(cut_at(block, 1, &columns).into_iter().rev());
        }
    }
    Ok(out)
}

/// The parts of a block between some of its lines.
fn cut_at(block: Block, axis: usize, lines: &[u32]) -> Vec<Block> {
    let mut out = Vec::new();
    let mut rest = block;
    let mut done = 0;
    for &at in lines {
        let [low, high] = rest.cut(axis, at - done);
        out.push(low);
        (rest, done) = (high, at);
    }
    out.push(rest);
    out
}

/// Whether the cells on both sides of a grid edge meet at an angle, at one of its ends at least.
///
/// ```text
///   p₊ ─ q₊      axis 0: the edge p q between two rows; (q − p) × (p − p₋) and (q − p) × (p₊ − p) are the
///   p ── q       normals of the cells at p
///   p₋ ─ q₋
/// ```
fn bends(scene: &Scene, block: &Block, [axis, at, along]: [u32; 3], least: f64) -> bool {
    let node = |k: u32, l: u32| {
        let (r, c) = if axis == 0 { (k, l) } else { (l, k) };
        scene.point(block.vertex(scene.patches, r, c))
    };
    let edge = node(at, along + 1) - node(at, along);
    [along, along + 1].into_iter().any(|l| {
        let [low, p, high] = [at - 1, at, at + 1].map(|k| node(k, l));
        let [a, b]: [DVec3; 2] = [edge.cross(p - low), edge.cross(high - p)];
        a.dot(b) < least * a.length() * b.length()
    })
}

/// Whether cells of a block meet at a crease.
pub fn is_creased(scene: &Scene, block: &Block) -> bool {
    let lines = (0..2).flat_map(|axis| (1..block.size[axis]).map(move |at| (axis, at)));
    let mut edges = lines.flat_map(|(axis, at)| (0..block.size[1 - axis]).map(move |along| [axis as u32, at, along]));
    edges.any(|edge| bends(scene, block, edge, CELL_CREASE))
}

fn weighs_right(scene: &Scene, block: Block) -> Result<bool> {
    let under = exact::block_by_length(scene, block)?;
    let right: Vec<Vec<f64>> =
        under.border.iter().flat_map(|[_, right, ..]| right.windows(2)).map(<[f64]>::to_vec).collect();
    Ok(matches!(under.surface, Surface::Spline(surface) if weigh::is_right(&surface, &right)))
}

/// Whether the rule is right on a single cell, whichever corner comes first. It is where no two corner normals are more than
/// 60° apart.
pub fn cell_weighs_right(corners: [DVec3; 4]) -> bool {
    let normal = |k: usize| (corners[(k + 1) % 4] - corners[k]).cross(corners[(k + 3) % 4] - corners[k]);
    let normals = [0, 1, 2, 3].map(normal);
    let apart = |a: DVec3, b: DVec3| a.dot(b) < 0.5 * a.length() * b.length();
    if !(0..4).any(|k| (0..k).any(|j| apart(normals[j], normals[k]))) {
        return true;
    }
    // The rule is another one across and along; half a turn changes nothing.
    let [a, b, c, d] = corners;
    [[a, b, d, c], [b, c, a, d]].into_iter().all(|net| {
        let surface = BSplineSurface::new(Knots::index(1), Knots::index(1), net.to_vec());
        surface.is_ok_and(|surface| weigh::is_right(&surface, &[vec![0.0, 1.0]]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rule has more points one way than the other on some cells: patches and models ask from different corners.
    #[test]
    fn whether_a_cell_weighs_right_does_not_depend_on_its_first_corner() {
        let side = |k: u32, m: u32| f64::from((k * m) % 29) / 29.0;
        let mut judged = [0; 2];
        for k in 0..2000u32 {
            let lifted = |x: f64, y: f64, m: u32| DVec3::new(x, y, 3.0 * side(k, m) - 1.5);
            let cell =
                [lifted(0.0, 0.0, 7), lifted(1.0, 0.0, 11), lifted(1.2 - side(k, 3), 1.0, 13), lifted(0.0, 1.0, 5)];
            let found: Vec<bool> = (0..4)
                .map(|turn| {
                    let mut turned = cell;
                    turned.rotate_left(turn);
                    cell_weighs_right(turned)
                })
                .collect();
            assert!(found.iter().all(|f| *f == found[0]), "{cell:?} {found:?}");
            judged[usize::from(found[0])] += 1;
        }
        assert!(judged.iter().all(|&n| n > 100), "{judged:?}");
    }
}
