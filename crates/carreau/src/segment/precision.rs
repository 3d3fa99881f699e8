//! How exactly the vertices of a file can lie on a surface: rounding to single or double precision, or to decimal digits.

use super::surface::Surface;
use glam::DVec3;

/// A count: fewest decimal digits that a file may be rounded to, because with fewer no surface can be told.
const LEAST_DIGITS: i32 = 5;
/// A count: most decimal digits that a file of double precision may be rounded to, because more are as good as all.
const MOST_DIGITS: i32 = 8;
/// A count: the same of a file of single precision, because that has some more than seven.
const SINGLE_DIGITS: i32 = 7;
/// A share of the coordinates that need the last digit: well below the nine tenths of rounded ones, because of zeros
/// and walls.
const LAST_DIGIT_SHARE: f64 = 0.25;

/// Rounding of numbers of single or double precision, as a distance.
pub fn floor(surface: &Surface<'_>, extent: f64) -> f64 {
    let (low, high) = surface.mesh.bounds();
    let largest = low.abs().max(high.abs()).max_element();
    if is_single(surface.triangles.points()) {
        4.0 * f64::from(f32::EPSILON) * largest.max(extent / 4.0)
    } else {
        1e-9 * extent + 64.0 * f64::EPSILON * largest
    }
}

fn is_single(points: &[DVec3]) -> bool {
    points.iter().all(|p| p.to_array().iter().all(|&x| f64::from(x as f32) == x))
}

/// How far a vertex may be off in a file whose coordinates have few decimal digits, as those of text formats do; `None` for
/// other files.
pub fn decimal(points: &[DVec3]) -> Option<f64> {
    let (slack, most) = if is_single(points) { (f64::from(f32::EPSILON), SINGLE_DIGITS) } else { (1e-13, MOST_DIGITS) };
    let all = || points.iter().flat_map(|p| p.to_array());
    let is_rounded = |x: f64, digits: i32| {
        if x == 0.0 || !x.is_finite() {
            return true;
        }
        let unit = last_digit(x, digits);
        let rounded = (x / unit).round() * unit;
        (x - rounded).abs() <= slack * x.abs()
    };
    let digits = (LEAST_DIGITS..=most).find(|&digits| all().all(|x| is_rounded(x, digits)))?;
    let needing = all().filter(|&x| !is_rounded(x, digits - 1)).count();
    let largest = all().fold(0.0, |m: f64, x| m.max(x.abs()));
    // Half a unit in each of three coordinates, and some slack for the fit.
    (needing as f64 >= LAST_DIGIT_SHARE * 3.0 * points.len() as f64).then(|| last_digit(largest, digits))
}

/// The unit of the last of so many significant digits of a number.
fn last_digit(x: f64, digits: i32) -> f64 {
    10f64.powi(x.abs().log10().floor() as i32 + 1 - digits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_to_digits_is_seen() {
        let round = |x: f64, digits: i32| (x / last_digit(x, digits)).round() * last_digit(x, digits);
        let point = |k: f64| DVec3::new(40.0 * k.sin(), 3.0 + k.cos(), 0.1 * (1.7 * k).sin());
        let exact: Vec<DVec3> = (1..200).map(|k| point(f64::from(k))).collect();
        assert_eq!(decimal(&exact), None);
        for digits in 5..8 {
            let rounded: Vec<DVec3> =
                exact.iter().map(|p| DVec3::from_array(p.to_array().map(|x| round(x, digits)))).collect();
            assert_eq!(decimal(&rounded), Some(10f64.powi(2 - digits)));
        }
        // Whole numbers are rounded to nothing.
        let whole: Vec<DVec3> = (1..200).map(|k| DVec3::new(f64::from(k), 3.0, 0.0)).collect();
        assert_eq!(decimal(&whole), None);
    }
}
