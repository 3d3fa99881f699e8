//! Curves: the shapes of edges and the profiles of swept surfaces.
//!
//! | file | holds |
//! |---|---|
//! | `mod` | the kinds, their parameters, evaluation |
//! | `project` | the parameter of the nearest point |
//!
//! Parameters are those of ISO 10303-42 (E = centre, x and y from the frame):
//!
//! | kind | point at t | period |
//! |---|---|---|
//! | line | E + t d | – |
//! | circle | E + r (cos t x + sin t y) | 2π |
//! | ellipse | E + a cos t x + b sin t y | 2π |
//! | parabola | E + f (t² x + 2 t y) | – |
//! | hyperbola | E + a cosh t x + b sinh t y (one branch) | – |
//! | spline | B-spline of degree 1 to 3, clamped | its domain where it is closed |

mod project;

use super::frame::{Frame, Motion};
use crate::geometry::bspline::BSplineCurve;
use glam::DVec3;
use std::f64::consts::TAU;

/// A curve in space, unbounded except for splines.
#[derive(Debug, Clone, PartialEq)]
pub enum Curve {
    /// A straight line; the parameter is a length.
    Line {
        /// The point with parameter 0.
        origin: DVec3,
        /// A unit vector.
        direction: DVec3,
    },
    /// A circle in the plane z = 0 of its frame; the parameter is an angle.
    Circle {
        /// Its centre, axis and the point with parameter 0.
        frame: Frame,
        /// Above 0.
        radius: f64,
    },
    /// An ellipse in the plane z = 0 of its frame.
    Ellipse {
        /// Its centre, normal and first axis.
        frame: Frame,
        /// The semi-axes along x and y, both above 0, the first not the smaller one.
        radii: [f64; 2],
    },
    /// A parabola in the plane z = 0 of its frame, opening towards x.
    Parabola {
        /// Its apex, normal and axis.
        frame: Frame,
        /// Distance from the apex to the focus, above 0.
        focal: f64,
    },
    /// The branch of a hyperbola around the positive x axis of its frame.
    Hyperbola {
        /// Its centre, normal and axis.
        frame: Frame,
        /// The semi-axis along x, and the imaginary one along y, both above 0.
        radii: [f64; 2],
    },
    /// A B-spline.
    Spline(BSplineCurve),
}

/// The kinds of curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CurveKind {
    /// A straight line.
    Line,
    /// A circle.
    Circle,
    /// An ellipse.
    Ellipse,
    /// A parabola.
    Parabola,
    /// A hyperbola.
    Hyperbola,
    /// A B-spline.
    Spline,
}

impl CurveKind {
    /// The name in records: `line`, `circle`, `ellipse`, `parabola`, `hyperbola` or `bspline`.
    pub fn name(self) -> &'static str {
        match self {
            CurveKind::Line => "line",
            CurveKind::Circle => "circle",
            CurveKind::Ellipse => "ellipse",
            CurveKind::Parabola => "parabola",
            CurveKind::Hyperbola => "hyperbola",
            CurveKind::Spline => "bspline",
        }
    }
}

impl Curve {
    /// The line from one point to another, and its parameters there. Points that coincide give a line along x.
    pub fn segment(a: DVec3, b: DVec3) -> (Self, [f64; 2]) {
        (Curve::Line { origin: a, direction: (b - a).normalize_or(DVec3::X) }, [0.0, a.distance(b)])
    }

    /// Which kind this is.
    pub fn kind(&self) -> CurveKind {
        match self {
            Curve::Line { .. } => CurveKind::Line,
            Curve::Circle { .. } => CurveKind::Circle,
            Curve::Ellipse { .. } => CurveKind::Ellipse,
            Curve::Parabola { .. } => CurveKind::Parabola,
            Curve::Hyperbola { .. } => CurveKind::Hyperbola,
            Curve::Spline(_) => CurveKind::Spline,
        }
    }

    /// The length in parameters after which the curve repeats itself; a spline does where its ends are the same point.
    pub fn period(&self) -> Option<f64> {
        match self {
            Curve::Circle { .. } | Curve::Ellipse { .. } => Some(TAU),
            Curve::Spline(s) => {
                let [a, b] = s.knots().domain();
                (s.ends()[0] == s.ends()[1]).then_some(b - a)
            }
            _ => None,
        }
    }

