//! What the vertices deviate from their surfaces by: white noise, which is measured; a share of an edge, where edges were rounded; a
//! little more than exact surfaces; or waves, which the surfaces through them tell from organic shapes.

use super::level::{self, Noise};
use super::model::MODEL_REACH;
use super::propose::{self, Probe};
use super::{Before, Start, Way};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use crate::segment::surface::{Surface, quantile};
use crate::segment::surfaces::PART_SHARE;

/// A share of an edge: deviations below are no noise, because chords of exact surfaces deviate by more.
const QUIETEST_NOISE: f64 = 2e-3;
/// A share of an edge: deviations above leave no part, because faces cannot be told from noise there.
const LOUDEST_NOISE: f64 = 0.15;
/// A factor: paraboloids of a few triangles and surfaces of the part see the same noise up to this. On organic shapes
/// the surfaces grow until they are as wrong as noise allows: measured 1.46 to 1.86 on scans, at most 1.1 on parts.
const SAME_NOISE: f64 = 1.28;
/// A factor: some of the seeds are enough where both are apart by more, because all of them would not bring them
/// together.
const OTHER_NOISE: f64 = 1.55;
/// A factor: the rougher part of a mesh with white noise is rougher than the quieter part by no more, because white
/// noise is the same everywhere.
const EVEN_FACTOR: f64 = 2.5;
/// A factor: noise that is larger than a distance by this cannot hide in it, because no surface could hold its vertices
/// as closely.
const HIDDEN_FACTOR: f64 = 6.0;
/// A share of the seeds that lies on surfaces where the mesh is a part: small, because those on blends and borders
/// miss.
const PROBED_SHARE: f64 = 0.25;
/// A share of the area: what no exact surface is sure to hold is crumbs where it is no more, because no face of a part
/// is smaller.
const UNSURE_CRUMBS: f64 = 2e-3;
/// A share of the area: what no exact surface holds at all is crumbs where it is no more, because a few triangles of
/// every file are spoiled.
const FREE_CRUMBS: f64 = 1e-4;
/// Height over longest side of the middle triangle below which triangles are those of a kernel, because smoothing,
/// remeshing and scanning leave better ones, 0.87 at most.
const WELL_SHAPED: f64 = 0.3;
/// A share of an edge: free triangles whose vertices lie this near to a smooth surface are freeform, beside exact
/// surfaces, because noise would be larger.
const SMOOTH_ROUGHNESS: f64 = 5e-3;
/// A share of an edge: least tolerance of triangles that came about somehow, because noise, chords and the waves of
/// smoothing are within that.
const LEAST_TOLERANCE: f64 = 0.045;
/// A count: triangles that say as much as a single one with independent noise would, because such deviations are those
/// of the neighbours too.
const TRIANGLES_A_SAMPLE: f64 = 4.0;
/// A count: triangles whose deviations from the right surface are alike where smooth waves are a part of the noise,
/// because such waves are some ten edges long.
const TRIANGLES_A_WAVE: f64 = 200.0;
/// A share of the seeds whose surfaces are large where the noise is white, because smooth waves that look like white noise to
/// paraboloids have none, small because a part of small faces has few.
const LARGE_WHITE: f64 = 0.3;
/// The same where it is not: more, because what has hardly a large surface then has rounded edges, not waves.
const LARGE_FIRST: f64 = 0.5;
/// A factor: surfaces that are wrong by more than this times the tolerance that found them are those of an organic shape, because
/// they grow as far as they can: measured 1.67 to 1.95 there where they are large, 1.57 at most on most parts.
const ORGANIC_NOISE: f64 = 1.62;
/// A share of the seeds: where the surfaces of so many are large, that says nothing, because waves may be larger than the
/// tolerance, and organic shapes have small surfaces in places.
const LARGE_NEARLY_ALL: f64 = 0.9;
/// A factor: the tolerance is more than what surfaces of some triangles are wrong by, because one is to hold all of its face.
const AMPLE_FACTOR: f64 = 1.3;
/// Multiple of the tolerance of exact surfaces to which the rest is divided, because surfaces that are a little less exact fall to
/// pieces at that tolerance; on fandisk 1.5 to 4 give the same regions.
const CLOSE_FACTOR: f64 = 2.5;
/// A count: most triangles that no exact surface holds, because more would take minutes as well.
const MOST_OPEN: usize = 60_000;

/// The noise of a mesh that looks like a part with white noise. Few probes decide: a scan of a million triangles is told in a
/// fraction of a second.
pub fn white(surface: &Surface<'_>, order: &[u32], before: &Before<'_>, context: &Context) -> Result<Option<Noise>> {
    let Some(sigma) = level::level(surface, order) else { return Ok(None) };
    // No surface could hold its vertices as closely.
    if before.share >= PART_SHARE && sigma > HIDDEN_FACTOR * before.exact.tolerance {
        return Ok(None);
    }
    let edge = surface.mean_edge();
    if !(QUIETEST_NOISE * edge..LOUDEST_NOISE * edge).contains(&sigma) {
        return Ok(None);
    }
    // White noise is the same everywhere; smoothed edges are rougher than what lies between.
    let rough = level::roughness(surface, order).unwrap_or_default();
    if rough > EVEN_FACTOR * sigma {
        return Ok(None);
    }
    let first = Noise::white(surface, sigma);
    let hopeless = |probe: &Probe| probe.sigma > OTHER_NOISE * sigma;
    let probe = propose::probe(surface, &first, order, hopeless, context)?;
    tracing::debug!(sigma, rough, probe = probe.sigma, share = probe.share, large = probe.large, "white noise");
    let same = probe.sigma > 0.0 && probe.sigma <= SAME_NOISE * sigma;
    let is_part = same && probe.share >= PROBED_SHARE && probe.large >= LARGE_WHITE;
    Ok(is_part.then(|| if probe.sigma < sigma { Noise::white(surface, probe.sigma) } else { first }))
}

