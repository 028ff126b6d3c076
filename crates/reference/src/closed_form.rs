//! The solver `closed_form`: the formulas as printed, with pseudo-inverses by singular value decomposition, without limits and
//! inequality tasks.
#![allow(non_snake_case)]

use revprio_problem::{
    ActiveSet, Damping, Matrix, Method, Path, Problem, ProblemError, Resolution, Solve, Status, Vector,
};

use crate::certified_formula::{Stage, certificate};
use crate::damping::{factor, kept_directions};
use crate::report::{status, write_velocity, write_violations};
use crate::singularity::Singularities;
use crate::svd::{PROJECTION_ERROR, RANK_TOLERANCE, Svd, concatenate, norm, stack};

/// The printed formula of each method. Do not use it on a real arm. It ignores joint limits.
#[derive(Debug, Clone, Copy, Default)]
pub struct ClosedForm;

impl Solve for ClosedForm {
    fn solve(&mut self, problem: &Problem, _guess: &[ActiveSet], answer: &mut Resolution) -> Result<(), ProblemError> {
        problem.check()?;
        let known = Singularities::new(problem.tasks.tasks(), problem.damping);
        let Formula { joint_velocity, kkt_residual, stages } = evaluate(problem);
        write_velocity(problem, &known, &joint_velocity, answer);
        answer.certificate = problem.wants_certificate.then(|| Box::new(certificate(problem, &stages)));
        let report = &mut answer.solver;
        report.path = Path::ClosedForm;
        if report.status != Status::Failed {
            report.status = status(kkt_residual);
            report.kkt_residual = Some(kkt_residual).filter(|residual| residual.is_finite());
            report.rank_uncertain = known.rank_uncertain;
            write_violations(problem, answer);
        }
        Ok(())
    }

    fn keeps_limits(&self) -> bool {
        false
    }
}

/// Length of the rows of J_k in J_k^RP, relative to the lower rows.
const ROW_LENGTH: f64 = 10.0;

/// Factor that rows of J_k get at most.
const MAX_ROW_LENGTH: f64 = 1e6;

/// A joint velocity and its distance from the optimality conditions.
#[derive(Debug, Clone)]
struct Formula {
    /// q̇, n, rad/s.
    joint_velocity: Vector,
    /// Largest relative stationarity residual.
    kkt_residual: f64,
    /// The stages of the formula, in the order of evaluation.
    stages: Vec<Stage>,
}

/// A task of equations.
struct Equations {
    J: Matrix,
    xdot: Vector,
}

/// Evaluates the formula of the problem's method.
fn evaluate(problem: &Problem) -> Formula {
    let n = problem.tasks.joint_count();
    let zeta = problem.null_space_velocity.clone().unwrap_or_else(|| Vector::zeros(n));
    let tasks: Vec<Equations> = problem
        .tasks
        .tasks()
        .iter()
        .filter(|task| task.is_equation())
        .map(|task| Equations { J: task.jacobian.clone(), xdot: task.lower.clone() })
        .collect();
    match problem.method {
        Method::Pseudoinverse => least_squares(&tasks, &zeta, None),
        Method::DampedLeastSquares => least_squares(&tasks, &zeta, problem.damping),
        Method::TaskPriority | Method::StrictReversePriority => task_priority(&tasks, &zeta, problem.damping),
        Method::SingularityRobust => singularity_robust(&tasks, zeta, problem.damping),
        Method::ReversePriority => reverse_priority(&tasks, zeta, problem.damping),
    }
}

/// q̇ = J^# ẋ + (I − J^# J) ζ̇ over all rows.
///
/// Paper: Eqs. (5), (15). Departs: Eq. (4) inverts JᵀJ, singular for n > m, and the projector of Eq. (7) is zero.
fn least_squares(tasks: &[Equations], zeta: &Vector, damping: Option<Damping>) -> Formula {
    let (J, xdot) = stacked(tasks, zeta.len());
    let svd = Svd::new(&J);
    let lambda = factor(damping, svd.smallest());
    let delta = svd.solve(svd.rank(RANK_TOLERANCE * norm(&J)), lambda, &(&xdot - &J * zeta));
    let joint_velocity = zeta + &delta;
    let gradient = J.tr_mul(&(&J * &joint_velocity - &xdot)) + lambda * lambda * &delta;
    let kkt_residual = relative(&gradient, norm(&J) + lambda, joint_velocity.norm() + zeta.norm(), xdot.norm());
    let stages = vec![Stage { joint_velocity: joint_velocity.clone(), lambda }];
    Formula { joint_velocity, kkt_residual, stages }
}

/// One part of the average of [`task_priority`].
struct Kept {
    weight: f64,
    qdot: Vector,
    /// Projector onto what the tasks so far leave.
    N: Matrix,
    /// Smallest relative singular value that N leaves out.
    weakest: f64,
}

