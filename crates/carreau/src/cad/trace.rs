//! Intersection curves without a name: points on both surfaces, and a cubic spline through them.
//!
//! Points come from the mesh's polyline and are moved onto both surfaces by Gauss–Newton steps of least length; the spline is
//! C² by chord length. Spans whose middle is too far from a surface get another point there, until none is.

use super::tuning::{DOUBLINGS, FREE_EIGENVALUE, NEWTON_STEPS, SPLINE_POINTS, TANGENT_COSINE};
use crate::brep::Surface;
use crate::geometry::bspline::{BSplineCurve, Knots};
use crate::numeric::eigen3::{Eigen3, outer};
use glam::{DMat3, DVec3};

/// Surface normal at the point next to `p`, and signed distance along it.
pub fn signed(surface: &Surface, p: DVec3) -> (DVec3, f64) {
    let [u, v] = surface.project(p);
    let n = surface.normal(u, v);
    (n, n.dot(p - surface.point(u, v)))
}

/// The point near `p` on all surfaces, by steps of least length; where they are tangent, between them.
pub fn meet(surfaces: &[&Surface], p: DVec3) -> DVec3 {
    let mut p = p;
    // The way is short: from the second step on the nearest points are near those before.
    let mut feet: Vec<[f64; 2]> = surfaces.iter().map(|s| s.project(p)).collect();
    for _ in 0..NEWTON_STEPS {
        let (mut matrix, mut rhs) = (DMat3::ZERO, DVec3::ZERO);
        for (s, at) in surfaces.iter().zip(&mut feet) {
            *at = s.project_near(p, *at);
            let n = s.normal(at[0], at[1]);
            matrix += outer(n);
            rhs -= n * n.dot(p - s.point(at[0], at[1]));
        }
        let step = Eigen3::new(matrix).solve(rhs, FREE_EIGENVALUE);
        p += step;
        if !(step.length() > 1e-15 * p.length()) {
            break;
        }
    }
    p
}

/// Largest distance of a point from two surfaces.
pub fn gap(a: &Surface, b: &Surface, p: DVec3) -> f64 {
    a.distance(p).max(b.distance(p))
}

/// Whether two surfaces touch, rather than cross, near all of these points.
pub fn touch(a: &Surface, b: &Surface, points: &[DVec3]) -> bool {
    points.iter().all(|&p| {
        let (n, m) = (signed(a, p).0, signed(b, p).0);
        n.dot(m).abs() > TANGENT_COSINE
    })
}

/// The point of a contact near `p`: on both surfaces, where their normals agree, sought across the direction of travel.
fn contact(a: &Surface, b: &Surface, p: DVec3, along: DVec3) -> DVec3 {
    let mut p = meet(&[a, b], p);
    let turn = |q: DVec3, across: DVec3| {
        let (n, m) = (signed(a, q).0, signed(b, q).0);
        (if n.dot(m) < 0.0 { -m } else { m } - n).dot(across)
    };
    for _ in 0..NEWTON_STEPS {
        let across = signed(a, p).0.cross(along).normalize_or_zero();
        let h = 1e-4 * along.length();
        let (f, g) = (turn(p, across), turn(meet(&[a, b], p + across * h), across));
        let step = -f * h / (g - f);
        if !step.is_finite() || step.abs() > along.length() {
            break;
        }
        p = meet(&[a, b], p + across * step);
        if step.abs() < 1e-13 * along.length() {
            break;
        }
    }
    p
}

/// A spline near both surfaces along a polyline, and its largest distance from them. A closed polyline repeats its first point.
pub fn trace(a: &Surface, b: &Surface, polyline: &[DVec3], tolerance: f64) -> Option<(BSplineCurve, f64)> {
    let met: Vec<DVec3> = polyline.iter().map(|&p| meet(&[a, b], p)).collect();
    let tangent = touch(a, b, &met);
    let place = |p: DVec3, along: DVec3| if tangent { contact(a, b, p, along) } else { meet(&[a, b], p) };
    let n = polyline.len();
    let closed = polyline[0] == polyline[n - 1];
    let mut points: Vec<DVec3> =
        (0..n).map(|k| place(polyline[k], polyline[(k + 1).min(n - 1)] - polyline[k.saturating_sub(1)])).collect();
    if closed {
        points[n - 1] = points[0];
    }
    refined(points, closed, place, |p| gap(a, b, p), tolerance)
}

