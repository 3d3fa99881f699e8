//! Loops in the parameters of their surface: which is the outer one, where the seam is, which way a sphere is turned.
//!
//! ```text
//!      v │   ──────◄──────────── ring b          A loop that goes round in u is a ring: the face lies above
//!        │       │   ╭─►─╮                       a ring that runs to larger u (seen with the face's normal to
//!        │  seam │   ╰─◄─╯ hole                  the reader), and below one that runs back.
//!        │   ────┴─►──────────── ring a
//!        └──────────────────────────── u
//! ```

use super::conics::seam;
use super::draft::{Draft, DraftFace, Merge};
use super::regions::Piece;
use super::tuning::{CAP_ANGLE, LOOP_SAMPLES, SEAM_CLEARANCE};
use crate::brep::{Curve, Frame, Surface};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A share of a period: what stays this near to a seam runs along it, because where it crosses is left to rounding.
const ALONG_SEAM: f64 = 1e-6;

/// A loop as a polygon in the parameters.
struct Unrolled {
    /// Parameters, the use that each sample is on, and the parameter of that edge; the last sample closes the loop.
    samples: Vec<([f64; 2], usize, f64)>,
    winding: [i32; 2],
}

/// A place where a loop crosses a line of constant parameter.
#[derive(Clone, Copy)]
struct Crossing {
    /// The other parameter.
    at: f64,
    of: usize,
    use_: usize,
    t: f64,
}

/// What is wrong with a face.
pub type Reason = &'static str;

/// Turns a sphere so that its poles are out of the way of the loops: outside of a small face, on the axis of a zone.
pub fn turn_sphere(piece: &mut Piece, draft: &Draft, loops: &[Vec<(u32, bool)>], middle: DVec3) {
    let Surface::Sphere { frame, .. } = &mut piece.surface else { return };
    let center = frame.origin;
    let towards = (middle - center).normalize_or(DVec3::X);
    let samples = |uses: &Vec<(u32, bool)>| -> Vec<DVec3> {
        uses.iter().flat_map(|&(e, r)| points(draft, e, r)).map(|(p, _)| (p - center).normalize_or_zero()).collect()
    };
    let rims: Vec<Vec<DVec3>> = loops.iter().map(samples).collect();
    let widest = rims.iter().flatten().map(|p| p.dot(towards).clamp(-1.0, 1.0).acos()).fold(0.0, f64::max);
    if !rims.is_empty() && widest < CAP_ANGLE {
        // Among the directions across, the one that boundaries lean to: corners of boxes have their axes.
        let area = rims.iter().map(|r| area_vector(r)).sum::<DVec3>();
        let aside = rims.iter().flatten().copied().fold(DVec3::ZERO, |a, p| if a == DVec3::ZERO { p } else { a });
        let z =
            towards.cross(if aside.cross(towards).length() > 1e-3 { aside } else { towards.any_orthonormal_vector() });
        let _ = area;
        *frame = Frame::new(center, z, towards);
        return;
    }
    let largest = rims.iter().map(|r| area_vector(r)).max_by(|a, b| a.length().total_cmp(&b.length()));
    if let Some(z) = largest.and_then(DVec3::try_normalize) {
        *frame = Frame::new(center, z, towards);
    }
}

fn area_vector(rim: &[DVec3]) -> DVec3 {
    (0..rim.len()).map(|k| rim[k].cross(rim[(k + 1) % rim.len()])).sum()
}

/// Points along an edge in the sense of a use, both ends included, with their parameters.
fn points(draft: &Draft, edge: u32, reversed: bool) -> impl Iterator<Item = (DVec3, f64)> + '_ {
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

