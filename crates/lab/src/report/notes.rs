//! Remarks on the runs of a scenario, computed from the runs.

use revprio_api::wire::{Solver, Status};

use super::comparison::{MethodPair, REVERSE_PRIORITY};
use super::run::Run;
use super::time_series::MM;
use crate::metrics::{Metrics, largest_difference};
use crate::number::significant;
use crate::simulator::recording::{Recording, Sample};

/// Returns remarks on a scenario in which both methods of the paper were run; none otherwise.
#[must_use]
pub fn of_scenario(runs: &[Run]) -> Vec<String> {
    let Some(pair) = MethodPair::from_runs(runs) else { return Vec::new() };
    let mut notes = vec![comparison(&pair)];
    notes.extend(wall_contact(&pair));
    let with_solver =
        |solver| runs.iter().find(|run| run.recording.method == REVERSE_PRIORITY && run.recording.solver == solver);
    if let (Some(qp), Some(closed_form)) = (with_solver(Solver::Qp), with_solver(Solver::ClosedForm)) {
        notes.push(certificate(&qp.recording, &closed_form.recording));
    }
    notes
}

/// Returns the smallest σ_min of all task rows over a run.
fn min_sigma(run: &Recording) -> f64 {
    smallest(run.samples.iter().map(|sample| sample.smallest_singular_value))
}

fn comparison(pair: &MethodPair) -> String {
    let difference = significant(pair.difference(), 2);
    let [reverse_sigma, classical_sigma] = [pair.reverse, pair.classical].map(|run| min_sigma(&run.recording));
    if pair.coincide() {
        return format!(
            "Reverse priority and the classical control command the same joint velocities (largest difference \
             {difference} rad/s). The smallest singular value of all task rows stays at {} or above, so that nothing is \
             damped. With independent rows and without damping, both methods compute J⁺ẋ.",
            significant(classical_sigma, 3)
        );
    }
    let threshold = pair.classical.scenario.controller.damping.map(|damping| damping.threshold);
    let Some(threshold) = threshold.filter(|threshold| classical_sigma < *threshold) else {
        return format!(
            "Reverse priority and the classical control differ by up to {difference} rad/s, although nothing is damped. \
             Limits are active or tasks are in conflict."
        );
    };
    let rmse = match [pair.reverse, pair.classical].map(|run| Metrics::of(&run.recording).rmse_fx) {
        [Some(reverse), Some(classical)] => format!(
            " The RMSE of F_x is {} N with reverse priority and {} N with the classical control, {} times as much.",
            significant(reverse, 3),
            significant(classical, 3),
            significant(classical / reverse, 2)
        ),
        _ => String::new(),
    };
    format!(
        "The smallest singular value of all task rows falls to {} (reverse priority) and {} (classical control), below \
         the damping threshold of {threshold}. The classical control damps all rows. Reverse priority damps only the term \
         that protects the lower task. The primary task stays exact. The axes of the lower task move away from their \
         set-points.{rmse}",
        significant(reverse_sigma, 2),
        significant(classical_sigma, 2)
    )
}

fn wall_contact(pair: &MethodPair) -> Option<String> {
    let (reverse, classical) = (&pair.reverse.recording, &pair.classical.recording);
    reverse.samples.first()?.wall_distance?;
    if pair.coincide() {
        return Some(wall_run("With both methods", reverse));
    }
    let runs = [("With reverse priority", reverse), ("With the classical control", classical)];
    Some(runs.map(|(control, run)| wall_run(control, run)).join(" "))
}

fn wall_run(control: &str, run: &Recording) -> String {
    let metrics = Metrics::of(run);
    let error = |axis: usize| largest(run.samples.iter().map(|sample| sample.position_error[axis].abs()));
    let (y, z) = (significant(MM * error(1), 2), significant(MM * error(2), 2));
    let approach = if let (Some(contact), Some(force)) = (metrics.first_contact_s, metrics.final_force) {
        format!(
            "the tool touches the wall at {} s. The force peaks at {} N and ends at {} N; there are {} contacts.",
            significant(contact, 3),
            significant(metrics.peak_force, 3),
            significant(force, 8),
            metrics.contacts
        )
    } else {
        let distance = smallest(run.samples.iter().filter_map(|sample| sample.wall_distance));
        format!("the tool does not reach the wall and stays at least {} mm away.", significant(MM * distance, 2))
    };
    format!("{control}, {approach} The tool deviates by up to {y} mm in y and {z} mm in z.")
}

fn certificate(qp: &Recording, closed_form: &Recording) -> String {
    let optimal = |sample: &&Sample| sample.status == Status::Optimal;
    let certified = qp.samples.iter().filter(optimal).count();
    let residual = largest(qp.samples.iter().filter_map(|sample| sample.kkt_residual));
    format!(
        "The answer of the solver `qp` is certified optimal in {certified} of {} periods (largest KKT residual {}). It \
         differs from the closed form by at most {} rad/s.",
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