/// A spline on a surface, or nowhere in particular, through a polyline, and its largest distance from the surface. A closed
/// polyline repeats its first point.
pub fn upon(surface: Option<&Surface>, polyline: &[DVec3], tolerance: f64) -> Option<(BSplineCurve, f64)> {
    let n = polyline.len();
    let closed = polyline[0] == polyline[n - 1];
    let Some(surface) = surface else {
        let points = if n < 4 { doubled(polyline, |p, _| p, |_| true) } else { polyline.to_vec() };
        return interpolate(&points, closed).map(|(spline, _)| (spline, 0.0));
    };
    let place = |p: DVec3, _: DVec3| {
        let [u, v] = surface.project(p);
        surface.point(u, v)
    };
    let mut points: Vec<DVec3> = polyline.iter().map(|&p| place(p, DVec3::ZERO)).collect();
    if closed {
        points[n - 1] = points[0];
    }
    refined(points, closed, place, |p| surface.distance(p), tolerance)
}

/// The spline through points, which are doubled where it is farther than a tolerance from where it should be.
fn refined(
    mut points: Vec<DVec3>,
    closed: bool,
    place: impl Fn(DVec3, DVec3) -> DVec3,
    gap: impl Fn(DVec3) -> f64,
    tolerance: f64,
) -> Option<(BSplineCurve, f64)> {
    // Two points give no direction.
    while points.len() < 4 {
        points = doubled(&points, &place, |_| true);
    }
    let mut best: Option<(BSplineCurve, f64)> = None;
    for _ in 0..DOUBLINGS {
        points.dedup();
        if points.len() < 3 {
            return None;
        }
        let (spline, times) = interpolate(&points, closed)?;
        let error: Vec<f64> = times
            .windows(2)
            .map(|w| {
                [0.25, 0.5, 0.75].map(|s| gap(spline.point(w[0] + s * (w[1] - w[0])))).into_iter().fold(0.0, f64::max)
            })
            .collect();
        let worst = error.iter().copied().fold(0.0, f64::max);
        if !worst.is_finite() {
            return best;
        }
        if best.as_ref().is_none_or(|b| worst < b.1) {
            best = Some((spline, worst));
        }
        if worst <= tolerance || points.len() > SPLINE_POINTS {
            break;
        }
        // The neighbours too: knots that grade gently make no waves.
        let bad = |k: usize| (k.saturating_sub(1)..=(k + 1).min(error.len() - 1)).any(|j| error[j] > tolerance);
        points = doubled(&points, &place, bad);
    }
    best
}

fn doubled(points: &[DVec3], place: impl Fn(DVec3, DVec3) -> DVec3, which: impl Fn(usize) -> bool) -> Vec<DVec3> {
    let mut out = vec![points[0]];
    for (k, w) in points.windows(2).enumerate() {
        if which(k) {
            out.push(place(0.5 * (w[0] + w[1]), w[1] - w[0]));
        }
        out.push(w[1]);
    }
    out
}

/// The C² cubic through points, by chord length: natural at free ends, periodic where the last point is the first. Also the
/// parameters of the points.
pub fn interpolate(points: &[DVec3], closed: bool) -> Option<(BSplineCurve, Vec<f64>)> {
    let mut t = vec![0.0];
    for w in points.windows(2) {
        t.push(t[t.len() - 1] + w[0].distance(w[1]));
    }
    let spline = interpolate_at(points, &t, closed)?;
    Some((spline, t))
}

