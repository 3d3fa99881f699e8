//! Lengths as users state them: absolute, or as a share of the model's bounding-box diagonal.

use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// A length: `2.5` (in the unit of the file) or `1%` (of the bounding-box diagonal).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Length {
    /// In the unit of the file.
    Absolute(f64),
    /// Share of the bounding-box diagonal: `OfDiagonal(0.01)` is one per cent.
    OfDiagonal(f64),
}

impl Length {
    /// The length in the unit of the file, for a model with this bounding-box diagonal.
    pub fn resolve(self, diagonal: f64) -> f64 {
        match self {
            Length::Absolute(x) => x,
            Length::OfDiagonal(share) => share * diagonal,
        }
    }
}

impl FromStr for Length {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let wrong = || Error::Options(format!("'{text}' is not a length such as 2.5 or 1%"));
        let (number, percent) = match text.trim().strip_suffix('%') {
            Some(rest) => (rest, true),
            None => (text.trim(), false),
        };
        let value: f64 = number.trim().parse().map_err(|_| wrong())?;
        if !value.is_finite() || value < 0.0 {
            return Err(wrong());
        }
        Ok(if percent { Length::OfDiagonal(value / 100.0) } else { Length::Absolute(value) })
    }
}

impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Length::Absolute(x) => write!(f, "{x}"),
            Length::OfDiagonal(share) => write!(f, "{}%", share * 100.0),
        }
    }
}

impl TryFrom<String> for Length {
    type Error = Error;
    fn try_from(text: String) -> Result<Self, Error> {
        text.parse()
    }
}

impl From<Length> for String {
    fn from(length: Length) -> String {
        length.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absolute_and_relative_lengths() -> Result<(), Error> {
        assert_eq!("2.5".parse::<Length>()?, Length::Absolute(2.5));
        assert_eq!("1%".parse::<Length>()?.resolve(200.0), 2.0);
        for wrong in ["", "%", "a", "-1", "nan", "inf%", "1 mm"] {
            assert!(wrong.parse::<Length>().is_err(), "{wrong}");
        }
        Ok(())
    }
}
