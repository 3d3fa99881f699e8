//! Sorts triangles into leaves, half and half along the longest axis.

use super::box3::Box3;
use glam::DVec3;

/// Triangles per leaf.
pub const TRIANGLES_PER_LEAF: usize = 4;
/// Subtrees with fewer triangles are built by one thread.
pub const SERIAL: usize = 8192;

/// Sorts the items into leaves and fills the boxes of a subtree; returns its box.
pub fn build(
    boxes: &mut [Box3],
    items: &mut [(DVec3, u32)],
    leaves: usize,
    outline: &(impl Fn(u32) -> [DVec3; 5] + Sync),
) -> Box3 {
    boxes[0] = if leaves == 1 {
        items.iter().flat_map(|&(_, item)| outline(item)).fold(Box3::EMPTY, Box3::with)
    } else {
        let left = leaves.div_ceil(2);
        let axis = longest_axis(items);
        items.select_nth_unstable_by(left * TRIANGLES_PER_LEAF, |a, b| {
            a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1))
        });
        let serial = items.len() < SERIAL;
        let (left_items, right_items) = items.split_at_mut(left * TRIANGLES_PER_LEAF);
        let (left_boxes, right_boxes) = boxes[1..].split_at_mut(2 * left - 1);
        let mut build_left = || build(left_boxes, left_items, left, outline);
        let mut build_right = || build(right_boxes, right_items, leaves - left, outline);
        let (a, b) = if serial { (build_left(), build_right()) } else { rayon::join(build_left, build_right) };
        a.with(b.low).with(b.high)
    };
    boxes[0]
}

pub fn longest_axis(items: &[(DVec3, u32)]) -> usize {
    let all = items.iter().fold(Box3::EMPTY, |b, &(centre, _)| b.with(centre));
    (all.high - all.low).max_position()
}
