//! Chooses where to look from.

use crate::mesh::Polygons;
use glam::{DVec2, DVec3};

/// From where to look at a model.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum View {
    /// Three-quarter view from above; see [`View::automatic`].
    #[default]
    Automatic,
    /// From this side.
    From {
        /// Direction from the model towards the eye; need not have unit length.
        eye: DVec3,
        /// Direction that points upwards in the image.
        up: DVec3,
    },
}

/// How far the eye stands above the horizon, in degrees.
const ELEVATION: f64 = 24.0;
/// How far the eye stands aside from the normal of the model's broad side, in degrees.
const AZIMUTH: f64 = 32.0;

impl View {
    /// A three-quarter view of a model: from above, with its broader side to the front.
    ///
    /// Up is the z axis, or y if the model stands much better on that. Pass the result to all pictures that are to be
    /// compared.
    pub fn automatic(points: &[DVec3], faces: &Polygons) -> View {
        three_quarter(picked(points, &used_vertices(points, faces)).collect())
    }

    /// Unit directions right, up and towards the eye; sensible ones where the view is degenerate or open.
    pub(super) fn axes(&self) -> [DVec3; 3] {
        let View::From { eye, up } = *self else { return [DVec3::X, DVec3::Z, DVec3::NEG_Y] };
        let unit = |d: DVec3| (d / d.abs().max_element()).try_normalize();
        let eye = unit(eye).unwrap_or(DVec3::Z);
        let across = unit(up).map_or(DVec3::ZERO, |up| up.cross(eye));
        let right = if across.length() > 1e-6 { across.normalize() } else { eye.any_orthonormal_vector() };
        [right, eye.cross(right), eye]
    }
}

/// Which vertices faces use.
pub(super) fn used_vertices(points: &[DVec3], faces: &Polygons) -> Vec<bool> {
    let mut used = vec![false; points.len()];
    faces.corners().iter().for_each(|&v| mark(&mut used, v));
    used
}

/// Marks a vertex, if it exists.
pub(super) fn mark(used: &mut [bool], v: u32) {
    if let Some(slot) = used.get_mut(v as usize) {
        *slot = true;
    }
}

/// The marked points that are finite.
pub(super) fn picked<'a>(points: &'a [DVec3], used: &'a [bool]) -> impl Iterator<Item = DVec3> + 'a {
    points.iter().zip(used).filter(|(p, used)| **used && p.is_finite()).map(|(p, _)| *p)
}

/// The view described at [`View::automatic`].
pub(super) fn three_quarter(mut points: Vec<DVec3>) -> View {
    let size = stretch(&mut points);
    let up = up_axis(&points);
    let (front, side) = if up == DVec3::Z { (DVec3::NEG_Y, DVec3::X) } else { (DVec3::Z, DVec3::X) };
    let broad_front = size.dot(side.abs()) >= 0.8 * size.dot(front.abs());
    let azimuth = if broad_front { AZIMUTH } else { 90.0 - AZIMUTH }.to_radians();
    let level = front * azimuth.cos() + side * azimuth.sin();
    let elevation = ELEVATION.to_radians();
    View::From { eye: level * elevation.cos() + up * elevation.sin(), up }
}

/// Moves and stretches points to fill the unit cube; returns half the size of the box they filled.
fn stretch(points: &mut [DVec3]) -> DVec3 {
    // Halved, so that the size of a box from −1e308 to 1e308 is finite.
    points.iter_mut().for_each(|p| *p /= 2.0);
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = points.iter().fold(start, |(l, h), &p| (l.min(p), h.max(p)));
    let size = if points.is_empty() { DVec3::ZERO } else { high - low };
    points.iter_mut().for_each(|p| *p = (*p - low) / size.max(DVec3::splat(f64::MIN_POSITIVE)));
    size
}

/// The upright axis of a model: z, the custom of CAD, unless it stands much better on y, the custom of scans and
/// characters. A model stands well on a broad support, as an animal does on its feet.
fn up_axis(points: &[DVec3]) -> DVec3 {
    let [y, z] = [1, 2].map(|axis| support(points, axis));
    if y > 2.5 * z { DVec3::Y } else { DVec3::Z }
}

/// The share of the base of the unit cube under the convex hull of the points near it.
fn support(points: &[DVec3], axis: usize) -> f64 {
    let near = points.iter().filter(|p| p[axis] < 0.03);
    let mut shadow: Vec<DVec2> = near.map(|p| DVec2::new(p[(axis + 1) % 3], p[(axis + 2) % 3])).collect();
    shadow.sort_unstable_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    let lower = left_turns(shadow.iter().copied());
    let upper = left_turns(shadow.iter().rev().copied());
    let area = |chain: &[DVec2]| chain.windows(2).map(|w| w[0].perp_dot(w[1])).sum::<f64>() / 2.0;
    area(&lower) + area(&upper)
}

/// Half of a convex hull: the points of a sorted sequence that are left when every turn has to be to the left.
fn left_turns(points: impl Iterator<Item = DVec2>) -> Vec<DVec2> {
    let mut chain: Vec<DVec2> = Vec::new();
    for p in points {
        while let [.., a, b] = chain[..] {
            if (b - a).perp_dot(p - b) > 0.0 {
                break;
            }
            chain.pop();
        }
        chain.push(p);
    }
    chain
}
