//! The border loops of a surface.

use crate::mesh::{CornerId, Side, SurfaceMesh};
use rustc_hash::FxHashSet;

/// A closed walk along the border.
pub struct Loop {
    /// The corners that its half-edges leave, in the sense of the faces.
    pub corners: Vec<u32>,
    /// Every vertex comes once, and there are at least three.
    pub simple: bool,
}

/// All loops, in the order of their first half-edges: from each to the next around the vertex where it ends.
pub fn loops(mesh: &SurfaceMesh) -> Vec<Loop> {
    let is_border = |c: CornerId| mesh.side(c) == Side::Border;
    let mut seen = vec![false; mesh.corner_count()];
    let mut loops = Vec::new();
    for start in (0..mesh.corner_count()).map(CornerId::new).filter(|&c| is_border(c)) {
        if seen[start.index()] {
            continue;
        }
        let (mut corners, mut at, mut is_closed) = (Vec::new(), start, true);
        loop {
            seen[at.index()] = true;
            corners.push(at.0);
            match next_on_border(mesh, at) {
                Some(next) if next == start => break,
                Some(next) if !seen[next.index()] => at = next,
                _ => {
                    is_closed = false;
                    break;
                }
            }
        }
        let mut vertices = FxHashSet::default();
        let simple =
            is_closed && corners.len() >= 3 && corners.iter().all(|&c| vertices.insert(mesh.vertex(CornerId(c))));
        loops.push(Loop { corners, simple });
    }
    loops
}

/// The next half-edge of the border; none where the faces around the vertex are not regular.
fn next_on_border(mesh: &SurfaceMesh, c: CornerId) -> Option<CornerId> {
    let mut at = mesh.next(c);
    for _ in 0..mesh.corner_count() {
        match mesh.side(at) {
            Side::Border => return Some(at),
            Side::Inner(across) => at = mesh.next(across),
            _ => return None,
        }
    }
    None
}