fn unroll(surface: &Surface, draft: &Draft, uses: &[(u32, bool)]) -> Unrolled {
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
    fn area(&self) -> f64 {
        self.samples.windows(2).map(|w| 0.5 * (w[0].0[0] * w[1].0[1] - w[1].0[0] * w[0].0[1])).sum()
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

/// The loops of a face, its seam, and which of its loops is the outer one.
pub fn face(
    piece: &Piece,
    draft: &mut Draft,
    loops: Vec<Vec<(u32, bool)>>,
    diagonal: f64,
) -> Result<DraftFace, Reason> {
    let surface = &piece.surface;
    let unrolled: Vec<Unrolled> = loops.iter().map(|l| unroll(surface, draft, l)).collect();
    let mut face = DraftFace { loops, ..DraftFace::default() };
    if face.loops.is_empty() {
        return whole(piece, draft).ok_or("a closed region lies on an open surface");
    }
    let rings: Vec<usize> = (0..unrolled.len()).filter(|&k| unrolled[k].winding != [0, 0]).collect();
    let sense = if piece.same_sense { 1.0 } else { -1.0 };
    if rings.is_empty() {
        if matches!(surface, Surface::Torus { .. }) && unrolled.iter().all(|u| sense * u.area() < 0.0) {
            return Err("a torus with holes has no border");
        }
        let outer = (0..unrolled.len())
            .max_by(|&a, &b| (unrolled[a].area() * sense).total_cmp(&(unrolled[b].area() * sense)).then(b.cmp(&a)));
        face.outer = outer.unwrap_or(0);
        let is_wrong = |(k, u): (usize, &Unrolled)| (u.area() * sense > 0.0) != (k == face.outer);
        if unrolled.iter().enumerate().any(is_wrong) {
            return Err("its loops run the wrong way round");
        }
        return Ok(face);
    }
    let k = usize::from(unrolled[rings[0]].winding[0] == 0);
    if rings.iter().any(|&r| unrolled[r].winding[k].abs() != 1 || unrolled[r].winding[1 - k] != 0) || rings.len() > 2 {
        return Err("its loops wind around the surface in more than one way");
    }
    // The material is on the left of every loop: above a ring that runs to larger u, and left of one that runs to larger v.
    let upward = |r: usize| f64::from(unrolled[r].winding[k]) * sense * if k == 0 { 1.0 } else { -1.0 } > 0.0;
    let seams = Seams { piece, unrolled: &unrolled, k };
    if rings.len() == 1 {
        let end = point_of(surface, upward(rings[0])).ok_or("one ring alone bounds no face of its surface")?;
        let (crossing, x) = seams.best(draft, &face, rings[0], None, upward(rings[0])).ok_or("no seam is free")?;
        let edge = face.loops[rings[0]][crossing.use_].0;
        let t = seams.refined(draft, edge, crossing.t, x);
        let a = draft.vertex_on(edge, t, diagonal);
        let b = draft.vertex(end.0, 0.0);
        let seam = seams.edge(draft, x, [(a, crossing.at), (b, end.1)]).ok_or("its surface has no seam")?;
        face.merge = Some(Merge { first: (rings[0], a), second: (None, b), seam });
        return Ok(face);
    }
    let [a, b] = if upward(rings[0]) { [rings[0], rings[1]] } else { [rings[1], rings[0]] };
    if !upward(a) || upward(b) {
        return Err("its rings run the same way");
    }
    let (low, x) = seams.best(draft, &face, a, Some(b), true).ok_or("no seam is free")?;
    let high = seams.beyond(&low, x).ok_or("no seam is free")?;
    let mut ends = [(0, 0.0); 2];
    for (end, c) in ends.iter_mut().zip([low, high]) {
        let edge = face.loops[c.of][c.use_].0;
        let t = seams.refined(draft, edge, c.t, x);
        *end = (draft.vertex_on(edge, t, diagonal), c.at);
    }
    let seam = seams.edge(draft, x, ends).ok_or("its surface has no seam")?;
    face.merge = Some(Merge { first: (a, ends[0].0), second: (Some(b), ends[1].0), seam });
    Ok(face)
}

/// The apex or the pole beyond a ring, with its v.
fn point_of(surface: &Surface, upward: bool) -> Option<(DVec3, f64)> {
    match surface {
        Surface::Cone { radius, half_angle, .. } if !upward => {
            let v = -radius / half_angle.tan();
            Some((surface.point(0.0, v), v))
        }
        Surface::Sphere { .. } => {
            let v = if upward { FRAC_PI_2 } else { -FRAC_PI_2 };
            Some((surface.point(0.0, v), v))
        }
        Surface::Revolution { profile, .. } => {
            let v = profile.domain()[usize::from(upward)];
            let p = surface.point(0.0, v);
            (profile.period().is_none() && surface.is_on_axis(p)).then_some((p, v))
        }
        _ => None,
    }
}

/// Faces without a border: a whole sphere, a whole torus.
fn whole(piece: &Piece, draft: &mut Draft) -> Option<DraftFace> {
    match &piece.surface {
        Surface::Sphere { .. } => {
            let pole = draft.vertex(piece.surface.point(0.0, FRAC_PI_2), 0.0);
            Some(DraftFace { pole: Some(pole), ..DraftFace::default() })
        }
        Surface::Revolution { profile, .. } if profile.period().is_none() => {
            let range = profile.domain();
            let ends = range.map(|v| piece.surface.point(0.0, v));
            if !ends.iter().all(|&p| piece.surface.is_on_axis(p)) {
                return None;
            }
            let ends = ends.map(|p| draft.vertex(p, 0.0));
            let meridian = draft.seam(seam(&piece.surface, 0, 0.0)?, range, ends);
            Some(DraftFace { loops: vec![vec![(meridian, false), (meridian, true)]], ..DraftFace::default() })
        }
        Surface::Torus { .. } | Surface::Revolution { .. } => {
            let [_, profile] = piece.surface.domain();
            let v = draft.vertex(piece.surface.point(0.0, profile[0]), 0.0);
            let a = draft.seam(seam(&piece.surface, 1, profile[0])?, [0.0, TAU], [v, v]);
            let b = draft.seam(seam(&piece.surface, 0, 0.0)?, profile, [v, v]);
            let mut uses = vec![(a, false), (b, false), (a, true), (b, true)];
            if !piece.same_sense {
                uses = uses.into_iter().rev().map(|(e, r)| (e, !r)).collect();
            }
            Some(DraftFace { loops: vec![uses], ..DraftFace::default() })
        }
        _ => None,
    }
}

struct Seams<'a> {
    piece: &'a Piece,
    unrolled: &'a [Unrolled],
    /// The parameter that is constant along the seam.
    k: usize,
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
    fn beyond(&self, low: &Crossing, x: f64) -> Option<Crossing> {
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

    /// The best place for a seam: through vertices that are there, far from other loops. Returns the crossing of ring `a`.
    fn best(
        &self,
        draft: &Draft,
        face: &DraftFace,
        a: usize,
        b: Option<usize>,
        upward: bool,
    ) -> Option<(Crossing, f64)> {
        let surface = &self.piece.surface;
        let period = self.period();
        let mut places: Vec<(f64, u32)> = Vec::new();
        for ring in [Some(a), b].into_iter().flatten() {
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
        let (mut known, count) = (places.clone(), 24);
        known.sort_by(|x, y| x.0.total_cmp(&y.0));
        let start = self.unrolled[a].samples[0].0[self.k];
        places.extend((0..count).map(|j| (start + period * f64::from(j) / f64::from(count), 0)));
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

    /// Smallest distance of the holes from a parameter, in that parameter.
    fn clearance(&self, x: f64, a: usize, b: Option<usize>) -> f64 {
        let period = self.period();
        let holes = self.unrolled.iter().enumerate().filter(|(k, _)| *k != a && Some(*k) != b);
        let off = |y: f64| {
            let d = (y - x).rem_euclid(period);
            d.min(period - d)
        };
        holes.flat_map(|(_, u)| u.samples.iter().map(|s| off(s.0[self.k]))).fold(period, f64::min)
    }

    /// The parameter of an edge where it crosses a seam, from a nearby one.
    fn refined(&self, draft: &Draft, edge: u32, t: f64, x: f64) -> f64 {
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
    fn edge(&self, draft: &mut Draft, x: f64, ends: [(u32, f64); 2]) -> Option<(u32, bool)> {
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
