//! Area, volume and centroid of a model, by Gauss–Legendre quadrature over its trimmed faces.
//!
//! A face is the image of a domain D of the parameter plane. With F(u, v) = ∫ g(s, v) ds from a fixed s to u, Green's theorem
//! makes the integral of g over D one of F dv along its border: the outer rule follows the edges, piece by piece and halved
//! until two levels agree, the inner one runs along u between the surface's breaks.
//!
//! ```text
//!   v ▲      ┌───────────┐
//!     │ ·····│··inner·►  ● a point of the outer rule, on an edge
//!     │      └───────────┘
//!     └──────┼──────────────► u
//!          fixed
//! ```
//!
//! With N = ∂S/∂u × ∂S/∂v, g is |N| for the area, S·N / 3 for the volume, and S_x² N_x / 2 (and so on) for the first
//! moments, about a point near the model so that nothing cancels.

use super::boundary::{EdgeSamples, Ring, Sample, unroll};
use super::row::Row;
use super::surface::Surface;
use super::tessellate::{Fineness, sample_edges};
use super::{Brep, Curve, Face};
use crate::context::Context;
use crate::error::Result;
use crate::numeric::gauss::GaussRule;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_3, FRAC_PI_4};

/// Points of the rule along u.
const INNER: usize = 8;
/// Points of the rule along u on planes, where the integrand is a polynomial.
const INNER_PLANE: usize = 2;
/// Points of the rule along u on splines, which makes volume and moments of bicubic ones exact between two knots.
const INNER_SPLINE: usize = 6;
/// Points of the rule along an edge.
const OUTER: usize = 6;
/// Where two levels of the outer rule agree within this share of the face's extent squared (cubed, to the fourth), it is
/// not divided further.
const ENOUGH: f64 = 1e-13;
/// Most halvings of a piece of an edge.
const MAX_PIECE_HALVINGS: u32 = 8;
/// The same for faces on splines, where feet of points are found by Newton's method to 1e-8 of the domain, so that two levels never
/// agree better than that.
const ENOUGH_ON_SPLINE: f64 = 1e-9;
/// Most halvings of a piece of an edge there.
const MAX_HALVINGS_ON_SPLINE: u32 = 3;

/// Area, volume and first moments.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Mass {
    /// Area.
    pub area: f64,
    /// Signed volume; of one face: that of the cone over it with its tip at the centre of the model's box.
    pub volume: f64,
    /// The integral of the position over the volume, about the centre of the model's box.
    pub moment: DVec3,
    /// That centre.
    pub about: DVec3,
    /// How far the last two levels of the quadrature were apart, in sum: of the volume.
    pub error: f64,
}

impl Mass {
    /// The centre of mass; the centre of the box where there is no volume.
    pub fn centroid(&self) -> DVec3 {
        let offset = self.moment / self.volume;
        if offset.is_finite() { self.about + offset } else { self.about }
    }

    fn plus(self, other: &Mass) -> Mass {
        Mass {
            area: self.area + other.area,
            volume: self.volume + other.volume,
            moment: self.moment + other.moment,
            about: other.about,
            error: self.error + other.error,
        }
    }
}

impl Brep {
    /// Area, volume and moments of every face.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
    pub fn face_masses(&self, context: &Context) -> Result<Vec<Mass>> {
        let [low, high] = self.bounds();
        let about = 0.5 * (low + high);
        // Only the angle counts here: pieces of edges over which little turns.
        let samples = sample_edges(self, &Fineness { chord: f64::INFINITY, angle: FRAC_PI_3 });
        let [inner, plane, spline, outer] = [INNER, INNER_PLANE, INNER_SPLINE, OUTER].map(GaussRule::new);
        let rules = Rules { inner, plane, spline, outer };
        context.install(|| {
            let one = |face: &Face| {
                context.check()?;
                Ok(of_face(self, face, &samples, about, &rules))
            };
            self.faces.par_iter().map(one).collect()
        })
    }

    /// Area, volume and moments of the whole model: of all its faces.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
    pub fn mass(&self, context: &Context) -> Result<Mass> {
        Ok(self.face_masses(context)?.iter().fold(Mass::default(), Mass::plus))
    }

    /// The same for each solid, from the masses of its faces.
    pub fn solid_masses(&self, faces: &[Mass]) -> Vec<Mass> {
        let of = |s: &super::Solid| {
            let shells = [s.outer].into_iter().chain(s.voids.iter().copied());
            let faces_of = shells.flat_map(|k| self.shells[k as usize].faces.iter().map(|&f| &faces[f as usize]));
            faces_of.fold(Mass::default(), Mass::plus)
        };
        self.solids.iter().map(of).collect()
    }
}

