//! Checks of an experiment that must hold, by its recordings. Each returns what is wrong, in words.

use revprio_api::wire::Solver;

use super::run::Run;
use crate::metrics::{differences, largest_difference};
use crate::number::significant;
use crate::simulator::Scenario;
use crate::simulator::recording::Recording;

/// Largest difference between the joint velocities of two solvers in the same scenario with the same method (rad/s). They
/// differ by rounding only, some 1e-12 rad/s, unless a solver is wrong.
pub const SOLVERS_AGREE: f64 = 1e-8;

/// Returns the scenarios without a complete run, and the pairs of solvers that differ by more than [`SOLVERS_AGREE`].
///
/// `scenarios`: the scenarios that must have been run, each with its method and solver. Every two solvers of a scenario and
/// method are compared.
#[must_use]
pub fn solver_differences(scenarios: &[Scenario], runs: &[Run]) -> Vec<String> {
    let runs: Vec<(&Scenario, Option<&Run>)> =
        scenarios.iter().map(|scenario| (scenario, find(scenario, runs))).collect();
    let incomplete = runs.iter().filter_map(|(scenario, run)| incompleteness(scenario, *run));
    let different = runs.iter().enumerate().flat_map(|(i, (scenario, run))| {
        let others = runs[i + 1..].iter().filter(|(other, _)| is_other_solver(scenario, other));
        others.filter_map(|(_, other)| difference((*run)?, (*other)?))
    });
    incomplete.chain(different).collect()
}

/// Returns the distribution of the differences between `auto` and another solver over all control periods of the same scenarios
/// and methods, in words; `None` without such runs.
#[must_use]
pub fn agreement(runs: &[Run], other: Solver) -> Option<String> {
    let of = |solver| runs.iter().filter(move |run| run.recording.solver == solver).map(|run| &run.recording);
    let is_same = |a: &Recording, b: &Recording| (&a.scenario, a.method) == (&b.scenario, b.method);
    let pairs = of(Solver::Auto).filter_map(|auto| Some((auto, of(other).find(|found| is_same(auto, found))?)));
    let mut all: Vec<f64> = pairs.flat_map(|(auto, found)| differences(auto, found)).collect();
    all.sort_by(f64::total_cmp);
    let last = all.len().checked_sub(1)?;
    let above = |bar: f64| all.iter().filter(|difference| **difference > bar).count();
    let share = |bar: f64| significant(100.0 * above(bar) as f64 / all.len() as f64, 2);
    Some(format!(
        "auto and {other}: median {}, 99 % {}, largest {} rad/s; > 1e-9, 1e-7, 1e-5: {}, {}, {} %",
        significant(all[last / 2], 2),
        significant(all[last - last / 100], 2),
        significant(all[last], 2),
        share(1e-9),
        share(1e-7),
        share(1e-5),
    ))
}

fn find<'a>(scenario: &Scenario, runs: &'a [Run]) -> Option<&'a Run> {
    let (name, controller) = (&scenario.name, &scenario.controller);
    runs.iter().map(|run| (run, &run.recording)).find_map(|(run, recording)| {
        let is_same =
            (&recording.scenario, recording.method, recording.solver) == (name, controller.method, controller.solver);
        is_same.then_some(run)
    })
}

fn is_other_solver(one: &Scenario, other: &Scenario) -> bool {
    (&one.name, one.controller.method) == (&other.name, other.controller.method)
        && one.controller.solver != other.controller.solver
}

/// Returns why a scenario has no complete run; `None` if each of its control periods has an answer.
fn incompleteness(scenario: &Scenario, run: Option<&Run>) -> Option<String> {
    let (name, method, solver) = (&scenario.name, scenario.controller.method, scenario.controller.solver);
    let answered = run.map(|run| run.recording.samples.iter().filter(|sample| sample.answered).count() as u64);
    let reason = match answered {
        None => "did not finish".to_owned(),
        Some(answered) if answered == scenario.cycles() => return None,
        Some(answered) => format!("has {answered} answers in {} control periods", scenario.cycles()),
    };
    Some(format!("{name}, {method}: the run of the solver {solver} {reason}"))
}

/// Returns how much two solvers differ; `None` if they agree.
fn difference(one: &Run, other: &Run) -> Option<String> {
    let difference = largest_difference(&one.recording, &other.recording);
    let (one, other) = (&one.recording, &other.recording);
    (difference > SOLVERS_AGREE).then(|| {
        format!(
            "{}, {}: the joint velocities of the solvers {} and {} differ by up to {} rad/s; at most {SOLVERS_AGREE:e} rad/s \
             are rounding",
            one.scenario,
            one.method,
            one.solver,
            other.solver,
            significant(difference, 2),
        )
    })
}

