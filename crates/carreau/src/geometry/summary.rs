//! Many numbers in a few.

use serde::Serialize;

/// Numbers summed one by one before their sums are added: the result does not depend on who sums which part.
const NUMBERS_PER_SUM: usize = 4096;

/// Extremes, mean and percentiles of a list of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Summary {
    /// How many numbers.
    pub count: usize,
    /// The smallest.
    pub min: f64,
    /// Not smaller than 5 % of them.
    pub p05: f64,
    /// The median.
    pub p50: f64,
    /// The arithmetic mean.
    pub mean: f64,
    /// Not smaller than 95 % of them.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

impl Summary {
    /// Summarises numbers, which may be reordered; `None` if there are none.
    pub fn of(mut values: Vec<f64>) -> Option<Self> {
        let count = values.len();
        let mean = sum(&values) / count as f64;
        let mut nearest_rank = |share: f64| {
            let rank = ((share * count as f64).ceil() as usize).clamp(1, count) - 1;
            *values.select_nth_unstable_by(rank, f64::total_cmp).1
        };
        (count > 0).then(|| Summary {
            count,
            min: nearest_rank(0.0),
            p05: nearest_rank(0.05),
            p50: nearest_rank(0.5),
            mean,
            p95: nearest_rank(0.95),
            max: nearest_rank(1.0),
        })
    }
}

/// The sum over fixed chunks: more exact than one by one, and the same however the work is divided.
pub fn sum(values: &[f64]) -> f64 {
    values.chunks(NUMBERS_PER_SUM).map(|chunk| chunk.iter().sum::<f64>()).sum()
}

/// How many numbers fall into each of several equal intervals.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Histogram {
    /// Lower end of the first interval.
    pub low: f64,
    /// Upper end of the last interval, which it belongs to.
    pub high: f64,
    /// Count of every interval; numbers outside are counted in the first and the last.
    pub counts: Vec<usize>,
}

impl Histogram {
    /// Counts numbers in `bins` (at least one) equal intervals from `low` to `high`.
    pub fn of(values: &[f64], low: f64, high: f64, bins: usize) -> Self {
        let mut counts = vec![0; bins.max(1)];
        let last = counts.len() - 1;
        for &value in values {
            let at = (value - low) / (high - low) * counts.len() as f64;
            // The cast takes everything below zero, and NaN, to the first interval.
            counts[(at as usize).min(last)] += 1;
        }
        Histogram { low, high, counts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn percentiles_are_members_by_nearest_rank() {
        let s = Summary::of((1..=100).rev().map(f64::from).collect()).unwrap();
        assert_eq!((s.min, s.p05, s.p50, s.mean, s.p95, s.max), (1.0, 5.0, 50.0, 50.5, 95.0, 100.0));
        assert_eq!(Summary::of(vec![3.0]).unwrap().p05, 3.0);
        assert_eq!(Summary::of(Vec::new()), None);
    }

    #[test]
    fn intervals_include_their_ends() {
        let h = Histogram::of(&[-1.0, 0.0, 0.49, 0.5, 1.0, 2.0, f64::NAN], 0.0, 1.0, 2);
        assert_eq!(h.counts, [4, 3]);
    }

    proptest! {
        #[test]
        fn summaries_are_ordered(values in prop::collection::vec(-1e3f64..1e3, 1..300)) {
            let s = Summary::of(values).unwrap();
            prop_assert!(s.min <= s.p05 && s.p05 <= s.p50 && s.p50 <= s.p95 && s.p95 <= s.max);
            prop_assert!(s.min - 1e-9 <= s.mean && s.mean <= s.max + 1e-9);
        }
    }
}
