//! The order of the local operations: the method at a glance.

use super::decimate::Demand;
use super::relocate::Accept;
use super::target;
use super::work::Work;
use crate::context::Context;
use crate::error::{Error, Result};
use std::f64::consts::FRAC_1_SQRT_2;

/// Length in the metric above which edges are split while the mesh is balanced.
const LONG: f64 = 1.45;
/// Length in the metric below which edges are collapsed then.
const SHORT: f64 = 0.85;
/// Relocations of all vertices after every round.
const SMOOTHINGS: usize = 2;

/// Edges of size one that a mesh may be divided into: 100 million, some tens of gigabytes. Sizes that a vertex far away makes
/// tiny against the edges to it ask for any number.
const MOST_EDGES: f64 = 1e8;

/// Rounds of splits, collapses, flips and relocations: for scans, and for clean models, whose ridges need more of
/// them.
const BALANCING_ROUNDS: [usize; 2] = [3, 8];
/// Relocations for better shapes at the end: for scans, and for clean models.
const RESHAPINGS: [usize; 2] = [1, 4];
/// The same behind everything that changes edges, on clean models.
const LAST_RESHAPINGS: usize = 3;

impl Work<'_> {
    /// Makes all edges as close to length one as shapes and surface allow; with a wanted number of triangles the sizes are
    /// scaled on the way until that is what they give.
    pub fn adapt(&mut self, wanted: Option<usize>, context: &Context) -> Result<()> {
        let (rounds, reshapings) =
            (BALANCING_ROUNDS[usize::from(self.limits.clean)], RESHAPINGS[usize::from(self.limits.clean)]);
        let strict = Demand { good_length: 2.0, longest: f64::INFINITY, least_shape: 0.1, ears: false };
        {
            let _stage = context.stage("decimate");
            let most = wanted.map_or(0, |n| (1.1 * n as f64) as usize);
            self.decimate(FRAC_1_SQRT_2, &strict, most, context)?;
            self.swap(4, context)?;
            self.decimate(1.0, &strict, most, context)?;
        }
        for round in 1..=rounds {
            if let Some(wanted) = wanted {
                self.steer(1.06 * wanted as f64);
            }
            self.check_lengths()?;
            self.balance(context)?;
            if let Some(wanted) = wanted
                && round == rounds
            {
                self.steer(wanted as f64);
                self.trim(wanted, 0.001, context)?;
            }
            let _stage = context.stage("relocate");
            for _ in 0..SMOOTHINGS {
                self.relocate(Accept::Harmless, context)?;
            }
        }
        self.reshape_all(reshapings, context)?;
        let _stage = context.stage("polish");
        self.polish(context)?;
        if let Some(wanted) = wanted {
            self.trim(wanted, target::WITHIN, context)?;
        }
        if self.limits.clean && self.stretch.is_empty() {
            // What polishing and trimming have left stands alone: its neighbours settle around it.
            for _ in 0..LAST_RESHAPINGS {
                self.reshape(context)?;
                self.swap(2, context)?;
            }
        }
        if self.limits.clean {
            self.keep_ridges(context)?;
        }
        if !self.curved {
            let _stage = context.stage("fit");
            self.fit(context)?;
            if self.limits.clean {
                self.close_gaps(context)?;
            }
        }
        Ok(())
    }

    /// Makes triangles better shaped, by swaps and relocations.
    fn reshape_all(&mut self, rounds: usize, context: &Context) -> Result<()> {
        let _stage = context.stage("reshape");
        for _ in 0..2 {
            self.swap(4, context)?;
            self.relocate(Accept::Better, context)?;
        }
        // The tips of equilateral triangles are no aim where edges are to be stretched.
        for _ in 0..if self.stretch.is_empty() { rounds } else { 0 } {
            self.reshape(context)?;
            self.regularise(context)?;
            self.reshape(context)?;
            self.swap(2, context)?;
        }
        Ok(())
    }

    /// Refuses sizes at which the edges alone would be too many.
    fn check_lengths(&self) -> Result<()> {
        let edges: f64 = self.mesh.edges().map(|h| self.edge_length(h)).sum();
        if edges <= MOST_EDGES {
            return Ok(());
        }
        Err(Error::Numeric(format!(
            "the sizes ask for {edges:.0e} edges, more than {MOST_EDGES:.0e}; a larger least size or a larger deviation asks for fewer"
        )))
    }

    /// Splits what is too long, collapses what is too short, flips to good shapes and regular valences.
    fn balance(&mut self, context: &Context) -> Result<()> {
        {
            let _stage = context.stage("divide");
            self.divide(LONG, 3, context)?;
        }
        {
            let _stage = context.stage("collapse");
            let demand = Demand { good_length: 0.72, longest: LONG, least_shape: 0.5, ears: false };
            self.decimate(SHORT, &demand, 0, context)?;
        }
        if self.limits.clean {
            let _stage = context.stage("space");
            self.space_ridges(context)?;
        }
        let _stage = context.stage("swap");
        self.swap(4, context)?;
        self.regularise(context)?;
        Ok(())
    }
}
