//! The blend that makes damped answers continuous, compared with its definition in `docs/solver.md`: each part is a problem of
//! its own, and singular values come from the matrices themselves.

#[path = "solvers/mod.rs"]
mod solvers;

use proptest::prelude::*;
use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Damping, Matrix, Vector};
use revprio_core::resolution::{Method, Problem, Resolution, Side, Solver, Status, resolve};
use revprio_core::task::{Task, TaskStack};
use solvers::resolve_with;

const N: usize = 5;

/// A level: rows with bounds, equal ones for equations.
#[derive(Debug, Clone)]
struct Level {
    rows: Matrix,
    lower: Vector,
    upper: Vector,
}

impl Level {
    fn is_equation(&self) -> bool {
        self.lower == self.upper
    }
}

fn problem(levels: &[Level], limits: &VelocityBox, reference: &Vector, damping: Option<Damping>) -> Problem {
    let task = |level: &Level| {
        let (rows, lower, upper) = (level.rows.clone(), level.lower.clone(), level.upper.clone());
        if level.is_equation() { Task::new("", rows, lower) } else { Task::between("", rows, lower, upper) }
    };
    Problem {
        limits: limits.clone(),
        method: Method::StrictReversePriority,
        null_space_velocity: Some(reference.clone()),
        damping,
        ..Problem::new(TaskStack::new(levels.iter().map(task).collect()).unwrap())
    }
}

fn solve(levels: &[Level], limits: &VelocityBox, reference: &Vector, damping: Option<Damping>) -> Resolution {
    resolve(&problem(levels, limits, reference, damping), &[]).unwrap()
}

fn stack<'a>(matrices: impl Iterator<Item = &'a Matrix>) -> Matrix {
    matrices.fold(Matrix::zeros(0, N), |above, matrix| {
        let m = above.nrows();
        Matrix::from_fn(m + matrix.nrows(), N, |i, j| if i < m { above[(i, j)] } else { matrix[(i - m, j)] })
    })
}

/// Smoothstep of the smallest of `count` singular values.
fn regularity(matrix: &Matrix, count: usize, threshold: f64) -> f64 {
    if matrix.nrows().min(matrix.ncols()) < count {
        return 0.0;
    }
    let smallest = matrix.clone().svd(false, false).singular_values.min();
    let ratio = (smallest / threshold).min(1.0);
    ratio * ratio * (3.0 - 2.0 * ratio)
}

/// 0 at the nearer bound, 1 in the middle between the bounds.
fn room(value: f64, lower: f64, upper: f64) -> f64 {
    let half_width = if (upper - lower).is_finite() { (upper - lower) / 2.0 } else { 1.0 };
    if lower == upper { 0.0 } else { ((value - lower).min(upper - value).max(0.0) / half_width).min(1.0) }
}

/// s of the first levels at a velocity.
fn weight(levels: &[Level], limits: &VelocityBox, x: &Vector, threshold: f64) -> f64 {
    let of_rows = |levels: &[Level]| {
        let m = levels.iter().map(|level| level.rows.nrows()).sum();
        let column = |j: usize| room(x[j], limits.lower()[j], limits.upper()[j]);
        let Level { rows, lower, upper } = merged(levels);
        let values = &rows * x;
        let matrix = Matrix::from_fn(m, N + m, |i, j| match j {
            _ if j < N => rows[(i, j)] * column(j),
            _ if j == N + i => room(values[i], lower[i], upper[i]),
            _ => 0.0,
        });
        regularity(&matrix, m, threshold)
    };
    let independent = of_rows(levels);
    if levels.iter().map(|level| level.rows.nrows()).sum::<usize>() < N {
        return independent;
    }
    let equations = stack(levels.iter().filter(|level| level.is_equation()).map(|level| &level.rows));
    let determined = regularity(&equations.transpose(), N, threshold);
    let above = if levels.len() == 1 { 1.0 } else { of_rows(&levels[..levels.len() - 1]) };
    independent.max(determined * above)
}

/// Rows with a weight that aim at the part τ of what a velocity achieves: bounds give way by this part of the violation.
fn aimed_at(level: &Level, velocity: &Vector, part: f64, weight: f64) -> Level {
    let achieved = &level.rows * velocity;
    let moved = |bound: f64, value: f64| if part == 1.0 { value } else { bound + part * (value - bound) };
    let (lower, upper) = if level.is_equation() {
        let target = level.lower.zip_map(&achieved, moved);
        (target.clone(), target)
    } else {
        let lower =
            level.lower.zip_map(&achieved, |bound, value| if value < bound { moved(bound, value) } else { bound });
        let upper =
            level.upper.zip_map(&achieved, |bound, value| if value > bound { moved(bound, value) } else { bound });
        (lower, upper)
    };
    Level { rows: &level.rows * weight, lower: lower * weight, upper: upper * weight }
}