    /// First and last parameter: infinite for lines, parabolas and hyperbolas, [0, 2π] for circles and ellipses.
    pub fn domain(&self) -> [f64; 2] {
        match self {
            Curve::Circle { .. } | Curve::Ellipse { .. } => [0.0, TAU],
            Curve::Spline(s) => s.knots().domain(),
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// The point at a parameter.
    pub fn point(&self, t: f64) -> DVec3 {
        match self {
            Curve::Spline(s) => s.point(self.wrapped(t)),
            _ => self.derivatives(t)[0],
        }
    }

    /// Point, first and second derivative.
    pub fn derivatives(&self, t: f64) -> [DVec3; 3] {
        let plane = |f: &Frame, [p, d, dd]: [[f64; 2]; 3]| {
            let vector = |[x, y]: [f64; 2]| x * f.x + y * f.y();
            [f.origin + vector(p), vector(d), vector(dd)]
        };
        let (sin, cos) = t.sin_cos();
        let ellipse = |[a, b]: [f64; 2]| [[a * cos, b * sin], [-a * sin, b * cos], [-a * cos, -b * sin]];
        match self {
            Curve::Line { origin, direction } => [origin + t * direction, *direction, DVec3::ZERO],
            Curve::Circle { frame, radius } => plane(frame, ellipse([*radius; 2])),
            Curve::Ellipse { frame, radii } => plane(frame, ellipse(*radii)),
            Curve::Parabola { frame, focal: f } => {
                plane(frame, [[f * t * t, 2.0 * f * t], [2.0 * f * t, 2.0 * f], [2.0 * f, 0.0]])
            }
            Curve::Hyperbola { frame, radii: [a, b] } => {
                let (sinh, cosh) = (t.sinh(), t.cosh());
                plane(frame, [[a * cosh, b * sinh], [a * sinh, b * cosh], [a * cosh, b * sinh]])
            }
            Curve::Spline(s) => s.derivatives(self.wrapped(t)),
        }
    }

    /// A parameter of a closed spline in its domain; any other parameter as it is.
    fn wrapped(&self, t: f64) -> f64 {
        let [low, high] = self.domain();
        match (self, self.period()) {
            (Curve::Spline(_), Some(period)) if !(low..=high).contains(&t) => low + (t - low).rem_euclid(period),
            _ => t,
        }
    }

    /// The same points in the opposite sense, and the range of parameters that takes the place of the given one.
    pub fn reversed(&self, [a, b]: [f64; 2]) -> (Self, [f64; 2]) {
        let flipped = |f: &Frame| Frame { z: -f.z, ..*f };
        let curve = match self {
            Curve::Line { origin, direction } => Curve::Line { origin: *origin, direction: -*direction },
            Curve::Circle { frame, radius } => Curve::Circle { frame: flipped(frame), radius: *radius },
            Curve::Ellipse { frame, radii } => Curve::Ellipse { frame: flipped(frame), radii: *radii },
            Curve::Parabola { frame, focal } => Curve::Parabola { frame: flipped(frame), focal: *focal },
            Curve::Hyperbola { frame, radii } => Curve::Hyperbola { frame: flipped(frame), radii: *radii },
            Curve::Spline(s) => {
                let [low, high] = s.knots().domain();
                return (Curve::Spline(s.reversed()), [low + (high - b), low + (high - a)]);
            }
        };
        (curve, [-b, -a])
    }

    /// The curve after a motion; parameters of lines are multiplied by the scale, all others stay.
    pub fn moved(&self, by: &Motion) -> Self {
        let s = by.scale;
        match self {
            Curve::Line { origin, direction } => {
                Curve::Line { origin: by.point(*origin), direction: by.rotation * *direction }
            }
            Curve::Circle { frame, radius } => Curve::Circle { frame: frame.moved(by), radius: s * radius },
            Curve::Ellipse { frame, radii } => Curve::Ellipse { frame: frame.moved(by), radii: radii.map(|r| s * r) },
            Curve::Parabola { frame, focal } => Curve::Parabola { frame: frame.moved(by), focal: s * focal },
            Curve::Hyperbola { frame, radii } => {
                Curve::Hyperbola { frame: frame.moved(by), radii: radii.map(|r| s * r) }
            }
            Curve::Spline(c) => Curve::Spline(c.mapped(|p| by.point(p))),
        }
    }

    /// Whether every number is finite and every radius and direction is in its range.
    pub fn is_sound(&self) -> bool {
        let positive = |x: &f64| *x > 0.0 && x.is_finite();
        match self {
            Curve::Line { origin, direction } => origin.is_finite() && (direction.length() - 1.0).abs() < 1e-9,
            Curve::Circle { frame, radius } => frame.is_sound() && positive(radius),
            Curve::Ellipse { frame, radii } => frame.is_sound() && radii.iter().all(positive) && radii[0] >= radii[1],
            Curve::Parabola { frame, focal } => frame.is_sound() && positive(focal),
            Curve::Hyperbola { frame, radii } => frame.is_sound() && radii.iter().all(positive),
            Curve::Spline(s) => s.points().iter().all(|p| p.is_finite()),
        }
    }
}
