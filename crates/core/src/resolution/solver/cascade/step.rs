//! The Newton step of a level, and how far it goes.

use super::{Cascade, Constraint, Role};
use crate::linalg::{Row, dot};
use crate::resolution::Side;
use crate::resolution::solution::refill;
use crate::resolution::solver::problem_rows::ProblemRows;
use crate::tolerances::TOLERANCES;

impl<const N: usize> Cascade<N> {
    /// Returns the step to the optimum of the present second derivatives.
    pub(super) fn newton_step(&mut self) -> Row<N> {
        let d = self.free.len();
        let largest = (0..d).map(|i| self.curvature[i].0[i]).fold(0.0, f64::max);
        refill(&mut self.factor, std::iter::repeat_n(Row::ZERO, d));
        let mut z = Row::<N>::ZERO;
        for (i, direction) in self.free.iter().enumerate() {
            z.0[i] = -direction.dot(&self.gradient);
        }
        // Cholesky's factorisation row by row: L Lᵀ, with rows of zeros where there is no curvature.
        for (i, curvature) in self.curvature.iter().enumerate() {
            let (before, rest) = self.factor.split_at_mut(i);
            let row = &mut rest[0].0;
            for (j, other) in before.iter().enumerate() {
                row[j] = (curvature.0[j] - dot(&row[..j], &other.0[..j])) * other.0[j];
            }
            let head = &row[..i];
            let pivot = curvature.0[i] - dot(head, head);
            // The reciprocal pivot stands on the diagonal.
            let inverse = if pivot > TOLERANCES.cascade_flat * largest { 1.0 / pivot.sqrt() } else { 0.0 };
            z.0[i] = (z.0[i] - dot(head, &z.0[..i])) * inverse;
            row[i] = inverse;
        }
        for i in (0..d).rev() {
            z.0[i] *= self.factor[i].0[i];
            for j in 0..i {
                z.0[j] -= self.factor[i].0[j] * z.0[i];
            }
        }
        let mut step = Row::ZERO;
        self.free.iter().zip(&z.0).for_each(|(direction, z)| step.add_scaled(*z, direction));
        step
    }

    /// Returns how far the step goes until it meets a bound (infinite without one), and that bound.
    pub(super) fn first_bound(&self, problem: &ProblemRows<N>, step: &Row<N>) -> (f64, Option<(usize, Side)>) {
        let n = problem.unknowns;
        let (mut most, mut first, mut steepest) = (f64::INFINITY, None, 0.0);
        let tiny = TOLERANCES.cascade_dependent * step.norm();
        let speed = self.x.norm() + step.norm();
        for (at, constraint) in self.constraints.iter().enumerate().filter(|(_, it)| it.role == Role::Kept) {
            let Constraint { value, slope, lower, upper, .. } = *constraint;
            let norm = if at < n { 1.0 } else { problem.rows[at - n].square.sqrt() };
            if slope.abs() <= tiny * norm {
                continue;
            }
            let (side, bound) = if slope > 0.0 { (Side::Upper, upper) } else { (Side::Lower, lower) };
            let length = ((bound - value) / slope).max(0.0);
            let near = TOLERANCES.cascade_at_once * speed * norm / slope.abs();
            if !(length <= most + near) || self.is_held(at) {
                continue;
            }
            // Among bounds that are met at once, the one that is met most steeply.
            let is_first = length < most - near;
            let steepness = slope.abs() / norm;
            if is_first || first.is_none() || (self.idle <= 2 * n && steepness > steepest) {
                (most, first, steepest) =
                    (if first.is_none() { length } else { length.min(most) }, Some((at, side)), steepness);
            }
        }
        (most, first)
    }

    pub(super) fn is_held(&self, constraint: usize) -> bool {
        self.held.iter().any(|held| held.constraint == constraint)
    }

    /// Returns how far along the step, at most `most`, the slack is least.
    pub(super) fn least_slack(&mut self, problem: &ProblemRows<N>, level: usize, step: &Row<N>, most: f64) -> f64 {
        let Some(size) = problem.levels.get(level) else { return most.min(1.0) };
        let (mut slope, mut curvature) = (self.gradient.dot(step), 0.0);
        self.kinks.clear();
        for &Constraint { value, slope: rate, role, lower, upper } in &self.constraints[problem.unknowns..][size.rows()]
        {
            let square = rate * rate;
            match role {
                Role::Equation => curvature += square,
                Role::Slack(side) => {
                    curvature += if side.is_some() { square } else { 0.0 };
                    if rate == 0.0 {
                        continue;
                    }
                    let (leaves, enters) = if rate > 0.0 { (lower, upper) } else { (upper, lower) };
                    let place = |bound: f64| (bound - value) / rate;
                    let (leaves, enters) = (place(leaves), place(enters));
                    if leaves > 0.0 && leaves < most {
                        self.kinks.push((leaves, -square));
                    }
                    // A row at its bound is broken at once.
                    if enters >= 0.0 && enters < most {
                        self.kinks.push((enters, square));
                    }
                }
                _ => {}
            }
        }
        self.kinks.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut at = 0.0;
        for &(place, change) in &self.kinks {
            let there = slope + curvature * (place - at);
            if there >= 0.0 {
                break;
            }
            (at, slope) = (place, there);
            curvature = (curvature + change).max(0.0);
        }
        let length = if curvature > 0.0 { at - slope / curvature } else { f64::INFINITY };
        // Without a bound a step ends at the optimum; rounding must not lengthen it without end.
        if length.is_finite() {
            length.min(most)
        } else if most.is_finite() {
            most
        } else {
            1.0
        }
    }
}
