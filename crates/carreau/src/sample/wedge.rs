//! A wedge: a prism over a triangle with one given angle.

use super::builder::Builder;
use super::extrude::{Frame, Piece, Profile, extrude};
use super::limits::{affordable_edge, positive, within};
use super::model::Model;
use super::shape::Measure;
use crate::context::Context;
use crate::error::Result;
use glam::{DVec2, DVec3};

/// A wedge whose edge lies on the y axis between two slopes of the given `length` that meet at `angle` degrees (1 to
/// 170); `width` is its extent along y.
///
/// ```text
///             upper ╱│
///          ╱         │ back      labels: 0 lower slope, 1 back, 2 upper slope, 3 and 4 the triangles
///   edge ╲           │
///             lower ╲│
/// ```
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for sizes that make no such model, or one of too many triangles.
pub fn wedge(angle: f64, length: f64, width: f64, edge: f64, context: &Context) -> Result<Model> {
    within("angle", angle, 1.0, 170.0)?;
    positive("length", length)?;
    positive("width", width)?;
    let half = angle.to_radians() / 2.0;
    let triangle = length * length * half.sin() * half.cos();
    let area = 2.0 * triangle + 2.0 * width * length * (1.0 + half.sin());
    affordable_edge(edge, area)?;
    let tip = |side: f64| DVec2::from_angle(side * half) * length;
    let profile = Profile {
        start: DVec2::ZERO,
        pieces: &[
            ("lower slope", Piece::Line(tip(-1.0))),
            ("back", Piece::Line(tip(1.0))),
            ("upper slope", Piece::Line(DVec2::ZERO)),
        ],
    };
    let frame = Frame { origin: DVec3::Y * (width / 2.0), u: DVec3::X, v: DVec3::Z };
    let mut b = Builder::default();
    extrude(&mut b, &frame, &profile, width, &[], edge, context)?;
    b.finish(Measure::closed(area, triangle * width))
}
