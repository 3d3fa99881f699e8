//! The z-buffer: which triangle is nearest to the eye at every sample of a band of rows.

use super::camera::Seen;
use super::scene::Scene;

/// No triangle.
pub(super) const NOTHING: u32 = u32::MAX;

/// A band of rows of samples.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rows {
    /// The first row.
    pub(super) first: usize,
    /// Number of rows.
    pub(super) count: usize,
    /// Rows before the first and after the last for which depth is kept too: lines look at their neighbourhood.
    pub(super) apron: usize,
}

/// Nearness and triangle at every sample of a band, apron included.
pub(super) struct Depth {
    pub(super) rows: Rows,
    pub(super) width: usize,
    nearness: Vec<f32>,
    triangle: Vec<u32>,
}

impl Depth {
    /// The triangles of a row of samples of the image, [`NOTHING`] where there is none.
    pub(super) fn triangles(&self, row: usize) -> &[u32] {
        let start = (row + self.rows.apron - self.rows.first) * self.width;
        &self.triangle[start..start + self.width]
    }

    /// Nearness at a sample; negative infinity where there is no triangle, outside the image and outside the band.
    pub(super) fn nearness(&self, x: i64, y: i64) -> f32 {
        let row = y + self.rows.apron as i64 - self.rows.first as i64;
        let inside = (0..self.width as i64).contains(&x) && row >= 0;
        let at = || self.nearness.get(row as usize * self.width + x as usize).copied();
        inside.then(at).flatten().unwrap_or(f32::NEG_INFINITY)
    }
}

/// The triangles that touch each band, in ascending order.
pub(super) struct Bins {
    offsets: Vec<u32>,
    triangles: Vec<u32>,
}

impl Bins {
    /// Sorts the triangles into bands of this many rows, aprons included.
    pub(super) fn new(scene: &Scene, bands: usize, rows: usize, apron: usize) -> Self {
        let touched = |t: usize| {
            let y = scene.corners(t).map(|c| c.y);
            let low = y.into_iter().fold(f64::INFINITY, f64::min) - apron as f64;
            let high = y.into_iter().fold(f64::NEG_INFINITY, f64::max) + apron as f64;
            // `as` saturates at zero.
            let band = |y: f64| ((y / rows as f64) as usize).min(bands - 1);
            band(low)..band(high) + 1
        };
        let mut offsets = vec![0u32; bands + 1];
        for t in 0..scene.triangles.len() {
            touched(t).for_each(|b| offsets[b + 1] += 1);
        }
        for b in 0..bands {
            offsets[b + 1] += offsets[b];
        }
        let mut fill = offsets.clone();
        let mut triangles = vec![0; offsets[bands] as usize];
        for t in 0..scene.triangles.len() {
            for b in touched(t) {
                triangles[fill[b] as usize] = t as u32;
                fill[b] += 1;
            }
        }
        Bins { offsets, triangles }
    }

    /// The triangles of a band.
    pub(super) fn of(&self, band: usize) -> &[u32] {
        &self.triangles[self.offsets[band] as usize..self.offsets[band + 1] as usize]
    }
}

/// Draws these triangles into a band of an image of `size` samples.
pub(super) fn rasterise(scene: &Scene, triangles: &[u32], size: [usize; 2], rows: Rows) -> Depth {
    let count = (rows.count + 2 * rows.apron) * size[0];
    let mut depth =
        Depth { rows, width: size[0], nearness: vec![f32::NEG_INFINITY; count], triangle: vec![NOTHING; count] };
    for &t in triangles {
        draw(&mut depth, t, scene.corners(t as usize));
    }
    depth
}

/// Draws one triangle row by row.
///
/// ```text
///      a              corners sorted by height: each row lies between the long side a–c
///     ╱ ╲             and one of the short sides a–b, b–c
///    ╱   ╲ row
///   ╱─────b
///  c╌╌╌╌╌╌
/// ```
///
/// Both triangles at an edge compute its crossings with the rows from the same sorted ends, so no sample is lost between
/// them. Of two equally near triangles the first is kept.
fn draw(depth: &mut Depth, triangle: u32, mut corners: [Seen; 3]) {
    corners.sort_by(|p, q| p.y.total_cmp(&q.y).then(p.x.total_cmp(&q.x)));
    let [a, b, c] = corners;
    let Some(slope) = slope(a, b, c) else { return };
    let least = a.nearness.min(b.nearness).min(c.nearness);
    let most = a.nearness.max(b.nearness).max(c.nearness);
    let first_row = depth.rows.first as f64 - depth.rows.apron as f64;
    let last_row = first_row + (depth.nearness.len() / depth.width) as f64 - 1.0;
    let top = (a.y - 0.5).ceil().max(first_row);
    let bottom = (c.y - 0.5).floor().min(last_row);
    let mut row = top;
    while row <= bottom {
        let y = row + 0.5;
        let long = crossing(a, c, y);
        let short = if y < b.y { crossing(a, b, y) } else { crossing(b, c, y) };
        let left = (long.min(short) - 0.5).ceil().max(0.0);
        let right = (long.max(short) - 0.5).floor().min(depth.width as f64 - 1.0);
        let start = (row - first_row) as usize * depth.width;
        let mut nearness = a.nearness + slope[0] * (left + 0.5 - a.x) + slope[1] * (y - a.y);
        // An empty row has left > right, also if both are beyond the image.
        for x in left as usize..(right + 1.0).max(left) as usize {
            let value = nearness.clamp(least, most) as f32;
            if value > depth.nearness[start + x] {
                depth.nearness[start + x] = value;
                depth.triangle[start + x] = triangle;
            }
            nearness += slope[0];
        }
        row += 1.0;
    }
}

/// Change of nearness per sample to the right and down; `None` for a triangle seen edge-on.
fn slope(a: Seen, b: Seen, c: Seen) -> Option<[f64; 2]> {
    let (ux, uy, un) = (b.x - a.x, b.y - a.y, b.nearness - a.nearness);
    let (vx, vy, vn) = (c.x - a.x, c.y - a.y, c.nearness - a.nearness);
    let area = ux * vy - uy * vx;
    let slope = [(un * vy - uy * vn) / area, (ux * vn - un * vx) / area];
    slope.iter().all(|s| s.is_finite()).then_some(slope)
}

/// Where the side from `p` down to `q` crosses the height `y`.
fn crossing(p: Seen, q: Seen, y: f64) -> f64 {
    if q.y > p.y { p.x + (q.x - p.x) * ((y - p.y) / (q.y - p.y)).clamp(0.0, 1.0) } else { p.x }
}
