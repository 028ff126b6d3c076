//! The plan of a joint that cannot follow the virtual one everywhere: accelerations that leave it as near as possible.
//!
//! Let z be the accelerations on the intervals h_k between the times ahead. Minimise
//!
//! Σ_k h_k (r_k − (B z)_k)² subject to |z_k| ≤ A and |u⁻ + (C z)_k| ≤ V,
//!
//! where r_k is the position of the virtual joint relative to a joint that goes on with u⁻, B z and C z are what the accelerations add
//! to positions and velocities at the ends of the intervals. B and C are the same for all joints and periods.
//!
//! The solver is the dual active-set method of Goldfarb and Idnani. All that changes are the values N z of the sixteen constraints,
//! with N = [I; C], and their multipliers. So the method needs only G = N H⁻¹ Nᵀ, which is computed once.

use super::newton::solve_cholesky;
use crate::controller::state::TIMES_AHEAD;

/// Number of intervals, which is that of unknowns.
pub(super) const INTERVALS: usize = TIMES_AHEAD.len() - 1;

/// Number of constraints: an acceleration and a velocity for each interval, both bounded on two sides.
const ROWS: usize = 2 * INTERVALS;

/// Weight of the changes (z_{k+1} − z_k)², which keeps the problem regular. It does not change a constant acceleration.
const REGULAR: f64 = 1e-8;

/// Relative violation of a bound that counts as none.
const TOLERANCE: f64 = 1e-9;

/// Share of a bound that must be new, so that it can join the working set.
const DEPENDENT: f64 = 1e-13;

/// Most changes of the working set. Plans need some ten.
const MAX_CHANGES: usize = 60;

/// The matrices of all plans.
#[derive(Debug)]
pub(super) struct Plan {
    /// N H⁻¹ Bᵀ W, from r to the values without constraints.
    free: [[f64; INTERVALS]; ROWS],
    /// G.
    gram: [[f64; ROWS]; ROWS],
}

/// A bound of the working set.
#[derive(Debug, Clone, Copy, Default)]
struct Active {
    row: usize,
    /// 1 at the upper bound, −1 at the lower one.
    side: f64,
    multiplier: f64,
}

/// The bounds of one joint: lower and upper, one pair per row of N.
type Bounds = [[f64; 2]; ROWS];

