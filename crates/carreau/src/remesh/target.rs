//! A wanted number of triangles: the scale of the size map that gives it.
//!
//! A mesh of equilateral triangles with edges of length one has 4 / (√3 h²) triangles per unit of area; real ones have
//! nearly as many. The integral gives the scale to begin with, the count that was reached corrects it. What is left to
//! correct makes all sizes larger or smaller, those too that a tolerance bounds: edges on ridges can then not follow, and
//! the triangles beside them are too tall.

use super::decimate::Demand;
use super::options::RemeshOptions;
use super::predicted::predicted;
use super::relocate::Accept;
use super::source::Source;
use super::work::{BALANCE, Work};
use crate::context::Context;
use crate::error::Result;

/// Excess of the predicted count, as a logarithm, from which one more step is good enough: on scans, where no tolerance
/// bounds the sizes, and on clean models.
const NEARLY: [f64; 2] = [0.1, 0.02];
/// The count is met within this share.
pub const MET: f64 = 0.009;
/// The same before gaps ask for their vertices.
pub const WITHIN: f64 = MET - super::gaps::ADDED;

/// The scale of the sizes for which the integral predicts a number of triangles, nearly: the run itself does the rest.
///
/// The count falls with a power of the scale, the second where nothing bounds the sizes; two counts tell which.
pub(super) fn find_scale(source: &mut Source, options: &RemeshOptions, wanted: f64, context: &Context) -> Result<f64> {
    let mut scale = options.scale;
    let mut power = 2.0;
    let mut before: Option<[f64; 2]> = None;
    for _ in 0..8 {
        source.set_size_map(&RemeshOptions { scale, ..options.clone() }, context)?;
        let excess = (predicted(&source.support) / wanted).ln();
        if let Some([last_scale, last_excess]) = before {
            power = ((last_excess - excess) / (scale / last_scale).ln()).clamp(0.3, 3.0);
        }
        before = Some([scale, excess]);
        scale *= (excess / power).exp().clamp(0.1, 10.0);
        if excess.abs() < NEARLY[usize::from(!source.noisy)] {
            break;
        }
    }
    Ok(scale)
}

impl Work<'_> {
    /// Scales the sizes so that edges have the mean length one when there are as many triangles as wanted.
    pub fn steer(&mut self, wanted: f64) {
        let shrink = (self.mesh.triangle_count() as f64 / wanted).sqrt();
        self.rescale(BALANCE * self.mean_length() * shrink);
    }

    /// Scales the sizes.
    fn rescale(&mut self, factor: f64) {
        self.scale *= factor;
        self.size.iter_mut().for_each(|h| *h *= factor);
    }

    /// Mean length of the edges in the metric.
    pub fn mean_length(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for h in self.mesh.edges() {
            sum += self.edge_length(h);
            count += 1.0;
        }
        sum / f64::max(count, 1.0)
    }

    /// Collapses the shortest or splits the longest edges until the number of triangles is wanted but for a share.
    pub fn trim(&mut self, wanted: usize, within: f64, context: &Context) -> Result<()> {
        let most = ((1.0 + within) * wanted as f64).floor() as usize;
        let least = ((1.0 - within) * wanted as f64).ceil() as usize;
        let fair = Demand { good_length: 0.62, longest: 1.6, least_shape: 0.55, ears: false };
        let poor = Demand { good_length: 0.5, longest: 1.75, least_shape: 0.35, ears: false };
        let tries = [0.8, 0.9, 1.0, 1.2, 1.5].map(|limit| (limit, fair)).into_iter();
        for (limit, demand) in tries.chain([1.0, 1.5, 1.5].map(|limit| (limit, poor))) {
            if self.mesh.triangle_count() <= most {
                break;
            }
            self.decimate(limit, &demand, most, context)?;
            self.swap(2, context)?;
            self.relocate(Accept::Better, context)?;
        }
        for limit in [1.3, 1.2, 1.1, 1.0] {
            if self.mesh.triangle_count() >= least {
                break;
            }
            self.divide_to(limit, least, context)?;
            self.swap(2, context)?;
            self.relocate(Accept::Better, context)?;
        }
        Ok(())
    }
}
