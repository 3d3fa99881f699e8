//! Pseudo-random numbers for noise: SplitMix64 (Steele, Lea, Flood 2014).

/// A generator that gives the same numbers for the same seed on every machine.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Random(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [−1, 1).
    pub(crate) fn symmetric(&mut self) -> f64 {
        // The upper 53 bits as a multiple of 2⁻⁵², shifted.
        (self.next() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_uniform_and_depend_on_the_seed() {
        let draw = |seed| {
            let mut random = Random::new(seed);
            (0..10_000).map(|_| random.symmetric()).collect::<Vec<f64>>()
        };
        let x = draw(7);
        assert!(x.iter().all(|v| (-1.0..1.0).contains(v)));
        let moment = |power: i32| x.iter().map(|v| v.powi(power)).sum::<f64>() / x.len() as f64;
        assert!(moment(1).abs() < 0.02 && (moment(2) - 1.0 / 3.0).abs() < 0.02);
        assert_eq!(x, draw(7));
        assert_ne!(x, draw(8));
    }
}
