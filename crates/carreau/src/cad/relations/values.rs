//! Radii and distances that are round numbers in the unit of the file.
//!
//! A value is taken for a round one where that is within the noise of the value, and where few other values would be as near to a round
//! one by chance: multiples of 10 are looked at before those of 5, and so on.

use super::conditions::{Radius, apart};
use super::{Claim, Relation};
use crate::cad::adjust::Body;
use crate::geometry::primitive::Primitive;

/// Lengths in the unit of the file of which round values are multiples, the coarsest first.
const ROUND_STEPS: [f64; 8] = [10.0, 5.0, 2.0, 1.0, 0.5, 0.25, 0.1, 0.05];
/// A count of standard deviations within which a value is a round one, because normal noise leaves them once in two thousand
/// times.
const ROUND_DEVIATIONS: f64 = 3.5;
/// A share of all values: no more may be as near to a multiple by chance, because one in so many would be taken for round wrongly.
const ROUND_CHANCE: f64 = 0.1;
/// A share of the diagonal: no value is more certain, because floats are no more precise.
const CERTAIN: f64 = 1e-7;

/// The claims that values are round. `unit`: a length of one in the unit of the file.
pub fn round_values(all: &[Body], held: &[Claim], unit: f64) -> Vec<Claim> {
    let covariances: Vec<Option<Vec<f64>>> = all.iter().map(Body::covariance).collect();
    let mut out = Vec::new();
    for (k, body) in (0u32..).zip(all) {
        let Some(covariance) = &covariances[k as usize] else { continue };
        for which in Radius::ALL {
            let Some(radius) = which.of(&body.primitive) else { continue };
            let deviation = Body::deviation(covariance, &which.row(1.0)).max(CERTAIN);
            if let Some(value) = rounded(radius * unit, deviation * unit) {
                let relation = Relation::Radius { body: [k], which, value: value / unit };
                out.push(Claim { relation, bound: ROUND_DEVIATIONS * deviation });
            }
        }
    }
    let parallel = held.iter().filter_map(|c| match c.relation {
        Relation::Parallel(bodies) => Some(bodies),
        _ => None,
    });
    let is_plane = |k: &u32| matches!(all[*k as usize].primitive, Primitive::Plane { .. });
    for bodies in parallel.filter(|bodies| bodies.iter().all(is_plane)) {
        let Some(condition) = apart(all, bodies, 0.0).pop() else { continue };
        let deviation = condition.by.iter().map(|(k, row)| {
            let covariance = covariances[*k as usize].as_ref();
            covariance.map_or(f64::INFINITY, |c| Body::deviation(c, row))
        });
        let deviation = deviation.fold(CERTAIN, f64::hypot);
        if let Some(value) = rounded(condition.value.abs() * unit, deviation * unit) {
            let relation = Relation::Apart { bodies, value: (value / unit).copysign(condition.value) };
            out.push(Claim { relation, bound: ROUND_DEVIATIONS * deviation });
        }
    }
    out
}

/// The round value that a value with a standard deviation may be.
fn rounded(value: f64, deviation: f64) -> Option<f64> {
    ROUND_STEPS.iter().find_map(|step| {
        let round = (value / step).round() * step;
        let off = (round - value).abs();
        let is_near = off <= ROUND_DEVIATIONS * deviation && 2.0 * off.max(deviation) <= ROUND_CHANCE * step;
        (is_near && round > 0.0).then_some(round)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_round_within_their_noise_alone() {
        assert_eq!(rounded(19.998, 0.002), Some(20.0));
        assert_eq!(rounded(12.501, 0.002), Some(12.5));
        // As near as that to a multiple of .05 is every second value.
        assert_eq!(rounded(12.31, 0.01), None);
        // Certain to be none.
        assert_eq!(rounded(12.3401, 0.00001), None);
        assert_eq!(rounded(0.001, 0.01), None);
    }
}
