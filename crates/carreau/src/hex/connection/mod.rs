//! Connection surfaces: a branching of n segments gets a partition of the sphere into n quads, each with the direction
//! of one segment in it; n + 2 vertices, 2 n sides (Viville et al., section 3.2).
//!
//! Two ways to make one: orange slices about an axis, and the dual of a spherical Delaunay triangulation changed until
//! every vertex has four edges. Two conditions decide whether a partition is any good:
//!
//! * inclusion: det(d, Vₖ, Vₖ₊₁) > 0 for the four sides of the quad of direction d, which is the sign of the Jacobian of
//!   the four hexes at the branching;
//! * convexity: det(Vₖ₋₁, Vₖ, Vₖ₊₁) > 0; not asked for at a vertex of two quads, whose two angles make a round, so that
//!   straight is the best it can be.
//!
//! Departure: the paper takes the first partition that its heuristic gives. Here all candidates (the heuristic's, and
//! orange slices on many axes) have their vertices moved to enlarge the least of those determinants, and the best wins:
//! orange slices on some axis always include and are convex, so that a valid partition always exists.

mod dual;
mod hull;
mod map;
mod orange;
mod partition;
mod search;

pub use search::PartitionSearch;

#[cfg(test)]
pub(super) mod tests {
    use super::partition::Connection;
    use super::*;
    use glam::DVec3;
    use proptest::prelude::*;

    /// Unit directions, no two closer than an angle, from numbers of a generator.
    pub fn star(numbers: &[f64], valence: usize, least_degrees: f64) -> Option<Vec<DVec3>> {
        let mut directions: Vec<DVec3> = Vec::new();
        for n in numbers.chunks_exact(3) {
            let d = DVec3::from_slice(n);
            if d.length() < 1.0 && d.length() > 0.1 {
                let d = d.normalize();
                if directions.iter().all(|e| e.dot(d) < least_degrees.to_radians().cos()) {
                    directions.push(d);
                }
            }
            if directions.len() == valence {
                return Some(directions);
            }
        }
        None
    }

    /// Every side has two quads that run it in opposite senses, and the counts are Euler's.
    pub fn assert_partition(c: &Connection, n: usize) {
        assert_eq!((c.quads.len(), c.sides.len(), c.vertices.len()), (n, n, n + 2));
        let mut ends: Vec<Vec<[u32; 2]>> = vec![Vec::new(); 2 * n];
        for (q, s) in c.quads.iter().zip(&c.sides) {
            (0..4).for_each(|k| ends[s[k] as usize].push([q[k], q[(k + 1) % 4]]));
        }
        for side in ends {
            assert!(matches!(side[..], [[a, b], [c, d]] if a == d && b == c && a != b), "{side:?}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn every_star_is_included(n in 3usize..13, numbers in prop::collection::vec(-1.0f64..1.0, 600)) {
            if let Some(directions) = star(&numbers, n, 15.0) {
                let c = PartitionSearch::default().partition(&directions).clone();
                assert_partition(&c, n);
                prop_assert!(c.least_determinant(&directions) > 0.0, "{}", c.least_determinant(&directions));
            }
        }
    }

    /// Orange slices have poles of valence 12 here, and the paper's heuristic a lower one but an angle turned inside out.
    #[test]
    fn validity_comes_before_low_valence() {
        let directions = [
            [-0.25139499652668257, -0.9507992141637049, 0.18105637262198349],
            [-0.7938746973598434, -0.22410944367486077, -0.5652768544240615],
            [-0.33648721330708453, 0.9392822186255586, 0.06727012007333295],
            [-0.8296350774319953, 0.4937118387753117, 0.260680376222507],
            [-0.9120162525412233, -0.26223543728398846, 0.3153710997113381],
            [0.20327206109957807, 0.9452887180611844, -0.25516604139769816],
            [-0.1216635717337983, -0.44764690988122574, -0.8858951514636281],
            [-0.6879669557927146, 0.7244838870272006, -0.04271492918481336],
            [-0.6206261060471968, -0.4012663519340511, -0.673653138713264],
            [-0.41742023824379626, -0.6202199191519493, -0.6641442588712501],
            [0.03702360681389938, 0.1404769898836702, -0.9893914634014754],
            [-0.5093096254395499, -0.7720546701966934, -0.38017797366772865],
        ];
        let directions = directions.map(DVec3::from_array);
        let c = PartitionSearch::default().partition(&directions).clone();
        assert_partition(&c, 12);
        assert!(c.least_determinant(&directions) > 0.0);
    }

    #[test]
    fn six_axes_are_a_cube() {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
        let c = PartitionSearch::default().partition(&axes).clone();
        assert_partition(&c, 6);
        let mut valence = [0; 8];
        c.quads.as_flattened().iter().for_each(|&v| valence[v as usize] += 1);
        assert_eq!(valence, [3; 8]);
    }

    #[test]
    fn directions_in_one_plane_and_in_one_half_of_space() {
        let flat: Vec<DVec3> =
            (0..5).map(|k| DVec3::from((glam::DVec2::from_angle(1.2 * f64::from(k)), 0.0))).collect();
        let tilted: Vec<DVec3> = flat.iter().map(|d| (*d + DVec3::Z).normalize()).collect();
        for directions in [flat, tilted] {
            let c = PartitionSearch::default().partition(&directions).clone();
            assert_partition(&c, 5);
            assert!(c.least_determinant(&directions) > 0.0);
        }
    }
}