/// The same with an open curve's continuation beyond those ends that `reaches` says, by half a span.
pub fn continued(points: &[DVec3], reaches: impl Fn(DVec3) -> bool) -> Option<BSplineCurve> {
    let (spline, mut t) = interpolate(points, false)?;
    let mut points = points.to_vec();
    let n = t.len() - 1;
    // The third derivative is constant in the first and last piece.
    for (end, next) in [(n, n - 1), (0, 1)] {
        let [p, d, dd] = spline.derivatives(t[end]);
        let ddd = (spline.derivatives(t[next])[2] - dd) / (t[next] - t[end]);
        let step = 0.5 * (t[end] - t[next]);
        let beyond = p + step * (d + step / 2.0 * (dd + step / 3.0 * ddd));
        if reaches(p) && reaches(beyond) {
            let at = if end == 0 { 0 } else { n + 1 };
            points.insert(at, beyond);
            t.insert(at, t[end] + step);
        }
    }
    let first = t[0];
    t.iter_mut().for_each(|x| *x -= first);
    interpolate_at(&points, &t, false)
}

fn interpolate_at(points: &[DVec3], t: &[f64], closed: bool) -> Option<BSplineCurve> {
    let n = points.len() - 1;
    let h: Vec<f64> = t.windows(2).map(|w| w[1] - w[0]).collect();
    if h.iter().any(|x| !(*x > 0.0)) {
        return None;
    }
    let d = if closed { periodic_slopes(points, &h) } else { free_slopes(points, &h) };
    // Control points as blossoms of the pieces: knots are the parameters, each once inside.
    let knots = Knots::from_breaks(3, t, 1).ok()?;
    let blossom = |k: usize, s: [f64; 3]| {
        let [p, q] = [points[k], points[k + 1]];
        let (e, hk) = ((q - p) / h[k], h[k]);
        let (c2, c3) = ((3.0 * e - 2.0 * d[k] - d[k + 1]) / hk, (d[k] + d[k + 1] - 2.0 * e) / (hk * hk));
        let [x, y, z] = s.map(|s| s - t[k]);
        p + d[k] * ((x + y + z) / 3.0) + c2 * ((x * y + y * z + z * x) / 3.0) + c3 * (x * y * z)
    };
    let values = knots.values();
    let control = (0..n + 3).map(|j| {
        // A span that the basis function lives on, in the middle of its support.
        let piece = j.saturating_sub(2).max(j.saturating_sub(1).min(n - 1)).min(n - 1);
        blossom(piece, [values[j + 1], values[j + 2], values[j + 3]])
    });
    let mut control: Vec<DVec3> = control.collect();
    (control[0], control[n + 2]) = (points[0], points[n]);
    BSplineCurve::new(knots, control).ok()
}

/// Slopes of the C² cubic with a third derivative that is continuous at the first and last inner point (not-a-knot would need
/// four points): parabolic ends.
fn free_slopes(p: &[DVec3], h: &[f64]) -> Vec<DVec3> {
    let n = h.len();
    let e: Vec<DVec3> = (0..n).map(|k| (p[k + 1] - p[k]) / h[k]).collect();
    if n == 1 {
        return vec![e[0]; 2];
    }
    // Not-a-knot: the first two pieces are one cubic, and so are the last two.
    let mut rows: Vec<[f64; 3]> = Vec::with_capacity(n + 1);
    let mut rhs: Vec<DVec3> = Vec::with_capacity(n + 1);
    let end = |h0: f64, h1: f64, e0: DVec3, e1: DVec3| {
        ([h1, h0 + h1], (e0 * (h1 * (3.0 * h0 + 2.0 * h1)) + e1 * (h0 * h0)) / (h0 + h1))
    };
    if n == 2 {
        // One parabola through three points.
        let middle = (e[0] * h[1] + e[1] * h[0]) / (h[0] + h[1]);
        return vec![2.0 * e[0] - middle, middle, 2.0 * e[1] - middle];
    }
    let (first, value) = end(h[0], h[1], e[0], e[1]);
    rows.push([0.0, first[0], first[1]]);
    rhs.push(value);
    for k in 1..n {
        rows.push([h[k], 2.0 * (h[k - 1] + h[k]), h[k - 1]]);
        rhs.push(3.0 * (e[k - 1] * h[k] + e[k] * h[k - 1]));
    }
    let (last, value) = end(h[n - 1], h[n - 2], e[n - 1], e[n - 2]);
    rows.push([last[1], last[0], 0.0]);
    rhs.push(value);
    tridiagonal(&rows, rhs)
}