/// All rows as one level.
fn merged(levels: &[Level]) -> Level {
    let entries = |of: fn(&Level) -> &Vector| {
        Vector::from_vec(levels.iter().flat_map(|level| of(level).iter().copied().collect::<Vec<_>>()).collect())
    };
    let rows = stack(levels.iter().map(|level| &level.rows));
    Level { rows, lower: entries(|level| &level.lower), upper: entries(|level| &level.upper) }
}

/// The middle of the box; next to a single bound, the speed next to zero that is 1 rad/s inside.
fn middle(lower: f64, upper: f64) -> f64 {
    if (upper - lower).is_finite() { f64::midpoint(lower, upper) } else { 0.0_f64.max(lower + 1.0).min(upper - 1.0) }
}

/// X_k: the first levels exactly, then one level after the other with the weight 1 + 1/λ_max, twice that for the first one.
/// What the levels between have achieved counts sixty times as much.
fn part(levels: &[Level], kept: usize, limits: &VelocityBox, free: &Vector, max_factor: f64) -> Vector {
    let weight = 1.0 + 1.0 / max_factor;
    let middle = Vector::from_fn(N, |j, _| middle(limits.lower()[j], limits.upper()[j]));
    let way = free - &middle;
    let room = |j: usize| if way[j] > 0.0 { limits.upper()[j] - middle[j] } else { middle[j] - limits.lower()[j] };
    // A pinned joint stays and does not count.
    let is_open = |j: &usize| limits.lower()[*j] < limits.upper()[*j];
    let scale = (0..N).filter(is_open).map(|j| room(j) / way[j].abs()).fold(1.0, f64::min);
    let start = limits.clamp(&(middle + way * scale));
    (kept..levels.len()).fold(start, |point, reached| {
        let mut rows: Vec<Level> =
            levels[kept..reached].iter().map(|level| aimed_at(level, &point, 1.0, 60.0 * weight)).collect();
        rows.push(aimed_at(&levels[reached], free, scale, if reached == 0 { 2.0 * weight } else { weight }));
        rows.push(Level { rows: Matrix::identity(N, N), lower: point.clone(), upper: point.clone() });
        let all: Vec<Level> = levels[..kept].iter().cloned().chain([merged(&rows)]).collect();
        solve(&all, limits, &point, None).joint_velocity
    })
}

/// The blend from X_0 to X_K, and how many problems it takes at least: parts without weight need not be known.
fn blend(levels: &[Level], limits: &VelocityBox, reference: &Vector, damping: Damping) -> (Vector, usize) {
    let exact = solve(levels, limits, reference, None).joint_velocity;
    let unlimited = VelocityBox::unbounded(N);
    let equations: Vec<Level> = levels.iter().filter(|level| level.is_equation()).cloned().collect();
    let free = solve(&equations, &unlimited, reference, None).joint_velocity;
    let first = weight(levels, limits, &exact, damping.threshold());
    let (mut parts, mut weights, mut problems) = (vec![exact], vec![first], 1 + usize::from(first < 1.0));
    for kept in (0..levels.len()).rev() {
        if weights[weights.len() - 1] == 1.0 {
            break;
        }
        let x = part(levels, kept, limits, &free, damping.max_factor());
        weights.push(if kept == 0 { 1.0 } else { weight(&levels[..kept], limits, &x, damping.threshold()) });
        parts.push(x);
        problems += if weights[weights.len() - 1] > 1e-9 { levels.len() - kept } else { 0 };
    }
    let start = parts[parts.len() - 1].clone();
    let blended = parts.iter().zip(&weights).rev().skip(1).fold(start, |x, (part, weight)| &x + (part - &x) * *weight);
    (blended, problems)
}

fn entries(count: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-1.0..1.0_f64, count)
}

/// The distance of the bounds of a level: equations, or wide and narrow bounds.
fn width() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![0.0, 0.0, 0.0, 0.3, f64::INFINITY])
}

