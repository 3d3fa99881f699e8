//! Chooses the step length along the branches: the one asked for, or the shortest that gives no more cells than asked
//! for.

use super::options::HexOptions;
use super::resample::{self, Step};
use crate::mesh::CurveNet;

/// Steps along the branches, in radii, where no size is asked for.
const DEFAULT_STEP: f64 = 1.5;
/// More segments than this are not made without being asked for: the steps grow instead.
const MANY_SEGMENTS: usize = 1500;
/// Steps are at most this long, in radii; longer than the first ones only where these are too many.
const LONGEST_STEPS: [f64; 2] = [1e3, 1e12];

/// The net resampled to the size asked for.
pub(super) fn resized(net: &CurveNet, options: &HexOptions) -> CurveNet {
    if let Some(length) = options.edge_length {
        return resample::resample(net, Step::Length(length));
    }
    let fine = resample::resample(net, Step::Radii(DEFAULT_STEP));
    let fits = |n: &CurveNet| match options.hexes {
        Some(wanted) => options.most_hexes(n) <= wanted as f64,
        None => n.edges.len() <= MANY_SEGMENTS.max(net.edges.len()),
    };
    if options.hexes.is_none() && fits(&fine) {
        return fine;
    }
    finest(net, Step::Radii, fits)
}

/// The finest resampled net that fits, by bisection of the logarithm of the steps.
pub(super) fn finest(net: &CurveNet, step: impl Fn(f64) -> Step, fits: impl Fn(&CurveNet) -> bool) -> CurveNet {
    // The longest one is for threads, thin beyond all measure.
    let [long, longest] = LONGEST_STEPS.map(|k| (k.ln(), step(k)));
    let usual = resample::resample(net, long.1);
    let (mut high, mut best) = match fits(&usual) {
        true => (long.0, usual),
        false => (longest.0, resample::resample(net, longest.1)),
    };
    let mut low = 0.02f64.ln();
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        let tried = resample::resample(net, step(middle.exp()));
        if fits(&tried) {
            high = middle;
            best = tried;
        } else {
            low = middle;
        }
    }
    best
}
