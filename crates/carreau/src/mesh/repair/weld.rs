//! Step 1: vertices at one place become one.

use super::soup::Soup;
use crate::mesh::weld::{first_at_same_position, leaders_within};

/// Welds vertices within the tolerance (0: at exactly equal positions). Returns how many vertices went.
pub fn weld(soup: &mut Soup, tolerance: f64) -> usize {
    let leader =
        if tolerance > 0.0 { leaders_within(&soup.points, tolerance) } else { first_at_same_position(&soup.points) };
    soup.merge_vertices(&leader)
}
