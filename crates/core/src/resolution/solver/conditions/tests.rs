//! The conditions on random working sets, compared with section 5 of `docs/solver.md` by dense matrices.
#![allow(non_snake_case)]

use super::*;
use crate::linalg::{Matrix, Svd, Vector};
use crate::resolution::Side;
use crate::resolution::hierarchy::Hierarchy;
use crate::resolution::solver::tests::{RandomSet, WIDTH, numbers};

/// What the conditions say, computed from the rows with pseudo-inverses.
struct Expected<'a> {
    of: &'a RandomSet,
    rounding: f64,
    projectors: Vec<Matrix>,
    /// The point on the working set without errors.
    exact: Vector,
    wrong: Vec<usize>,
    wrong_rows: Vec<usize>,
    multipliers: Vec<f64>,
    row_multipliers: Vec<f64>,
    residual: f64,
    undecided: Vec<usize>,
    undecided_rows: Vec<usize>,
}

impl<'a> Expected<'a> {
    fn new(of: &'a RandomSet, exact: Vector, rounding: f64) -> Self {
        let RandomSet { set, solved, .. } = of;
        let problem = of.problem();
        let mut expected = Self {
            of,
            rounding,
            projectors: of.projectors(),
            exact,
            wrong: Vec::new(),
            wrong_rows: Vec::new(),
            multipliers: vec![0.0; problem.unknowns],
            row_multipliers: vec![0.0; problem.rows.len()],
            residual: 0.0,
            undecided: solved.held.clone(),
            undecided_rows: problem.inequalities.iter().copied().filter(|&row| set.rows[row].is_some()).collect(),
        };
        expected.evaluate();
        expected
    }

    fn note(&mut self, size: f64, scale: f64) -> bool {
        self.residual = self.residual.max(size / scale);
        size > self.rounding * scale
    }

    /// Whether the sign of a bound that can give way is open.
    fn is_open(&self) -> bool {
        self.undecided.iter().any(|&j| !self.of.problem().is_pinned(j)) || !self.undecided_rows.is_empty()
    }

    fn evaluate(&mut self) {
        let (problem, RandomSet { set, solved, .. }) = (self.of.problem(), self.of);
        let (x, speed) = (&solved.x.0, solved.peak_speed);
        for &j in &solved.free {
            let outside = (x[j] - problem.upper.0[j]).max(problem.lower.0[j] - x[j]).max(0.0);
            if self.note(outside, speed) {
                self.wrong.push(j);
            }
        }
        let value = |row: usize| (0..problem.unknowns).map(|j| problem.coefficients[row][j] * x[j]).sum::<f64>();
        for row in (0..problem.rows.len()).filter(|&row| !problem.is_active(set, row)) {
            let missing = (value(row) - problem.rows[row].upper).max(problem.rows[row].lower - value(row)).max(0.0);
            if self.note(missing, self.of.matrix(&[row]).norm() * speed) {
                self.wrong_rows.push(row);
            }
        }
        for k in 0..problem.levels.len() {
            let targets = self.of.active(k).iter().map(|&row| problem.target(set, row).powi(2)).sum::<f64>().sqrt();
            let norm = self.norm(k);
            for row in &solved.rows[solved.spans[k].start..solved.spans[k].end] {
                let off = problem.target(set, row.index) - value(row.index) - row.residual;
                self.note(off.abs(), targets + norm * speed);
            }
            if solved.spans[k].has_residual {
                let base = Vector::from_column_slice(&solved.base.0[..problem.unknowns]);
                let seen = (&self.projectors[0] - &self.projectors[k + 1]) * (&self.exact - base);
                self.level(k, targets + norm * (solved.base_norm + seen.norm()));
            }
        }
        if self.is_open() || solved.rank() < solved.free.len() {
            self.level(problem.levels.len(), speed);
        }
    }

    fn norm(&self, level: usize) -> f64 {
        let level = self.of.problem().levels[level];
        self.of.matrix(&(level.start..level.end).collect::<Vec<_>>()).norm()
    }

    /// Returns w of all rows, h, and the size Σ |w_i| ‖A_level(i)‖, from the part of level k.
    fn multipliers_of(&self, k: usize, own: &[(usize, f64)]) -> (Vec<f64>, Vector, f64) {
        let (problem, solved) = (self.of.problem(), &self.of.solved);
        let n = problem.unknowns;
        let mut w = vec![0.0; problem.rows.len()];
        let (mut h, mut size) = (Vector::zeros(n), 0.0);
        if k == problem.levels.len() {
            h = Vector::from_fn(n, |j, _| problem.reference.0[j] - solved.x.0[j]);
            size = h.norm();
        } else {
            for &(row, entry) in own {
                w[row] = entry;
            }
            size += own.iter().map(|(_, entry)| entry * entry).sum::<f64>().sqrt() * self.norm(k);
        }
        let sum = |w: &[f64], rows: &[usize]| {
            self.of.matrix(rows).tr_mul(&Vector::from_iterator(rows.len(), rows.iter().map(|&row| w[row])))
        };
        // What the multipliers must balance has no errors in the point, which count as errors of stationarity.
        let mut balanced = if k == problem.levels.len() {
            Vector::from_fn(n, |j, _| problem.reference.0[j]) - &self.exact
        } else {
            sum(&w, &self.of.active(k))
        };
        if k < problem.levels.len() {
            h = balanced.clone();
        }
        for level in (0..k).rev() {
            let rows = self.of.active(level);
            let A = self.of.matrix(&rows);
            let svd = Svd::new(&(&A * &self.projectors[level]));
            let shortest = -svd.inverse(svd.rank(1e-9 * A.norm()), 0.0).tr_mul(&balanced);
            rows.iter().zip(&shortest).for_each(|(&row, &entry)| w[row] = entry);
            balanced += A.tr_mul(&shortest);
            h += A.tr_mul(&shortest);
            size += shortest.lp_norm(1) * self.norm(level);
        }
        (w, h, size)
    }

