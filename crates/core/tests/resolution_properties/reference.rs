//! Exact answers by independent methods: projectors instead of bases, all 3ⁿ active sets instead of a search.
#![allow(non_snake_case)]

use revprio_core::linalg::{Matrix, Vector};
use revprio_core::resolution::{Method, Problem};

/// One level: minimise ‖A q̇ − b‖ as far as the levels before it permit.
pub struct Level {
    pub A: Matrix,
    pub b: Vector,
}

const RANK: f64 = 1e-10;

/// Returns A⁺ by one-sided Jacobi rotations, A V = U Σ. Singular values below `cut` count as zero.
///
/// The decomposition of nalgebra is not used: for rank-deficient 10 × 3 matrices its second digit was wrong.
pub fn pinv(A: &Matrix, cut: f64) -> Matrix {
    let n = A.ncols();
    let (mut W, mut V) = (A.clone(), Matrix::identity(n, n));
    for _ in 0..40 {
        let mut rotated = false;
        for (p, q) in (0..n).flat_map(|p| (p + 1..n).map(move |q| (p, q))) {
            let (a, b, c) = (W.column(p).norm_squared(), W.column(q).norm_squared(), W.column(p).dot(&W.column(q)));
            if c.abs() > 1e-16 * (a * b).sqrt() && c.abs() > 1e-300 {
                rotated = true;
                let zeta = (b - a) / (2.0 * c);
                let t = zeta.signum() / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
                let cosine = 1.0 / (1.0 + t * t).sqrt();
                rotate(&mut W, p, q, cosine, cosine * t);
                rotate(&mut V, p, q, cosine, cosine * t);
            }
        }
        if !rotated {
            break;
        }
    }
    let mut inverse = Matrix::zeros(n, A.nrows());
    for i in (0..n).filter(|&i| W.column(i).norm() > cut) {
        inverse += V.column(i) * W.column(i).transpose() / W.column(i).norm_squared();
    }
    inverse
}

fn rotate(M: &mut Matrix, p: usize, q: usize, cosine: f64, sine: f64) {
    for i in 0..M.nrows() {
        let (x, y) = (M[(i, p)], M[(i, q)]);
        (M[(i, p)], M[(i, q)]) = (cosine * x - sine * y, sine * x + cosine * y);
    }
}

/// Returns A⁺ with the rank relative to A itself.
pub fn pinv_own(A: &Matrix) -> Matrix {
    pinv(A, RANK * A.norm())
}

/// Solves lexicographic least squares from `qdot`, in the directions that the projector `P` leaves free.
pub fn lexicographic(levels: &[Level], mut qdot: Vector, mut P: Matrix) -> Vector {
    for Level { A, b } in levels {
        let AP = A * &P;
        let inverse = &P * pinv(&AP, RANK * A.norm());
        qdot += &inverse * (b - A * &qdot);
        P -= &inverse * AP;
    }
    qdot
}

/// Solves lexicographic least squares without limits.
pub fn unlimited(levels: &[Level], n: usize) -> Vector {
    lexicographic(levels, Vector::zeros(n), Matrix::identity(n, n))
}

/// Returns ‖A q̇ − b‖ of each level.
pub fn residuals(levels: &[Level], qdot: &Vector) -> Vec<f64> {
    levels.iter().map(|level| (&level.A * qdot - &level.b).norm()).collect()
}

/// Solves lexicographic least squares in a box by trying every set of active bounds.
pub fn enumerate(levels: &[Level], lower: &Vector, upper: &Vector) -> Vector {
    let mut candidates = corners(levels, lower, upper);
    let size = candidates.iter().map(Vector::norm).fold(0.0, f64::max);
    for level in levels {
        let cost = |q: &Vector| (&level.A * q - &level.b).norm();
        let best = candidates.iter().min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap().clone();
        let limit = cost(&best) + 1e-13 * (level.A.norm() * size + level.b.norm());
        candidates.retain(|q| cost(q) <= limit);
    }
    candidates.swap_remove(0)
}

/// Returns the minimiser on each set of active bounds, if it lies in the box.
fn corners(levels: &[Level], lower: &Vector, upper: &Vector) -> Vec<Vector> {
    let n = lower.len();
    let mut found = Vec::new();
    let powers: Vec<usize> = std::iter::successors(Some(1), |power| Some(3 * power)).take(n + 1).collect();
    for pattern in 0..powers[n] {
        let choice = |i: usize| pattern / powers[i] % 3;
        let start = Vector::from_fn(n, |i, _| [0.0, lower[i], upper[i]][choice(i)]);
        if start.iter().any(|x| x.is_infinite()) {
            continue;
        }
        let P = Matrix::from_fn(n, n, |i, j| if i == j && choice(i) == 0 { 1.0 } else { 0.0 });
        let qdot = lexicographic(levels, start, P);
        let inside = |i: usize| {
            let tolerance = 1e-12 * (1.0 + qdot.norm());
            (lower[i] - tolerance..=upper[i] + tolerance).contains(&qdot[i])
        };
        if (0..n).all(inside) {
            found.push(qdot);
        }
    }
    found
}

/// Returns the levels of the problem without limits, for the two reverse-priority methods.
pub fn levels(problem: &Problem) -> Vec<Level> {
    let n = problem.tasks.joint_count();
    let zeta = problem.null_space_velocity.clone().unwrap_or_else(|| Vector::zeros(n));
    let tasks: Vec<Level> =
        problem.tasks.tasks().iter().map(|task| Level { A: task.jacobian.clone(), b: task.lower.clone() }).collect();
    match problem.method {
        Method::ReversePriority => stages(&tasks, zeta),
        _ => tasks.into_iter().chain([Level { A: Matrix::identity(n, n), b: zeta }]).collect(),
    }
}

/// Returns the three levels of the top stage, after it solves the lower stages without limits.
fn stages(tasks: &[Level], zeta: Vector) -> Vec<Level> {
    let n = zeta.len();
    let mut low = Matrix::zeros(0, n);
    let mut qdot = zeta;
    for (k, task) in tasks.iter().enumerate().rev() {
        let stage = vec![
            Level { A: task.A.clone(), b: task.b.clone() },
            Level { b: &low * &qdot, A: low.clone() },
            Level { A: Matrix::identity(n, n), b: qdot },
        ];
        if k == 0 {
            return stage;
        }
        qdot = unlimited(&stage, n);
        low = revprio_core::linalg::stack(&task.A, &low);
    }
    unreachable!("a stack has at least one task")
}
