//! What speaks against quads; the less does, the better they are.

use super::ceiling::worst_shape;
use super::source::Source;
use super::validate::{RECALL, recall};
use super::work::Work;
use super::{WITHIN, off, quality};
use crate::context::Context;
use crate::error::Result;

/// Quads farther from the surface than this share of their edges are of no use.
pub const STRAYS: f64 = 0.4;
/// So are those with a worse shape than this (the scaled Jacobian over what it can be between features).
const USELESS: f64 = 0.02;
/// So are those that lose more than this share of the features.
const MOST_LOST: f64 = 0.2;
/// Shapes below this count against quads, by grades of the other size; so does a number that is missed, in shares of it.
const POOR: f64 = 0.5;
const GRADE: f64 = 0.1;
/// So does a distance from the surface above this share of the diagonal, by grades of the other.
const FAR: f64 = 0.002;
const FARTHER: f64 = 0.001;
/// So do scaled Jacobians of less than this in the mean, by grades of the other size.
const DULL: f64 = 0.93;
const DULLER: f64 = 0.03;
/// So do features that are lost, by grades of this share.
const LOST: f64 = 0.02;

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
}

impl Judged {
    /// `gap`: how far the quads are from the surface; `quads`: how many are wanted.
    pub fn new(work: Work, source: &Source, gap: f64, quads: Option<usize>, context: &Context) -> Result<Self> {
        let grade = |beyond: f64, size: f64| (beyond / size).ceil().max(0.0) as u32;
        let strays = quality::straying(&work, source, context)?;
        let shape = worst_shape(&work);
        let kept = recall(&work, source).0;
        let misses = quads.map_or(0, |n| grade(off(work.faces.len(), n) - WITHIN, GRADE));
        let poor = grade(POOR - shape, GRADE);
        let dull = grade(DULL - quality::mean_jacobian(&work), DULLER);
        let far = grade(gap / source.diagonal - FAR, FARTHER);
        let lost = grade(RECALL - kept, LOST);
        let cost = Cost {
            is_useless: strays > STRAYS || shape < USELESS || kept < 1.0 - MOST_LOST,
            grades: poor + dull + misses + far + lost,
            irregular: quality::irregular(&work),
        };
        tracing::debug!(target: "carreau::quad", strays, shape, poor, dull, misses, far, lost, ?cost, "judged");
        Ok(Judged { work, cost, meets_number: misses == 0 })
    }
}
