//! How hard cells are worked on.

/// How much work is put into a mesh.
pub struct Effort {
    /// Powers of the energy in turn, with the iterations of each.
    pub(super) powers: &'static [(i32, usize)],
    /// Settings tried while cells are folded: least σ, and the share of the springs' strength.
    pub(super) attempts: &'static [(f64, f64)],
}

/// For the coarsest mesh, where iterations cost little.
pub const COARSE: Effort = Effort {
    powers: &[(1, 150), (2, 100), (4, 150), (8, 150)],
    attempts: &[(0.15, 0.02), (0.4, 1e-4), (0.05, 0.02), (0.25, 0.2)],
};
/// For a mesh that others are made from.
pub const PASSING: Effort = Effort { powers: &[(1, 60), (2, 40), (4, 40)], attempts: COARSE.attempts };
/// For the refined mesh, which starts nearly valid.
pub const FINE: Effort = Effort { powers: &[(4, 60), (8, 80)], attempts: &[(0.15, 0.02), (0.4, 1e-4)] };

/// For the inside of a mesh whose boundary stays.
pub const INNER: Effort = Effort { powers: &[(4, 40), (8, 60)], attempts: &[] };
