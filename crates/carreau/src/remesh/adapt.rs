//! The order of the operations.

use super::decimate::Demand;
use super::relocate::Accept;
use super::work::Work;
use crate::context::Context;
use crate::error::Result;
use std::f64::consts::FRAC_1_SQRT_2;

/// Edges above are split, edges below collapsed, while the mesh is balanced.
const LONG: f64 = 1.45;
const SHORT: f64 = 0.85;
/// Relocations of all vertices after every round.
const SMOOTHINGS: usize = 2;

impl Work<'_> {
    /// Makes all edges as close to length one as shapes and surface allow.
    pub fn adapt(&mut self, context: &Context) -> Result<()> {
        let strict = Demand { good_length: 2.0, longest: f64::INFINITY, least_shape: 0.1 };
        {
            let _stage = context.stage("decimate");
            self.decimate(FRAC_1_SQRT_2, &strict, context)?;
            self.swap(4, context)?;
            self.decimate(1.0, &strict, context)?;
        }
        self.balance(4, context)
    }

    /// Splits, collapses, flips and moves in turns, the worst last.
    fn balance(&mut self, rounds: usize, context: &Context) -> Result<()> {
        for _ in 0..rounds {
            {
                let _stage = context.stage("divide");
                self.divide(LONG, 3, context)?;
            }
            {
                let _stage = context.stage("collapse");
                let demand = Demand { good_length: 0.72, longest: LONG, least_shape: 0.5 };
                self.decimate(SHORT, &demand, context)?;
            }
            {
                let _stage = context.stage("swap");
                self.swap(4, context)?;
                self.regularise(context)?;
            }
            {
                let _stage = context.stage("relocate");
                for _ in 0..SMOOTHINGS {
                    self.relocate(Accept::Harmless, context)?;
                }
            }
        }
        for _ in 0..2 {
            self.swap(4, context)?;
            self.relocate(Accept::Better, context)?;
        }
        let _stage = context.stage("polish");
        self.polish(context)
    }
}
