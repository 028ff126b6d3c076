//! Directions that are fixed, held at bounds, or free, and the second derivatives of a level over the free ones.

use super::{Cascade, Held, Role, is_active, unit};
use crate::linalg::Row;
use crate::resolution::Side;
use crate::resolution::solution::refill;
use crate::resolution::solver::problem_rows::ProblemRows;
use crate::tolerances::TOLERANCES;

impl<const N: usize> Cascade<N> {
    /// Holds a bound: its normal is no free direction any more.
    pub(super) fn hold(&mut self, problem: &ProblemRows<N>, constraint: usize, side: Side) {
        let normal = normal(problem, constraint);
        let Some(direction) = self.take_direction(&normal, true) else { return };
        let held = self.placed(constraint, side, normal, direction);
        self.held.push(held);
    }

    /// Returns a bound behind those that are held; `direction`: what its normal has and they have not.
    pub(super) fn placed(&self, constraint: usize, side: Side, normal: Row<N>, direction: Row<N>) -> Held<N> {
        let mut coordinates = Row::ZERO;
        for (i, other) in self.held.iter().enumerate() {
            coordinates.0[i] = other.direction.dot(&normal);
        }
        coordinates.0[self.held.len()] = direction.dot(&normal);
        Held { constraint, side, normal, direction, coordinates }
    }

    /// Removes the direction along a vector from the free ones; `None` if it is not free. `curved`: the curvature follows.
    pub(super) fn take_direction(&mut self, vector: &Row<N>, curved: bool) -> Option<Row<N>> {
        let d = self.free.len();
        let mut v = Row::<N>::ZERO;
        for (i, direction) in self.free.iter().enumerate() {
            v.0[i] = direction.dot(vector);
        }
        let length = v.norm();
        if d == 0 || !(length > TOLERANCES.cascade_dependent * vector.norm()) {
            return None;
        }
        // The reflection I − g v vᵀ that leaves of v its last entry alone.
        let last = v.0[d - 1];
        let gain = 1.0 / (length * (length + last.abs()));
        v.0[d - 1] += length.copysign(last);
        let mut sum = Row::<N>::ZERO;
        self.free.iter().zip(&v.0).for_each(|(direction, v)| sum.add_scaled(*v, direction));
        for (direction, v) in self.free.iter_mut().zip(&v.0) {
            direction.add_scaled(-gain * v, &sum);
        }
        if curved {
            // H ← (I − g v vᵀ) H (I − g v vᵀ) = H − v wᵀ − w vᵀ, w = p − (g/2)(pᵀv) v, p = g H v.
            let mut w = Row::<N>::ZERO;
            for (i, row) in self.curvature.iter().enumerate() {
                w.0[i] = gain * row.dot(&v);
            }
            let half = 0.5 * gain * w.dot(&v);
            w.add_scaled(-half, &v);
            for (i, row) in self.curvature.iter_mut().enumerate() {
                row.add_scaled(-v.0[i], &w);
                row.add_scaled(-w.0[i], &v);
            }
            self.curvature.pop();
            for row in &mut self.curvature {
                row.0[d - 1] = 0.0;
            }
        }
        self.free.pop()
    }