struct Rules {
    inner: GaussRule,
    plane: GaussRule,
    spline: GaussRule,
    outer: GaussRule,
}

/// Area, volume, moments.
type Sums = [f64; 5];

fn add(a: &mut Sums, b: &Sums, factor: f64) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += factor * b);
}

/// Everything the integrals over one face need.
struct Integral<'a> {
    brep: &'a Brep,
    surface: &'a Surface,
    about: DVec3,
    rules: &'a Rules,
    /// Where the inner integrals begin.
    from: f64,
    /// Values of u where the surface is not smooth, increasing.
    breaks: Vec<f64>,
    /// What does not matter of each sum.
    enough: Sums,
    /// Most halvings.
    halvings: u32,
}

fn of_face(brep: &Brep, face: &Face, samples: &[EdgeSamples], about: DVec3, rules: &Rules) -> Mass {
    let surface = brep.surface(face);
    if let (true, Surface::Sphere { frame, radius }) = (face.loops.is_empty(), surface) {
        return whole_sphere(frame.origin, *radius, about, face.same_sense);
    }
    let rings = unroll(brep, face, samples);
    let points = || rings.iter().flat_map(|r| &r.samples);
    let from = points().map(|s| s.uv.x).fold(f64::INFINITY, f64::min);
    let extent = points().map(|s| surface.point(s.uv.x, s.uv.y).distance(about)).fold(0.0, f64::max);
    let (share, halvings) = match surface {
        Surface::Spline(_) => (ENOUGH_ON_SPLINE, MAX_HALVINGS_ON_SPLINE),
        _ => (ENOUGH, MAX_PIECE_HALVINGS),
    };
    let enough = [2, 3, 4, 4, 4].map(|power| share * extent.powi(power));
    let integral = Integral { brep, surface, about, rules, from, breaks: breaks_in_u(surface), enough, halvings };
    let (mut sums, mut error) = (Sums::default(), 0.0);
    for (ring, uses) in rings.iter().zip(&face.loops) {
        let given = |edge: u32| uses.iter().any(|of| of.edge == edge && !of.parameters.is_empty());
        integral.along(ring, &given, &mut sums, &mut error);
    }
    let sense = if face.same_sense { 1.0 } else { -1.0 };
    Mass { area: sense * sums[0], volume: sums[1], moment: DVec3::new(sums[2], sums[3], sums[4]), about, error }
}

fn whole_sphere(center: DVec3, radius: f64, about: DVec3, same_sense: bool) -> Mass {
    let sense = if same_sense { 1.0 } else { -1.0 };
    let volume = sense * 4.0 * FRAC_PI_3 * radius.powi(3);
    let area = 12.0 * FRAC_PI_3 * radius * radius;
    Mass { area, volume, moment: volume * (center - about), about, error: 0.0 }
}

fn breaks_in_u(surface: &Surface) -> Vec<f64> {
    match surface {
        Surface::Spline(s) => s.knots()[0].breaks(),
        Surface::Extrusion { profile: Curve::Spline(s), .. } => {
            let breaks = s.knots().breaks();
            let [low, high] = s.knots().domain();
            // Over the joint of a closed profile, too.
            let turns = [-1.0, 0.0, 1.0].into_iter().flat_map(|k| breaks.iter().map(move |t| t + k * (high - low)));
            turns.collect()
        }
        _ => Vec::new(),
    }
}

