//! Constants of the optimisation.

/// Most rounds of untangling.
pub const UNTANGLE_ROUNDS: usize = 30;
/// Most rounds of new targets and weights.
pub const WEIGHT_ROUNDS: usize = 4;
/// Least number of cells per task: enough work to pay for one.
pub const MIN_CELLS: usize = 512;
/// Least number of vertices per task.
pub const MIN_VERTICES: usize = 4096;
/// More cells than this are unfolded by patches first, fewer all together.
pub const FEW_CELLS: usize = 4000;
/// Cells from which on iterations are saved.
pub const MANY_CELLS: f64 = 20_000.0;

/// Targets stay within this factor of the first ones.
pub const DRIFT: f64 = 2.0;

/// The power of the energy that a mesh is delivered with; what comes before it need not converge as well.
pub const LAST_POWER: i32 = 8;
/// Share of the energy that ten iterations must gain before the last power.
pub const PASSED: f64 = 1e-3;
/// The same at the last power.
pub const CONVERGED: f64 = 3e-4;

/// The share of the energy beside the least scaled Jacobian.
pub const BARRIER_SHARE: f64 = 0.1;

/// Determinants above this share of the target count as positive.
pub const VALID: f64 = 1e-6;
