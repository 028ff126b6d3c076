//! A resolver that keeps its memory from period to period gives the answers of one without memory.

use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Damping, Matrix, Vector};
use revprio_core::resolution::{ActiveSet, Method, Problem, Resolution, Resolver, resolve};
use revprio_core::task::{Task, TaskStack};

const JOINTS: usize = 7;
const PERIODS: usize = 300;

/// Numbers between −1 and 1 that depend on the seed and an index alone.
fn number(seed: u64, index: usize) -> f64 {
    let mut x = (seed << 20 | index as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// Three tasks of 1, 2 and 3 rows at one place of a path whose last row passes through a combination of the others, so that a
/// singular value passes through zero in the middle, at a speed that depends on the seed.
fn problem(seed: u64, method: Method, damping: Option<Damping>, period: usize) -> Problem {
    let way = period as f64 / PERIODS as f64 - 0.5;
    let own = |i: usize, j: usize| number(seed, 10 * i + j) + 0.2 * way * number(seed, 100 + 10 * i + j);
    let distance = way * 10.0_f64.powf(2.0 * number(seed, 300));
    let entry = |i: usize, j: usize| {
        if i < 5 { own(i, j) } else { (0..5).map(|row| 0.5 * own(row, j)).sum::<f64>() + distance * own(5, j) }
    };
    let task = |first: usize, rows: usize| {
        let velocity = Vector::from_fn(rows, |i, _| 1.5 * number(seed, 200 + first + i));
        Task::new("", Matrix::from_fn(rows, JOINTS, |i, j| entry(first + i, j)), velocity)
    };
    let tasks = TaskStack::new(vec![task(0, 1), task(1, 2), task(3, 3)]).unwrap();
    let limits = VelocityBox::new(&[-0.8; JOINTS], &[0.8; JOINTS]).unwrap();
    Problem { limits, method, damping, ..Problem::new(tasks) }
}

/// Ranks, singularities, damping and stages depend on singular values, which a resolver may know from an earlier period. Its
/// answers have the same bits, far from singularities and through them.
#[test]
fn memory_does_not_change_an_answer() {
    let (mut limited, mut regular, mut singular) = (0, 0, 0);
    for seed in 0..24 {
        for method in [
            Method::ReversePriority,
            Method::StrictReversePriority,
            Method::SingularityRobust,
            Method::DampedLeastSquares,
        ] {
            for damping in [None, Damping::new(0.05, 0.1)] {
                let (mut resolver, mut answer) = (Resolver::default(), Resolution::default());
                let mut guess: Vec<ActiveSet> = Vec::new();
                for period in 0..PERIODS {
                    let problem = problem(seed, method, damping, period);
                    resolver.resolve(&problem, &guess, &mut answer).unwrap();
                    let fresh = resolve(&problem, &guess).unwrap();
                    assert_eq!(answer, fresh, "seed {seed}, {method:?}, {damping:?}, period {period}");
                    limited += u32::from(!guess.iter().all(ActiveSet::is_empty));
                    let smallest = answer.singularity.smallest_singular_value();
                    regular += u32::from(smallest > 0.1);
                    singular += u32::from(smallest < 0.01);
                    guess.clone_from(&answer.active_set);
                }
            }
        }
    }
    assert!(limited > 20_000 && regular > 10_000 && singular > 2_000, "{limited} {regular} {singular}");
}

/// Limits that the answer meets exactly, without being held back by them.
#[test]
fn memory_does_not_change_an_answer_that_ends_at_a_limit() {
    let at = |velocity: f64| {
        let jacobian = Matrix::from_row_slice(2, 3, &[1.0, 0.0, 0.3, 0.0, 1.0, -0.2]);
        let task = Task::new("", jacobian, Vector::from_vec(vec![velocity, 0.4]));
        let limits = VelocityBox::new(&[-0.5; 3], &[0.5; 3]).unwrap();
        Problem { limits, method: Method::StrictReversePriority, ..Problem::new(TaskStack::new(vec![task]).unwrap()) }
    };
    let (mut resolver, mut answer) = (Resolver::default(), Resolution::default());
    resolver.resolve(&at(0.6), &[], &mut answer).unwrap();
    let guess = answer.active_set.clone();
    assert_eq!(answer.active_limits().count(), 1);
    // The first period with a guess keeps the rows, the next ones use them.
    resolver.resolve(&at(0.6), &guess, &mut answer).unwrap();
    let unlimited = resolve(&Problem { limits: VelocityBox::unbounded(3), ..at(0.5) }, &[]).unwrap();
    let limit = unlimited.joint_velocity[0];
    let exact = Problem { limits: VelocityBox::new(&[-1.0; 3], &[limit, 1.0, 1.0]).unwrap(), ..at(0.5) };
    resolver.resolve(&exact, &guess, &mut answer).unwrap();
    assert_eq!(answer, resolve(&exact, &guess).unwrap());
    assert_eq!(answer.joint_velocity, unlimited.joint_velocity);
}
