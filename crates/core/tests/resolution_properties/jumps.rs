//! Measures how much damped commands jump, how steep they are, and what that costs: the tables of `docs/solver.md`.

use revprio_core::resolution::Solver;

use crate::smooth_paths::{FAMILIES, METHODS, Path, Step, Walk};

/// Steps along each path.
const STEPS: u32 = 1000;

/// Paths of each family and method.
const PATHS: u64 = 20;

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
    /// Paths whose largest change is not four times smaller with steps that are eight times finer.
    steep: u32,
    working_sets: u32,
    residuals: [f64; 4],
    changes: Vec<f64>,
}

impl Row {
    fn add(&mut self, path: &Path) {
        let mut walk = Walk::new(path, Solver::Auto);
        let mut steps = walk.steps(STEPS);
        self.limited += walk.limited;
        self.working_sets += walk.working_sets;
        for (sum, residual) in self.residuals.iter_mut().zip(walk.residuals) {
            *sum += residual;
        }
        self.changes.extend(steps.iter().map(|step| step.change));
        steps.sort_by(|a, b| b.change.total_cmp(&a.change));
        let largest = &steps[..4];
        self.jumps += u32::from(largest.iter().any(|&step| jump_within(&mut walk, step) > 1e-4));
        let fine = largest.iter().flat_map(|&step| walk.split(step, 8)).fold(0.0_f64, |a, step| a.max(step.change));
        self.steep += u32::from(steps[0].change > 1e-3 && fine > steps[0].change / 4.0);
    }

    fn print(&mut self, name: &str) {
        self.changes.sort_by(f64::total_cmp);
        let answers = self.changes.len() as f64;
        println!(
            "| {name} | {:.0} % | {} | {} | {:.3} | {:.4} | {:.2} | {:.3?} |",
            100.0 * f64::from(self.limited) / answers,
            self.jumps,
            self.steep,
            self.changes.last().unwrap(),
            self.changes[self.changes.len() * 99 / 100],
            f64::from(self.working_sets) / answers,
            self.residuals.map(|sum| sum / answers)
        );
    }
}

#[test]
#[ignore = "a measurement"]
fn table_of_jumps() {
    println!("{PATHS} paths of {STEPS} steps each; changes in rad/s");
    println!(
        "| family | method | limited | jump | steep | largest change | 99 % | working sets | residuals of the tasks |"
    );
    for (family, method) in FAMILIES.into_iter().flat_map(|family| METHODS.map(|method| (family, method))) {
        let mut row = Row::default();
        for seed in 0..PATHS {
            row.add(&Path::random(seed, method, family));
        }
        row.print(&format!("{family:?} | {method:?}"));
    }
}
