//! What programs will show as area and volume of a model, and what they should show.
//!
//! OpenCASCADE's default rule (`BRepGProp` without an accuracy; FreeCAD, CadQuery, build123d and Gmsh call it) integrates a
//! face as ∮ (∫ f du) dv along its border in the parameter plane, f from the smallest u to the border's: one set of Gauss
//! points for every edge, one for the way across, however many knots there are. Their numbers follow from degrees and
//! knots (`BRepGProp_Face`): a surface with s spans of degree p has max(8, 2 (p + 1) s) across, a border curve
//! max(4, 2 (p + 1) s), volumes take the larger of the curve's and the v direction's both ways, and 61 is the most. (Newer
//! versions give straight border curves as many as the v direction has; the older ones are the stricter judge.) So knots of
//! the border curves in the parameter plane make the rule finer. The rule is restated here, next to the same integral from knot to knot, so that a face can be judged before it is written.
//!
//! ```text
//!   v │    ┌──────────•        every • one Gauss point of the right side; along the dotted
//!     │    │·  ·  ·  ··        line the points across
//!     │    │          •
//!     │    └──────────┘        left, bottom and top contribute nothing
//!     └────────────────── u
//! ```

use crate::brep::{Brep, Curve, EdgeUse, Face, Surface};
use crate::geometry::bspline::BSplineSurface;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::LazyLock;

/// Most Gauss points of the rule in one direction.
const MOST_POINTS: usize = 61;
/// Error of the rule that a divided face may have, as a share of its area: a tenth of what all together may have.
const SHARE: f64 = 1e-5;

/// Area, and volume between the surface and an origin.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Weight {
    pub area: f64,
    pub volume: f64,
}

/// By the default rule, and exactly.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Weighed {
    pub rule: Weight,
    pub exact: Weight,
}

impl Weighed {
    /// Relative errors of area and volume by the rule.
    pub fn errors(&self) -> [f64; 2] {
        let relative = |a: f64, b: f64| if b == 0.0 { 0.0 } else { (a - b).abs() / b.abs() };
        [relative(self.rule.area, self.exact.area), relative(self.rule.volume, self.exact.volume)]
    }

    fn plus(self, other: Weighed) -> Weighed {
        let sum = |a: Weight, b: Weight| Weight { area: a.area + b.area, volume: a.volume + b.volume };
        Weighed { rule: sum(self.rule, other.rule), exact: sum(self.exact, other.exact) }
    }
}

/// The whole model.
pub fn weigh(brep: &Brep) -> Weighed {
    let [low, high] = brep.bounds();
    let origin = 0.5 * (low + high);
    let faces: Vec<Weighed> = brep.faces.par_iter().map(|face| weigh_face(brep, face, origin)).collect();
    faces.into_iter().fold(Weighed::default(), Weighed::plus)
}

/// One face; its volume is that between it and the origin.
pub fn weigh_face(brep: &Brep, face: &Face, origin: DVec3) -> Weighed {
    match brep.surface(face) {
        Surface::Plane { frame } => {
            let parts = face.uses().map(|of| plane_area(brep, of, [frame.origin, frame.x, frame.y()]));
            let [rule, exact] = parts.fold([0.0; 2], |s, a| [s[0] + a[0], s[1] + a[1]]);
            let height = (frame.origin - origin).dot(frame.z) / 3.0;
            let weight = |area: f64| Weight { area, volume: area * height };
            Weighed { rule: weight(rule), exact: weight(exact) }
        }
        Surface::Spline(surface) => {
            let runs = face.uses().map(|of| Run::new(brep, of));
            runs.fold(Weighed::default(), |sum, run| sum.plus(run.weighed(surface, origin)))
        }
        // Patches have no others.
        _ => Weighed::default(),
    }
}

/// Whether the rule is right on a whole surface whose right side is cut into edges with these breaks in v.
pub fn is_right(surface: &BSplineSurface, right: &[Vec<f64>]) -> bool {
    let u = surface.knots()[0].domain()[1];
    let runs =
        right.iter().map(|breaks| Run { points: breaks.iter().map(|&v| [u, v]).collect(), breaks: breaks.clone() });
    let points = surface.points();
    let origin = points.iter().sum::<DVec3>() / points.len() as f64;
    let size = points.iter().map(|p| p.distance(origin)).fold(0.0, f64::max);
    let all = runs.fold(Weighed::default(), |sum, run| sum.plus(run.weighed(surface, origin)));
    let area = all.exact.area;
    (all.rule.area - area).abs() <= SHARE * area && (all.rule.volume - all.exact.volume).abs() <= SHARE * area * size
}