    /// Returns h of each dependent row of level k alone, with the multipliers of the rows.
    fn dependent_parts(&self, k: usize) -> Vec<(Vec<f64>, Vector)> {
        let (pivots, dependents) = self.of.solved.level(k);
        let places: Vec<usize> = pivots.iter().map(|row| row.index).collect();
        let part = |dependent: usize| {
            let N = &self.projectors[k];
            let pivot_rows = self.of.matrix(&places) * N;
            let svd = Svd::new(&pivot_rows);
            let w = -svd.inverse(places.len(), 0.0).tr_mul(&(self.of.matrix(&[dependent]) * N).transpose());
            let own = places.iter().zip(w.as_slice()).map(|(&row, &entry)| (row, entry));
            let (w, h, _) = self.multipliers_of(k, &own.chain([(dependent, 1.0)]).collect::<Vec<_>>());
            (w, h)
        };
        dependents.iter().map(|row| part(row.index)).collect()
    }

    fn level(&mut self, k: usize, size: f64) {
        let (problem, RandomSet { set, solved, .. }) = (self.of.problem(), self.of);
        let own: Vec<(usize, f64)> = match solved.spans.get(k) {
            Some(span) => solved.rows[span.start..span.end].iter().map(|row| (row.index, row.residual)).collect(),
            None => Vec::new(),
        };
        let (w, h, amount) = self.multipliers_of(k, &own);
        let last = k == problem.levels.len();
        let (length, norm) = if last {
            (Vector::from_fn(problem.unknowns, |j, _| problem.reference.0[j] - solved.x.0[j]).norm(), 1.0)
        } else {
            (own.iter().map(|(_, entry)| entry * entry).sum::<f64>().sqrt(), self.norm(k))
        };
        let force = |w: f64, row: usize| w.abs() * self.of.matrix(&[row]).norm();
        let (mut sizes, mut row_sizes) = (vec![amount; problem.unknowns], vec![amount; problem.rows.len()]);
        let dependents = if last { 0 } else { solved.level(k).1.len() };
        if self.is_open() && dependents != 1 {
            let coarse = amount * (1.0 + size / length);
            let is_doubtful = |value: f64| value > self.rounding * amount && value <= self.rounding * coarse;
            let open = self.undecided.iter().map(|&j| h[j].abs());
            if dependents > 0 && open.chain(self.undecided_rows.iter().map(|&row| force(w[row], row))).any(is_doubtful)
            {
                for (w, e) in self.dependent_parts(k) {
                    sizes.iter_mut().zip(&e).for_each(|(sum, e)| *sum += size * e.abs());
                    row_sizes.iter_mut().enumerate().for_each(|(row, sum)| *sum += size * force(w[row], row));
                }
            } else {
                sizes.fill(coarse);
                row_sizes.fill(coarse);
            }
        }
        for j in self.undecided.clone() {
            let side = set.unknowns[j].map_or(0.0, Side::sign);
            let points_inwards = side * h[j] < 0.0 && !problem.is_pinned(j);
            if points_inwards {
                self.note(h[j].abs(), sizes[j]);
            }
            if h[j].abs() > self.rounding * sizes[j] {
                self.undecided.retain(|&other| other != j);
                self.multipliers[j] = h[j];
                self.wrong.extend(points_inwards.then_some(j));
            }
        }
        for row in self.undecided_rows.clone() {
            let points_inwards = set.rows[row].map_or(0.0, Side::sign) * -w[row] < 0.0;
            let force = w[row].abs() * self.of.matrix(&[row]).norm();
            if points_inwards {
                self.note(force, row_sizes[row]);
            }
            if force > self.rounding * row_sizes[row] {
                self.undecided_rows.retain(|&other| other != row);
                self.row_multipliers[row] = -w[row];
                self.wrong_rows.extend(points_inwards.then_some(row));
            }
        }
        let stationarity = solved.free.iter().map(|&j| h[j].abs()).fold(0.0, f64::max);
        self.note(stationarity, amount.max(size * norm));
    }
}

