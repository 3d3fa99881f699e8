//! Checks of the models' parameters.

use crate::error::{Error, Result};

/// No model has more triangles than this: parameters that ask for more are refused before anything is allocated.
const MAX_TRIANGLES: f64 = 2e7;

/// Refuses a parameter that is not a positive, finite number.
pub(super) fn positive(name: &str, value: f64) -> Result<()> {
    within(name, value, f64::MIN_POSITIVE, f64::MAX)
}

/// Refuses a parameter outside `low..=high`.
pub(super) fn within(name: &str, value: f64, low: f64, high: f64) -> Result<()> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(Error::Options(match (low > f64::MIN_POSITIVE, high < f64::MAX) {
        (false, false) => format!("{name} is {value}; it must be a positive number"),
        (_, false) => format!("{name} is {value}; it must be at least {low}"),
        _ => format!("{name} is {value}; it must lie between {low} and {high}"),
    }))
}

/// Refuses a count below the least that makes a surface.
pub(super) fn at_least(name: &str, count: u32, least: u32) -> Result<()> {
    if count >= least { Ok(()) } else { Err(Error::Options(format!("{name} is {count}; it must be at least {least}"))) }
}

/// Refuses a model with too many triangles; the estimate is in floating point so that it cannot overflow.
pub(super) fn affordable(triangles: f64) -> Result<()> {
    if triangles <= MAX_TRIANGLES {
        return Ok(());
    }
    Err(Error::Options(format!(
        "the model would have {triangles:.0} triangles, more than {MAX_TRIANGLES:.0}; use longer edges"
    )))
}

/// Refuses an edge length that makes too many triangles on a surface of this area; equilateral triangles assumed.
pub(super) fn affordable_edge(edge: f64, area: f64) -> Result<()> {
    positive("the edge length", edge)?;
    affordable(area / edge / edge * (4.0 / 3f64.sqrt()))
}

/// Number of edges of about this length along a curve, at least `least`.
pub(super) fn divisions(length: f64, edge: f64, least: u32) -> u32 {
    // `as` saturates; callers have checked that the total is affordable.
    ((length / edge).round() as u32).max(least)
}
