//! A surface as an explanation of noisy triangles: what a triangle costs, the triangles it reaches, its fit.

use super::level::Noise;
use super::patch::Patches;
use crate::geometry::normals::angle_between;
use crate::geometry::primitive::{Fit, Kind, Primitive, Scratch, fit_within, refine};
use crate::segment::regions::{FIRST_SAMPLES, FIT_SAMPLES};
use crate::segment::surface::Surface;
use glam::DVec3;

/// A count of standard deviations: vertices farther away are not on the surface, because normal noise is larger once in
/// three thousand times.
pub const MODEL_REACH: f64 = 3.6;
/// The price of a triangle that has nothing to do with a surface, for 1 in the mean on its own one: a limit, because
/// one outlier is not to outweigh a face.
pub const DEAREST_PRICE: f64 = 8.0;
/// The price of a triangle on no surface: half of the dearest, because triangles off their surface are to become free.
pub const FREE_PRICE: f64 = 4.0;
/// The price of a surface, in prices of triangles: that of a few, because a surface for each of them would be cheaper
/// otherwise.
const SURFACE_PRICE: f64 = 4.0;
/// The price of each parameter of a surface in the same unit, because of surfaces that fit alike the simplest is to
/// win.
const PARAMETER_PRICE: f64 = 1.5;
/// Variances of the noise: the largest wrongness of a surface, see [`Model::wrongness`], because what it is wrong by
/// hides in noise up to there.
const MOST_WRONGNESS: f64 = 0.3;
/// Weight of the turn in the price, for 1 of the distances: less, because both say nearly the same.
const NORMAL_SHARE: f64 = 0.5;
/// Radians: turn of chords, which is no noise, because a facet of a curved surface is turned against it at its corners.
const CHORD_TURN: f64 = 0.05;
/// A count: steps of a fit, few because it starts near.
const MODEL_STEPS: usize = 20;
/// A count: rounds of growth and fit, few because each of them reaches much farther.
const GROWTH_ROUNDS: usize = 6;
/// A factor to which the level of noise is known, because it is measured on few patches.
const LEVEL_FACTOR: f64 = 1.25;

/// A surface with the side that the triangles look to.
#[derive(Debug, Clone, Copy)]
pub struct Model {
    pub primitive: Primitive,
    /// 1: along the natural normal; −1: against it.
    pub sign: f64,
}

impl Model {
    /// Distances of the corners and turn of the normal of a triangle, in deviations; the turn is infinite where the triangle
    /// looks the other way.
    fn misfit(&self, surface: &Surface<'_>, noise: &Noise, k: u32) -> ([f64; 3], f64) {
        let p = surface.triangles.triangle(k).map(|v| surface.triangles.points()[v as usize]);
        let distances = p.map(|p| self.primitive.distance(p).abs() / noise.sigma);
        let own = surface.normals[k as usize];
        let natural = p.map(|p| self.primitive.normal(p)).into_iter().sum::<DVec3>() * self.sign;
        if own == DVec3::ZERO || natural == DVec3::ZERO {
            return (distances, 0.0);
        }
        let angle = angle_between(own, natural);
        let away = angle > std::f64::consts::FRAC_PI_2;
        let turn = if away { f64::INFINITY } else { angle / (noise.turn[k as usize] + CHORD_TURN) };
        (distances, turn)
    }

    /// Minus the logarithm of the likelihood of a triangle, up to [`DEAREST_PRICE`].
    pub fn price(&self, surface: &Surface<'_>, noise: &Noise, k: u32) -> f64 {
        let (d, turn) = self.misfit(surface, noise, k);
        let square = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / 3.0;
        (0.5 * square + 0.5 * NORMAL_SHARE * turn * turn).min(DEAREST_PRICE)
    }

    /// Whether a triangle may lie on the surface.
    pub fn holds(&self, surface: &Surface<'_>, noise: &Noise, k: u32) -> bool {
        let (d, turn) = self.misfit(surface, noise, k);
        d.into_iter().all(|d| d <= MODEL_REACH) && turn <= MODEL_REACH
    }

    /// The price of the surface itself.
    pub fn cost(&self, noise: &Noise) -> f64 {
        noise.triangles_a_sample * (SURFACE_PRICE + PARAMETER_PRICE * self.primitive.kind().parameters() as f64)
    }

    /// Mean product of the distances at the two ends of edges, in variances of the noise, and the number of edges: about 0
    /// where the distances are noise; where the surface is a wrong one, the mean square of what it is wrong by.
    pub fn wrongness(&self, surface: &Surface<'_>, noise: &Noise, triangles: &[u32]) -> (f64, usize) {
        let most = MODEL_REACH * noise.sigma;
        let products = |&k: &u32| {
            let p = surface.triangles.triangle(k).map(|v| surface.triangles.points()[v as usize]);
            let d = p.map(|p| self.primitive.distance(p).clamp(-most, most) / noise.sigma);
            d[0] * d[1] + d[1] * d[2] + d[2] * d[0]
        };
        let sum: f64 = triangles.iter().map(products).sum();
        (sum / (3 * triangles.len().max(1)) as f64, triangles.len() * 3 / 2)
    }

