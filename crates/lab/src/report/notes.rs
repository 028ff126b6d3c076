//! What the runs of a scenario show, in words that are derived from the runs.

use revprio_api::wire::{Method, Solver, Status};

use super::experiment::{COINCIDE, Run};
use super::metrics::{Metrics, largest_difference};
use super::number::significant;
use super::paper_figures::{CLASSICAL, REVERSE_PRIORITY};
use crate::simulator::recording::{Recording, Sample};

const MM: f64 = 1e3;

/// Remarks on a scenario for which both methods of the paper were run; none otherwise.
#[must_use]
pub fn of_scenario(runs: &[Run]) -> Vec<String> {
    let (Some(reverse), Some(classical)) = (of_method(runs, REVERSE_PRIORITY), of_method(runs, CLASSICAL)) else {
        return Vec::new();
    };
    let mut notes = vec![comparison(reverse, classical)];
    notes.extend(at_the_wall(&reverse.recording, &classical.recording));
    let with =
        |solver| runs.iter().find(|run| run.recording.method == REVERSE_PRIORITY && run.recording.solver == solver);
    if let (Some(qp), Some(closed_form)) = (with(Solver::Qp), with(Solver::ClosedForm)) {
        notes.push(certificate(&qp.recording, &closed_form.recording));
    }
    notes
}

/// The run of a method; of several solvers the closed form.
pub fn of_method(runs: &[Run], method: Method) -> Option<&Run> {
    let runs = runs.iter().filter(|run| run.recording.method == method);
    runs.min_by_key(|run| run.recording.solver != Solver::ClosedForm)
}

/// σ_min of all task rows, at its smallest.
fn sigma(run: &Recording) -> f64 {
    smallest(run.samples.iter().map(|sample| sample.smallest_singular_value))
}

fn comparison(reverse: &Run, classical: &Run) -> String {
    let difference = largest_difference(&reverse.recording, &classical.recording);
    let [lowest_reverse, lowest] = [reverse, classical].map(|run| sigma(&run.recording));
    if difference <= COINCIDE {
        return format!(
            "Reverse priority and the classical control command the same joint velocities (largest difference {} rad/s): \
             the smallest singular value of all task rows stays at {} or above, out of reach of the damping, and with \
             independent rows and nothing damped both are J⁺ẋ.",
            significant(difference, 2),
            significant(lowest, 3)
        );
    }
    let damped = classical.scenario.controller.damping.is_some_and(|damping| lowest < damping.threshold);
    if !damped {
        return format!(
            "Reverse priority and the classical control differ by up to {} rad/s, though nothing is damped: limits or \
             tasks in conflict part them.",
            significant(difference, 2)
        );
    }
    let rmse = match [reverse, classical].map(|run| Metrics::of(&run.recording).rmse_fx) {
        [Some(reverse), Some(classical)] => format!(
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
        significant(lowest_reverse, 2),
        significant(lowest, 2)
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
