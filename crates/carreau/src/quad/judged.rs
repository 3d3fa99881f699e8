//! What speaks against quads; the less does, the better they are.

use super::ceiling::worst_shape;
use super::source::Source;
use super::validate::{LEAST_RECALL, recall};
use super::work::Work;
use super::{NUMBER_WITHIN, off, quality};
use crate::context::Context;
use crate::error::Result;

/// A share of their edges: quads that are farther from the surface are of no use, because they leave out a part of it.
pub const USELESS_STRAYING: f64 = 0.4;
/// A scaled Jacobian over what it can be: quads with a worse one are of no use, because they are all but turned over.
const USELESS_SHAPE: f64 = 0.02;
/// A share of the features: quads that lose more are of no use, because they are made for what they keep.
const USELESS_LOST: f64 = 0.2;
/// A scaled Jacobian over what it can be: a worst one below counts against quads, because better ones do no harm.
const GRADED_SHAPE: f64 = 0.5;
/// A scaled Jacobian over what it can be: a grade of the worst shape, because less is hardly seen.
const SHAPE_GRADE: f64 = 0.1;
/// A share of the number: a grade of what is missed of it, because that is to weigh as much as a tenth of the worst
/// shape.
const NUMBER_GRADE: f64 = 0.1;
/// A share of the diagonal: a distance from the surface above it counts against quads, because that is what a feature
/// may be off by, too.
const GRADED_GAP: f64 = 0.002;
/// A share of the diagonal: a grade of that distance, because that is to weigh as much as a tenth of the worst shape.
const GAP_GRADE: f64 = 0.001;
/// A scaled Jacobian: a mean below it counts against quads, because good ones are above it on most surfaces.
const GRADED_MEAN: f64 = 0.93;
/// A scaled Jacobian: a grade of that mean, smaller than of the worst because it changes far less.
const MEAN_GRADE: f64 = 0.03;
/// A share of the features: a grade of what is lost, because few features are to weigh as much as a poor shape.
const LOST_GRADE: f64 = 0.02;

/// What speaks against quads, in the order of its weight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cost {
    /// They stray from the surface, lose features, or one of them is of no use.
    pub is_useless: bool,
    /// Grades of the worst shape and of the mean, of a number missed, of a distance, of lost features.
    pub grades: u32,
    pub irregular: usize,
}

/// Quads that the validator accepts.
pub struct Judged {
    pub work: Work,
    pub cost: Cost,
    /// They are as many as were asked for.
    pub meets_number: bool,
    /// They lose a part of the features, which are not those of a scan.
    pub loses: bool,
    /// One of them is all but turned over.
    pub is_flat: bool,
}

impl Judged {
    /// Nothing forbids them.
    pub fn is_useful(&self) -> bool {
        !self.cost.is_useless && !self.loses
    }

    /// What keeps to the number and leaves a part out is better than many times as many quads, if it keeps the features.
    pub fn will_do(&self) -> bool {
        self.is_useful() || self.meets_number && !self.loses && !self.is_flat
    }

    /// What orders quads, the best first: what keeps all features goes before what loses some.
    pub fn worth(&self) -> (bool, Cost) {
        (self.loses, self.cost)
    }

    /// `gap`: how far the quads are from the surface; `quads`: how many are wanted.
    pub fn new(work: Work, source: &Source, gap: f64, quads: Option<usize>, context: &Context) -> Result<Self> {
        let grade = |beyond: f64, size: f64| (beyond / size).ceil().max(0.0) as u32;
        let strays = quality::straying(&work, source, context)?;
        let shape = worst_shape(&work);
        let kept = recall(&work, source).0;
        let misses = quads.map_or(0, |n| grade(off(work.faces.len(), n) - NUMBER_WITHIN, NUMBER_GRADE));
        let poor = grade(GRADED_SHAPE - shape, SHAPE_GRADE);
        let dull = grade(GRADED_MEAN - quality::mean_jacobian(&work), MEAN_GRADE);
        let far = grade(gap / source.diagonal - GRADED_GAP, GAP_GRADE);
        let lost = grade(LEAST_RECALL - kept, LOST_GRADE);
        let cost = Cost {
            is_useless: strays > USELESS_STRAYING || shape < USELESS_SHAPE || kept < 1.0 - USELESS_LOST,
            grades: poor + dull + misses + far + lost,
            irregular: quality::irregular(&work),
        };
        tracing::debug!(target: "carreau::quad", strays, shape, poor, dull, misses, far, lost, ?cost, "judged");
        let loses = !source.is_noisy && kept < LEAST_RECALL;
        Ok(Judged { work, cost, meets_number: misses == 0, loses, is_flat: shape < USELESS_SHAPE })
    }
}