    /// The model of a primitive on the side that the triangles look to.
    pub fn of(primitive: Primitive, surface: &Surface<'_>, triangles: &[u32]) -> Self {
        let along =
            |&k: &u32| surface.areas[k as usize] * primitive.normal(surface.center(k)).dot(surface.normals[k as usize]);
        let sum: f64 = triangles.iter().map(along).sum();
        Model { primitive, sign: if sum < 0.0 { -1.0 } else { 1.0 } }
    }
}

/// Whether distances with this root mean square may be noise alone.
pub fn is_noise(rms: f64, points: usize, kind: Kind, sigma: f64) -> bool {
    // The sum of squares over σ² has about this mean, and a variance of twice that.
    let freedom = points.saturating_sub(kind.parameters()) as f64;
    let most = (LEVEL_FACTOR * sigma).powi(2) * (1.0 + 3.0 * (2.0 / freedom).sqrt());
    freedom >= 1.0 && rms * rms * points as f64 / freedom <= most
}

/// Whether a wrongness over so many edges is more than chance.
pub fn is_wrong((wrongness, edges): (f64, usize)) -> bool {
    wrongness > MOST_WRONGNESS + 2.0 / (edges.max(1) as f64).sqrt()
}

/// Fits models to triangles.
pub struct Fitter<'a> {
    pub surface: &'a Surface<'a>,
    pub noise: &'a Noise,
    pub patches: Patches<'a>,
    /// Triangles that a surface grows over at most.
    pub most: usize,
    /// Triangles that no surface grows over.
    pub fixed: &'a [bool],
    scratch: Scratch,
}

impl<'a> Fitter<'a> {
    pub fn new(surface: &'a Surface<'a>, noise: &'a Noise, fixed: &'a [bool]) -> Self {
        let patches = Patches::new(surface);
        Fitter { surface, noise, patches, most: usize::MAX, fixed, scratch: Scratch::default() }
    }

    /// A surface of a kind through the gathered points, if they are on one.
    pub fn through(&mut self, kind: Kind) -> Option<Fit> {
        if self.patches.points.len() < kind.parameters() + 2 {
            return None;
        }
        let start = self.quick(kind, 1.3 * MODEL_REACH * self.noise.sigma)?;
        let points = &self.patches.points;
        let found = refine(start, points, None, MODEL_STEPS)?;
        is_noise(found.rms, points.len(), kind, self.noise.sigma).then_some(found)
    }

    /// A fit to a few of the gathered points, from all kinds of starts.
    fn quick(&mut self, kind: Kind, tolerance: f64) -> Option<Primitive> {
        let Patches { points, normals, .. } = &self.patches;
        let n = points.len();
        if n <= FIRST_SAMPLES {
            return fit_within(kind, points, normals, tolerance, &mut self.scratch).map(|fit| fit.primitive);
        }
        let few = |all: &[DVec3]| -> Vec<DVec3> { (0..FIRST_SAMPLES).map(|k| all[k * n / FIRST_SAMPLES]).collect() };
        fit_within(kind, &few(points), &few(normals), tolerance, &mut self.scratch).map(|fit| fit.primitive)
    }

    /// The model through a start, grown from a seed and fitted again, and its triangles.
    pub fn grow(&mut self, start: Model, seed: u32) -> Option<(Model, Vec<u32>)> {
        let (surface, noise, fixed) = (self.surface, self.noise, self.fixed);
        let mut model = start;
        let mut best: Option<(Model, Vec<u32>)> = None;
        for _ in 0..GROWTH_ROUNDS {
            if !model.holds(surface, noise, seed) {
                break;
            }
            self.patches.reach(seed, self.most, &|_, k| !fixed[k as usize] && model.holds(surface, noise, k));
            let before = best.as_ref().map_or(0, |b| b.1.len());
            if self.patches.triangles.len() <= before {
                break;
            }
            let settled = self.patches.triangles.len() as f64 <= 1.02 * before as f64;
            best = Some((model, self.patches.triangles.clone()));
            self.patches.gather();
            self.patches.thin(FIT_SAMPLES);
            let Some(fit) = refine(model.primitive, &self.patches.points, None, MODEL_STEPS) else { break };
            model = Model::of(fit.primitive, surface, &self.patches.triangles);
            if settled {
                break;
            }
        }
        best
    }

    /// The best fit of a kind to triangles, from a start where one is given; whatever its distances.
    pub fn fit(&mut self, kind: Kind, triangles: &[u32], start: Option<Primitive>) -> Option<Fit> {
        self.patches.gather_of(triangles);
        self.patches.thin(FIT_SAMPLES);
        let start = match start {
            Some(start) => start,
            None => self.quick(kind, 2.0 * MODEL_REACH * self.noise.sigma)?,
        };
        refine(start, &self.patches.points, None, MODEL_STEPS)
    }
}
