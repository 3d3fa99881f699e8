//! What the two CAD writers have in common: options, units, numbers, the choice by extension.

use super::{extension, iges, step};
use crate::error::{Error, Result};
use crate::geometry::brep::{Brep, Face, Surface};
use crate::geometry::bspline::BSplineSurface;
use crate::geometry::normals::{angle_between, unit};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::str::FromStr;

/// Extensions of the CAD formats, in lower case.
pub const CAD_EXTENSIONS: &[&str] = &["step", "stp", "igs", "iges"];

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

/// Choices of the CAD writers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CadOptions {
    /// The unit of the coordinates.
    pub unit: Unit,
    /// The application protocol of STEP files.
    pub schema: StepSchema,
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
            name: "carreau".into(),
            date: "1970-01-01T00:00:00".into(),
            parameter_curves: false,
        }
    }
}

impl CadOptions {
    /// Fails when the date has not the form `YYYY-MM-DDThh:mm:ss`.
    pub(super) fn check(&self) -> Result<()> {
        let form = b"dddd-dd-ddTdd:dd:dd";
        let fits = |(&f, b): (&u8, u8)| if f == b'd' { b.is_ascii_digit() } else { f == b };
        if self.date.len() == form.len() && form.iter().zip(self.date.bytes()).all(fits) {
            return Ok(());
        }
        Err(Error::Options(format!("'{}' is not a date such as 2000-12-31T23:59:59", self.date)))
    }
}

/// Grid lines that bend a surface by more than this are kinks, in degrees.
const KINK_DEG: f64 = 5.0;

/// Whether a face is written with its border in the parameter plane: trimmed faces, and those with kinks. Readers
/// integrate over a face between the breaks of its border curves; without breaks at the rows, areas and volumes of kinked
/// faces come out wrong by up to 1e-4 in OpenCASCADE.
pub(super) fn needs_parameter_curves(face: &Face) -> bool {
    face.trimmed || matches!(&face.surface, Surface::Spline(surface) if has_kinks(surface))
}

/// Whether a surface of degree (1, 1) bends sharply along some grid line.
fn has_kinks(surface: &BSplineSurface) -> bool {
    let [u, v] = surface.knots();
    if u.degree() != 1 || v.degree() != 1 {
        return false;
    }
    let (cols, rows) = (u.count() - 1, v.count() - 1);
    let point = |r: usize, c: usize| surface.control(c, r);
    let normal =
        |r: usize, c: usize| unit((point(r + 1, c + 1) - point(r, c)).cross(point(r + 1, c) - point(r, c + 1)));
    let kink = |a: DVec3, b: DVec3| angle_between(a, b) > KINK_DEG.to_radians();
    (0..rows).any(|r| {
        (0..cols).any(|c| {
            let here = normal(r, c);
            (c + 1 < cols && kink(here, normal(r, c + 1))) || (r + 1 < rows && kink(here, normal(r + 1, c)))
        })
    })
}

/// Writes a CAD file into a buffer; the extension of `path` decides the format.
pub fn write_cad(path: &Path, brep: &Brep, options: &CadOptions, out: &mut Vec<u8>) -> Result<()> {
    match extension(path).as_str() {
        "step" | "stp" => step::write(brep, options, out),
        "igs" | "iges" => iges::write(brep, options, out),
        _ => Err(Error::write(path, format!("not a CAD format; known are: {}", CAD_EXTENSIONS.join(", ")))),
    }
}

/// Appends the shortest number with a decimal point that reads back to the same double; `exponent` is the letter.
pub(super) fn push_real(out: &mut Vec<u8>, x: f64, exponent: u8) {
    let mut buffer = ryu::Buffer::new();
    let text = buffer.format(x);
    let (mantissa, power) = text.split_once('e').map_or((text, None), |(m, p)| (m, Some(p)));
    out.extend_from_slice(mantissa.strip_suffix(".0").unwrap_or(mantissa).as_bytes());
    if mantissa.ends_with(".0") || !mantissa.contains('.') {
        out.push(b'.');
    }
    if let Some(power) = power {
        out.push(exponent);
        out.extend_from_slice(power.as_bytes());
    }
}

/// The distance below which points of this model may be taken as one: a power of ten, small against the model and
/// against its shortest edge.
pub(super) fn resolution(brep: &Brep) -> f64 {
    let [low, high] = brep.bounds();
    let length = |[a, b]: [u32; 2]| brep.vertices[a as usize].distance(brep.vertices[b as usize]);
    let shortest = brep.edges.iter().map(|e| length(e.ends)).filter(|&l| l > 0.0).fold(f64::INFINITY, f64::min);
    let wanted = (1e-7 * (high - low).length()).min(1e-2 * shortest);
    let least = 1e-12 * low.abs().max(high.abs()).max_element();
    let exponent = wanted.max(least).log10().floor();
    if exponent.is_finite() { format!("1e{}", exponent as i32).parse().unwrap_or(1e-7) } else { 1e-7 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bspline::Knots;

    /// A strip of two cells, folded by an angle along the middle.
    fn folded(degrees: f64) -> BSplineSurface {
        let fold = degrees.to_radians();
        let points = [0.0, 1.0]
            .map(|y| [DVec3::new(-1.0, y, 0.0), DVec3::new(0.0, y, 0.0), DVec3::new(fold.cos(), y, fold.sin())]);
        BSplineSurface::new(Knots::index(2), Knots::index(1), points.as_flattened().to_vec()).unwrap()
    }

    #[test]
    fn kinks_are_found_along_grid_lines() {
        assert!(!has_kinks(&folded(0.0)) && !has_kinks(&folded(4.0)));
        assert!(has_kinks(&folded(6.0)) && has_kinks(&folded(90.0)));
    }

    #[test]
    fn reals_have_a_point_and_read_back() {
        let text = |x: f64| {
            let mut out = Vec::new();
            push_real(&mut out, x, b'E');
            String::from_utf8(out).unwrap()
        };
        assert_eq!([1.0, 0.1, -0.0, 1e-7, 1.5e-7, 1e300].map(text), ["1.", "0.1", "-0.", "1.E-7", "1.5E-7", "1.E300"]);
        for x in [0.1 + 0.2, f64::MAX, f64::MIN_POSITIVE, 5e-324, -123456789.123] {
            assert!(text(x).contains('.'));
            assert_eq!(text(x).parse::<f64>().unwrap().to_bits(), x.to_bits());
        }
    }

    #[test]
    fn dates_are_checked() {
        let with = |date: &str| CadOptions { date: date.into(), ..Default::default() }.check().is_ok();
        assert!(CadOptions::default().check().is_ok() && with("2024-02-29T12:00:00"));
        assert!(!with("") && !with("2024-02-29") && !with("2024-02-29 12:00:00") && !with("2024-02-29T12:00:0x"));
    }
}