/// One or two rows.
fn level() -> impl Strategy<Value = Level> {
    (1..3_usize, entries(2 * N), entries(2), width()).prop_map(|(m, rows, targets, width)| {
        let lower = Vector::from_row_slice(&targets[..m]);
        Level { rows: Matrix::from_row_slice(m, N, &rows[..m * N]), upper: lower.add_scalar(width), lower }
    })
}

/// A level that determines all joints.
fn full_level() -> impl Strategy<Value = Level> {
    (entries(N * N), entries(N), width()).prop_map(|(rows, targets, width)| {
        let lower = Vector::from_vec(targets);
        let rows = Matrix::identity(N, N) + Matrix::from_row_slice(N, N, &rows) * 0.4;
        Level { rows, upper: lower.add_scalar(width), lower }
    })
}

/// Whether damping leaves the targets as they are: no singular value of a level, in the null space of the levels above, is
/// below the threshold. Then only what the limits leave of the levels is singular.
fn keep_their_targets(equations: &[Level], threshold: f64) -> bool {
    (0..equations.len()).all(|k| {
        let above = stack(equations[..k].iter().map(|level| &level.rows));
        let dimensions = N.saturating_sub(above.nrows());
        let mut open = Matrix::identity(N, N);
        if k > 0 {
            open -= above.clone().pseudo_inverse(1e-9).unwrap() * &above;
        }
        let projected = &equations[k].rows * open;
        let mut sigma = projected.svd(false, false).singular_values.as_slice().to_vec();
        sigma.sort_by(|a, b| b.total_cmp(a));
        dimensions > 0 && sigma[equations[k].rows.nrows().min(dimensions) - 1] > threshold
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_damped_answer_is_the_blend_of_its_definition(
        mut levels in prop::collection::vec(level(), 1..5), limits in entries(N), reference in entries(N),
        full in full_level(), place in 0..8_usize, unit in prop::sample::select(vec![1.0, 16.0]),
        kinds in prop::collection::vec(prop::sample::select(vec![Some(0.0), None, None, None, Some(f64::INFINITY)]), N),
    ) {
        let damping = Damping::new(0.6 * unit, 0.2).unwrap();
        let mut upper: Vec<f64> = limits.iter().map(|limit| 0.05 + limit.abs()).collect();
        let mut lower: Vec<f64> = upper.iter().enumerate().map(|(j, limit)| if j == 0 { -0.5 } else { -limit }).collect();
        // Pinned joints, and joints with one bound, on either side of zero.
        for (j, width) in kinds.iter().enumerate() {
            match width {
                Some(width) if limits[j] > 0.3 => (lower[j], upper[j]) = (limits[j] - 0.6, limits[j] - 0.6 + width),
                Some(width) => (lower[j], upper[j]) = (limits[j] - width, limits[j]),
                None => {}
            }
        }
        let limits = VelocityBox::new(&lower, &upper).unwrap();
        let reference = Vector::from_vec(reference);
        if place < levels.len() {
            levels.truncate(place);
            levels.push(full);
        }
        for level in &mut levels {
            (level.rows, level.lower, level.upper) = (&level.rows * unit, &level.lower * unit, &level.upper * unit);
        }
        let equations: Vec<Level> = levels.iter().filter(|level| level.is_equation()).cloned().collect();
        prop_assume!(!equations.is_empty() && keep_their_targets(&equations, 0.6 * unit));
        let exact = solve(&levels, &limits, &reference, None);
        prop_assume!(exact.active_set.iter().any(|set| !set.is_empty()) || kinds.contains(&Some(0.0)));
        let (expected, problems) = blend(&levels, &limits, &reference, damping);
        let found = solve(&levels, &limits, &reference, Some(damping));
        prop_assert_eq!(found.solver.status, Status::Optimal);
        let error = (&found.joint_velocity - &expected).amax();
        prop_assert!(error < 1e-8, "{error:e}");
        prop_assert!(found.solver.working_sets as usize >= problems, "{:?}, {problems} problems", found.solver);
        for (joint, active) in found.active_limits() {
            prop_assert_eq!(found.joint_velocity[joint], active.value, "{:?} is not reached", active);
        }
        for (k, level) in levels.iter().enumerate() {
            for (row, active) in found.active_rows(k) {
                let value = (&level.rows * &found.joint_velocity)[row];
                let is_reached =
                    if active.bound.side == Side::Lower { value <= level.lower[row] + 1e-9 } else { value >= level.upper[row] - 1e-9 };
                prop_assert!(level.is_equation() || is_reached, "{:?} is not reached by {}", active, value);
            }
        }
    }
}

/// Without an active bound the answer is x^f, and nothing else is computed: one working set, although two tasks are singular
/// together. A damping factor of zero leaves the exact answer, whatever the limits do.
#[test]
fn a_damped_answer_is_exact_without_active_bounds_and_without_a_factor() {
    let level = |row: [f64; N], target: f64| {
        let target = Vector::from_row_slice(&[target]);
        Level { rows: Matrix::from_row_slice(1, N, &row), lower: target.clone(), upper: target }
    };
    let levels = [level([1.0, 0.0, 0.0, 0.0, 0.0], 0.5), level([1.0, 0.1, 0.0, 0.0, 0.0], 0.5)];
    let reference = Vector::zeros(N);
    let wide = VelocityBox::new(&[-9.0; N], &[9.0; N]).unwrap();
    let damped = solve(&levels, &wide, &reference, Damping::new(0.6, 0.2));
    assert_eq!((damped.active_limits().count(), damped.solver.working_sets), (0, 1));
    let narrow = VelocityBox::new(&[-0.4; N], &[0.4; N]).unwrap();
    let exact = solve(&levels, &narrow, &reference, None);
    let damped = solve(&levels, &narrow, &reference, Damping::new(0.6, 0.0));
    assert_eq!((exact.active_limits().count(), &damped.joint_velocity), (2, &exact.joint_velocity));
}

/// Rows with room do not count as bounds: seven inequality rows on five joints leave the levels regular.
#[test]
fn more_inequality_rows_than_joints_leave_room() {
    let row = |i: usize, j: usize| if i < N { f64::from(u8::from(i == j)) } else { 0.5 - (i + j) as f64 / 8.0 };
    let wide =
        Level { rows: Matrix::from_fn(7, N, row), lower: Vector::repeat(7, -3.0), upper: Vector::repeat(7, 3.0) };
    let target = Vector::from_row_slice(&[1.0]);
    let goal =
        Level { rows: Matrix::from_row_slice(1, N, &[1.0, 0.4, 0.0, 0.0, 0.0]), lower: target.clone(), upper: target };
    let limits = VelocityBox::new(&[-1.0; N], &[0.8, 1.0, 1.0, 1.0, 1.0]).unwrap();
    let (levels, reference, damping) = ([wide, goal], Vector::zeros(N), Damping::new(0.6, 0.2).unwrap());
    let expected = blend(&levels, &limits, &reference, damping).0;
    let found = solve(&levels, &limits, &reference, Some(damping)).joint_velocity;
    assert!((&found - &expected).amax() < 1e-8, "{found} {expected}");
}

/// Joint 0 stops at a limit and the first task at a bound of its row, on either side, in every part of the blend.
#[test]
fn a_damped_answer_lists_the_bounds_that_it_reaches() {
    for sign in [1.0, -1.0] {
        let target = Vector::from_row_slice(&[sign]);
        let level = |row: [f64; N], lower: &Vector, upper: &Vector| Level {
            rows: Matrix::from_row_slice(1, N, &row),
            lower: lower.clone(),
            upper: upper.clone(),
        };
        let (half, one) = (Vector::from_row_slice(&[0.5]), Vector::from_row_slice(&[2.0]));
        let bounds = if sign > 0.0 { (-&one, half) } else { (-half, one) };
        let levels = [
            level([0.0, 0.0, 1.0, 0.0, 0.0], &bounds.0, &bounds.1),
            level([1.0, 0.4, 0.0, 0.0, 0.0], &target, &target),
            level([0.0, 0.0, 1.0, 0.0, 0.0], &target, &target),
        ];
        let limits = VelocityBox::new(&[-0.8; N], &[0.8; N]).unwrap();
        let problem = problem(&levels, &limits, &Vector::zeros(N), Damping::new(0.6, 0.2));
        let side = if sign > 0.0 { Side::Upper } else { Side::Lower };
        for solver in [Solver::Auto, Solver::Qp] {
            let answer = resolve_with(solver, &problem, &[]).unwrap();
            let joints: Vec<_> = answer.active_limits().map(|(joint, it)| (joint, it.bound.side)).collect();
            let rows: Vec<_> = answer.active_rows(0).map(|(row, it)| (row, it.bound.side)).collect();
            assert_eq!((joints, rows), (vec![(0, side)], vec![(0, side)]), "{solver:?}: {answer:?}");
        }
    }
}