/// ∮ x dy of an edge on a plane (base, x, y): by the rule, and exactly.
fn plane_area(brep: &Brep, of: &EdgeUse, [base, x, y]: [DVec3; 3]) -> [f64; 2] {
    let edge = &brep.edges[of.edge as usize];
    let flat = |p: DVec3| [(p - base).dot(x), (p - base).dot(y)];
    let sense = if of.reversed { -1.0 } else { 1.0 };
    let Curve::Spline(curve) = &edge.curve else {
        let [a, b] = edge.ends.map(|v| flat(brep.point(v)));
        return [sense * 0.5 * (a[0] + b[0]) * (b[1] - a[1]); 2];
    };
    let at = |t: f64| {
        let [p, d, _] = curve.derivatives(t);
        (p - base).dot(x) * d.dot(y)
    };
    let breaks = curve.knots().breaks();
    let count = border_points(curve.knots().degree(), breaks.len() - 1);
    let rule = integral(curve.knots().domain(), count, at);
    let exact: f64 = breaks.windows(2).map(|w| integral([w[0], w[1]], 4, at)).sum();
    [sense * rule, sense * exact]
}

/// Gauss points of a border curve.
fn border_points(degree: usize, spans: usize) -> usize {
    (2 * (degree + 1) * spans).clamp(4, MOST_POINTS)
}

fn integral([a, b]: [f64; 2], count: usize, f: impl Fn(f64) -> f64) -> f64 {
    let (half, middle) = (0.5 * (b - a), 0.5 * (a + b));
    half * gauss(count).iter().map(|&(x, w)| w * f(middle + half * x)).sum::<f64>()
}

/// A border curve in the parameter plane: a polyline over break points.
struct Run {
    points: Vec<[f64; 2]>,
    breaks: Vec<f64>,
}

impl Run {
    fn new(brep: &Brep, of: &EdgeUse) -> Run {
        let mut points = of.parameters.clone();
        let mut breaks = match &brep.edges[of.edge as usize].curve {
            Curve::Spline(c) if points.len() > 2 => c.knots().breaks(),
            _ => vec![0.0, 1.0],
        };
        if of.reversed {
            points.reverse();
            breaks = breaks.iter().rev().map(|t| -t).collect();
        }
        Run { points, breaks }
    }

    /// Position and dv/dl.
    fn at(&self, l: f64) -> ([f64; 2], f64) {
        let last = self.points.len().min(self.breaks.len()) - 1;
        let k = self.breaks.partition_point(|&b| b <= l).clamp(1, last);
        let (step, [a, b]) = (self.breaks[k] - self.breaks[k - 1], [self.points[k - 1], self.points[k]]);
        let share = (l - self.breaks[k - 1]) / step;
        ([0, 1].map(|x| a[x] + share * (b[x] - a[x])), (b[1] - a[1]) / step)
    }

    fn weighed(&self, surface: &BSplineSurface, origin: DVec3) -> Weighed {
        if self.points.len() < 2 || self.breaks.len() < 2 {
            return Weighed::default();
        }
        let [u, v] = surface.knots();
        let low = u.domain()[0];
        let moves = self.points.windows(2).any(|w| w[0][1] != w[1][1]);
        if !moves || self.points.iter().all(|p| p[0] == low) {
            return Weighed::default();
        }
        let spans = |k: &crate::geometry::bspline::Knots| k.distinct().count() - 1;
        let across = |k: &crate::geometry::bspline::Knots| (2 * (k.degree() + 1) * spans(k)).max(8);
        let along = border_points(1, self.breaks.len() - 1);
        let ends = [self.breaks[0], self.breaks[self.breaks.len() - 1]];
        let sum = |count: [usize; 2]| {
            integral_of(ends, count[0], |l| {
                let (p, speed) = self.at(l);
                let line = integral_of([low, p[0]], count[1], |x| density(surface, x, p[1], origin));
                line.map(|x| speed * x)
            })
        };
        let area = sum([along, across(u).max(across(v)).min(MOST_POINTS)])[0];
        let both = along.max(across(v)).min(MOST_POINTS);
        let volume = sum([both, both])[1];
        let exact = self.exact(surface, origin);
        Weighed { rule: Weight { area, volume }, exact: Weight { area: exact[0], volume: exact[1] } }
    }

