//! The page of an experiment holds what its runs say.

use revprio_api::wire::{Method, Solver};

use super::*;
use crate::simulator::recording::Sample;

/// A run in contact with a wall in x, one sample per period, that ends at this force and moves a joint so fast.
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
fn every_scenario_has_a_section_with_its_own_rows() {
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
fn runs_that_command_the_same_share_a_curve_of_the_comparison() {
    let runs = [(Method::ReversePriority, 0.1), (Method::TaskPriority, 0.1), (Method::DampedLeastSquares, 0.2)];
    let runs = runs.map(|(method, velocity)| run("mine", method, 30.0, velocity)).to_vec();
    let report = experiment(runs).report();
    let figure = &report.sections[0].figures[0];
    let labels: Vec<_> = figure.panels[0].curves.iter().map(|curve| curve.label.as_str()).collect();
    let shared = "reverse priority (closed form) = task priority (closed form)";
    assert_eq!(labels, [shared, "damped least squares (closed form)", "target"]);
    let headings: Vec<_> = figure.panels.iter().map(|panel| panel.heading.as_str()).collect();
    assert!(
        headings.contains(&"(c) What task 1 lacks") && headings.contains(&"(e) Speed of the fastest joint"),
        "{headings:?}"
    );
}

#[test]
fn a_claim_is_seen_where_the_methods_differ_and_only_there() {
    let verdicts = |classical_force, classical_velocity| -> Vec<&str> {
        let reverse = run("stiff_wall", Method::ReversePriority, 30.0, 0.1);
        let classical = run("stiff_wall", Method::DampedLeastSquares, classical_force, classical_velocity);
        experiment(vec![reverse, classical]).report().claims.iter().map(|claim| claim.verdict.words()).collect()
    };
    assert_eq!(verdicts(30.0, 0.1), ["seen", "no difference here"]);
    assert_eq!(verdicts(0.0, 0.2), ["seen", "seen"]);
    assert_eq!(verdicts(30.0, 0.2), ["seen", "not seen"]);
}

#[test]
fn a_scenario_that_is_not_the_papers_makes_no_claim() {
    let runs = vec![run("mine", Method::ReversePriority, 30.0, 0.1), run("mine", Method::DampedLeastSquares, 0.0, 0.2)];
    assert!(experiment(runs).report().claims.is_empty());
}
