//! Measures how much damped commands jump, how steep they are, and what that costs: the tables of `docs/solver.md`.

use revprio_core::linalg::Damping;
use revprio_core::resolution::{Method, Problem, Solver, resolve};
use revprio_core::task::TaskStack;

use crate::smooth_paths::{FAMILIES, METHODS, Path, Step, Walk};

/// Steps along each path.
const STEPS: u32 = 1000;

/// Paths of each family and method.
const PATHS: u64 = 20;

/// How often steep paths are walked with steps that are eight times finer again.
const REFINEMENTS: usize = 3;

/// Halves a step 20 times and follows the half with the larger change: what remains is a jump.
fn jump_within(walk: &mut Walk, mut step: Step) -> f64 {
    for _ in 0..20 {
        let halves = walk.split(step, 2);
        step = if halves[0].change > halves[1].change { halves[0] } else { halves[1] };
    }
    step.change
}

/// What a walk shows.
#[derive(Default)]
struct Row {
    limited: u32,
    jumps: u32,
    /// Paths whose largest change is not four times smaller with steps that are eight times finer; then those of them for
    /// which this is so again from the finer steps on, and so forth.
    steep: [u32; REFINEMENTS],
    working_sets: u32,
    residuals: [f64; 4],
    changes: Vec<f64>,
    /// How much more than the limits force it to task 1 misses, where it is not singular itself.
    misses: Vec<f64>,
}

/// Returns how much more task 1 misses than within the limits alone; `None` for a task with bounds and near its own singularity.
fn miss(problem: &Problem) -> Option<f64> {
    let first = &problem.tasks.tasks()[0];
    let sigma = first.jacobian.clone().svd(false, false).singular_values.min();
    if !first.is_equation() || sigma < Damping::STANDARD.threshold() {
        return None;
    }
    let tasks = TaskStack::new(vec![first.clone()]).unwrap();
    let alone = Problem { tasks, method: Method::StrictReversePriority, damping: None, ..problem.clone() };
    let residual = |problem: &Problem| resolve(problem, &[]).unwrap().tasks[0].residual_norm;
    Some(residual(problem) - residual(&alone))
}

impl Row {
    fn add(&mut self, path: &Path) {
        let mut walk = Walk::new(path, Solver::Auto);
        let mut steps = walk.steps(STEPS);
        self.limited += walk.limited;
        self.misses.extend((0..200).filter_map(|step| miss(&path.problem(f64::from(step) / 200.0))));
        self.working_sets += walk.working_sets;
        for (sum, residual) in self.residuals.iter_mut().zip(walk.residuals) {
            *sum += residual;
        }
        self.changes.extend(steps.iter().map(|step| step.change));
        steps.sort_by(|a, b| b.change.total_cmp(&a.change));
        steps.truncate(4);
        self.jumps += u32::from(steps.iter().any(|&step| jump_within(&mut walk, step) > 1e-4));
        for steep in &mut self.steep {
            let coarse = steps[0].change;
            steps = steps.iter().flat_map(|&step| walk.split(step, 8)).collect();
            steps.sort_by(|a, b| b.change.total_cmp(&a.change));
            steps.truncate(4);
            if coarse < 1e-3 || steps[0].change <= coarse / 4.0 {
                break;
            }
            *steep += 1;
        }
    }

    fn print(&mut self, name: &str) {
        self.changes.sort_by(f64::total_cmp);
        let answers = self.changes.len() as f64;
        self.misses.sort_by(f64::total_cmp);
        let misses = self.misses.len() as f64;
        let miss = [self.misses.iter().sum::<f64>() / misses, self.misses[self.misses.len() * 99 / 100]];
        println!(
            "| {name} | {:.0} % | {} | {:?} | {:.3} | {:.4} | {:.2} | {:.3?} | {:.4?}, {:.1} % |",
            100.0 * f64::from(self.limited) / answers,
            self.jumps,
            self.steep,
            self.changes.last().unwrap(),
            self.changes[self.changes.len() * 99 / 100],
            f64::from(self.working_sets) / answers,
            self.residuals.map(|sum| sum / answers),
            miss,
            100.0 * self.misses.iter().filter(|&&miss| miss > 1e-6).count() as f64 / misses,
        );
    }
}

#[test]
#[ignore = "asserts nothing; prints the table of docs/solver.md"]
fn table_of_jumps() {
    println!("{PATHS} paths of {STEPS} steps each; changes in rad/s");
    println!(
        "| family | method | limited | jump | steep | largest change | 99 % | working sets | residuals of the tasks |"
    );
    for (family, method) in FAMILIES.into_iter().flat_map(|family| METHODS.map(|method| (family, method))) {
        if method == Method::TaskPriority {
            continue;
        }
        let mut row = Row::default();
        for seed in 0..PATHS {
            row.add(&Path::random(seed, method, family));
        }
        row.print(&format!("{family:?} | {method:?}"));
    }
}