#[cfg(test)]
mod tests {
    use revprio_api::wire::Method;

    use super::*;
    use crate::simulator::recording::Sample;

    const SOLVERS: [Solver; 3] = [Solver::ClosedForm, Solver::Qp, Solver::Auto];

    /// One control period with each solver and these joint velocities (rad/s), and its scenarios.
    fn runs_with(velocities: [f64; 3]) -> (Vec<Scenario>, Vec<Run>) {
        let run = |(solver, velocity)| {
            let sample = Sample { joint_velocity: vec![velocity], ..Sample::at_rest() };
            let run = Run::of(Recording { solver, samples: vec![sample], ..Recording::empty() });
            let mut scenario = Scenario { duration_s: run.scenario.period_s(), ..run.scenario.clone() };
            (scenario.controller.method, scenario.controller.solver) = (Method::ReversePriority, solver);
            (scenario, run)
        };
        SOLVERS.into_iter().zip(velocities).map(run).unzip()
    }

    #[test]
    fn solvers_that_differ_by_rounding_agree() {
        let (scenarios, runs) = runs_with([0.1, 0.1 + 1e-12, 0.1 - 9e-9]);
        assert!(solver_differences(&scenarios, &runs).is_empty());
    }

    #[test]
    fn the_distribution_of_the_differences_is_stated() {
        let (_, runs) = runs_with([0.1, 0.1, 0.1 + 2e-8]);
        let line = agreement(&runs, Solver::Qp).unwrap();
        assert!(line.starts_with("auto and qp: median 2.0e-8, 99 % 2.0e-8, largest 2.0e-8"), "{line}");
        assert!(line.ends_with("> 1e-9, 1e-7, 1e-5: 100, 0, 0 %"), "{line}");
        assert_eq!(agreement(&runs[..2], Solver::Qp), None);
    }

    #[test]
    fn each_pair_of_solvers_that_differs_is_named_with_its_difference() {
        let (scenarios, runs) = runs_with([0.1, 0.1 + 2e-8, 0.1]);
        let wrong = solver_differences(&scenarios, &runs);
        let pairs = ["closed_form and qp", "qp and auto"];
        assert_eq!(wrong.len(), 2, "{wrong:?}");
        for (wrong, pair) in wrong.iter().zip(pairs) {
            let words = format!(
                "stiff_wall, reverse_priority: the joint velocities of the solvers {pair} differ by up to 2.0e-8"
            );
            assert!(wrong.starts_with(&words), "{wrong}");
        }
        // Each differs from the closed form by less than the bound, but not from each other.
        let (scenarios, runs) = runs_with([0.1, 0.1 + 6e-9, 0.1 - 6e-9]);
        assert!(solver_differences(&scenarios, &runs)[0].contains("qp and auto differ by up to 1.2e-8"));
    }

    #[test]
    fn solvers_that_command_nothing_differ_from_one_that_does() {
        let (scenarios, runs) = runs_with([0.1, 0.0, 0.1]);
        assert_eq!(solver_differences(&scenarios, &runs).len(), 2);
        let (scenarios, runs) = runs_with([0.1, f64::NAN, 0.1]);
        assert_eq!(solver_differences(&scenarios, &runs).len(), 2);
    }

    #[test]
    fn missing_runs_and_missing_answers_are_named() {
        let (scenarios, mut runs) = runs_with([0.1; 3]);
        runs[1].recording.samples[0].answered = false;
        runs.pop();
        let run = "stiff_wall, reverse_priority: the run of the solver";
        let wrong = [format!("{run} qp has 0 answers in 1 control periods"), format!("{run} auto did not finish")];
        assert_eq!(solver_differences(&scenarios, &runs), wrong);
    }

    #[test]
    fn runs_of_other_methods_and_scenarios_are_not_compared() {
        let (mut scenarios, mut runs) = runs_with([0.1, 0.2, 0.3]);
        (scenarios[1].controller.method, runs[1].recording.method) = (Method::TaskPriority, Method::TaskPriority);
        (scenarios[2].name, runs[2].recording.scenario) = ("other".to_owned(), "other".to_owned());
        assert!(solver_differences(&scenarios, &runs).is_empty());
    }
}
