//! Whether linear inequalities can be kept together, by a method that shares nothing with the solver.

use revprio_core::linalg::{Matrix, Vector};

use crate::hierarchy::length;

/// A demand a·x ≤ bound.
#[derive(Debug, Clone)]
pub struct Demand {
    pub coefficients: Vec<f64>,
    pub bound: f64,
}

/// Residuals up to this are rounding. The columns have length one.
const ROUNDING: f64 = 1e-9;

/// Returns whether one point keeps all demands. Both answers come with a proof, which is checked.
///
/// By Farkas, either some x has A x ≤ b, or some y ≥ 0 has Aᵀy = 0 and b·y = −1. The point nearest to (0, −1) among all
/// (Aᵀy, b·y) with y ≥ 0 tells which: it is (0, −1) itself, or the difference r = (0, −1) − (Aᵀy, b·y) gives x as the
/// ratio of its parts.
pub fn is_feasible(demands: &[Demand]) -> bool {
    let Some(first) = demands.first() else { return true };
    let n = first.coefficients.len();
    let entry = |i: usize, j: usize| if i < n { demands[j].coefficients[i] } else { demands[j].bound };
    let mut G = Matrix::from_fn(n + 1, demands.len(), entry);
    // A positive factor changes no demand. A demand 0·x ≤ 0 stays zero.
    G.column_iter_mut().for_each(|mut column| column /= column.norm().max(f64::MIN_POSITIVE));
    let target = Vector::from_fn(n + 1, |i, _| if i < n { 0.0 } else { -1.0 });
    let y = nearest(&G, &target);
    let r = target - &G * &y;
    if r.norm() <= ROUNDING * y.norm().max(1.0) {
        assert!(y.norm() < 1e6, "the demands contradict each other by rounding only: {demands:?}");
        return false;
    }
    let x: Vec<f64> = r.iter().take(n).map(|entry| entry / -r[n]).collect();
    let excess = demands.iter().map(|demand| demand.excess(&x)).fold(0.0, f64::max);
    assert!(excess <= 1e-6, "undecided: {x:?} exceeds {demands:?} by {excess:e}");
    true
}

impl Demand {
    /// Returns a·x ≥ bound.
    pub fn at_least(coefficients: &[f64], bound: f64) -> Self {
        Self { coefficients: coefficients.iter().map(|a| -a).collect(), bound: -bound }
    }

    pub fn at_most(coefficients: &[f64], bound: f64) -> Self {
        Self { coefficients: coefficients.to_vec(), bound }
    }

    /// Returns by how much the point breaks the demand, relative to the numbers that it compares and to a speed of one.
    fn excess(&self, x: &[f64]) -> f64 {
        let value: f64 = self.coefficients.iter().zip(x).map(|(a, x)| a * x).sum();
        let size = self.bound.abs() + length(&self.coefficients) * (length(x) + 1.0);
        if value > self.bound { (value - self.bound) / size } else { 0.0 }
    }
}

/// Returns the y ≥ 0 with the smallest ‖G y − target‖ (Lawson and Hanson, "Solving least squares problems", chapter
/// 23).
fn nearest(G: &Matrix, target: &Vector) -> Vector {
    let mut y = Vector::zeros(G.ncols());
    let mut positive: Vec<usize> = Vec::new();
    for _ in 0..100 * (G.ncols() + 1) {
        let slope = G.transpose() * (target - G * &y);
        let Some(entering) = entering(G, target, &slope, &positive) else { return y };
        positive.push(entering);
        loop {
            let goal = least_squares(&G.select_columns(&positive), target).expect("the columns are independent");
            if goal.iter().all(|goal| *goal > 0.0) {
                y.fill(0.0);
                positive.iter().zip(&goal).for_each(|(&j, goal)| y[j] = *goal);
                break;
            }
            // Go to the first entry that vanishes, and leave it out.
            let steps = positive.iter().zip(&goal).filter(|(_, goal)| **goal <= 0.0);
            let step = steps.map(|(&j, goal)| y[j] / (y[j] - goal)).fold(1.0, f64::min);
            for (&j, goal) in positive.iter().zip(&goal) {
                y[j] += step * (goal - y[j]);
            }
            positive.retain(|&j| y[j] > 1e-13);
            (0..G.ncols()).filter(|j| !positive.contains(j)).for_each(|j| y[j] = 0.0);
        }
    }
    panic!("the search for a proof does not end: {G} {target}");
}

/// Returns the steepest entry that would be positive with those that are.
fn entering(G: &Matrix, target: &Vector, slope: &Vector, positive: &[usize]) -> Option<usize> {
    let mut candidates: Vec<usize> = (0..G.ncols()).filter(|j| slope[*j] > 1e-12 && !positive.contains(j)).collect();
    candidates.sort_by(|&i, &j| slope[j].total_cmp(&slope[i]));
    candidates.into_iter().find(|&j| {
        let columns = G.select_columns(&[positive, &[j]].concat());
        columns.nrows() >= columns.ncols()
            && least_squares(&columns, target).is_some_and(|goal| goal[positive.len()] > 1e-13)
    })
}

/// Returns the least-squares solution, unless a column depends on those before it.
fn least_squares(columns: &Matrix, target: &Vector) -> Option<Vector> {
    let qr = columns.clone().qr();
    let independent = qr.r().diagonal().iter().all(|pivot| pivot.abs() > 1e-11);
    independent.then(|| qr.r().solve_upper_triangular(&(qr.q().transpose() * target)))?
}

#[test]
fn feasible_and_contradicting_demands_are_told_apart() {
    let above = |coefficients: [f64; 2], bound| Demand::at_least(&coefficients, bound);
    let below = |coefficients: [f64; 2], bound| Demand::at_most(&coefficients, bound);
    assert!(is_feasible(&[]));
    assert!(is_feasible(&[above([1.0, 0.0], 1.0), below([1.0, 0.0], 1.0)]));
    assert!(!is_feasible(&[above([1.0, 0.0], 1.001), below([1.0, 0.0], 1.0)]));
    let triangle = [above([1.0, 0.0], 1.0), above([0.0, 1.0], 1.0), below([1.0, 1.0], 1.9)];
    assert!(!is_feasible(&triangle));
    for left_out in 0..3 {
        let rest: Vec<Demand> = (0..3).filter(|&i| i != left_out).map(|i| triangle[i].clone()).collect();
        assert!(is_feasible(&rest));
    }
    assert!(!is_feasible(&[above([0.0, 0.0], 1.0)]) && is_feasible(&[below([0.0, 0.0], 1.0)]));
}