impl Plan {
    /// Computes the matrices.
    pub fn new() -> Self {
        let length = |k: usize| TIMES_AHEAD[k + 1] - TIMES_AHEAD[k];
        let position = |k: usize, i: usize| {
            let h = length(i);
            if i <= k { h * h / 2.0 + h * (TIMES_AHEAD[k + 1] - TIMES_AHEAD[i + 1]) } else { 0.0 }
        };
        let constraint = |row: usize, i: usize| match row.checked_sub(INTERVALS) {
            Some(k) => {
                if i <= k {
                    length(i)
                } else {
                    0.0
                }
            }
            None => {
                if row == i {
                    1.0
                } else {
                    0.0
                }
            }
        };
        let mut hessian = [[0.0; INTERVALS]; INTERVALS];
        for (i, row) in hessian.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = (0..INTERVALS).map(|k| position(k, i) * length(k) * position(k, j)).sum();
            }
        }
        for i in 1..INTERVALS {
            hessian[i][i] += REGULAR;
            hessian[i - 1][i - 1] += REGULAR;
            hessian[i][i - 1] -= REGULAR;
            hessian[i - 1][i] -= REGULAR;
        }
        // One column of H⁻¹ Nᵀ for each row of N.
        let column = |row: usize| {
            let mut matrix = hessian.concat();
            let mut x: [f64; INTERVALS] = std::array::from_fn(|i| constraint(row, i));
            solve_cholesky(&mut matrix, &mut x);
            x
        };
        let columns: [[f64; INTERVALS]; ROWS] = std::array::from_fn(column);
        let sum = |x: &[f64; INTERVALS], factor: &dyn Fn(usize) -> f64| -> f64 {
            x.iter().enumerate().map(|(i, x)| x * factor(i)).sum()
        };
        Self {
            free: columns.map(|x| std::array::from_fn(|k| sum(&x, &|i| position(k, i) * length(k)))),
            gram: columns.map(|x| std::array::from_fn(|row| sum(&x, &|i| constraint(row, i)))),
        }
    }

    /// Returns z_1, from r (rad or m), u⁻, A and V.
    pub fn first_acceleration(&self, relative: &[f64; INTERVALS], velocity: f64, limits: [f64; 2]) -> f64 {
        let [acceleration, speed] = limits;
        let bound = |row: usize| {
            if row < INTERVALS { [-acceleration, acceleration] } else { [-speed - velocity, speed - velocity] }
        };
        let values = self.free.map(|row| row.iter().zip(relative).map(|(factor, r)| factor * r).sum());
        let values = self.solve(values, &std::array::from_fn(bound), [acceleration, speed]);
        values[0].clamp(-acceleration, acceleration)
    }

    /// Returns the values of the constraints at the solution, from those without constraints; `scales`: of the bounds.
    fn solve(&self, mut values: [f64; ROWS], bounds: &Bounds, scales: [f64; 2]) -> [f64; ROWS] {
        let (mut active, mut count) = ([Active::default(); INTERVALS], 0);
        let mut added: Option<Active> = None;
        for _ in 0..MAX_CHANGES {
            let Some(new) = added.or_else(|| most_violated(&values, bounds, scales)) else { break };
            let (ratios, slopes) = self.direction(&active[..count], &new);
            let curvature = new.side * slopes[new.row];
            let bound = bounds[new.row][usize::from(new.side > 0.0)];
            let full = if count < INTERVALS && curvature > DEPENDENT * self.gram[new.row][new.row] {
                new.side * (values[new.row] - bound) / curvature
            } else {
                f64::INFINITY
            };
            let blocking = (0..count).filter(|&i| ratios[i] > 0.0).map(|i| (i, active[i].multiplier / ratios[i]));
            let blocking = blocking.min_by(|a, b| a.1.total_cmp(&b.1));
            let length = blocking.map_or(full, |(_, length)| length.min(full));
            if length == f64::INFINITY {
                break;
            }
            if full < f64::INFINITY {
                values.iter_mut().zip(&slopes).for_each(|(value, slope)| *value -= length * slope);
            }
            active[..count].iter_mut().zip(&ratios).for_each(|(bound, ratio)| bound.multiplier -= length * ratio);
            let new = Active { multiplier: new.multiplier + length, ..new };
            match blocking {
                Some((dropped, step)) if step < full => {
                    active.copy_within(dropped + 1..count, dropped);
                    (count, added) = (count - 1, Some(new));
                }
                _ => {
                    active[count] = new;
                    (count, added) = (count + 1, None);
                }
            }
        }
        values
    }

    /// Returns, for a step of length 1 of the multiplier of a new bound, how the multipliers of the others and all values fall.
    fn direction(&self, active: &[Active], new: &Active) -> ([f64; INTERVALS], [f64; ROWS]) {
        let (count, mut matrix, mut ratios) = (active.len(), [0.0; INTERVALS * INTERVALS], [0.0; INTERVALS]);
        for (i, a) in active.iter().enumerate() {
            for (j, b) in active[..=i].iter().enumerate() {
                matrix[i * count + j] = a.side * b.side * self.gram[a.row][b.row];
            }
            ratios[i] = a.side * new.side * self.gram[a.row][new.row];
        }
        solve_cholesky(&mut matrix[..count * count], &mut ratios[..count]);
        let mut slopes = self.gram[new.row].map(|entry| new.side * entry);
        for (a, ratio) in active.iter().zip(ratios) {
            slopes.iter_mut().zip(&self.gram[a.row]).for_each(|(slope, entry)| *slope -= ratio * a.side * entry);
        }
        (ratios, slopes)
    }
}

