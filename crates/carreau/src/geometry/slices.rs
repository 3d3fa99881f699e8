//! Long triangles in slices, for search trees: the box around a needle that lies askew holds much that is far from it.
//!
//! ```text
//!   ┌───────╱╲┐            ┌─╱╲┐
//!   │     ╱  ╱│          ┌─┼──╱┘
//!   │   ╱  ╱  │    →   ┌─┼──┼┘
//!   │ ╱  ╱    │      ┌─┼──┼┘
//!   ╱__╱──────┘      ╱_┼─┘
//! ```

use glam::DVec3;
use rayon::prelude::*;

/// Length from which on triangles are cut, over the side of as many equal ones; slices are that long.
const LONG: f64 = 2.0;
/// Length over height from which on triangles are cut.
const SLIM: f64 = 16.0;
/// Most slices of a triangle.
const MOST_SLICES: f64 = 32.0;
/// Most slices of all triangles, over their number.
const ALL: f64 = 8.0;
/// Slices reach into the next ones by this share of their length, for the sake of rounding.
const SLACK: f64 = 1e-6;

/// A triangle, or one slice of it across its longest side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Slice {
    /// The triangle.
    pub id: u32,
    /// Which of its slices, from the start of its longest side.
    pub number: u16,
    /// How many it has.
    pub of: u16,
}

/// All triangles, the long ones in slices.
pub fn slices(count: usize, corners: impl Fn(u32) -> [DVec3; 3] + Sync) -> Vec<Slice> {
    let all = || (0..count as u32).into_par_iter().map(&corners);
    let around = |(low, high): (DVec3, DVec3), p: DVec3| (low.min(p), high.max(p));
    let nothing = || (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = all()
        .fold(nothing, |bounds, corners| corners.into_iter().fold(bounds, around))
        .reduce(nothing, |a, b| (a.0.min(b.0), a.1.max(b.1)));
    let side = LONG * low.distance(high) / (count as f64).sqrt();
    let wanted = |corners| {
        let [a, b, c] = from_longest(corners);
        let (along, area) = ((b - a).length(), (b - a).cross(c - a).length());
        let is_long = along > side && along * along > SLIM * area;
        if is_long { (along / side).ceil().min(MOST_SLICES) as usize } else { 1 }
    };
    let sum: usize = all().map(wanted).sum();
    let share = (ALL * count as f64 / sum as f64).min(1.0);
    let cut = |id: u32| {
        let of = if sum > count { (share * wanted(corners(id)) as f64).ceil() as u16 } else { 1 };
        (0..of).map(move |number| Slice { id, number, of })
    };
    (0..count as u32).flat_map(cut).collect()
}

/// The corners of a triangle, the ends of its longest side first.
fn from_longest(corners: [DVec3; 3]) -> [DVec3; 3] {
    let length = |k: usize| corners[k].distance_squared(corners[(k + 1) % 3]);
    let first = (1..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    [0, 1, 2].map(|k| corners[(first + k) % 3])
}

impl Slice {
    /// Whether it is all of its triangle.
    pub fn is_whole(&self) -> bool {
        self.of == 1
    }

    /// Whether a point of the triangle counts as this slice's: it is exactly one's, which reaches around it.
    pub fn holds(&self, corners: [DVec3; 3], p: DVec3) -> bool {
        if self.is_whole() {
            return true;
        }
        let [a, b, _] = from_longest(corners);
        let share = (p - a).dot(b - a) / (b - a).length_squared();
        ((share * f64::from(self.of)) as u16).min(self.of - 1) == self.number
    }

    /// The corners of the slice, some of them twice.
    pub fn outline(&self, corners: [DVec3; 3]) -> [DVec3; 5] {
        if self.is_whole() {
            let [a, b, c] = corners;
            return [a, b, c, c, c];
        }
        let [a, b, c] = from_longest(corners);
        let at = |n: f64| (n / f64::from(self.of)).clamp(0.0, 1.0);
        let [from, to] = [at(f64::from(self.number) - SLACK), at(f64::from(self.number + 1) + SLACK)];
        // Where the third corner is above the longest side.
        let apex = (c - a).dot(b - a) / (b - a).length_squared();
        let above = |share: f64| match share < apex {
            true => a.lerp(c, share / apex),
            false => c.lerp(b, ((share - apex) / (1.0 - apex).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)),
        };
        let top = if from < apex && apex < to { c } else { above(to) };
        [a.lerp(b, from), a.lerp(b, to), above(from), above(to), top]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-1.0f64..1.0).prop_map(DVec3::from_array)
    }

    proptest! {
        #[test]
        fn a_point_is_in_one_slice_whose_outline_is_around_it(
            [a, b, c] in prop::array::uniform3(point()), of in 1u16..30, u in 0.0f64..1.0, v in 0.0f64..1.0,
            is_flat in any::<bool>(),
        ) {
            let corners = if is_flat { [a, b, b] } else { [a, b, c] };
            let c = corners[2];
            let p = a.lerp(b, u).lerp(c, v);
            let all = (0..of).map(|number| Slice { id: 0, number, of });
            let own: Vec<Slice> = all.filter(|s| s.holds(corners, p)).collect();
            prop_assert_eq!(own.len(), 1);
            let outline = own[0].outline(corners);
            let low = outline.into_iter().fold(DVec3::INFINITY, DVec3::min);
            let high = outline.into_iter().fold(DVec3::NEG_INFINITY, DVec3::max);
            prop_assert!(p.distance(p.clamp(low, high)) < 1e-12);
        }
    }

    #[test]
    fn what_is_long_beside_the_others_is_cut() {
        // A fan of needles, and a grid with as many triangles.
        let at = |k: u32| DVec3::from_array([(f64::from(k) * 1e-3).cos(), (f64::from(k) * 1e-3).sin(), 0.0]);
        let fan = slices(3000, |k| [DVec3::ZERO, at(k), at(k + 1)]);
        assert!(fan.len() > 6000 && fan.len() <= 27_000, "{}", fan.len());
        let corner = |k: u32| DVec3::new(f64::from(k % 50), f64::from(k / 50), 0.0);
        let grid = slices(2500, |k| [corner(k), corner(k) + DVec3::X, corner(k) + DVec3::Y]);
        assert!(grid.len() == 2500 && grid.iter().all(Slice::is_whole));
        assert!(slices(0, |_| [DVec3::ZERO; 3]).is_empty());
        // Points, and a coordinate that is not finite, stay what they are.
        assert_eq!(slices(5, |_| [DVec3::ONE; 3]).len(), 5);
        assert_eq!(slices(2, |_| [DVec3::ONE, DVec3::NAN, DVec3::X]).len(), 2);
    }
}
