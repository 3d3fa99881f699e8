//! Constants of projections onto curves and surfaces.

/// Most steps of Newton's method.
pub const MAX_STEPS: usize = 20;
/// Most halvings of such a step.
pub const MAX_HALVINGS: i32 = 16;
/// Steps that matter no more, as a share of the domain: their effect on the distance is of second order.
pub const TINY: f64 = 1e-8;
