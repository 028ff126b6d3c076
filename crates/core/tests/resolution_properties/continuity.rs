//! Damped commands are continuous along smooth paths of posture, task velocity and limits: steps that are eight times finer
//! make the largest change of q̇ at least four times smaller, across changes of active limits, ranks and conflicts.

use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Damping, Matrix, Vector};
use revprio_core::resolution::{Method, Problem, Resolution, Solver, resolve};
use revprio_core::task::{Task, TaskStack};

use crate::smooth_paths::{FAMILIES, METHODS, Path, Walk};

/// Steps of the coarsest walk along a path.
const STEPS: u32 = 1000;

/// Changes below this are no jump, however they compare: rad/s.
const SMALL: f64 = 1e-3;

/// Steps with the largest changes that are examined.
const EXAMINED: usize = 4;

/// Returns the largest changes of the walks that were needed, if none of them shows that the path is continuous.
///
/// A steep change may need finer steps than the coarsest walk has; a jump stays, however fine the steps are.
fn jump(walk: &mut Walk) -> Option<Vec<f64>> {
    let mut steps = walk.steps(STEPS);
    let mut largest = Vec::new();
    for _ in 0..4 {
        steps.sort_by(|a, b| b.change.total_cmp(&a.change));
        let change = steps[0].change;
        if change <= SMALL || largest.last().is_some_and(|coarse| change <= coarse / 4.0) {
            return None;
        }
        largest.push(change);
        steps = steps[..EXAMINED].iter().flat_map(|step| walk.split(*step, 8)).collect();
    }
    Some(largest)
}

fn assert_continuous(seeds: std::ops::Range<u64>, solver: Solver) {
    for family in FAMILIES {
        let mut limited = 0;
        for method in METHODS {
            for seed in seeds.clone() {
                let path = Path::random(seed, method, family);
                let mut walk = Walk::new(&path, solver);
                let jump = jump(&mut walk);
                assert!(jump.is_none(), "{family:?}, {method:?}, seed {seed}: the largest changes are {jump:?}");
                limited += walk.limited;
            }
        }
        assert!(limited > STEPS, "{family:?}: limits are rarely active: {limited}");
    }
}

/// `REVPRIO_PATHS` asks for more paths of each family and method.
#[test]
fn damped_commands_are_continuous_where_limits_ranks_and_conflicts_change() {
    let paths = std::env::var("REVPRIO_PATHS").map_or(6, |paths| paths.parse().expect("a number of paths"));
    assert_continuous(0..paths, Solver::Auto);
}

#[test]
fn qp_and_auto_blend_alike() {
    for (family, method) in FAMILIES.into_iter().flat_map(|family| METHODS.map(|method| (family, method))) {
        let path = Path::random(7, method, family);
        let (mut auto, mut qp) = (Walk::new(&path, Solver::Auto), Walk::new(&path, Solver::Qp));
        for step in 1..30 {
            let t = f64::from(step) / 31.0;
            let difference = (auto.at(t) - qp.at(t)).amax();
            assert!(difference < 1e-8, "{family:?}, {method:?}, t = {t}: {difference}");
        }
        assert_eq!(auto.limited, qp.limited, "{family:?}, {method:?}: answers with active limits");
    }
}

fn matrix(rows: usize, entries: &[f64]) -> Matrix {
    Matrix::from_row_slice(rows, entries.len() / rows, entries)
}

fn damped(method: Method, limits: VelocityBox, tasks: Vec<Task>) -> Resolution {
    let damping = Some(Damping::STANDARD);
    resolve(&Problem { limits, method, damping, ..Problem::new(TaskStack::new(tasks).unwrap()) }, &[]).unwrap()
}

#[test]
fn an_active_limit_does_not_make_the_answer_jump_where_damping_begins() {
    // σ_min of [[1, 0, 1], [t, t, 0]] is 0.05 where t² has this value.
    let squared = 0.05_f64.powi(2) * (2.0 - 0.05_f64.powi(2)) / (3.0 - 2.0 * 0.05_f64.powi(2));
    let threshold = squared.sqrt();
    for method in METHODS {
        let at = |t: f64| {
            let sum = Task::new("sum", matrix(1, &[1.0, 0.0, 1.0]), Vector::from_element(1, 1.0));
            let weak = Task::new("weak", matrix(1, &[t, t, 0.0]), Vector::from_element(1, 0.5 * t));
            damped(method, VelocityBox::new(&[-1.0; 3], &[0.3, 1.0, 1.0]).unwrap(), vec![sum, weak])
        };
        let (below, above) = (at(threshold - 1e-8), at(threshold + 1e-8));
        assert!(
            below.singularity.smallest_singular_value() < 0.05 && above.singularity.smallest_singular_value() > 0.05
        );
        let change = (&below.joint_velocity - &above.joint_velocity).amax();
        assert!(change < 1e-3, "{method:?}: {change}");
    }
}

#[test]
fn inequality_rows_that_become_parallel_do_not_make_the_answer_jump() {
    let at = |t: f64| {
        let (lower, upper) = (Vector::from_vec(vec![-3.0, -3.0, -5.0]), Vector::from_vec(vec![0.0, 0.0, 5.0]));
        let wedge = Task::between("wedge", matrix(3, &[1.0, t, -1.0, t, 0.0, 1.0]), lower, upper);
        let move_out = Task::new("move out", matrix(1, &[0.0, 1.0]), Vector::from_element(1, 0.5));
        let limits = VelocityBox::new(&[-1.0; 2], &[1.0; 2]).unwrap();
        damped(Method::StrictReversePriority, limits, vec![wedge, move_out]).joint_velocity
    };
    assert!((at(1e-9) - at(-1e-9)).amax() < 1e-3);
    assert!((at(0.2) - at(0.0)).amax() > 0.4, "the exact answers differ");
}
