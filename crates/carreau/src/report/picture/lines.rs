//! Lines: round strokes with smooth edges, hidden by nearer faces.

use super::camera::{Camera, Seen};
use super::color::{Linear, linear, mix};
use super::content::{Path, Picture};
use super::raster::Depth;
use super::tuning::SAMPLES;

/// How much farther than a face a line may be, as a share of its distance, and still be seen: lines on the surface are.
const BIAS: f64 = 2e-4;

/// A layer of lines in the image.
pub(super) struct Strokes {
    color: Linear,
    opacity: f32,
    /// Half the width in samples.
    radius: f64,
    hidden: bool,
    segments: Vec<[Seen; 2]>,
}

/// The lines of a picture in the image.
pub(super) fn strokes(picture: &Picture<'_>, camera: &Camera) -> Vec<Strokes> {
    let layer = |layer: &super::content::Lines<'_>| {
        let point = |v: u32| picture.points.get(v as usize).copied();
        let pairs: Vec<_> = match layer.path {
            Path::Edges(edges) => edges.iter().filter_map(|&[a, b]| Some([point(a)?, point(b)?])).collect(),
            Path::Segments(segments) => segments.to_vec(),
        };
        let finite = pairs.into_iter().filter(|pair| pair.iter().all(|p| p.is_finite()));
        Strokes {
            color: linear(layer.color),
            opacity: if layer.opacity > 0.0 { layer.opacity.min(1.0) as f32 } else { 0.0 },
            radius: radius(layer.width),
            hidden: layer.hidden,
            segments: finite.map(|pair| pair.map(|p| camera.see(p))).collect(),
        }
    };
    picture.lines.iter().map(layer).collect()
}

/// Half the width in samples, between none and a very broad line.
fn radius(width: f64) -> f64 {
    width.clamp(0.0, 200.0) * SAMPLES as f64 / 2.0
}

/// Rows of depth that lines need around a band: their half width, and the neighbours of a sample.
pub(super) fn apron(picture: &Picture<'_>) -> usize {
    let widest = picture.lines.iter().map(|l| radius(l.width)).fold(0.0, f64::max);
    if picture.lines.is_empty() { 0 } else { widest.ceil() as usize + 3 }
}

/// Draws all layers over the colours of a band.
pub(super) fn draw(layers: &[Strokes], depth: &Depth, colors: &mut [Linear]) {
    let mut cover = vec![0f32; colors.len()];
    for layer in layers {
        // The cover of a layer is the largest of its strokes, so that joints and crossings look like one stroke.
        cover.fill(0.0);
        for &segment in &layer.segments {
            stroke(layer, segment, depth, &mut cover);
        }
        for (color, &share) in colors.iter_mut().zip(&cover) {
            if share > 0.0 {
                *color = mix(*color, layer.color, share * layer.opacity);
            }
        }
    }
}

/// Adds the cover of one stroke: all samples within the radius of the segment.
fn stroke(layer: &Strokes, [p, q]: [Seen; 2], depth: &Depth, cover: &mut [f32]) {
    let reach = layer.radius + 0.5;
    let (first, end) = (depth.rows.first, depth.rows.first + depth.rows.count);
    let top = ((p.y.min(q.y) - reach - 0.5).ceil().max(first as f64)) as usize;
    let bottom = (p.y.max(q.y) + reach - 0.5).floor().min(end as f64 - 1.0);
    let (dx, dy) = (q.x - p.x, q.y - p.y);
    let square = dx * dx + dy * dy;
    let mut row = top;
    while (row as f64) <= bottom {
        let y = row as f64 + 0.5;
        let [left, right] = reached([p, q], y, reach);
        let left = (left - 0.5).ceil().max(0.0) as usize;
        let right = (right + 0.5).floor().clamp(0.0, depth.width as f64) as usize;
        for x in left..right {
            let (ex, ey) = (x as f64 + 0.5 - p.x, y - p.y);
            let along = if square > 0.0 { ((ex * dx + ey * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
            let distance = (ex - along * dx).hypot(ey - along * dy);
            let share = (reach - distance).clamp(0.0, 1.0).min(2.0 * layer.radius) as f32;
            let slot = &mut cover[(row - first) * depth.width + x];
            if share > *slot && (!layer.hidden || is_seen(depth, at([p, q], along))) {
                *slot = share;
            }
        }
        row += 1;
    }
}

/// The point of a segment at a share of its length in the image.
fn at([p, q]: [Seen; 2], along: f64) -> Seen {
    let lerp = |a: f64, b: f64| a + (b - a) * along;
    Seen { x: lerp(p.x, q.x), y: lerp(p.y, q.y), nearness: lerp(p.nearness, q.nearness) }
}

/// The part of a row at height `y` that may be closer to a segment than `reach`.
fn reached([p, q]: [Seen; 2], y: f64, reach: f64) -> [f64; 2] {
    let x_at = |height: f64| {
        let along = if q.y == p.y { 0.0 } else { (height - p.y) / (q.y - p.y) };
        p.x + (q.x - p.x) * along.clamp(0.0, 1.0)
    };
    let ends = if p.y == q.y { [p.x, q.x] } else { [x_at(y - reach), x_at(y + reach)] };
    [ends[0].min(ends[1]) - reach, ends[0].max(ends[1]) + reach]
}

/// Whether a point of a line is in front of the faces, or hardly behind.
///
/// The farthest of the nine samples around decides: faces that fall away steeply beside the line do not hide it, and
/// the line along a silhouette is seen in full. The test is made on the middle of the line for its whole width.
fn is_seen(depth: &Depth, p: Seen) -> bool {
    let (x, y) = (p.x.floor() as i64, p.y.floor() as i64);
    let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
    let farthest = around.map(|(dx, dy)| depth.nearness(x + dx, y + dy)).fold(f32::INFINITY, f32::min);
    p.nearness + BIAS * p.nearness.abs() >= f64::from(farthest)
}