/// What no exact surface is sure to hold.
pub struct Open {
    /// Length of an edge there.
    edge: f64,
    /// How rough the rougher part is.
    rough: f64,
    /// Deviation of the vertices from smooth surfaces.
    level: f64,
    /// Share of the area that exact surfaces hold.
    pub held: f64,
}

impl Open {
    /// `None` where next to nothing is open, or where too much is; where it does not look like triangles that came about
    /// somehow.
    pub fn of(surface: &Surface<'_>, order: &[u32], before: &Before<'_>, start: &Start) -> Option<Open> {
        let open: Vec<u32> = order.iter().copied().filter(|&k| !start.fixed[k as usize]).collect();
        if open.len() > MOST_OPEN {
            return None;
        }
        let area: f64 = open.iter().map(|&k| surface.areas[k as usize]).sum();
        let free: f64 =
            open.iter().filter(|&&k| before.exact.label[k as usize] == NONE).map(|&k| surface.areas[k as usize]).sum();
        let nothing_left = area <= UNSURE_CRUMBS * surface.total_area || free <= FREE_CRUMBS * surface.total_area;
        if nothing_left && before.tolerance.is_none() {
            return None;
        }
        let mut areas: Vec<f64> = open.iter().map(|&k| surface.areas[k as usize]).collect();
        let middle = quantile(&mut areas, 0.5, f64::total_cmp).unwrap_or_default();
        let edge = (middle * 4.0 / 3f64.sqrt()).sqrt();
        // Where there are too few patches to tell there are too few triangles to divide.
        let rough = level::roughness(surface, &open)?;
        let shape = |&k: &u32| {
            let longest = (3 * k..3 * k + 3).map(|c| surface.edge_length(c)).fold(0.0, f64::max);
            2.0 * surface.areas[k as usize] / (longest * longest).max(f64::MIN_POSITIVE)
        };
        let mut shapes: Vec<f64> = open.iter().map(shape).collect();
        if before.tolerance.is_none() && quantile(&mut shapes, 0.5, f64::total_cmp).is_none_or(|s| s < WELL_SHAPED) {
            return None;
        }
        let held = 1.0 - area / surface.total_area.max(f64::MIN_POSITIVE);
        let level = level::level(surface, &open).unwrap_or_default();
        tracing::debug!(edge, rough = rough / edge, level = level / edge, held, "what no surface holds");
        Some(Open { edge, rough, level, held })
    }

    /// The noise beside exact surfaces: a share of an edge where edges were rounded; what exact surfaces were found at, and a
    /// little more, where the rest is as smooth as they are.
    pub fn beside_exact(&self, surface: &Surface<'_>, before: &Before<'_>) -> (Noise, Way) {
        let rounded = self.rough >= SMOOTH_ROUGHNESS * self.edge;
        let (sigma, way) = match before.tolerance {
            Some(tolerance) => (tolerance / MODEL_REACH, Way::Loose),
            None if rounded => (LEAST_TOLERANCE * self.edge, Way::Loose),
            None => (CLOSE_FACTOR * before.exact.tolerance / MODEL_REACH, Way::Close),
        };
        (Noise::new(surface, sigma, self.edge, TRIANGLES_A_SAMPLE), way)
    }

    /// The noise where exact surfaces hold next to nothing, measured on surfaces through a few places; `None` where these are
    /// small, or so wrong that to divide an organic shape would be time lost.
    pub fn waves(
        &self,
        surface: &Surface<'_>,
        order: &[u32],
        given: Option<f64>,
        context: &Context,
    ) -> Result<Option<Noise>> {
        let edge = self.edge;
        let least = self.level.clamp(LEAST_TOLERANCE * edge, LOUDEST_NOISE * edge);
        let sigma = given.map_or(least, |tolerance| tolerance / MODEL_REACH);
        let noise = |sigma| Noise::new(surface, sigma, edge, TRIANGLES_A_SAMPLE);
        let is_organic =
            |probe: &Probe| given.is_none() && probe.large < LARGE_NEARLY_ALL && probe.sigma > ORGANIC_NOISE * sigma;
        let probe = propose::probe(surface, &noise(sigma), order, is_organic, context)?;
        tracing::debug!(sigma = sigma / edge, probe = probe.sigma / edge, large = probe.large, "waves");
        if probe.large < LARGE_FIRST || is_organic(&probe) {
            return Ok(None);
        }
        let ample = if given.is_some() { sigma } else { sigma.max(AMPLE_FACTOR * probe.sigma) };
        if given.is_none() && ample > LOUDEST_NOISE * edge {
            return Ok(None);
        }
        Ok(Some(Noise { triangles_a_wave: TRIANGLES_A_WAVE, ..noise(ample) }))
    }
}
