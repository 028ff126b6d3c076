//! One damped step of the virtual arm towards the targets of all tasks, by their priority.
//!
//! Task k moves in the null space of the tasks above it (projector N):
//!
//! dq ← dq + N J_kᵀ (J_k N J_kᵀ + λ² I)⁻¹ (e_k − J_k dq), λ² = λ_0² + c |e|².
//!
//! The damping follows the error (Levenberg-Marquardt): far from the target the step stays short where the Jacobian is nearly
//! singular, and near the target the convergence is quadratic. A target out of reach has a point of rest.

use std::ops::Range;

use crate::linalg::{Matrix, dot};

/// λ_0².
const LEAST_DAMPING: f64 = 1e-6;

/// c.
const DAMPING_PER_ERROR: f64 = 0.03;

/// Largest change of a joint in one step, rad or m: further away the linearisation means nothing.
const MAX_STEP: f64 = 0.6;

/// How often joints at their limits are taken out and the step is computed again.
const MAX_PASSES: usize = 3;

/// A row counts as dependent on the rows above it if less than this share of it is new.
const DEPENDENT: f64 = 1e-4;

/// A motion in the null space of all tasks.
pub(super) struct NullSpaceStep<'a> {
    /// The motion before it is projected, n, rad or m.
    pub motion: &'a [f64],
    /// Returns the factor of the projected motion from the length of what is new in the row that depends most on those before it.
    pub factor: &'a dyn Fn(f64) -> f64,
}

/// The storage of one step over n joints, which count in units of their scales S: q = S y. Tasks so move fast joints more than slow
/// ones.
#[derive(Debug)]
pub(super) struct Newton {
    n: usize,
    /// The rows of each task.
    tasks: Vec<Range<usize>>,
    /// The weighed Jacobians of all tasks, row by row, n entries each.
    rows: Vec<f64>,
    /// e, one entry per row.
    error: Vec<f64>,
    /// The rows in the null space of the tasks above, without the joints that are held.
    projected: Vec<f64>,
    /// An orthonormal basis of the rows so far, n entries each.
    basis: Vec<f64>,
    rank: usize,
    smallest: f64,
    /// The Gram matrix of a task, then its Cholesky factor, row by row.
    gram: Vec<f64>,
    /// What is left of e, then the solution.
    residual: Vec<f64>,
    /// The step of the scaled joints, n.
    step: Vec<f64>,
    /// The step of the joints, n, rad or m.
    result: Vec<f64>,
    held: Vec<bool>,
    /// S, the scale of each joint, n.
    scales: Vec<f64>,
    scratch: Vec<f64>,
}

impl Newton {
    /// Allocates the storage for tasks of these numbers of rows over n joints.
    pub fn new(heights: &[usize], scales: Vec<f64>) -> Self {
        let n = scales.len();
        let mut start = 0;
        let mut range = |height: &usize| {
            start += height;
            start - height..start
        };
        let tasks: Vec<_> = heights.iter().map(&mut range).collect();
        let (total, most) = (start, heights.iter().copied().max().unwrap_or(0));
        Self {
            n,
            tasks,
            rows: vec![0.0; total * n],
            error: vec![0.0; total],
            projected: vec![0.0; total * n],
            basis: vec![0.0; n * n],
            rank: 0,
            smallest: f64::INFINITY,
            gram: vec![0.0; most * most],
            residual: vec![0.0; total],
            step: vec![0.0; n],
            result: vec![0.0; n],
            scales,
            held: vec![false; n],
            scratch: vec![0.0; n],
        }
    }

    /// Sets the weighed Jacobian of a task (m × n) and e, its weighed distance to the target (m).
    pub fn set(&mut self, task: usize, jacobian: &Matrix, error: impl Fn(usize) -> f64) {
        let range = self.tasks[task].clone();
        for (i, row) in range.enumerate() {
            self.error[row] = error(i);
            for (j, entry) in self.rows[row * self.n..(row + 1) * self.n].iter_mut().enumerate() {
                *entry = jacobian[(i, j)] * self.scales[j];
            }
        }
    }

    /// Returns |e|, the distance from the targets.
    pub fn error(&self) -> f64 {
        dot(&self.error, &self.error).sqrt()
    }

    /// Returns the step from a posture q (n) that stays in the ranges of the joints (n).
    pub fn step(&mut self, q: &[f64], ranges: &[[f64; 2]], null_space: Option<&NullSpaceStep>) -> &[f64] {
        let damping = LEAST_DAMPING + DAMPING_PER_ERROR * dot(&self.error, &self.error);
        self.held.fill(false);
        self.step.fill(0.0);
        for _ in 0..MAX_PASSES {
            self.descend(damping, null_space);
            if !self.hold(q, ranges) {
                break;
            }
        }
        for (result, (entry, scale)) in self.result.iter_mut().zip(self.step.iter().zip(&self.scales)) {
            *result = entry * scale;
        }
        let largest = self.result.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
        if largest > MAX_STEP {
            self.result.iter_mut().for_each(|entry| *entry *= MAX_STEP / largest);
        }
        &self.result
    }

    /// Holds the joints that would leave their ranges at their ends; returns whether there are any.
    fn hold(&mut self, q: &[f64], ranges: &[[f64; 2]]) -> bool {
        let mut holds = false;
        for (j, [lower, upper]) in ranges.iter().enumerate() {
            let end = q[j] + self.step[j] * self.scales[j];
            if !self.held[j] && !(*lower..=*upper).contains(&end) {
                self.step[j] = (end.clamp(*lower, *upper) - q[j]) / self.scales[j];
                (self.held[j], holds) = (true, true);
            }
        }
        holds
    }

