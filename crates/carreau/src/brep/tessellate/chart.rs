//! The plane in which a face is triangulated: its parameter plane, stretched so that lengths are nearly those of the surface; polar
//! coordinates about the pole for a face that has one, so that triangles there fan out from it as they do in space.
//!
//! ```text
//!    u ►  ┌──────────┐  pole            seam  ╲ │ ╱
//!         │          │            ▷            ╲│╱ pole
//!         └──────────┘  ring                ring╲╱ (an opening is left, so that the seam has two sides)
//! ```

use crate::brep::Surface;
use crate::brep::boundary::Ring;
use glam::DVec2;

/// The opening that is left of a full turn where a surface does not tell how large it is: a cone's does.
const OPENING: f64 = 0.9;

/// A map between (u, v) and a plane, of positive orientation.
#[derive(Debug, Clone, Copy)]
pub(super) enum Chart {
    /// Lengths of a unit of u and of v.
    Stretched(DVec2),
    /// About a pole.
    Polar {
        /// Its v.
        pole: f64,
        /// 1 where v grows away from the pole, −1 where it falls.
        away: f64,
        /// The u whose ray is the positive x axis.
        middle: f64,
        /// Angle in the plane of a unit of u.
        turn: f64,
        /// Length of a unit of v.
        scale: f64,
        /// Distances that are none.
        tiny: f64,
    },
}

impl Chart {
    /// The chart of a face with these loops.
    pub fn new(surface: &Surface, rings: &[Ring]) -> Self {
        let samples = || rings.iter().flat_map(|r| &r.samples);
        let size = mean_lengths(surface, rings);
        let is_pole = |uv: DVec2| surface.is_pole(surface.point(uv.x, uv.y));
        let mut poles: Vec<f64> = samples().map(|s| s.uv).filter(|&uv| is_pole(uv)).map(|uv| uv.y).collect();
        poles.sort_by(f64::total_cmp);
        poles.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        let &[pole] = &poles[..] else { return Chart::Stretched(size) };
        let range =
            |k: usize| samples().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], s| [l.min(s.uv[k]), h.max(s.uv[k])]);
        let ([u0, u1], [low, high]) = (range(0), range(1));
        let away = if pole <= 0.5 * (low + high) { 1.0 } else { -1.0 };
        let (turn, scale) = match surface {
            Surface::Cone { half_angle, .. } => (half_angle.sin(), 1.0 / half_angle.cos()),
            _ => (OPENING, size.y),
        };
        Chart::Polar { pole, away, middle: 0.5 * (u0 + u1), turn, scale, tiny: 1e-9 * (high - low) * scale }
    }

    /// From parameters to the plane.
    pub fn place(&self, uv: DVec2) -> DVec2 {
        match *self {
            Chart::Stretched(scale) => uv * scale,
            Chart::Polar { pole, away, middle, turn, scale, tiny } => {
                let r = (uv.y - pole) * away * scale;
                let r = if r > tiny { r } else { 0.0 };
                r * DVec2::from_angle(-away * turn * (uv.x - middle))
            }
        }
    }

    /// From the plane to parameters; at a pole u is that of the middle.
    pub fn parameters(&self, p: DVec2) -> DVec2 {
        match *self {
            Chart::Stretched(scale) => p / scale,
            Chart::Polar { pole, away, middle, turn, scale, .. } => {
                let angle = if self.is_pole(p) { 0.0 } else { p.to_angle() };
                DVec2::new(middle - away * angle / turn, pole + away * p.length() / scale)
            }
        }
    }

    /// Whether a place of the plane is the pole.
    pub fn is_pole(&self, p: DVec2) -> bool {
        matches!(self, Chart::Polar { tiny, .. } if p.length() <= *tiny)
    }
}

/// Mean lengths of a unit of u and of v along the border.
pub(super) fn mean_lengths(surface: &Surface, rings: &[Ring]) -> DVec2 {
    let mut sum = DVec2::ZERO;
    let mut count = 0.0;
    for s in rings.iter().flat_map(|r| &r.samples) {
        let [a, b] = surface.jet(s.uv.x, s.uv.y).first;
        sum += DVec2::new(a.length(), b.length());
        count += 1.0;
    }
    let mean = sum / f64::max(count, 1.0);
    DVec2::new(if mean.x > 0.0 { mean.x } else { 1.0 }, if mean.y > 0.0 { mean.y } else { 1.0 })
}
