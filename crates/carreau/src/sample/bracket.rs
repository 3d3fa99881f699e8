//! An L-bracket bent from plate: two legs, a bend, three holes.

use super::builder::Builder;
use super::extrude::{Frame, Hole, Piece, Profile, extrude};
use super::limits::{affordable_edge, positive};
use super::model::Model;
use super::shape::Measure;
use crate::context::Context;
use crate::error::{Error, Result};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Sizes of a [`bracket`]; think of millimetres.
///
/// ```text
///  z
///  │ ┌─┐               The foot lies on z = 0, the back on x = 0; y runs from 0 to `width`.
///  │ │ │ height
///  │ │o│               Inner fillet and outer bend have the same axis, so the plate
///  │ │ ╰──────┐        has the same `thickness` everywhere.
///  │ ╰──o─o───┘
///  └──── length ─── x
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bracket {
    /// Extent of the foot along x.
    pub length: f64,
    /// Extent of the back along z.
    pub height: f64,
    /// Extent along y.
    pub width: f64,
    /// Thickness of the plate.
    pub thickness: f64,
    /// Radius of the fillet between the legs, on the inside.
    pub fillet: f64,
    /// Radius of the two screw holes in the foot.
    pub screw: f64,
    /// Radius of the one hole in the back.
    pub bore: f64,
}

impl Default for Bracket {
    fn default() -> Self {
        Bracket { length: 60.0, height: 54.0, width: 44.0, thickness: 8.0, fillet: 8.0, screw: 4.5, bore: 11.0 }
    }
}

impl Bracket {
    /// Radius of the bend on the outside: where the flat parts of the legs begin.
    fn bend(&self) -> f64 {
        self.fillet + self.thickness
    }

    /// Refuses sizes for which the holes meet each other or an edge.
    fn check(&self) -> Result<()> {
        let sizes = [self.length, self.height, self.width, self.thickness, self.fillet, self.screw, self.bore];
        let names = ["length", "height", "width", "thickness", "fillet", "screw", "bore"];
        names.into_iter().zip(sizes).try_for_each(|(name, size)| positive(name, size))?;
        let room = |hole: f64, place: f64| 2.2 * hole < place;
        let fits = room(self.screw, self.width / 2.0)
            && room(self.screw, self.length - self.bend())
            && room(self.bore, self.width)
            && room(self.bore, self.height - self.bend());
        if fits {
            Ok(())
        } else {
            Err(Error::Options("the holes do not fit into the flat parts of the bracket's legs".into()))
        }
    }

    /// Exact area and volume.
    fn measure(&self) -> Option<Measure> {
        let straight = self.length + self.height - 2.0 * self.bend();
        let section = straight * self.thickness + PI / 4.0 * (self.bend().powi(2) - self.fillet.powi(2));
        let outline = 2.0 * straight + 2.0 * self.thickness + FRAC_PI_2 * (self.bend() + self.fillet);
        let discs = PI * (2.0 * self.screw.powi(2) + self.bore.powi(2));
        let walls = 2.0 * PI * (2.0 * self.screw + self.bore) * self.thickness;
        Measure::closed(
            2.0 * section + outline * self.width - 2.0 * discs + walls,
            section * self.width - discs * self.thickness,
        )
    }

    fn holes(&self) -> [Hole; 3] {
        let (x, z) = ((self.length + self.bend()) / 2.0, (self.height + self.bend()) / 2.0);
        let through = DVec3::Z * self.thickness;
        let screw = |name, y| Hole {
            name,
            faces: ["underside", "foot"],
            centre: DVec3::new(x, y, 0.0),
            through,
            radius: self.screw,
        };
        [
            screw("screw hole 1", self.width / 4.0),
            screw("screw hole 2", self.width * 0.75),
            Hole {
                name: "bore",
                faces: ["back", "front"],
                centre: DVec3::new(0.0, self.width / 2.0, z),
                through: DVec3::X * self.thickness,
                radius: self.bore,
            },
        ]
    }
}

/// An L-bracket with edges of about this length; every hole has at least twelve segments, every arc three.
///
/// Labels: 0 underside, 1 toe, 2 foot, 3 fillet (cylinder), 4 front, 5 top, 6 back, 7 bend (cylinder), 8 and 9 the
/// L-shaped ends, 10 to 12 the holes (cylinders).
///
/// # Errors
/// [`Error::Options`] for sizes that make no such model, or one of too many triangles.
pub fn bracket(size: &Bracket, edge: f64, context: &Context) -> Result<Model> {
    size.check()?;
    let measure = size.measure();
    affordable_edge(edge, measure.map_or(0.0, |m| m.area))?;
    let (l, h, t) = (size.length, size.height, size.thickness);
    let axis = DVec2::splat(size.bend());
    let profile = Profile {
        start: DVec2::new(size.bend(), 0.0),
        pieces: &[
            ("underside", Piece::Line(DVec2::new(l, 0.0))),
            ("toe", Piece::Line(DVec2::new(l, t))),
            ("foot", Piece::Line(DVec2::new(size.bend(), t))),
            ("fillet", Piece::Arc(axis, -FRAC_PI_2)),
            ("front", Piece::Line(DVec2::new(t, h))),
            ("top", Piece::Line(DVec2::new(0.0, h))),
            ("back", Piece::Line(DVec2::new(0.0, size.bend()))),
            ("bend", Piece::Arc(axis, FRAC_PI_2)),
        ],
    };
    // x × z points towards −y: the sweep begins at the far side.
    let frame = Frame { origin: DVec3::Y * size.width, u: DVec3::X, v: DVec3::Z };
    let mut b = Builder::default();
    extrude(&mut b, &frame, &profile, size.width, &size.holes(), edge, context)?;
    b.finish(measure)
}
