//! What the two CAD writers have in common: options, units, numbers, the choice by extension.

use super::source::extension;
use super::{iges, step};
use crate::brep::{Brep, Face, Surface};
use crate::error::{Error, Result};
use crate::geometry::bspline::BSplineSurface;
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
    pub(super) fn check(&self) -> Result<()> {
        let form = b"dddd-dd-ddTdd:dd:dd";
        let fits = |(&f, b): (&u8, u8)| if f == b'd' { b.is_ascii_digit() } else { f == b };
        if self.date.len() == form.len() && form.iter().zip(self.date.bytes()).all(fits) {
            return Ok(());
        }
        Err(Error::Options(format!("'{}' is not a date such as 2000-12-31T23:59:59", self.date)))
    }
}

/// Grid lines where the area vector ∂x/∂u × ∂x/∂v jumps by more than this share of its length are breaks: a twentieth is a
/// bend by three degrees, or two neighbouring cells of a flat face whose widths differ by 5 %.
const BREAK: f64 = 0.05;

/// Whether a face is written with its border in the parameter plane: trimmed faces, and those with breaks. Readers
/// integrate over a face between the breaks of its border curves; where these are missing, areas and volumes come out wrong
/// by up to 1e-3 of the face in OpenCASCADE, on flat faces with cells of unequal size as on bent ones.
pub(super) fn needs_parameter_curves(brep: &Brep, face: &Face) -> bool {
    face.trimmed || matches!(brep.surface(face), Surface::Spline(surface) if has_breaks(surface))
}

/// Whether the area vector of a surface of degree (1, 1) jumps across some grid line. It is linear along the line between
/// two grid points, so the grid points tell.
///
/// ```text
///   q ─ q ─ q      Across the line p q the vectors (p − p₋) × (q − p) and (p₊ − p) × (q − p) meet at p,
///   │   │   │      (q − q₋) × (q − p) and (q₊ − q) × (q − p) at q.
///   p₋─ p ─ p₊
/// ```
fn has_breaks(surface: &BSplineSurface) -> bool {
    let [u, v] = surface.knots();
    if u.degree() != 1 || v.degree() != 1 {
        return false;
    }
    let (cols, rows) = (u.count(), v.count());
    let across_columns = |r: usize, c: usize| surface.control(c, r);
    let across_rows = |r: usize, c: usize| surface.control(r, c);
    breaks_across_columns(rows, cols, across_columns) || breaks_across_columns(cols, rows, across_rows)
}

/// [`has_breaks`] for the grid lines of constant column.
fn breaks_across_columns(rows: usize, cols: usize, point: impl Fn(usize, usize) -> DVec3) -> bool {
    let jumps = |r: usize, c: usize, along: DVec3| {
        let (before, after) = (point(r, c) - point(r, c - 1), point(r, c + 1) - point(r, c));
        let (before, after) = (before.cross(along), after.cross(along));
        before.distance(after) > BREAK * before.length().max(after.length())
    };
    (1..cols.saturating_sub(1)).any(|c| {
        (1..rows).any(|r| {
            let along = point(r, c) - point(r - 1, c);
            jumps(r - 1, c, along) || jumps(r, c, along)
        })
    })
}

/// Writes a CAD file into a buffer; the extension of `path` decides the format.
///
/// # Errors
/// [`Error::Write`] for an extension that is no CAD format,
/// [`Error::Options`] for options that make no sense.
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
    let length = |[a, b]: [u32; 2]| brep.point(a).distance(brep.point(b));
    let shortest = brep.edges.iter().map(|e| length(e.ends)).filter(|&l| l > 0.0).fold(f64::INFINITY, f64::min);
    let wanted = (1e-7 * (high - low).length()).min(1e-2 * shortest).max(brep.tolerance());
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

    /// A flat strip of two cells with these widths.
    fn flat(widths: [f64; 2]) -> BSplineSurface {
        let points = [0.0, 1.0].map(|y| [-widths[0], 0.0, widths[1]].map(|x| DVec3::new(x, y, 0.0)));
        BSplineSurface::new(Knots::index(2), Knots::index(1), points.as_flattened().to_vec()).unwrap()
    }

    /// The same with rows for columns.
    fn turned(s: &BSplineSurface) -> BSplineSurface {
        let [u, v] = s.knots();
        let points = (0..u.count()).flat_map(|c| (0..v.count()).map(move |r| s.control(c, r))).collect();
        BSplineSurface::new(v.clone(), u.clone(), points).unwrap()
    }

    #[test]
    fn breaks_are_bends_and_changes_of_width_across_grid_lines() {
        let broken = |s: BSplineSurface| {
            let either = [has_breaks(&s), has_breaks(&turned(&s))];
            assert_eq!(either[0], either[1]);
            either[0]
        };
        assert!(!broken(folded(0.0)) && !broken(folded(2.0)));
        assert!(broken(folded(4.0)) && broken(folded(90.0)) && broken(folded(180.0)));
        assert!(!broken(flat([1.0, 1.04])) && broken(flat([1.0, 1.1])) && broken(flat([1.0, 0.0])));
        assert!(!broken(flat([0.0, 0.0])));
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