fn periodic_slopes(p: &[DVec3], h: &[f64]) -> Vec<DVec3> {
    let n = h.len();
    let e: Vec<DVec3> = (0..n).map(|k| (p[k + 1] - p[k]) / h[k]).collect();
    // Cyclic system by Sherman–Morrison.
    let row = |k: usize| {
        let before = (k + n - 1) % n;
        ([h[k], 2.0 * (h[before] + h[k]), h[before]], 3.0 * (e[before] * h[k] + e[k] * h[before]))
    };
    let (mut rows, rhs): (Vec<[f64; 3]>, Vec<DVec3>) = (0..n).map(row).unzip();
    let (corner_low, corner_high) = (rows[n - 1][2], rows[0][0]);
    let gamma = -rows[0][1];
    rows[0][1] -= gamma;
    rows[n - 1][1] -= corner_low * corner_high / gamma;
    let mut u = vec![DVec3::ZERO; n];
    u[0] = DVec3::splat(gamma);
    u[n - 1] += DVec3::splat(corner_low);
    let x = tridiagonal(&rows, rhs);
    let z = tridiagonal(&rows, u);
    let share = (x[0] + x[n - 1] * (corner_high / gamma)) / (1.0 + z[0].x + z[n - 1].x * corner_high / gamma);
    let mut d: Vec<DVec3> = (0..n).map(|k| x[k] - share * z[k].x).collect();
    d.push(d[0]);
    d
}

/// Thomas's algorithm; rows hold what is left of, on, and right of the diagonal.
fn tridiagonal(rows: &[[f64; 3]], mut rhs: Vec<DVec3>) -> Vec<DVec3> {
    let n = rows.len();
    let mut diagonal: Vec<f64> = rows.iter().map(|r| r[1]).collect();
    for k in 1..n {
        let share = rows[k][0] / diagonal[k - 1];
        diagonal[k] -= share * rows[k - 1][2];
        let above = rhs[k - 1];
        rhs[k] -= share * above;
    }
    rhs[n - 1] /= diagonal[n - 1];
    for k in (0..n - 1).rev() {
        let below = rhs[k + 1];
        rhs[k] = (rhs[k] - rows[k][2] * below) / diagonal[k];
    }
    rhs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_reproduced_and_circles_are_smooth() {
        let cubic = |t: f64| DVec3::new(t, 0.3 * t * t - 0.1 * t * t * t, 0.0);
        // Parameters are chord lengths, so that only a straight line is reproduced to rounding.
        let line: Vec<DVec3> = [0.0, 0.3, 1.0, 1.1, 2.0].iter().map(|&t| DVec3::new(t, 2.0 * t, -t)).collect();
        let (spline, times) = interpolate(&line, false).unwrap();
        assert!(times.iter().zip(&line).all(|(&t, p)| spline.point(t).distance(*p) < 1e-13));
        let points: Vec<DVec3> = (0..=32).map(|k| cubic(f64::from(k) / 16.0)).collect();
        let (spline, times) = interpolate(&points, false).unwrap();
        assert!(times.iter().zip(&points).all(|(&t, p)| spline.point(t).distance(*p) < 1e-13));
        let longer = continued(&points, |_| true).unwrap();
        let shift = spline.points()[0].distance(longer.points()[0]);
        let same = |&t: &f64| longer.project(spline.point(t), t + shift);
        assert!(times.iter().all(|t| longer.point(same(t)).distance(spline.point(*t)) < 1e-12));
        assert!(longer.ends()[1].x > 2.0 && longer.ends()[0].x < 0.0);
        let circle: Vec<DVec3> = (0..=32)
            .map(|k| std::f64::consts::TAU * f64::from(k % 32) / 32.0)
            .map(|a| DVec3::new(a.cos(), a.sin(), 0.0))
            .collect();
        let (spline, times) = interpolate(&circle, true).unwrap();
        let off = |w: &[f64]| (spline.point(0.5 * (w[0] + w[1])).length() - 1.0).abs();
        assert!(times.windows(2).map(off).fold(0.0, f64::max) < 2e-5);
        let ends = [0.0, times[32]].map(|t| spline.derivatives(t)[1]);
        assert!(ends[0].distance(ends[1]) < 1e-9);
    }
}