    /// The same from knot to knot.
    fn exact(&self, surface: &BSplineSurface, origin: DVec3) -> [f64; 2] {
        let [u, v] = surface.knots().map(|k| k.breaks());
        let count = if surface.knots().iter().all(|k| k.degree() == 1) { 6 } else { 8 };
        let mut sum = [0.0; 2];
        for (w, l) in self.points.windows(2).zip(self.breaks.windows(2)) {
            // Where the segment crosses the rows.
            let [a, b] = [w[0][1], w[1][1]];
            let mut stops: Vec<f64> =
                v.iter().map(|&t| (t - a) / (b - a)).filter(|s| *s > 1e-12 && *s < 1.0 - 1e-12).collect();
            stops.extend([0.0, 1.0]);
            stops.sort_unstable_by(f64::total_cmp);
            for s in stops.windows(2) {
                let part = integral_of([0, 1].map(|k| l[0] + s[k] * (l[1] - l[0])), count, |l| {
                    let (p, speed) = self.at(l);
                    let mut line = [0.0; 2];
                    for span in u.windows(2).filter(|span| span[0] < p[0]) {
                        let of =
                            integral_of([span[0], span[1].min(p[0])], count, |x| density(surface, x, p[1], origin));
                        line = [line[0] + of[0], line[1] + of[1]];
                    }
                    line.map(|x| speed * x)
                });
                sum = [sum[0] + part[0], sum[1] + part[1]];
            }
        }
        sum
    }
}

/// Area and volume of a surface for each unit of parameter area.
fn density(surface: &BSplineSurface, u: f64, v: f64, origin: DVec3) -> [f64; 2] {
    let [point, du, dv] = if surface.knots().iter().all(|k| k.degree() == 1) {
        bilinear(surface, u, v)
    } else {
        let jet = surface.jet(u, v);
        [jet.point, jet.first[0], jet.first[1]]
    };
    let vector = du.cross(dv);
    [vector.length(), (point - origin).dot(vector) / 3.0]
}

/// Point and derivatives of a surface of degree (1, 1): most faces are, and the rule looks at thousands of points of each.
fn bilinear(surface: &BSplineSurface, u: f64, v: f64) -> [DVec3; 3] {
    let [(i, s, width), (j, t, height)] = [(0, u), (1, v)].map(|(k, x)| {
        let knots = surface.knots()[k];
        let span = knots.span(x);
        let (low, high) = (knots.values()[span], knots.values()[span + 1]);
        (span - 1, (x - low) / (high - low), high - low)
    });
    let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(k, l)| surface.control(i + k, j + l));
    let (bottom, top) = (a.lerp(b, s), c.lerp(d, s));
    [bottom.lerp(top, t), (b - a).lerp(d - c, t) / width, (top - bottom) / height]
}

fn integral_of([a, b]: [f64; 2], count: usize, f: impl Fn(f64) -> [f64; 2]) -> [f64; 2] {
    let (half, middle) = (0.5 * (b - a), 0.5 * (a + b));
    let terms = gauss(count).iter().map(|&(x, w)| f(middle + half * x).map(|y| half * w * y));
    terms.fold([0.0; 2], |s, y| [s[0] + y[0], s[1] + y[1]])
}

/// Points in −1..=1 and weights of the Gauss–Legendre rule with 1 to 61 points.
fn gauss(count: usize) -> &'static [(f64, f64)] {
    static RULES: LazyLock<Vec<Vec<(f64, f64)>>> = LazyLock::new(|| (1..=MOST_POINTS).map(legendre).collect());
    &RULES[count.clamp(1, MOST_POINTS) - 1]
}

/// The roots of a Legendre polynomial by Newton's method, and their weights.
fn legendre(n: usize) -> Vec<(f64, f64)> {
    let root = |k: usize| {
        let mut x = -(std::f64::consts::PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 1.0;
        // Quadratic convergence from a guess that is good to four digits.
        for _ in 0..8 {
            let (mut p, mut before) = (x, 1.0);
            for j in 2..=n {
                let j = j as f64;
                (p, before) = (((2.0 * j - 1.0) * x * p - (j - 1.0) * before) / j, p);
            }
            slope = n as f64 * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(root).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bspline::Knots;

    #[test]
    fn the_short_way_to_bilinear_points_is_that_of_splines() {
        let [u, v] = [&[0.0, 0.3, 1.0, 1.1][..], &[-1.0, 2.0, 2.5]].map(|at| Knots::from_breaks(1, at, 1).unwrap());
        let at = |k: u32| DVec3::new(f64::from(k % 4), f64::from(k / 4), f64::from(k * k % 7));
        let surface = BSplineSurface::new(u, v, (0..12).map(at).collect()).unwrap();
        for k in 0..=20 {
            for l in 0..=20 {
                let (u, v) = (1.1 * f64::from(k) / 20.0, -1.0 + 3.5 * f64::from(l) / 20.0);
                let (jet, short) = (surface.jet(u, v), bilinear(&surface, u, v));
                let off = [short[0] - jet.point, short[1] - jet.first[0], short[2] - jet.first[1]];
                assert!(off.iter().all(|d| d.length() < 1e-12), "{u} {v} {off:?}");
            }
        }
    }
}