/// Returns the bound that is violated most, relative to its scale, with the multiplier 0.
fn most_violated(values: &[f64; ROWS], bounds: &Bounds, [acceleration, speed]: [f64; 2]) -> Option<Active> {
    let mut worst = (TOLERANCE, None);
    for (row, (value, [lower, upper])) in values.iter().zip(bounds).enumerate() {
        let scale = if row < INTERVALS { acceleration } else { speed };
        for (side, excess) in [(1.0, value - upper), (-1.0, lower - value)] {
            if excess / scale > worst.0 {
                worst = (excess / scale, Some(Active { row, side, multiplier: 0.0 }));
            }
        }
    }
    worst.1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A joint that needs no more than it has follows exactly; one that needs more uses its limits.
    #[test]
    fn plans_use_what_the_joint_can_give() {
        let plan = Plan::new();
        let at = |acceleration: f64| std::array::from_fn(|k| 0.5 * acceleration * TIMES_AHEAD[k + 1].powi(2));
        for limits in [[5.0, 100.0], [5.0, 4.0]] {
            let found = plan.first_acceleration(&at(3.0), 0.0, limits);
            assert!((found - 3.0).abs() < 1e-3, "{found}");
            assert!((plan.first_acceleration(&at(30.0), 0.0, limits) - 5.0).abs() < 1e-9);
            assert!((plan.first_acceleration(&at(-30.0), 0.0, limits) + 5.0).abs() < 1e-9);
        }
        // At its speed limit it does not accelerate.
        assert!(plan.first_acceleration(&at(30.0), 2.0, [5.0, 2.0]).abs() < 1e-6);
    }

    /// Returns Σ_k h_k (r_k − (B z)_k)² of accelerations z.
    fn cost(z: &[f64], relative: &[f64; INTERVALS]) -> f64 {
        let (mut position, mut velocity, mut sum) = (0.0, 0.0, 0.0);
        for (k, (z, r)) in z.iter().zip(relative).enumerate() {
            let h = TIMES_AHEAD[k + 1] - TIMES_AHEAD[k];
            position += h * velocity + h * h / 2.0 * z;
            velocity += h * z;
            sum += h * (r - position).powi(2);
        }
        sum
    }

    /// On random problems the plan keeps all bounds, and no step from it towards another plan within the bounds leads nearer to the
    /// virtual joint.
    #[test]
    fn random_plans_keep_their_bounds_and_are_best() {
        const LIMITS: [f64; 2] = [5.0, 2.0];
        let plan = Plan::new();
        let mut seed = 1_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed) / f64::from(u32::MAX) * 2.0 - 1.0
        };
        for _ in 0..2000 {
            let velocity = 2.0 * random();
            let bounds: Bounds = std::array::from_fn(|row| {
                if row < INTERVALS { [-LIMITS[0], LIMITS[0]] } else { [-LIMITS[1] - velocity, LIMITS[1] - velocity] }
            });
            let mut planned = || {
                let relative: [f64; INTERVALS] = std::array::from_fn(|_| random());
                let values = plan.free.map(|row| row.iter().zip(&relative).map(|(f, r)| f * r).sum());
                (relative, plan.solve(values, &bounds, LIMITS))
            };
            let (relative, best) = planned();
            for (row, (value, [lower, upper])) in best.iter().zip(bounds).enumerate() {
                assert!(*value > lower - 1e-5 && *value < upper + 1e-5, "{row}: {value} outside {lower} to {upper}");
            }
            let (_, other) = planned();
            let towards =
                |share: f64| -> [f64; INTERVALS] { std::array::from_fn(|k| best[k] + share * (other[k] - best[k])) };
            for share in [1e-3, 0.1, 1.0] {
                let gain = cost(&best[..INTERVALS], &relative) - cost(&towards(share), &relative);
                assert!(gain < 1e-6 * share, "{share}: {gain}");
            }
        }
    }
}
