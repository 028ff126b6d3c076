//! Reproducible random numbers.

use rand_pcg::Pcg64;
use rand_pcg::rand_core::RngCore;

/// The use of random numbers. Each purpose has its own stream, so that one does not change the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Sensor noise.
    Sensors,
    /// Faults of the connection.
    LossyChannel,
}

/// A random number generator. The same seed and purpose always give the same numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct RandomSource(Pcg64);

impl RandomSource {
    /// Returns the generator for a seed and a purpose.
    pub fn new(seed: u64, purpose: Purpose) -> Self {
        Self(Pcg64::new(seed.into(), purpose as u128))
    }

    /// Returns a number that is uniformly distributed in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a number that is normally distributed with mean 0 and standard deviation 1 (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_mean_0_variance_1_and_the_tails_of_a_normal_distribution() {
        let mut random = RandomSource::new(1, Purpose::Sensors);
        let draws: Vec<f64> = (0..100_000).map(|_| random.normal()).collect();
        let mean = |of: &dyn Fn(f64) -> f64| draws.iter().map(|v| of(*v)).sum::<f64>() / 1e5;
        assert!(mean(&|v| v).abs() < 0.02 && (mean(&|v| v * v) - 1.0).abs() < 0.02);
        let beyond_two = mean(&|v| if v.abs() > 2.0 { 1.0 } else { 0.0 });
        assert!((beyond_two - 0.0455).abs() < 0.003, "{beyond_two}");
    }

    #[test]
    fn seeds_and_purposes_have_different_numbers() {
        let first = |seed, purpose| RandomSource::new(seed, purpose).uniform();
        assert_eq!(first(7, Purpose::LossyChannel), first(7, Purpose::LossyChannel));
        assert!((first(7, Purpose::LossyChannel) - first(8, Purpose::LossyChannel)).abs() > 1e-3);
        assert!((first(7, Purpose::LossyChannel) - first(7, Purpose::Sensors)).abs() > 1e-3);
    }
}
