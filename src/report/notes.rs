//! What the runs of a scenario show, in words that are derived from the runs.

use super::Note;
use super::metrics::{Metrics, largest_difference};
use super::number::significant;
use super::paper_figures::{CLASSICAL, REVERSE_PRIORITY};
use crate::simulator::recording::{Recording, Sample};
use crate::wire::{Method, Solver, Status};

/// Commands that differ less (rad/s) count as the same.
const COINCIDE: f64 = 1e-9;

const MM: f64 = 1e3;

/// Remarks on each scenario for which both methods were run, in the order of the recordings.
pub fn of_recordings(recordings: &[Recording]) -> Vec<Note> {
    let mut scenarios: Vec<&str> = recordings.iter().map(|run| run.scenario.as_str()).collect();
    scenarios.dedup();
    scenarios.into_iter().filter_map(|scenario| note(scenario, recordings)).collect()
}

fn note(scenario: &str, recordings: &[Recording]) -> Option<Note> {
    let find = |method: Method, solver: Solver| {
        recordings.iter().find(|run| run.scenario == scenario && run.method == method && run.solver == solver)
    };
    let reverse = find(REVERSE_PRIORITY, Solver::ClosedForm)?;
    let classical = find(CLASSICAL, Solver::ClosedForm)?;
    let mut sentences = vec![comparison(reverse, classical)];
    sentences.extend(at_the_wall(reverse, classical));
    sentences.extend(find(REVERSE_PRIORITY, Solver::Qp).map(|qp| certificate(qp, reverse)));
    Some(Note { scenario: scenario.to_owned(), text: sentences.join(" ") })
}

fn comparison(reverse: &Recording, classical: &Recording) -> String {
    let difference = largest_difference(reverse, classical);
    let sigma = |run: &Recording| smallest(run.samples.iter().map(|sample| sample.smallest_singular_value));
    if difference <= COINCIDE {
        return format!(
            "Reverse priority and the classical control command the same joint velocities (largest difference {} rad/s): \
             the smallest singular value of all task rows stays at {} or above, out of reach of the damping, and with \
             independent rows and nothing damped both are J⁺ẋ.",
            significant(difference, 2),
            significant(sigma(classical), 3)
        );
    }
    let rmse = match (Metrics::of(reverse).rmse_fx, Metrics::of(classical).rmse_fx) {
        (Some(reverse), Some(classical)) => format!(
            " The RMSE of F_x is {} N with reverse priority and {} N with the classical control, {} times as much.",
            significant(reverse, 3),
            significant(classical, 3),
            significant(classical / reverse, 2)
        ),
        _ => String::new(),
    };
    format!(
        "The smallest singular value of all task rows falls to {} (reverse priority) and {} (classical), far into the \
         damping. The classical control damps all rows alike; reverse priority damps only how far the lower task is \
         spared, so that the primary one stays exact and \
         the lower one pays: its axes leave their set-points on the way.{rmse}",
        significant(sigma(reverse), 2),
        significant(sigma(classical), 2)
    )
}

fn at_the_wall(reverse: &Recording, classical: &Recording) -> Option<String> {
    reverse.samples.first()?.wall_distance?;
    if largest_difference(reverse, classical) <= COINCIDE {
        return Some(format!("{}.", wall_run("The tool", reverse)));
    }
    let runs = [("With reverse priority the tool", reverse), ("with the classical control it", classical)];
    Some(format!("{}.", runs.map(|(name, run)| wall_run(name, run)).join("; ")))
}

fn wall_run(name: &str, run: &Recording) -> String {
    let metrics = Metrics::of(run);
    let error = |axis: usize| largest(run.samples.iter().map(|sample| sample.position_error[axis].abs()));
    let (y, z) = (significant(MM * error(1), 2), significant(MM * error(2), 2));
    let given_up = format!("y and z leave their place by up to {y} and {z} mm");
    match (metrics.first_contact_s, metrics.final_force) {
        (Some(contact), Some(force)) => format!(
            "{name} touches the wall after {} s, peaks at {} N, makes {} contacts and ends at {} N, {given_up}",
            significant(contact, 3),
            significant(metrics.peak_force, 3),
            metrics.contacts,
            significant(force, 8)
        ),
        _ => format!("{name} does not reach the wall, {} mm short, {given_up}", significant(MM * shortfall(run), 2)),
    }
}

/// Smallest distance to the wall, m.
fn shortfall(run: &Recording) -> f64 {
    smallest(run.samples.iter().filter_map(|sample| sample.wall_distance))
}

fn certificate(qp: &Recording, closed_form: &Recording) -> String {
    let optimal = |sample: &&Sample| sample.status == Status::Optimal;
    let certified = qp.samples.iter().filter(optimal).count();
    let residual = largest(qp.samples.iter().filter_map(|sample| sample.kkt_residual));
    format!(
        "The QP cascade is certified optimal in {certified} of {} periods (largest KKT residual {}) and differs from the \
         closed form by at most {} rad/s.",
        qp.samples.len(),
        significant(residual, 2),
        significant(largest_difference(qp, closed_form), 2)
    )
}

fn smallest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::INFINITY, f64::min)
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}