fn evaluate(of: &RandomSet, rounding: f64) -> Conditions<WIDTH> {
    let mut conditions = Conditions::default();
    let (problem, RandomSet { set, solved, .. }) = (of.problem(), of);
    let trial = Trial { problem: &problem, set, solved };
    conditions.check_point(trial, rounding);
    conditions.check_levels(trial);
    conditions
}

fn assert_near(found: &[f64], expected: &[f64], context: &str) {
    let size = expected.iter().fold(1.0_f64, |size, entry| size.max(entry.abs()));
    let near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-8 * size);
    assert!(near && found.len() == expected.len(), "{context}: {found:?} {expected:?}");
}

/// Errors of the point and of the residuals are put in, so that the certificate is a number above rounding.
#[test]
fn the_conditions_are_those_of_the_documentation() {
    let (mut wrong, mut wrong_rows, mut decided, mut last_level) = (0, 0, 0, 0);
    for seed in 0..600 {
        let mut of = RandomSet::new(seed);
        let exact = Vector::from_column_slice(&of.solved.x.0[..of.problem().unknowns]);
        let mut number = numbers(seed + 2_000_000);
        let error = [0.0, 1e-3, 0.3][usize::try_from(seed % 3).unwrap()];
        for &j in &of.solved.free {
            of.solved.x.0[j] += error * number();
        }
        for row in of.solved.rows.iter_mut().filter(|row| row.residual != 0.0) {
            row.residual *= 1.0 + error * number();
        }
        for rounding in [1e-13, 1e-3, 0.05] {
            let expected = Expected::new(&of, exact.clone(), rounding);
            let found = evaluate(&of, rounding);
            let context = format!("seed {seed}, rounding {rounding:e}");
            let sorted = |list: &[usize]| {
                let mut list = list.to_vec();
                list.sort_unstable();
                list
            };
            assert_eq!(sorted(&found.wrong), sorted(&expected.wrong), "wrong unknowns, {context}");
            assert_eq!(sorted(&found.wrong_rows), sorted(&expected.wrong_rows), "wrong rows, {context}");
            assert_eq!(found.are_met(), expected.wrong.is_empty() && expected.wrong_rows.is_empty());
            assert_near(&found.multipliers.0[..exact.len()], &expected.multipliers, &context);
            assert_near(&found.row_multipliers, &expected.row_multipliers, &context);
            let difference = (found.residual - expected.residual).abs();
            assert!(
                difference <= 1e-7 * expected.residual + 1e-13,
                "{context}: {} {}",
                found.residual,
                expected.residual
            );
            wrong += expected.wrong.len();
            wrong_rows += expected.wrong_rows.len();
            decided += expected.row_multipliers.iter().filter(|entry| **entry != 0.0).count();
            last_level += usize::from(expected.residual > 1e-9);
        }
    }
    assert!(wrong > 300 && wrong_rows > 150 && decided > 150 && last_level > 300, "{wrong} {wrong_rows} {decided}");
}

/// Returns a problem of one level with the rows a·x = b, whose first unknown is pinned at a finite `upper`.
fn of_rows(rows: &[([f64; 2], f64)], upper: f64) -> RandomSet {
    let mut hierarchy = Hierarchy::default();
    hierarchy.clear(&[0.0; 2]);
    hierarchy.set_width(WIDTH);
    for (row, target) in rows {
        hierarchy.push_equation(row.iter().copied(), *target);
    }
    hierarchy.end_level();
    if upper.is_finite() {
        (hierarchy.lower[0], hierarchy.upper[0]) = (upper, upper);
    }
    let mut set = WorkingSet::default();
    set.clear(2, rows.len());
    RandomSet::of(hierarchy, set)
}

#[test]
fn nothing_is_certified_where_sizes_overflow() {
    let residual = |row: [f64; 2], target: f64, upper: f64| evaluate(&of_rows(&[(row, target)], upper), 1e-13).residual;
    assert!(residual([1.0, 0.0], 1.0, f64::INFINITY) < 1e-15);
    assert_eq!(residual([1e200, 0.0], 1.0, f64::INFINITY), f64::INFINITY, "‖A‖²");
    assert_eq!(residual([1.0, 0.0], 1e200, f64::INFINITY), f64::INFINITY, "‖b‖");
    assert_eq!(residual([0.0, 1.0], 1.0, 1e200), f64::INFINITY, "the speed");
    assert_eq!(residual([0.0, 0.0], 0.0, f64::INFINITY), 0.0);
}

/// Four equal rows, whose residuals all have the same error δ: Aᵀr is off by 4 · 16 δ, relative to ‖A‖ (‖b‖ + ‖A‖ ‖x‖).
#[test]
fn an_error_that_all_rows_share_is_one_of_stationarity() {
    let mut of = of_rows(&[1.0, 2.0, 3.0, 4.0].map(|target| ([16.0, 0.0], 16.0 * target)), f64::INFINITY);
    of.solved.rows.iter_mut().for_each(|row| row.residual += 1e-3);
    let size = 32.0 * (16.0 * 30.0_f64.sqrt() + 32.0 * 2.5);
    assert!((evaluate(&of, 1e-13).residual - 64e-3 / size).abs() < 1e-12);
}