/// q̇ ← q̇ + (J_k N_k)^# (ẋ_k − J_k q̇) for k = 1 … l, N_k the null-space projector of all higher tasks; then N ζ̇.
///
/// Weak directions of J_k N belong to N gradually: the answer is an average, see `docs/solver.md`, section 9.
///
/// Paper: Eq. (11), with the augmented Jacobian in the projector.
fn task_priority(tasks: &[Equations], zeta: &Vector, damping: Option<Damping>) -> Formula {
    let n = zeta.len();
    let start = Kept { weight: 1.0, qdot: Vector::zeros(n), N: Matrix::identity(n, n), weakest: 1.0 };
    let mut answers = vec![start];
    let mut kkt_residual = 0.0_f64;
    let mut projected = Vec::new();
    for (place, Equations { J, xdot }) in tasks.iter().enumerate() {
        let fades = place + 1 < tasks.len() || zeta.amax() > 0.0;
        for Kept { weight, mut qdot, N, weakest } in std::mem::take(&mut answers) {
            let JN = J * &N;
            let svd = Svd::new(&JN);
            // A projector along a weak direction has that much more error.
            let open = J.nrows().min(dimension(&N));
            let rank = svd.rank(RANK_TOLERANCE.max(PROJECTION_ERROR / weakest) * norm(J)).min(open);
            let smallest = svd.singular_values()[..open].last().copied().unwrap_or(0.0);
            let lambda = factor(damping, smallest);
            let delta = svd.solve(rank, lambda, &(xdot - J * &qdot));
            qdot += &delta;
            let gradient = JN.tr_mul(&(J * &qdot - xdot)) + lambda * lambda * &delta;
            kkt_residual =
                kkt_residual.max(relative(&gradient, norm(J) + lambda, qdot.norm() + delta.norm(), xdot.norm()));
            projected.push(JN);
            for (kept, share) in kept_directions(svd.singular_values(), rank, damping.filter(|_| fades)) {
                let weakest = if kept > 0 { weakest.min(svd.singular_values()[kept - 1] / norm(J)) } else { weakest };
                let N = &N - svd.row_projector(kept);
                answers.push(Kept { weight: weight * share, qdot: qdot.clone(), N, weakest });
            }
        }
    }
    let part = |Kept { weight, qdot, N, .. }: &Kept| (qdot + N * zeta) * *weight;
    let joint_velocity = answers.iter().map(part).fold(Vector::zeros(n), |sum, part| sum + part);
    if damping.is_none() {
        // What lower tasks have changed of higher ones.
        for (Equations { J, xdot }, JN) in tasks.iter().zip(&projected) {
            let gradient = JN.tr_mul(&(J * &joint_velocity - xdot));
            let size = joint_velocity.norm() + zeta.norm();
            kkt_residual = kkt_residual.max(relative(&gradient, norm(J), size, xdot.norm()));
        }
    }
    let stages = vec![Stage { joint_velocity: joint_velocity.clone(), lambda: 0.0 }];
    Formula { joint_velocity, kkt_residual, stages }
}

/// Returns the number of dimensions that a projector keeps, which is its trace.
fn dimension(N: &Matrix) -> usize {
    let trace = N.trace();
    (0..N.nrows()).take_while(|&dimension| dimension as f64 + 0.5 < trace).count()
}

/// q̇_k = q̇_{k+1} + J_k^# (ẋ_k − J_k q̇_{k+1}) for k = l … 1.
///
/// Paper: Eq. (13), q̇ = J_1⁺ẋ_1 + (I − J_1⁺J_1) J_2⁺ẋ_2 for two tasks.
fn singularity_robust(tasks: &[Equations], zeta: Vector, damping: Option<Damping>) -> Formula {
    let start = Formula { joint_velocity: zeta, kkt_residual: 0.0, stages: Vec::new() };
    tasks.iter().rev().fold(start, |Formula { joint_velocity, kkt_residual, mut stages }, Equations { J, xdot }| {
        let svd = Svd::new(J);
        let mu = factor(damping, svd.smallest());
        let delta = svd.solve(svd.rank(RANK_TOLERANCE * norm(J)), mu, &(xdot - J * &joint_velocity));
        let qdot = joint_velocity + &delta;
        let gradient = J.tr_mul(&(J * &qdot - xdot)) + mu * mu * &delta;
        let residual = relative(&gradient, norm(J) + mu, qdot.norm() + delta.norm(), xdot.norm());
        stages.push(Stage { joint_velocity: qdot.clone(), lambda: 0.0 });
        Formula { joint_velocity: qdot, kkt_residual: kkt_residual.max(residual), stages }
    })
}

