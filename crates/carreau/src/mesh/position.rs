//! The order of places.

use glam::DVec3;
use std::cmp::Ordering;

/// Lexicographic order of positions.
pub fn by_position(a: DVec3, b: DVec3) -> Ordering {
    a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
}
