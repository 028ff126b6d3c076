//! What a run over many problems found.

use std::fmt;

use crate::hierarchy::{Hierarchy, length};

/// Slacks count as equally good up to this, relative to the size of their level.
const EQUALLY_GOOD: f64 = 1e-9;

/// Errors above this are wrong answers, unless both are equally good.
const WRONG: f64 = 1e-6;

/// Errors of the answers, and the seeds of the problems that failed.
#[derive(Debug, Default)]
pub struct Findings {
    /// Largest error of a joint velocity, relative to the speed of the problem, for each answer.
    pub errors: Vec<f64>,
    /// Seeds of answers that are neither near the expected one nor as good.
    pub wrong: Vec<u64>,
    /// Seeds of answers whose status is not optimal.
    pub uncertified: Vec<u64>,
}

impl Findings {
    /// Adds the comparison of an answer with the expected one.
    pub fn compare(&mut self, seed: u64, hierarchy: &Hierarchy, velocity: &[f64], expected: &[f64]) {
        let difference = velocity.iter().zip(expected).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        let speed = hierarchy.speed().max(length(expected));
        let error = if difference == 0.0 { 0.0 } else { difference / speed };
        if !(error <= WRONG || equally_good(hierarchy, velocity, expected)) {
            self.wrong.push(seed);
        }
        self.errors.push(error);
    }

    /// Returns the error that the given share of the answers does not exceed.
    pub fn quantile(&self, share: f64) -> f64 {
        let mut errors = self.errors.clone();
        errors.sort_by(f64::total_cmp);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of a length")]
        let place = (share * (errors.len() - 1) as f64).round() as usize;
        errors[place]
    }

    /// Asserts that all answers are optimal, and all but one in ten thousand exact to rounding.
    pub fn assert_exact(&self) {
        assert!(self.wrong.is_empty() && self.uncertified.is_empty(), "{self}");
        assert!(self.quantile(0.9999) <= 1e-12, "{self}");
    }
}

impl fmt::Display for Findings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let first = |seeds: &[u64]| seeds[..seeds.len().min(10)].to_vec();
        write!(f, "{} answers: {} wrong {:?}, ", self.errors.len(), self.wrong.len(), first(&self.wrong))?;
        write!(f, "{} not certified {:?}; error", self.uncertified.len(), first(&self.uncertified))?;
        for (name, share) in [("median", 0.5), ("p99", 0.99), ("p99.9", 0.999), ("p99.99", 0.9999), ("worst", 1.0)] {
            write!(f, " {name} {:.1e}", self.quantile(share))?;
        }
        Ok(())
    }
}

/// Returns whether two velocities have the same slack at every level, and the same distance from the reference.
fn equally_good(hierarchy: &Hierarchy, velocity: &[f64], other: &[f64]) -> bool {
    let (slacks, others) = (hierarchy.slacks(velocity), hierarchy.slacks(other));
    let level = |k: usize| (slacks[k] - others[k]).abs() <= EQUALLY_GOOD * hierarchy.size(k, other);
    let distances = (hierarchy.distance(velocity) - hierarchy.distance(other)).abs();
    (0..slacks.len()).all(level) && distances <= EQUALLY_GOOD * (length(&hierarchy.reference) + length(other))
}
