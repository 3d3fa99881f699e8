//! Ranges of options: one way to check a number and to say what is wrong with it.

use crate::error::{Error, Result};
use std::fmt::Display;
use std::ops::{Bound, RangeBounds};

/// Refuses a number outside of a range; not a number is outside of every range. `name` is the option's, `unit` follows the
/// bounds in the message and may be empty.
///
/// ```
/// use carreau::bounds::within;
/// assert!(within("feature-angle", 30.0, 0.0..=180.0, "degrees").is_ok());
/// let refused = within("feature-angle", f64::NAN, 0.0..=180.0, "degrees").unwrap_err();
/// assert_eq!(refused.to_string(), "feature-angle is NaN, it must be from 0 to 180 degrees");
/// ```
///
/// # Errors
/// [`Error::Options`].
pub fn within<T>(name: &str, value: T, range: impl RangeBounds<T>, unit: &str) -> Result<()>
where
    T: PartialOrd + Display + Default,
{
    if range.contains(&value) {
        return Ok(());
    }
    let low = match range.start_bound() {
        Bound::Included(low) => format!("from {low}"),
        Bound::Excluded(low) => format!("above {low}"),
        Bound::Unbounded => String::new(),
    };
    let high = match range.end_bound() {
        Bound::Included(high) => format!("to {high}"),
        Bound::Excluded(high) => format!("below {high}"),
        Bound::Unbounded => "on".to_string(),
    };
    let text = format!("{name} is {value}, it must be {low} {high} {unit}");
    Err(Error::Options(text.split_whitespace().collect::<Vec<_>>().join(" ")))
}

/// Refuses a length or a weight that is not above zero and finite.
///
/// # Errors
/// [`Error::Options`].
pub fn positive(name: &str, value: f64) -> Result<()> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::Options(format!("{name} is {value}, it must be above 0")))
}

/// Refuses an angle outside of 0 to 180 degrees.
///
/// # Errors
/// [`Error::Options`].
pub fn angle(name: &str, degrees: f64) -> Result<()> {
    within(name, degrees, 0.0..=180.0, "degrees")
}
