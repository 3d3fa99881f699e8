//! Where a face is cut open: its loops as polygons in the parameters of its surface, and the line of constant parameter
//! between them that is free for a seam.

use super::conics::seam;
use super::draft::{Draft, DraftFace};
use super::regions::Piece;
use super::tuning::{LOOP_SAMPLES, SEAM_CLEARANCE};
use crate::brep::{Curve, Surface};
use glam::DVec3;
use std::f64::consts::TAU;

/// A share of a period: what stays this near to a seam runs along it, because where it crosses is left to rounding.
pub const ALONG_SEAM: f64 = 1e-6;

/// A loop as a polygon in the parameters.
pub struct Unrolled {
    /// Parameters, the use that each sample is on, and the parameter of that edge; the last sample closes the loop.
    pub samples: Vec<([f64; 2], usize, f64)>,
    pub winding: [i32; 2],
}

/// The parameter in which a surface closes as its profile does, where that is a spline.
pub fn spline_period(surface: &Surface) -> Option<usize> {
    let k = match surface {
        Surface::Extrusion { profile: Curve::Spline(_), .. } => 0,
        Surface::Revolution { profile: Curve::Spline(_), .. } => 1,
        _ => return None,
    };
    surface.periods()[k].map(|_| k)
}

/// A place where a loop crosses a line of constant parameter.
#[derive(Clone, Copy)]
pub struct Crossing {
    /// The other parameter.
    pub at: f64,
    pub of: usize,
    pub use_: usize,
    pub t: f64,
}

/// Points along an edge in the sense of a use, both ends included, with their parameters.
pub fn points(draft: &Draft, edge: u32, reversed: bool) -> impl Iterator<Item = (DVec3, f64)> + '_ {
    let e = &draft.edges[edge as usize];
    let count = match &e.curve {
        Curve::Line { .. } => LOOP_SAMPLES / 4,
        Curve::Spline(s) => (2 * s.points().len()).clamp(LOOP_SAMPLES, 16 * LOOP_SAMPLES),
        _ => 2 * LOOP_SAMPLES,
    };
    (0..=count).map(move |k| {
        let s = k as f64 / count as f64;
        let s = if reversed { 1.0 - s } else { s };
        let t = e.range[0] + s * (e.range[1] - e.range[0]);
        (e.curve.point(t), t)
    })
}

/// The least and the largest of a measure of the points of loops.
pub fn extent(draft: &Draft, loops: &[Vec<(u32, bool)>], of: impl Fn(DVec3) -> f64) -> [f64; 2] {
    let values = loops.iter().flatten().flat_map(|&(e, r)| points(draft, e, r)).map(|(p, _)| of(p));
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

/// A loop unrolled from its first sample on, into whatever period it leads to.
pub fn unroll(surface: &Surface, draft: &Draft, uses: &[(u32, bool)]) -> Unrolled {
    let all: Vec<(DVec3, usize, f64)> =
        uses.iter().enumerate().flat_map(|(k, &(e, r))| points(draft, e, r).map(move |(p, t)| (p, k, t))).collect();
    // Not from an apex or a pole, whose angle means nothing.
    let first = all.iter().position(|s| !surface.is_on_axis(s.0)).unwrap_or(0);
    let mut samples: Vec<([f64; 2], usize, f64)> = Vec::with_capacity(all.len() + 1);
    let mut at = surface.project(all[first].0);
    for k in 0..all.len() {
        let (p, u, t) = all[(first + k) % all.len()];
        at = if k == 0 { at } else { surface.project_near(p, at) };
        samples.push((at, u, t));
    }
    let last = surface.project_near(all[first].0, at);
    let mut winding = [0, 0];
    for (k, period) in surface.periods().into_iter().enumerate() {
        if let Some(period) = period {
            winding[k] = ((last[k] - samples[0].0[k]) / period).round() as i32;
        }
    }
    let (_, u, t) = samples[samples.len() - 1];
    samples.push((last, u, t));
    Unrolled { samples, winding }
}

impl Unrolled {
    /// Area in the parameters, positive where the loop is counter-clockwise.
    pub fn area(&self) -> f64 {
        self.samples.windows(2).map(|w| 0.5 * (w[0].0[0] * w[1].0[1] - w[1].0[0] * w[0].0[1])).sum()
    }

    /// The least and the largest value of parameter `k`.
    pub fn reach(&self, k: usize) -> [f64; 2] {
        let values = || self.samples.iter().map(|s| s.0[k]);
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    }

    /// Where the loop crosses parameter `k` = `at`, in any period.
    fn crossings(&self, k: usize, at: f64, period: f64, of: usize, out: &mut Vec<Crossing>) {
        for w in self.samples.windows(2) {
            let (a, b) = (w[0].0[k], w[1].0[k]);
            let (low, high) = (a.min(b), a.max(b));
            let mut x = at + period * ((low - at) / period).ceil();
            while x < high || (x == low && a != b) {
                let s = if a == b { 0.0 } else { (x - a) / (b - a) };
                // Between two edges nothing lies but rounding.
                let t = if w[0].1 == w[1].1 { w[0].2 + s * (w[1].2 - w[0].2) } else { w[0].2 };
                out.push(Crossing { at: w[0].0[1 - k] + s * (w[1].0[1 - k] - w[0].0[1 - k]), of, use_: w[0].1, t });
                x += period;
            }
        }
    }
}

/// The lines of constant parameter along which a face may be cut open.
pub struct Seams<'a> {
    pub piece: &'a Piece,
    pub unrolled: &'a [Unrolled],
    /// The parameter that is constant along the seam.
    pub k: usize,
}

