//! The report of an experiment.

use revprio_api::wire::{Method, Solver};

use super::*;
use crate::simulator::recording::Sample;

/// A run at a wall in x with a constant force (N) and a constant speed of its joint (rad/s).
fn run(scenario: &str, method: Method, force: f64, velocity: f64) -> Run {
    let sample = |i: i32| Sample {
        time_s: 1e-3 * f64::from(i),
        joint_velocity: vec![velocity],
        force: [force, 0.0, 0.0],
        target_force: [Some(30.0), None, None],
        wall_distance: Some(if force > 0.0 { -1e-4 } else { 0.02 }),
        residual_norms: vec![0.0, 0.5],
        ..Sample::at_rest()
    };
    let samples = (0..200).map(sample).collect();
    let scenario = scenario.to_owned();
    Run::of(Recording { scenario, method, solver: Solver::ClosedForm, samples, ..Recording::empty() })
}

fn experiment(runs: Vec<Run>) -> Experiment {
    Experiment {
        title: "Title".to_owned(),
        question: vec!["Who?".to_owned()],
        command: "revprio compare".to_owned(),
        program: Program { version: "1.2.3".to_owned(), commit: Some("abc".to_owned()) },
        runs,
        failures: vec!["One did not finish.".to_owned()],
    }
}

#[test]
fn each_scenario_has_a_section_with_its_own_rows() {
    let methods = [Method::ReversePriority, Method::DampedLeastSquares];
    let runs = ["a", "b"].into_iter().flat_map(|name| methods.map(|method| run(name, method, 30.0, 0.1))).collect();
    let report = experiment(runs).report();
    assert_eq!(report.rows.len(), 4);
    let sections: Vec<_> = report.sections.iter().map(|section| (section.name.as_str(), section.rows.len())).collect();
    assert_eq!(sections, [("a", 2), ("b", 2)]);
    assert_eq!(report.introduction, ["Who?", "One did not finish."]);
    assert_eq!(report.sections[0].figures[0].name, "comparison_a");
}

#[test]
fn runs_with_the_same_commands_share_a_curve() {
    let runs = [(Method::ReversePriority, 0.1), (Method::TaskPriority, 0.1), (Method::DampedLeastSquares, 0.2)];
    let runs = runs.map(|(method, velocity)| run("mine", method, 30.0, velocity)).to_vec();
    let report = experiment(runs).report();
    let figure = &report.sections[0].figures[0];
    let labels: Vec<_> = figure.panels[0].curves.iter().map(|curve| curve.label.as_str()).collect();
    let shared = "reverse priority (closed form) = task priority (closed form)";
    assert_eq!(labels, [shared, "damped least squares (closed form)", "target"]);
    let headings: Vec<_> = figure.panels.iter().map(|panel| panel.heading.as_str()).collect();
    // The residual of task 1 is zero everywhere, so it has no panel.
    assert_eq!(headings[2..], ["(c) Residual of task 2", "(d) Speed of the fastest joint"]);
}

#[test]
fn claims_are_confirmed_only_where_the_methods_differ() {
    let verdicts = |classical_force, classical_velocity| -> Vec<&str> {
        let reverse = run("stiff_wall", Method::ReversePriority, 30.0, 0.1);
        let classical = run("stiff_wall", Method::DampedLeastSquares, classical_force, classical_velocity);
        experiment(vec![reverse, classical]).report().claims.iter().map(|claim| claim.verdict.as_str()).collect()
    };
    assert_eq!(verdicts(30.0, 0.1), ["confirmed", "no difference"]);
    assert_eq!(verdicts(0.0, 0.2), ["confirmed", "confirmed"]);
    assert_eq!(verdicts(30.0, 0.2), ["confirmed", "not confirmed"]);
}

#[test]
fn claims_are_not_judged_by_a_part_of_the_experiment() {
    let mut runs =
        [Method::ReversePriority, Method::DampedLeastSquares].map(|method| run("stiff_wall", method, 0.0, 0.1));
    runs[1].scenario.duration_s = 1.0;
    let claims = experiment(runs.to_vec()).report().claims;
    let results: Vec<_> = claims.iter().map(|claim| (claim.measured.as_str(), claim.verdict.as_str())).collect();
    assert_eq!(results, [("only the first 1 s of 5 s ran", "not judged"); 2]);
}

#[test]
fn scenarios_that_are_not_in_the_paper_have_no_claims() {
    let runs = vec![run("mine", Method::ReversePriority, 30.0, 0.1), run("mine", Method::DampedLeastSquares, 0.0, 0.2)];
    assert!(experiment(runs).report().claims.is_empty());
}

#[test]
fn a_changed_scenario_of_the_same_name_has_no_claims_and_no_figures_of_the_paper() {
    let report = |change: fn(&mut Run)| {
        let mut runs = [(Method::ReversePriority, 30.0), (Method::DampedLeastSquares, 0.0)]
            .map(|(method, force)| run("stiff_wall", method, force, 0.1));
        runs.iter_mut().for_each(change);
        let report = experiment(runs.to_vec()).report();
        let has_figure = |figure: &crate::report::figure::Figure| figure.name.starts_with("figure");
        (report.claims.len(), report.sections[0].figures.iter().any(has_figure))
    };
    assert_eq!(report(|_| ()), (2, true));
    assert_eq!(report(|run| run.scenario.contacts[0].stiffness = 1e4), (0, false));
    assert_eq!(report(|run| run.scenario.duration_s = 50.0), (0, false));
}