/// q̇_k = q̇_{k+1} + T_k (J_k T_k)⁺ J_k J_k^# (ẋ_k − J_k q̇_{k+1}) for k = l … 1, T_k the first m_k columns of (J_k^RP)^#.
///
/// J_k^# is damped with μ_k from σ_min(J_k), (J_k^RP)^# with λ_k from σ_min(J_k^RP). J_k T_k has the rank of J_k. The product
/// T_k (J_k T_k)⁺ does not depend on the length of the rows of J_k in J_k^RP. They are made longer than the lower ones,
/// because short rows would stand in J_k T_k squared.
///
/// Lower tasks may use weak directions of J_k gradually: the stage is an average, see `docs/solver.md`, section 9.
///
/// Paper: Eqs. (22), (25), (29), (32), which are this without damping.
fn reverse_priority(tasks: &[Equations], zeta: Vector, damping: Option<Damping>) -> Formula {
    let n = zeta.len();
    let (mut qdot, mut low, mut kkt_residual, mut stages) = (zeta, Matrix::zeros(0, n), 0.0_f64, Vec::new());
    for Equations { J, xdot } in tasks.iter().rev() {
        let all = stack(J, &low);
        let own_svd = Svd::new(J);
        let (mu, lambda) = (factor(damping, own_svd.smallest()), factor(damping, Svd::new(&all).smallest()));
        let length = (ROW_LENGTH * norm(&low) / norm(J)).clamp(1.0, MAX_ROW_LENGTH);
        let weighted = stack(&(J * length), &low);
        let all_svd = Svd::new(&weighted);
        let rank = own_svd.rank(RANK_TOLERANCE * norm(J));
        let reach = own_svd.solve(rank, mu, &(xdot - J * &qdot));
        let all_rank = all_svd.rank(RANK_TOLERANCE * norm(&weighted));
        let mut sum = Vector::zeros(n);
        for (kept, share) in kept_directions(own_svd.singular_values(), rank, damping.filter(|_| low.nrows() > 0)) {
            let (delta, residual) = if kept == rank {
                let T = all_svd.inverse(all_rank, lambda).columns(0, J.nrows()).into_owned();
                let delta = &T * Svd::new(&(J * &T)).solve(rank, 0.0, &(J * &reach));
                let residual = ReverseStage { J, xdot, low: &low, own: &own_svd, rank, mu, lambda, before: &qdot }
                    .residual(&reach, &delta);
                (delta, residual)
            } else {
                released(&own_svd.row_projector(kept), &low, lambda, &reach)
            };
            kkt_residual = kkt_residual.max(residual);
            sum += delta * share;
        }
        qdot += sum;
        stages.push(Stage { joint_velocity: qdot.clone(), lambda: if low.nrows() > 0 { lambda } else { 0.0 } });
        low = all;
    }
    Formula { joint_velocity: qdot, kkt_residual, stages }
}

/// Returns argmin ‖J_{k+1}^RP Δ‖² + λ² ‖Δ‖² that equals `reach` along the directions of a projector, and its residual.
fn released(projector: &Matrix, low: &Matrix, lambda: f64, reach: &Vector) -> (Vector, f64) {
    let base = projector * reach;
    let svd = Svd::new(&(low - low * projector));
    let delta = &base - svd.solve(svd.rank(RANK_TOLERANCE * norm(low)), lambda, &(low * &base));
    let gradient = low.tr_mul(&(low * &delta)) + lambda * lambda * &delta;
    let open = &gradient - projector * &gradient;
    let residual = relative(&open, norm(low) + lambda, reach.norm() + delta.norm(), 0.0);
    (delta, residual)
}

/// Stage k: J_k Δ = J_k J_k^# e_k, then min ‖J_{k+1}^RP Δ‖² + λ² ‖Δ‖².
struct ReverseStage<'a> {
    J: &'a Matrix,
    xdot: &'a Vector,
    /// J_{k+1}^RP.
    low: &'a Matrix,
    /// J_k, decomposed, and its rank.
    own: &'a Svd,
    rank: usize,
    mu: f64,
    lambda: f64,
    /// q̇_{k+1}.
    before: &'a Vector,
}

impl ReverseStage<'_> {
    /// Returns the residual of both optimality conditions at Δ = `delta`; `reach`: J_k^# e_k.
    fn residual(&self, reach: &Vector, delta: &Vector) -> f64 {
        let Self { J, xdot, low, own, rank, mu, lambda, before } = self;
        let reached = J.tr_mul(&(*J * (*before + delta) - *xdot)) + *mu * *mu * reach;
        let gradient = low.tr_mul(&(*low * delta)) + *lambda * *lambda * delta;
        let kept = &gradient - own.inverse(*rank, 0.0) * (*J * &gradient);
        let size = before.norm() + reach.norm() + delta.norm();
        let reaching = relative(&reached, norm(J) + *mu, size, xdot.norm());
        reaching.max(relative(&kept, norm(low) + *lambda, size, 0.0))
    }
}

/// All rows and velocities, highest priority on top.
fn stacked(tasks: &[Equations], n: usize) -> (Matrix, Vector) {
    let empty = (Matrix::zeros(0, n), Vector::zeros(0));
    tasks.iter().fold(empty, |(J, xdot), task| (stack(&J, &task.J), concatenate(&xdot, &task.xdot)))
}

/// Returns ‖gradient‖_∞ relative to the size that it can have by scale alone.
fn relative(gradient: &Vector, a: f64, x: f64, b: f64) -> f64 {
    match (gradient.amax(), a * (a * x + b)) {
        (0.0, _) => 0.0,
        (size, scale) if scale.is_finite() => size / scale,
        _ => f64::INFINITY,
    }
}
