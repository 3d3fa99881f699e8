//! The parameters of the point of a surface that is nearest to a given one.

use super::Surface;
use crate::geometry::bspline::BSplineSurface;
use glam::DVec3;
use std::f64::consts::PI;

/// Samples of a span of a spline in each direction, among which the start of a search is chosen.
const SURFACE_SPAN_SAMPLES: usize = 3;
/// Most such samples in all.
const MAX_SAMPLES: usize = 4096;
/// Samples from which Newton's method is tried.
const SURFACE_STARTS: usize = 3;

impl Surface {
    /// The parameters of the nearest point: angles in [−π, π], parameters of splines in their domain. On the axis of a
    /// surface that is round, u is 0.
    pub fn project(&self, p: DVec3) -> [f64; 2] {
        match self {
            Surface::Extrusion { profile, .. } => self.project_swept(p, |q| profile.project(q)),
            Surface::Revolution { profile, .. } => self.project_swept(p, |q| profile.project(q)),
            Surface::Spline(s) => nearest(s, p),
            _ => self.project_analytic(p),
        }
    }

    /// The parameters of a nearest point, searched from `start` on splines and swept surfaces. Periodic parameters come out
    /// in the period nearest to `start`, so that following a curve from sample to sample unrolls it; u stays that of
    /// `start` on the axis of a surface that is round.
    pub fn project_near(&self, p: DVec3, start: [f64; 2]) -> [f64; 2] {
        let mut at = match self {
            Surface::Extrusion { profile, .. } => self.project_swept(p, |q| profile.project_near(q, start[0])),
            Surface::Revolution { profile, .. } => self.project_swept(p, |q| profile.project_near(q, start[1])),
            Surface::Spline(s) => s.project(p, start),
            _ => self.project_analytic(p),
        };
        if self.is_on_axis(p) {
            at[0] = start[0];
        }
        for (x, (start, period)) in at.iter_mut().zip(start.into_iter().zip(self.periods())) {
            if let Some(period) = period {
                *x += period * ((start - *x) / period).round();
            }
        }
        at
    }

    /// The distance of a point from the whole surface.
    pub fn distance(&self, p: DVec3) -> f64 {
        let [u, v] = self.project(p);
        self.point(u, v).distance(p)
    }

    /// Whether a point is on the axis of a surface that is round, up to rounding: its angle means nothing.
    pub fn is_on_axis(&self, p: DVec3) -> bool {
        let (Surface::Cylinder { frame, .. }
        | Surface::Cone { frame, .. }
        | Surface::Sphere { frame, .. }
        | Surface::Torus { frame, .. }
        | Surface::Revolution { frame, .. }) = self
        else {
            return false;
        };
        let offset = p - frame.origin;
        let profile = frame.profile(p);
        profile.x <= 1e-9 * offset.length().max(1e-3 * p.length())
    }

    /// Whether a point of the surface is a pole or an apex, where u has no value.
    pub fn is_pole(&self, p: DVec3) -> bool {
        // The axis of these meets the surface nowhere.
        let clear = match self {
            Surface::Cylinder { .. } => true,
            Surface::Torus { major_radius, minor_radius, .. } => minor_radius < major_radius,
            _ => false,
        };
        !clear && self.is_on_axis(p)
    }

    fn project_analytic(&self, p: DVec3) -> [f64; 2] {
        match self {
            Surface::Cylinder { frame, .. } => [frame.angle(p), frame.local(p).z],
            Surface::Cone { frame, radius, half_angle } => {
                let (rho, z) = frame.profile(p).into();
                let slope = half_angle.tan();
                let v = ((rho - radius) * slope + z) / (1.0 + slope * slope);
                [frame.angle(p), v.max(-radius / slope)]
            }
            Surface::Sphere { frame, .. } => {
                let (rho, z) = frame.profile(p).into();
                [frame.angle(p), z.atan2(rho)]
            }
            Surface::Torus { frame, major_radius, .. } => {
                let (rho, z) = frame.profile(p).into();
                [frame.angle(p), z.atan2(rho - major_radius)]
            }
            Surface::Plane { frame } => {
                let l = frame.local(p);
                [l.x, l.y]
            }
            _ => [0.0; 2],
        }
    }

    /// Swept surfaces: the point is moved into the profile's plane, where `foot` finds its parameter.
    fn project_swept(&self, p: DVec3, foot: impl Fn(DVec3) -> f64) -> [f64; 2] {
        match self {
            Surface::Extrusion { profile, direction } => {
                let level = (profile.point(profile.domain()[0].max(0.0)) - p).dot(*direction);
                let u = foot(p + level * direction);
                [u, (p - profile.point(u)).dot(*direction)]
            }
            Surface::Revolution { frame, .. } => {
                let (rho, z) = frame.profile(p).into();
                [frame.angle(p).clamp(-PI, PI), foot(frame.origin + rho * frame.x + z * frame.z)]
            }
            _ => [0.0; 2],
        }
    }
}

/// The best of Newton's results from the best points of a grid.
fn nearest(s: &BSplineSurface, p: DVec3) -> [f64; 2] {
    let spans = s.knots().map(|k| k.breaks().len() - 1);
    let per_span = if spans[0] * spans[1] * SURFACE_SPAN_SAMPLES * SURFACE_SPAN_SAMPLES > MAX_SAMPLES {
        1
    } else {
        SURFACE_SPAN_SAMPLES
    };
    let grid = s.knots().map(|k| {
        let breaks = k.breaks();
        let inside = |w: &[f64]| {
            let [a, b] = [w[0], w[1]];
            (0..per_span).map(move |k| a + (b - a) * k as f64 / per_span as f64)
        };
        let last = breaks.last().copied();
        breaks.windows(2).flat_map(inside).chain(last).collect::<Vec<f64>>()
    });
    let mut best = [(f64::INFINITY, [grid[0][0], grid[1][0]]); SURFACE_STARTS];
    for &u in &grid[0] {
        for &v in &grid[1] {
            let mut found = (s.point(u, v).distance_squared(p), [u, v]);
            for kept in &mut best {
                if found.0 < kept.0 {
                    std::mem::swap(&mut found, kept);
                }
            }
        }
    }
    let found = best.into_iter().filter(|b| b.0.is_finite()).map(|(_, start)| s.project(p, start));
    let measured = found.map(|[u, v]| (s.point(u, v).distance_squared(p), [u, v]));
    measured.min_by(|a, b| a.0.total_cmp(&b.0)).map_or([grid[0][0], grid[1][0]], |(_, at)| at)
}