    /// Computes the step of the joints that are not held.
    fn descend(&mut self, damping: f64, null_space: Option<&NullSpaceStep>) {
        for (entry, held) in self.step.iter_mut().zip(&self.held) {
            if !held {
                *entry = 0.0;
            }
        }
        (self.rank, self.smallest) = (0, f64::INFINITY);
        for task in 0..self.tasks.len() {
            self.descend_task(self.tasks[task].clone(), damping);
        }
        if let Some(NullSpaceStep { motion, factor }) = null_space {
            let Self { n, basis, rank, step, held, scratch, scales, .. } = self;
            for (entry, (motion, scale)) in scratch.iter_mut().zip(motion.iter().zip(&*scales)) {
                *entry = motion / scale;
            }
            zero_held(scratch, held);
            remove(basis, *rank, *n, scratch);
            let factor = factor(self.smallest);
            step.iter_mut().zip(&*scratch).for_each(|(step, entry)| *step += factor * entry);
        }
    }

    /// Adds the step of one task in the null space of those above it.
    fn descend_task(&mut self, task: Range<usize>, damping: f64) {
        let Self { n, rows, error, projected, basis, rank, gram, residual, step, held, .. } = self;
        let (n, m) = (*n, task.len());
        for row in task.clone() {
            let (entries, place) = (&rows[row * n..(row + 1) * n], &mut projected[row * n..(row + 1) * n]);
            residual[row] = error[row] - dot(entries, step);
            place.copy_from_slice(entries);
            zero_held(place, held);
            remove(basis, *rank, n, place);
        }
        let projected = &projected[task.start * n..task.end * n];
        for i in 0..m {
            for j in 0..=i {
                gram[i * m + j] = dot(&projected[i * n..(i + 1) * n], &projected[j * n..(j + 1) * n]);
            }
            gram[i * m + i] += damping;
        }
        let solution = &mut residual[task];
        solve_cholesky(gram, solution);
        for (row, factor) in projected.chunks_exact(n).zip(&*solution) {
            step.iter_mut().zip(row).for_each(|(step, entry)| *step += factor * entry);
        }
        for row in projected.chunks_exact(n) {
            self.smallest = self.smallest.min(extend(basis, rank, row));
        }
    }
}

fn zero_held(entries: &mut [f64], held: &[bool]) {
    entries.iter_mut().zip(held).filter(|(_, held)| **held).for_each(|(entry, _)| *entry = 0.0);
}

/// Removes the parts along the vectors of an orthonormal basis, n entries each.
fn remove(basis: &[f64], rank: usize, n: usize, vector: &mut [f64]) {
    for direction in basis[..rank * n].chunks_exact(n) {
        let along = dot(direction, vector);
        vector.iter_mut().zip(direction).for_each(|(entry, d)| *entry -= along * d);
    }
}

/// Adds what is new in a row to an orthonormal basis; returns its length, infinite for a row of zeros.
fn extend(basis: &mut [f64], rank: &mut usize, row: &[f64]) -> f64 {
    let (n, length) = (row.len(), dot(row, row).sqrt());
    if *rank == n || length == 0.0 {
        return f64::INFINITY;
    }
    let (known, rest) = basis.split_at_mut(*rank * n);
    let place = &mut rest[..n];
    place.copy_from_slice(row);
    remove(known, *rank, n, place);
    let new = dot(place, place).sqrt();
    if new > DEPENDENT * length {
        for entry in place {
            *entry /= new;
        }
        *rank += 1;
    }
    new
}

/// Solves A x = b for a symmetric positive definite A (its lower triangle, row by row), which its Cholesky factor overwrites.
pub(super) fn solve_cholesky(a: &mut [f64], x: &mut [f64]) {
    let m = x.len();
    for i in 0..m {
        for j in 0..=i {
            let sum = a[i * m + j] - dot(&a[i * m..i * m + j], &a[j * m..j * m + j]);
            a[i * m + j] = if i == j { sum.sqrt() } else { sum / a[j * m + j] };
        }
        x[i] = (x[i] - dot(&a[i * m..i * m + i], &x[..i])) / a[i * m + i];
    }
    for i in (0..m).rev() {
        let sum: f64 = (i + 1..m).map(|k| a[k * m + i] * x[k]).sum();
        x[i] = (x[i] - sum) / a[i * m + i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_positive_definite_system_is_solved() {
        let mut a = [4.0, 0.0, 0.0, 2.0, 5.0, 0.0, 1.0, 3.0, 6.0];
        let mut x = [4.0 + 4.0 + 3.0, 2.0 + 10.0 + 9.0, 1.0 + 6.0 + 18.0];
        solve_cholesky(&mut a, &mut x);
        assert!(x.iter().zip([1.0, 2.0, 3.0]).all(|(x, exact)| (x - exact).abs() < 1e-14), "{x:?}");
    }

    #[test]
    fn a_lower_task_gives_way_and_a_held_joint_does_not_move() {
        let mut newton = Newton::new(&[1, 1], vec![1.0, 2.0]);
        newton.set(0, &Matrix::from_row_slice(1, 2, &[1.0, 0.0]), |_| 0.01);
        newton.set(1, &Matrix::from_row_slice(1, 2, &[1.0, 1.0]), |_| 0.05);
        let free = [[-9.0, 9.0]; 2];
        let step = newton.step(&[0.0; 2], &free, None).to_vec();
        assert!((step[0] - 0.01).abs() < 1e-5 && (step[1] - 0.04).abs() < 1e-4, "{step:?}");
        let step = newton.step(&[0.0; 2], &[[-9.0, 9.0], [-9.0, 0.02]], None).to_vec();
        assert!((step[0] - 0.01).abs() < 1e-5 && (step[1] - 0.02).abs() < 1e-12, "{step:?}");
    }
}