    /// Releases the bound whose multiplier points inwards most; returns whether there is one. The direction becomes the last
    /// free one.
    pub(super) fn release(&mut self, zero: f64) -> bool {
        let multipliers = self.multipliers();
        let inwards = |(at, held): (usize, &Held<N>)| {
            let force = -held.side.sign() * multipliers.0[at] * held.normal.norm();
            (force > zero).then_some((at, force))
        };
        let mut wrong = self.held.iter().enumerate().filter_map(inwards);
        let found = if self.idle > 2 * self.free.len() + 10 {
            wrong.min_by_key(|(at, _)| self.held[*at].constraint)
        } else {
            wrong.by_ref().max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let Some((at, _)) = found else { return false };
        let released = self.held[at];
        let mut later = std::mem::take(&mut self.later);
        refill(&mut later, self.held.drain(at..).skip(1));
        for held in &later {
            self.hold_again(held);
        }
        self.later = later;
        let mut direction = released.normal;
        self.remove_known(&mut direction);
        self.free.push(direction.scaled(1.0 / direction.norm()));
        true
    }

    /// Places a held bound behind those that are held.
    pub(super) fn hold_again(&mut self, held: &Held<N>) {
        let mut direction = held.normal;
        self.remove_known(&mut direction);
        let length = direction.norm();
        if length > TOLERANCES.cascade_dependent * held.normal.norm() {
            let again = self.placed(held.constraint, held.side, held.normal, direction.scaled(1.0 / length));
            self.held.push(again);
        }
    }

    /// Removes the parts along fixed and held directions, twice for the sake of rounding.
    pub(super) fn remove_known(&self, vector: &mut Row<N>) {
        for _ in 0..2 {
            let known = self.fixed.iter().chain(self.held.iter().map(|held| &held.direction));
            for direction in known {
                vector.add_scaled(-direction.dot(vector), direction);
            }
        }
    }

    /// Returns the multipliers of the held bounds: gradient + Σ μ c has no part along their directions.
    pub(super) fn multipliers(&self) -> Row<N> {
        let mut multipliers = Row::<N>::ZERO;
        for (i, held) in self.held.iter().enumerate().rev() {
            let later: f64 = self
                .held
                .iter()
                .enumerate()
                .skip(i + 1)
                .map(|(j, other)| other.coordinates.0[i] * multipliers.0[j])
                .sum();
            multipliers.0[i] = (-held.direction.dot(&self.gradient) - later) / held.coordinates.0[i];
        }
        multipliers
    }

    /// Adds the curvature along the last free direction.
    pub(super) fn extend_curvature(&mut self, problem: &ProblemRows<N>, level: usize) {
        let Some(direction) = self.free.last().copied() else { return };
        let mut product = Row::<N>::ZERO;
        match problem.levels.get(level) {
            None => product = direction,
            Some(size) => {
                for i in (size.start..size.end).filter(|&i| is_active(self.constraints[problem.unknowns + i].role)) {
                    let row = &problem.coefficients[i];
                    product.add_scaled(direction.dot(row), row);
                }
            }
        }
        let d = self.free.len();
        let mut last = Row::<N>::ZERO;
        for (i, direction) in self.free.iter().enumerate() {
            last.0[i] = direction.dot(&product);
        }
        for (row, entry) in self.curvature.iter_mut().zip(&last.0) {
            row.0[d - 1] = *entry;
        }
        self.curvature.push(last);
    }

    /// Adds a row to the curvature, or takes it away.
    pub(super) fn add_curvature(&mut self, row: &[f64; N], sign: f64) {
        let mut along = Row::<N>::ZERO;
        for (i, direction) in self.free.iter().enumerate() {
            along.0[i] = direction.dot(row);
        }
        for (i, entries) in self.curvature.iter_mut().enumerate() {
            entries.add_scaled(sign * along.0[i], &along);
        }
    }

    /// Holds a bound for good.
    pub(super) fn fix_bound(&mut self, bound: &Held<N>) {
        let mut direction = bound.normal;
        self.remove_known(&mut direction);
        let length = direction.norm();
        if length > TOLERANCES.cascade_dependent * bound.normal.norm() {
            self.fixed.push(direction.scaled(1.0 / length));
        }
        self.constraints[bound.constraint].role = Role::Fixed(Some(bound.side));
    }

    /// Adds the candidates to the fixed directions, the longest remaining one first, and takes them from the free ones.
    pub(super) fn fix_candidates(&mut self, norm: f64) {
        let mut rows = std::mem::take(&mut self.candidates);
        for row in &mut rows {
            for direction in &self.fixed {
                row.add_scaled(-direction.dot(row), direction);
            }
        }
        while let Some((longest, square)) =
            rows.iter().map(|row| row.dot(row)).enumerate().max_by(|a, b| a.1.total_cmp(&b.1))
        {
            if !(square > (TOLERANCES.cascade_dependent * norm).powi(2)) {
                break;
            }
            let mut direction = rows.swap_remove(longest);
            for _ in 0..2 {
                for known in &self.fixed {
                    direction.add_scaled(-known.dot(&direction), known);
                }
            }
            let length = direction.norm();
            if !(length > TOLERANCES.cascade_dependent * norm) {
                continue;
            }
            direction = direction.scaled(1.0 / length);
            self.take_direction(&direction, false);
            for row in &mut rows {
                row.add_scaled(-direction.dot(row), &direction);
            }
            self.fixed.push(direction);
        }
        rows.clear();
        self.candidates = rows;
    }
}

/// Returns the gradient of a constraint: unknowns, then rows.
fn normal<const N: usize>(problem: &ProblemRows<N>, constraint: usize) -> Row<N> {
    match constraint.checked_sub(problem.unknowns) {
        None => unit(constraint),
        Some(row) => Row(problem.coefficients[row]),
    }
}
