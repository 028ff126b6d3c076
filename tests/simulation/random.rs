//! The only source of chance: everything that differs between two runs comes from the seed.

use std::time::Duration;

/// Random decisions of one part of a run.
pub struct Random(fastrand::Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    /// Returns the source of another part of the run. Its decisions do not depend on the order in which parts run.
    pub fn fork(&mut self) -> Self {
        Self(self.0.fork())
    }

    /// Returns true once in `n` times.
    pub fn one_in(&mut self, n: u32) -> bool {
        self.0.u32(0..n) == 0
    }

    /// Returns a whole number from `low` to `high`, both included.
    pub fn from(&mut self, low: u64, high: u64) -> u64 {
        self.0.u64(low..=high)
    }

    /// Returns an index below `n`.
    pub fn below(&mut self, n: usize) -> usize {
        self.0.usize(0..n)
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.f64()
    }

    pub fn millis(&mut self, low: u64, high: u64) -> Duration {
        Duration::from_millis(self.from(low, high))
    }

    pub fn pick<T: Clone>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())].clone()
    }

    /// Returns one of the values. Each has the chance of its weight.
    pub fn weighted<T: Clone>(&mut self, values: &[(u32, T)]) -> T {
        let mut left = self.0.u32(0..values.iter().map(|(weight, _)| weight).sum());
        for (weight, value) in values {
            match left.checked_sub(*weight) {
                Some(rest) => left = rest,
                None => return value.clone(),
            }
        }
        unreachable!("the weights are not zero")
    }

    pub fn bytes(&mut self) -> [u8; 16] {
        self.0.u128(..).to_le_bytes()
    }

    pub fn byte(&mut self) -> u8 {
        self.0.u8(..)
    }

    /// Returns a word that no other call returns.
    pub fn word(&mut self) -> String {
        format!("{:032x}", self.0.u128(..))
    }
}
