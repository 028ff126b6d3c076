//! What stands for Clarabel in a build without it: no program has an answer, so the solver `qp` fails.

use crate::program::{Effort, QpAnswer, QuadraticProgram, Unsolved};

/// Solves nothing.
#[derive(Default)]
pub struct Clarabel;

impl Clarabel {
    /// Finds no answer.
    #[expect(clippy::unused_self, reason = "the signature is that of the solver")]
    pub fn solve(&mut self, _: &QuadraticProgram, _: Effort) -> Result<QpAnswer, Unsolved> {
        Err(Unsolved { iterations: 0 })
    }
}

/// Finds no answer.
pub fn least_excess(_rows: &[f64], _bounds: &[f64], _n: usize) -> Result<Vec<f64>, Unsolved> {
    Err(Unsolved { iterations: 0 })
}