impl Integral<'_> {
    /// Adds the integral of F dv along a loop.
    fn along(&self, ring: &Ring, given: &dyn Fn(u32) -> bool, sums: &mut Sums, error: &mut f64) {
        for w in ring.samples.windows(2) {
            if w[1].edge == u32::MAX {
                continue;
            }
            let piece = if given(w[1].edge) { Piece::Straight } else { Piece::OnEdge };
            let span = w[1].span;
            let whole = self.rule(&piece, w, span, w[0].uv);
            self.halved(&piece, w, span, w[0].uv, whole, 0, sums, error);
        }
    }

    /// The rule over both halves of a span, and over halves of these where it matters.
    fn halved(
        &self,
        piece: &Piece,
        w: &[Sample],
        [a, b]: [f64; 2],
        start: DVec2,
        (whole, _): (Sums, DVec2),
        depth: u32,
        sums: &mut Sums,
        error: &mut f64,
    ) {
        let middle = 0.5 * (a + b);
        let first = self.rule(piece, w, [a, middle], start);
        let second = self.rule(piece, w, [middle, b], first.1);
        let mut better = first.0;
        add(&mut better, &second.0, 1.0);
        let off: Sums = std::array::from_fn(|k| (better[k] - whole[k]).abs());
        if off.iter().zip(&self.enough).all(|(x, e)| x <= e) || depth >= self.halvings {
            add(sums, &better, 1.0);
            *error += off[1];
            return;
        }
        let after = first.1;
        self.halved(piece, w, [a, middle], start, first, depth + 1, sums, error);
        self.halved(piece, w, [middle, b], after, second, depth + 1, sums, error);
    }

    /// The outer rule over a span of an edge; returns the parameters at its last node, too.
    fn rule(&self, piece: &Piece, w: &[Sample], [a, b]: [f64; 2], start: DVec2) -> (Sums, DVec2) {
        let mut sums = Sums::default();
        let mut at = start;
        // Nodes in the order of travel.
        let mut nodes: Vec<(f64, f64)> = self.rules.outer.over(a, b).collect();
        nodes.sort_by(|x, y| (x.0 - a).abs().total_cmp(&(y.0 - a).abs()));
        for (t, weight) in nodes {
            let (uv, slope) = self.place(piece, w, t, at);
            at = uv;
            if weight * slope != 0.0 {
                let inner = self.inner(uv);
                add(&mut sums, &inner, weight * slope);
            }
        }
        (sums, at)
    }

    /// Where a parameter of an edge is in the parameter plane, and how fast v grows there.
    fn place(&self, piece: &Piece, w: &[Sample], t: f64, near: DVec2) -> (DVec2, f64) {
        if let Piece::Straight = piece {
            let [a, b] = w[1].span;
            return (w[0].uv.lerp(w[1].uv, (t - a) / (b - a)), (w[1].uv.y - w[0].uv.y) / (b - a));
        }
        let [p, d, _] = self.brep.edges[w[1].edge as usize].curve.derivatives(t);
        let uv = DVec2::from(self.surface.project_near(p, near.into()));
        let [su, sv] = self.surface.jet(uv.x, uv.y).first;
        let (e, f, g) = (su.dot(su), su.dot(sv), sv.dot(sv));
        let slope = (e * sv.dot(d) - f * su.dot(d)) / (e * g - f * f);
        // Along a line v = const what is left is rounding.
        let level = slope.abs() * sv.length() < 1e-15 * d.length() || !slope.is_finite();
        (uv, if level { 0.0 } else { slope })
    }

    /// F at a point of the parameter plane.
    fn inner(&self, uv: DVec2) -> Sums {
        let mut out = Sums::default();
        let (rule, turn) = match self.surface {
            Surface::Plane { .. } => (&self.rules.plane, f64::INFINITY),
            Surface::Spline(_) => (&self.rules.spline, f64::INFINITY),
            Surface::Extrusion { profile: Curve::Spline(_) | Curve::Line { .. }, .. } => {
                (&self.rules.inner, f64::INFINITY)
            }
            _ => (&self.rules.inner, FRAC_PI_4),
        };
        let row = match self.surface {
            Surface::Spline(s) => Some(Row::of(s, uv.y)),
            _ => None,
        };
        let at = |u: f64| match &row {
            Some(row) => row.at(u),
            None => {
                let jet = self.surface.jet(u, uv.y);
                (jet.point, jet.first)
            }
        };
        let mut a = self.from;
        let inside = self.breaks.iter().copied().filter(|&t| t > self.from && t < uv.x);
        for b in inside.chain([uv.x]) {
            let pieces = ((b - a).abs() / turn).ceil().clamp(1.0, 64.0);
            for k in 0..pieces as u32 {
                let [low, high] = [k, k + 1].map(|k| a + (b - a) * f64::from(k) / pieces);
                rule.over(low, high).for_each(|(u, weight)| add(&mut out, &self.density(at(u)), weight));
            }
            a = b;
        }
        out
    }

    fn density(&self, (point, [along, across]): (DVec3, [DVec3; 2])) -> Sums {
        let n = along.cross(across);
        let p = point - self.about;
        let m = 0.5 * p * p * n;
        [n.length(), p.dot(n) / 3.0, m.x, m.y, m.z]
    }
}

/// How an edge runs in the parameter plane.
enum Piece {
    /// Straight between two samples, as its use says.
    Straight,
    /// Wherever its curve is projected to.
    OnEdge,
}
