//! Choices of the CAD writers.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// The unit that a CAD file says its numbers are in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Unit {
    /// Millimetres.
    #[default]
    #[serde(rename = "mm")]
    Millimetre,
    /// Centimetres.
    #[serde(rename = "cm")]
    Centimetre,
    /// Metres.
    #[serde(rename = "m")]
    Metre,
    /// Inches of 25.4 mm.
    #[serde(rename = "in")]
    Inch,
}

impl FromStr for Unit {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        match text {
            "mm" => Ok(Unit::Millimetre),
            "cm" => Ok(Unit::Centimetre),
            "m" => Ok(Unit::Metre),
            "in" => Ok(Unit::Inch),
            _ => Err(Error::Options(format!("'{text}' is not a unit; known are mm, cm, m, in"))),
        }
    }
}

/// The application protocol of a STEP file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StepSchema {
    /// ISO 10303-214, automotive design: the one that every system reads.
    #[default]
    Ap214,
    /// ISO 10303-242, its successor.
    Ap242,
}

/// What an IGES file has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum IgesForm {
    /// One surface for each face, trimmed where it has to be: what every reader knows.
    #[default]
    Surfaces,
    /// Manifold solids with their faces, edges and vertices (186): what knows which faces meet.
    Solids,
}

/// Choices of the CAD writers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CadOptions {
    /// The unit of the coordinates.
    pub unit: Unit,
    /// The application protocol of STEP files.
    pub schema: StepSchema,
    /// What IGES files have.
    pub iges: IgesForm,
    /// Name of the part.
    pub name: String,
    /// Date and time in the file, `YYYY-MM-DDThh:mm:ss`. Never the clock: the same input gives the same bytes.
    pub date: String,
    /// Whether STEP files have each edge in the parameter plane of its faces, too: larger files, but readers need not
    /// find these curves by projection, which fails on surfaces that fold over. Trimmed faces always have them.
    pub parameter_curves: bool,
}

impl Default for CadOptions {
    fn default() -> Self {
        CadOptions {
            unit: Unit::default(),
            schema: StepSchema::default(),
            iges: IgesForm::default(),
            name: "carreau".into(),
            date: "1970-01-01T00:00:00".into(),
            parameter_curves: false,
        }
    }
}

impl CadOptions {
    /// Fails when the date has not the form `YYYY-MM-DDThh:mm:ss`.
    pub(in crate::io) fn check(&self) -> Result<()> {
        let form = b"dddd-dd-ddTdd:dd:dd";
        let fits = |(&f, b): (&u8, u8)| if f == b'd' { b.is_ascii_digit() } else { f == b };
        if self.date.len() == form.len() && form.iter().zip(self.date.bytes()).all(fits) {
            return Ok(());
        }
        Err(Error::Options(format!("'{}' is not a date such as 2000-12-31T23:59:59", self.date)))
    }
}
