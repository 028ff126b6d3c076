//! The plan of a joint that cannot follow the virtual one everywhere: accelerations that leave it as near as possible.
//!
//! Minimise Σ_k h_k (r_k − (B z)_k)² over accelerations z of the intervals h_k with |z_k| ≤ A. r_k is where the virtual joint will be
//! relative to a joint at constant velocity, and B z is what the accelerations add. B is the same for all joints and periods.

use super::newton::solve_cholesky;
use crate::controller::state::TIMES_AHEAD;

/// Number of intervals.
pub(super) const INTERVALS: usize = TIMES_AHEAD.len() - 1;

/// Weight of z² that keeps the problem regular, relative to that of positions.
const REGULAR: f64 = 1e-9;

/// Most changes of the working set. Problems of eight unknowns need a few.
const MAX_CHANGES: usize = 30;

/// The matrices of the plan.
#[derive(Debug)]
pub(super) struct Plan {
    /// H = Bᵀ W B.
    hessian: [[f64; INTERVALS]; INTERVALS],
    /// Bᵀ W.
    gradient: [[f64; INTERVALS]; INTERVALS],
}

impl Plan {
    pub fn new() -> Self {
        let length = |k: usize| TIMES_AHEAD[k + 1] - TIMES_AHEAD[k];
        let b = |k: usize, i: usize| {
            let h = length(i);
            if i <= k { h * h / 2.0 + h * (TIMES_AHEAD[k + 1] - TIMES_AHEAD[i + 1]) } else { 0.0 }
        };
        let mean = TIMES_AHEAD[INTERVALS] / INTERVALS as f64;
        let weight = |k: usize| length(k) / mean;
        let mut plan = Self { hessian: Default::default(), gradient: Default::default() };
        for i in 0..INTERVALS {
            for j in 0..INTERVALS {
                plan.gradient[i][j] = b(j, i) * weight(j);
                plan.hessian[i][j] = (0..INTERVALS).map(|k| b(k, i) * weight(k) * b(k, j)).sum();
            }
            plan.hessian[i][i] += REGULAR;
        }
        plan
    }

    /// Returns z_1 for r (rad or m) and A; zero if A is not finite.
    pub fn first_acceleration(&self, relative: &[f64; INTERVALS], largest: f64) -> f64 {
        let linear: [f64; INTERVALS] =
            std::array::from_fn(|i| self.gradient[i].iter().zip(relative).map(|(g, r)| g * r).sum());
        // −1, 0, 1: at the lower bound, free, at the upper bound.
        let mut sides = [0.0_f64; INTERVALS];
        let mut z = [0.0; INTERVALS];
        for _ in 0..MAX_CHANGES {
            self.solve(&linear, &sides, largest, &mut z);
            let worst = (0..INTERVALS).filter(|&i| sides[i] == 0.0).max_by(|&a, &b| z[a].abs().total_cmp(&z[b].abs()));
            if let Some(i) = worst.filter(|&i| z[i].abs() > largest) {
                // Together: plans are mostly full acceleration, then full deceleration.
                for k in 0..INTERVALS {
                    if sides[k] == 0.0 && z[k].abs() > largest.max(0.5 * z[i].abs()) {
                        sides[k] = z[k].signum();
                    }
                }
                continue;
            }
            let slope =
                |i: usize| -> f64 { linear[i] - self.hessian[i].iter().zip(&z).map(|(h, z)| h * z).sum::<f64>() };
            let released = (0..INTERVALS).filter(|&i| sides[i] * slope(i) < 0.0);
            let Some(i) = released.max_by(|&a, &b| slope(a).abs().total_cmp(&slope(b).abs())) else { break };
            sides[i] = 0.0;
        }
        z[0].clamp(-largest, largest)
    }

    /// Solves for the free unknowns; the others are at their bounds.
    fn solve(&self, linear: &[f64; INTERVALS], sides: &[f64; INTERVALS], largest: f64, z: &mut [f64; INTERVALS]) {
        let (mut free, mut count) = ([0; INTERVALS], 0);
        for i in 0..INTERVALS {
            z[i] = sides[i] * largest;
            if sides[i] == 0.0 {
                (free[count], count) = (i, count + 1);
            }
        }
        let (mut matrix, mut solution) = ([0.0; INTERVALS * INTERVALS], [0.0; INTERVALS]);
        for (row, &i) in free[..count].iter().enumerate() {
            for (column, &j) in free[..=row].iter().enumerate() {
                matrix[row * count + column] = self.hessian[i][j];
            }
            solution[row] = linear[i] - self.hessian[i].iter().zip(&*z).map(|(h, z)| h * z).sum::<f64>();
        }
        solve_cholesky(&mut matrix[..count * count], &mut solution[..count]);
        for (&i, value) in free[..count].iter().zip(solution) {
            z[i] = value;
        }
    }
}