impl Seams<'_> {
    fn period(&self) -> f64 {
        self.piece.surface.periods()[self.k].unwrap_or(TAU)
    }

    fn all(&self, x: f64) -> Vec<Crossing> {
        let mut out = Vec::new();
        for (of, u) in self.unrolled.iter().enumerate() {
            u.crossings(self.k, x, self.period(), of, &mut out);
        }
        out.sort_by(|a, b| a.at.total_cmp(&b.at));
        out
    }

    /// The next crossing on the side of the material, around the period of a torus.
    pub fn beyond(&self, low: &Crossing, x: f64) -> Option<Crossing> {
        let all = self.all(x);
        match self.piece.surface.periods()[1 - self.k] {
            None => all.into_iter().find(|c| c.at > low.at),
            Some(period) => {
                let ahead = |c: &Crossing| {
                    let d = (c.at - low.at).rem_euclid(period);
                    if d < 1e-9 * period || d > (1.0 - 1e-9) * period { period } else { d }
                };
                let next = all.into_iter().min_by(|a, b| ahead(a).total_cmp(&ahead(b)))?;
                let d = ahead(&next);
                (d < period).then_some(Crossing { at: low.at + d, ..next })
            }
        }
    }

    /// The best place for a seam: through vertices that are there, far from other loops. Returns the crossing of ring
    /// `a`.
    pub fn best(
        &self,
        draft: &Draft,
        face: &DraftFace,
        a: usize,
        b: Option<usize>,
        upward: bool,
    ) -> Option<(Crossing, f64)> {
        let period = self.period();
        let mut places = self.known_places(draft, face, [Some(a), b]);
        let (mut known, count) = (places.clone(), 24);
        known.sort_by(|x, y| x.0.total_cmp(&y.0));
        let start = self.unrolled[a].samples[0].0[self.k];
        places.extend((0..count).map(|j| (start + period * f64::from(j) / f64::from(count), 0)));
        places.extend(self.between_holes(a, b).into_iter().map(|x| (x, 0)));
        let mut best: Option<(f64, Crossing, f64)> = None;
        for (x, fixed) in places {
            if self.is_along(x) {
                continue;
            }
            let all = self.all(x);
            let crossing = if upward {
                all.iter().copied().filter(|c| c.of == a).max_by(|p, q| p.at.total_cmp(&q.at))
            } else {
                all.iter().copied().find(|c| c.of == a)
            };
            let Some(crossing) = crossing else { continue };
            let free = match b {
                Some(b) => self.beyond(&crossing, x).is_some_and(|c| c.of == b),
                None => all.iter().all(|c| c.of == a || (c.at > crossing.at) != upward),
            };
            let clear = self.clearance(x, a, b) / period;
            if !free || clear < SEAM_CLEARANCE {
                continue;
            }
            // Vertices of both rings at one place are worth most, then one, then room.
            let both =
                known.iter().filter(|y| ((y.0 - x) / period - ((y.0 - x) / period).round()).abs() < 1e-9).count();
            let score = 10.0 * f64::from(fixed) + 10.0 * both.min(2) as f64 + clear.min(0.25);
            if best.as_ref().is_none_or(|b| score > b.0 + 1e-9) {
                best = Some((score, crossing, x));
            }
        }
        best.map(|b| (b.1, b.2))
    }

    /// Places of vertices of the rings, and where a closed spline begins, with their worth: elsewhere that has to be divided.
    fn known_places(&self, draft: &Draft, face: &DraftFace, rings: [Option<usize>; 2]) -> Vec<(f64, u32)> {
        let surface = &self.piece.surface;
        let mut places: Vec<(f64, u32)> = Vec::new();
        for ring in rings.into_iter().flatten() {
            for &(e, _) in &face.loops[ring] {
                let edge = &draft.edges[e as usize];
                if edge.ends.is_none() && matches!(edge.curve, Curve::Spline(_)) {
                    places.push((surface.project(edge.curve.point(edge.range[0]))[self.k], 1));
                }
                let ends = edge.ends.into_iter().flatten().chain(edge.splits.iter().map(|s| s.1));
                for v in ends {
                    places.push((surface.project(draft.vertices[v as usize].point)[self.k], 1));
                }
            }
        }
        if spline_period(surface) == Some(self.k) {
            places.push((surface.domain()[self.k][0], 4));
        }
        places
    }

    /// Whether a loop runs along a seam: where it crosses that is anybody's guess.
    fn is_along(&self, x: f64) -> bool {
        let period = self.period();
        let near = |y: f64| ((y - x) / period - ((y - x) / period).round()).abs() < ALONG_SEAM;
        let mut steps = self.unrolled.iter().flat_map(|u| u.samples.windows(2)).map(|w| [w[0].0, w[1].0]);
        steps.any(|[p, q]| {
            // Not between two edges, where nothing lies but rounding.
            let ahead =
                (p[1 - self.k] - q[1 - self.k]).abs() > ALONG_SEAM * f64::max(p[1 - self.k].abs(), q[1 - self.k].abs());
            near(p[self.k]) && near(q[self.k]) && ahead
        })
    }

    /// The middles between holes that follow each other around the period, because where two bores cross there is
    /// but a narrow bridge between them.
    fn between_holes(&self, a: usize, b: Option<usize>) -> Vec<f64> {
        let period = self.period();
        let mut spans: Vec<[f64; 2]> = self
            .holes(a, b)
            .map(|hole| {
                let along = hole.samples.iter().map(|s| s.0[self.k]);
                let [low, high] = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)]);
                let turns = period * (low / period).floor();
                [low - turns, high - turns]
            })
            .collect();
        spans.sort_by(|x, y| x[0].total_cmp(&y[0]));
        spans.extend(spans.first().map(|s| [s[0] + period, s[1] + period]));
        let mut reached = f64::NEG_INFINITY;
        let mut middles = Vec::new();
        for w in spans.windows(2) {
            reached = w[0][1].max(reached);
            if w[1][0] > reached {
                middles.push(0.5 * (reached + w[1][0]));
            }
        }
        middles
    }

    /// The loops that are neither of two rings.
    fn holes(&self, a: usize, b: Option<usize>) -> impl Iterator<Item = &Unrolled> {
        self.unrolled.iter().enumerate().filter(move |(k, _)| *k != a && Some(*k) != b).map(|(_, u)| u)
    }

    /// Smallest distance of the holes from a parameter, in that parameter.
    fn clearance(&self, x: f64, a: usize, b: Option<usize>) -> f64 {
        let period = self.period();
        let off = |y: f64| {
            let d = (y - x).rem_euclid(period);
            d.min(period - d)
        };
        self.holes(a, b).flat_map(|u| u.samples.iter().map(|s| off(s.0[self.k]))).fold(period, f64::min)
    }

    /// The parameter of an edge where it crosses a seam, from a nearby one.
    pub fn refined(&self, draft: &Draft, edge: u32, t: f64, x: f64) -> f64 {
        let e = &draft.edges[edge as usize];
        let (surface, period) = (&self.piece.surface, self.period());
        let off = |t: f64| {
            let d = (surface.project(e.curve.point(t))[self.k] - x) / period;
            period * (d - d.round())
        };
        let span = (e.range[1] - e.range[0]) / LOOP_SAMPLES as f64;
        let (mut t0, mut t1) = (t, t + 1e-3 * span);
        let (mut f0, mut f1) = (off(t0), off(t1));
        for _ in 0..30 {
            if f0.abs() < 1e-15 || f1 == f0 {
                break;
            }
            let next = t1 - f1 * (t1 - t0) / (f1 - f0);
            if !next.is_finite() || (next - t).abs() > span {
                break;
            }
            (t0, f0, t1) = (t1, f1, next);
            f1 = off(t1);
            if f1.abs() < 1e-15 {
                break;
            }
        }
        // A step that left the neighbourhood gained nothing.
        if f1.abs() < off(t).abs() { t1 } else { t }
    }

    /// The seam between two vertices at given values of the other parameter, and whether it runs against the way.
    pub fn edge(&self, draft: &mut Draft, x: f64, ends: [(u32, f64); 2]) -> Option<(u32, bool)> {
        let curve = seam(&self.piece.surface, self.k, x)?;
        let at = |(v, y): (u32, f64)| match &curve {
            Curve::Line { .. } => curve.project(draft.vertices[v as usize].point),
            _ => curve.project_near(draft.vertices[v as usize].point, y),
        };
        let [s, t] = ends.map(at);
        let against = t < s;
        let (range, vertices) =
            if against { ([t, s], [ends[1].0, ends[0].0]) } else { ([s, t], [ends[0].0, ends[1].0]) };
        (range[1] > range[0]).then(|| (draft.seam(curve, range, vertices), against))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::primitive::Primitive;
    use crate::mesh::{SurfaceMesh, Triangles};

    /// Two bores that cross and are of nearly one radius: the holes of the larger one leave two narrow bridges.
    #[test]
    fn a_bridge_between_two_holes_is_found() {
        let corners = vec![DVec3::X, DVec3::Y, DVec3::Z];
        let mesh = SurfaceMesh::from_triangles(corners, &[[0, 1, 2]]).unwrap();
        let p = Primitive::Cylinder { origin: DVec3::ZERO, axis: DVec3::Z, radius: 1.0 };
        let piece = Piece::on(Triangles::of(&mesh).unwrap(), vec![0], Surface::of_primitive(&p), Some(p), 0);
        let around = |at: Vec<[f64; 2]>, turns: i32| Unrolled {
            samples: at.into_iter().map(|p| (p, 0, 0.0)).collect(),
            winding: [turns, 0],
        };
        let ring = |v: f64, turns: i32| around((0..=40).map(|k| [TAU * f64::from(k) / 40.0, v]).collect(), turns);
        // From one angle to the other and back.
        let hole = |low: f64, high: f64| {
            let place = |k: i32| {
                let s = TAU * f64::from(k) / 40.0;
                [0.5 * (low + high) - 0.5 * (high - low) * s.cos(), 0.5 * s.sin()]
            };
            around((0..=40).map(place).collect(), 0)
        };
        for shift in [0.0, 1.0, 5.0, -20.0] {
            let holes = [hole(0.02 + shift, 3.12 + shift), hole(3.18 + shift, 6.24 + shift)];
            let unrolled: Vec<Unrolled> = [ring(-2.0, 1), ring(2.0, -1)].into_iter().chain(holes).collect();
            let seams = Seams { piece: &piece, unrolled: &unrolled, k: 0 };
            let places = seams.between_holes(0, Some(1));
            assert_eq!(places.len(), 2, "{places:?}");
            for x in places {
                assert!(seams.clearance(x, 0, Some(1)) > 0.02, "{x} for a shift of {shift}");
            }
        }
        // Rings alone leave all room, and one hole all but itself.
        let unrolled = vec![ring(-2.0, 1), ring(2.0, -1), hole(0.5, 1.5)];
        let seams = Seams { piece: &piece, unrolled: &unrolled, k: 0 };
        let places = seams.between_holes(0, Some(1));
        assert!(places.len() == 1 && seams.clearance(places[0], 0, Some(1)) > 2.5, "{places:?}");
    }
}
