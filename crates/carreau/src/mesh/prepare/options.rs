//! How a surface is prepared.

use crate::error::{Error, Result};
use crate::length::Length;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// How a surface is prepared.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PrepareOptions {
    /// Vertices nearer than this become one; 0: at exactly equal positions.
    pub weld: Length,
    /// Which pieces stay; by default all, or the largest body where a method needs one.
    pub keep: Option<Keep>,
    /// The surface is taken as it is.
    pub as_is: bool,
}

impl Default for PrepareOptions {
    fn default() -> Self {
        PrepareOptions { weld: Length::Absolute(0.0), keep: None, as_is: false }
    }
}

/// How many bodies a method takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Takes {
    /// Any number.
    #[default]
    Bodies,
    /// One: without [`PrepareOptions::keep`] it is given the largest.
    OneBody,
}

/// Which pieces of a surface stay.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Keep {
    /// Every one.
    All,
    /// The one with the largest area, with its cavities.
    Largest,
    /// Those with at least this share of the largest one's area.
    Share(f64),
}

impl FromStr for Keep {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = || Error::Options(format!("keep is all, largest or a share such as 1%, not '{text}'"));
        let number = |word: &str| word.trim().parse::<f64>().map_err(|_| wrong());
        let share = match text.trim() {
            "all" => return Ok(Keep::All),
            "largest" => return Ok(Keep::Largest),
            word => match word.strip_suffix('%') {
                Some(word) => number(word)? / 100.0,
                None => number(word)?,
            },
        };
        if (0.0..=1.0).contains(&share) { Ok(Keep::Share(share)) } else { Err(wrong()) }
    }
}

impl fmt::Display for Keep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Keep::All => write!(f, "all"),
            Keep::Largest => write!(f, "largest"),
            Keep::Share(share) => write!(f, "{}%", 100.0 * share),
        }
    }
}

impl TryFrom<String> for Keep {
    type Error = Error;
    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl From<Keep> for String {
    fn from(keep: Keep) -> String {
        keep.to_string()
    }
}
