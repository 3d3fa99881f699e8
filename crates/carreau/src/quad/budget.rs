//! How much may be done for a surface on a rung before the next one takes over: a count, no clock, so that the same surface
//! gets the same quads everywhere.

/// Triangles made for each quad that is wanted, and where few are wanted.
const SHARE: u64 = 320;
const LEAST: u64 = 320_000;
/// What it costs to settle a quad, in triangles made.
const QUAD: u64 = 5;
/// Steps in search of numbers that cost as much as a triangle.
const STEPS: u64 = 100;

/// What is left of it, in triangles made.
#[derive(Debug, Clone)]
pub struct Budget(u64);

impl Budget {
    /// For so many quads.
    pub fn new(quads: f64) -> Self {
        Budget(SHARE.saturating_mul(quads.max(0.0) as u64).max(LEAST))
    }

    /// Nothing is left.
    pub fn is_spent(&self) -> bool {
        self.0 == 0
    }

    /// What is left.
    pub fn left(&self) -> u64 {
        self.0
    }

    /// Others have spent this much of it.
    pub fn spend(&mut self, cost: u64) {
        self.0 = self.0.saturating_sub(cost);
    }

    fn take(&mut self, cost: u64) {
        self.spend(cost);
        tracing::debug!(target: "carreau::quad", cost, left = self.0, "budget");
    }

    /// Triangles were made.
    pub fn triangles(&mut self, count: usize) {
        self.take(count as u64);
    }

    /// Quads were settled.
    pub fn quads(&mut self, count: usize) {
        self.take(QUAD.saturating_mul(count as u64));
    }

    /// Numbers were searched for.
    pub fn steps(&mut self, count: u64) {
        self.take(count / STEPS);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_spent_once_and_not_overdrawn() {
        let mut budget = Budget::new(1e4);
        budget.triangles(1000);
        budget.quads(1000);
        budget.steps(1000 * STEPS);
        assert_eq!(budget.0, SHARE * 10_000 - 1000 - QUAD * 1000 - 1000);
        assert!(!budget.is_spent());
        budget.triangles(usize::MAX);
        budget.quads(1);
        assert!(budget.is_spent());
        assert!([0.0, -1.0, 1.0, f64::NAN].iter().all(|&few| Budget::new(few).0 == LEAST));
        assert!(!Budget::new(f64::INFINITY).is_spent());
    }
}
