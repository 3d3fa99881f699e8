//! Rows of flat strips: a curved surface was tessellated, then its triangles were subdivided without moving them onto the
//! surface. What is left of it are planes that share most of their border with each other, at bends that are no creases:
//!
//! ```text
//!   ╲_______╱‾‾‾‾‾‾‾╲_______╱       inner strips have a smooth neighbour on both long sides, outer ones on one
//!    outer    inner    outer
//! ```

use super::surface::Surface;
use crate::mesh::NONE;
use std::ops::Range;

/// A share of the border of an inner strip that is smooth: more than half, because both long sides are.
const SMOOTH_BORDER: f64 = 0.5;
/// A count: fewest inner strips of a row, because two planes at a small bend are some faces of a part.
const ROW_STRIPS: usize = 3;
/// Multiple of the area of the inner strip beside it that an outer one is smaller than, because planes of the part are
/// larger.
const OUTER_AREA: f64 = 3.0;
/// A share of the total area that fragments are smaller than, because larger planes are faces.
const FRAGMENT_AREA: f64 = 2e-3;

/// Which of the labels are in rows of strips. `is_plane` says which labels are planes, and smooth edges bend by an angle in
/// `bends`, in radians.
pub fn rows(surface: &Surface<'_>, label: &[u32], is_plane: &[bool], bends: &Range<f64>) -> Vec<bool> {
    let borders = Borders::new(surface, label, is_plane, bends);
    let inner: Vec<bool> = (0..is_plane.len()).map(|l| borders.smooth[l] > SMOOTH_BORDER * borders.all[l]).collect();
    let mut strip = vec![false; is_plane.len()];
    let mut seen = vec![false; is_plane.len()];
    for seed in (0..is_plane.len() as u32).filter(|&l| inner[l as usize]) {
        if std::mem::replace(&mut seen[seed as usize], true) {
            continue;
        }
        let mut row = vec![seed];
        let mut k = 0;
        while k < row.len() {
            for next in borders.neighbours(row[k]).filter(|&l| inner[l as usize]) {
                if !std::mem::replace(&mut seen[next as usize], true) {
                    row.push(next);
                }
            }
            k += 1;
        }
        if row.len() < ROW_STRIPS {
            continue;
        }
        for &l in &row {
            strip[l as usize] = true;
            let outer = |n: &u32| borders.area[*n as usize] < OUTER_AREA * borders.area[l as usize];
            borders.neighbours(l).filter(outer).for_each(|n| strip[n as usize] = true);
        }
    }
    strip
}

/// Which of the labels are small planes with most of their border towards a free surface: pieces of strips that are a part of
/// it.
pub fn fragments(surface: &Surface<'_>, label: &[u32], is_plane: &[bool], bends: &Range<f64>) -> Vec<bool> {
    let borders = Borders::new(surface, label, is_plane, bends);
    let small = |l: usize| borders.area[l] < FRAGMENT_AREA * surface.total_area;
    (0..is_plane.len()).map(|l| borders.free[l] > SMOOTH_BORDER * borders.all[l] && small(l)).collect()
}

/// What the planes have in common.
struct Borders {
    /// Length of the border of every plane, and of the smooth part of it that is shared with planes.
    all: Vec<f64>,
    smooth: Vec<f64>,
    /// Length of the smooth part that is shared with triangles without label.
    free: Vec<f64>,
    area: Vec<f64>,
    /// Planes that share smooth edges, both ways, sorted.
    pairs: Vec<[u32; 2]>,
}

impl Borders {
    fn new(surface: &Surface<'_>, label: &[u32], is_plane: &[bool], bends: &Range<f64>) -> Self {
        let plane = |l: u32| l != NONE && is_plane[l as usize];
        let zeros = || vec![0.0; is_plane.len()];
        let mut out = Borders { all: zeros(), smooth: zeros(), free: zeros(), area: zeros(), pairs: Vec::new() };
        for (t, &own) in label.iter().enumerate().filter(|(_, l)| plane(**l)) {
            out.area[own as usize] += surface.areas[t];
            for c in 3 * t as u32..3 * t as u32 + 3 {
                let o = surface.triangles.opposite(c);
                let other = if o == NONE { NONE } else { label[o as usize / 3] };
                if other == own {
                    continue;
                }
                let length = surface.edge_length(c);
                out.all[own as usize] += length;
                if o == NONE || !bends.contains(&f64::from(surface.bend[c as usize])) {
                    continue;
                }
                if plane(other) {
                    out.smooth[own as usize] += length;
                    out.pairs.push([own, other]);
                } else if other == NONE {
                    out.free[own as usize] += length;
                }
            }
        }
        out.pairs.sort_unstable();
        out.pairs.dedup();
        out
    }

    fn neighbours(&self, l: u32) -> impl Iterator<Item = u32> {
        let from = self.pairs.partition_point(|p| p[0] < l);
        self.pairs[from..].iter().take_while(move |p| p[0] == l).map(|p| p[1])
    }
}
