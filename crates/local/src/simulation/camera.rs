//! The camera of a run: it records periods and publishes pictures and samples.

use std::sync::Arc;
use std::time::Duration;

use revprio_api::clock::Instant;
use revprio_api::wire;
use revprio_core::controller::ControllerConfig;
use revprio_lab::simulator::Observed;

use super::live::{BINS, Picture};
use super::run_control::RunControl;
use crate::convert::{arm_view, finite, single};

/// Time between two pictures.
const FRAME_TIME: Duration = Duration::from_millis(50);

/// Approximate number of samples per picture.
const SAMPLES_PER_FRAME: u64 = 12;

/// Records a run period by period, and publishes pictures and samples of it.
pub struct Camera {
    run: Arc<RunControl>,
    now: Picture,
    position: Vec<f64>,
    /// Joint velocities q̇ of the previous command and of the last command.
    velocity: [Vec<f64>; 2],
    /// The sample of the current group of periods.
    pending: Option<wire::LiveSample>,
    /// Number of periods in the pending sample.
    pending_periods: u64,
    /// Number of periods per sample.
    periods_per_sample: u64,
    published: Instant,
    published_time_s: f64,
    published_done: u64,
}

impl Camera {
    /// Creates the camera of a run that is about to begin.
    pub fn new(run: Arc<RunControl>) -> Self {
        let now = (*run.live().picture()).clone();
        Self {
            run,
            now,
            position: Vec::new(),
            velocity: [const { Vec::new() }; 2],
            pending: None,
            pending_periods: 0,
            periods_per_sample: 1,
            published: Instant::now(),
            published_time_s: 0.0,
            published_done: 0,
        }
    }

    /// Records a period with this external force on the tool, N.
    pub fn record(&mut self, done: u64, period: &Observed, external_force: [f64; 3]) {
        let Observed { sample, answer, round_trip, cycle, .. } = period;
        self.now.cycle = cycle.map(|cycle| Arc::new(cycle.request()));
        count_path(&mut self.now.paths, sample.path);
        count_time(&mut self.now.solve_time, answer.elapsed_us);
        count_time(&mut self.now.round_trip, round_trip.as_secs_f64() * 1e6);
        self.now.time_s = sample.time_s + self.run.config().period_s;
        (self.now.done, self.now.external_force) = (done, external_force);
        self.position.clone_from(&sample.joint_position);
        self.velocity.swap(0, 1);
        self.velocity[1].clone_from(&sample.joint_velocity);
        let earlier = self.pending.take();
        self.pending = Some(live_sample(period, self.run.config(), earlier.as_ref()));
        self.pending_periods += 1;
        if self.pending_periods >= self.periods_per_sample {
            self.push_sample();
        }
        if self.published.elapsed() >= FRAME_TIME {
            self.publish();
        }
    }

    fn push_sample(&mut self) {
        if let Some(sample) = self.pending.take() {
            self.run.live().push(sample);
        }
        self.pending_periods = 0;
    }

    /// Publishes the periods since the last picture.
    pub fn publish(&mut self) {
        if self.now.done == self.published_done {
            return;
        }
        self.push_sample();
        let seconds = self.published.elapsed().as_secs_f64();
        self.now.reached_speed = (self.now.time_s - self.published_time_s) / seconds.max(1e-9);
        self.periods_per_sample = ((self.now.done - self.published_done) / SAMPLES_PER_FRAME).max(1);
        (self.published, self.published_time_s, self.published_done) = (Instant::now(), self.now.time_s, self.now.done);
        let last = if self.velocity[0].is_empty() { &self.velocity[1] } else { &self.velocity[0] };
        if let Some(arm) = arm_view(self.run.config(), &self.position, last) {
            self.now.arm = arm;
        }
        self.run.live().publish(self.now.clone());
    }
}

fn count_path(counts: &mut wire::PathCounts, path: wire::Path) {
    *match path {
        wire::Path::ClosedForm => &mut counts.closed_form,
        wire::Path::ActiveSet => &mut counts.active_set,
        wire::Path::Qp => &mut counts.qp,
    } += 1;
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and the number of bins")]
fn count_time(histogram: &mut wire::TimeHistogram, micros: f64) {
    let bin = (10.0 * micros.max(0.1).log10() + 1.0).floor().clamp(0.0, (BINS - 1) as f64) as usize;
    histogram.counts[bin] += 1;
    histogram.worst_us = histogram.worst_us.max(micros);
}

/// Returns the sample of a period. It includes the active limits of the `earlier` periods of the same sample.
fn live_sample(period: &Observed, config: &ControllerConfig, earlier: Option<&wire::LiveSample>) -> wire::LiveSample {
    let Observed { sample, obstacles, answer, round_trip, .. } = period;
    let list = |values: &[f64]| values.iter().map(|&value| single(value)).collect();
    let at = |side: wire::Side, earlier: Option<&Vec<usize>>| {
        let index = |name: &String| config.robot.joints().iter().position(|joint| joint.name == *name);
        let active = answer.active_limits.iter().filter(|limit| limit.side == side);
        let violated = answer.violated_limits.iter().filter(|limit| limit.side == side);
        let names = active.map(|limit| &limit.joint).chain(violated.map(|limit| &limit.joint));
        let mut joints: Vec<usize> = names.filter_map(index).chain(earlier.into_iter().flatten().copied()).collect();
        joints.sort_unstable();
        joints.dedup();
        joints
    };
    let mut active_inequalities = earlier.map_or_else(Vec::new, |sample| sample.active_inequalities.clone());
    active_inequalities.extend(answer.active_inequalities.iter().map(|inequality| inequality.name.clone()));
    active_inequalities.sort_unstable();
    active_inequalities.dedup();
    wire::LiveSample {
        time_s: sample.time_s,
        joint_position: list(&sample.joint_position),
        joint_velocity: list(&sample.joint_velocity),
        position: sample.position.map(single),
        orientation: sample.orientation.map(single),
        force: sample.force.map(single),
        target_force: sample.target_force.map(|force| force.and_then(finite)),
        wall_distance_m: sample.wall_distance.and_then(finite),
        residual_norms: list(&sample.residual_norms),
        task_residuals: answer.tasks.iter().map(residual).collect(),
        smallest_singular_value: single(sample.smallest_singular_value),
        at_lower: at(wire::Side::Lower, earlier.map(|sample| &sample.at_lower)),
        at_upper: at(wire::Side::Upper, earlier.map(|sample| &sample.at_upper)),
        active_inequalities,
        path: sample.path,
        status: sample.status,
        kkt_residual: sample.kkt_residual.and_then(finite),
        solve_us: single(answer.elapsed_us),
        round_trip_us: single(round_trip.as_secs_f64() * 1e6),
        answered: sample.answered,
        channels: answer.channels.iter().map(|(name, value)| (name.clone(), single(*value))).collect(),
        room: answer.collisions.clone().map(|report| wire::LiveRoom { report, obstacles: obstacles.to_vec() }),
        contacts: live_contacts(&answer.tasks),
        why: answer.why.clone(),
    }
}

/// Returns the contacts of all tasks.
fn live_contacts(tasks: &[wire::TaskOutcome]) -> Vec<wire::LiveContact> {
    let of_task = |(task, outcome): (usize, &wire::TaskOutcome)| {
        let contact = |(row, report): (usize, &wire::ContactReport)| wire::LiveContact {
            task,
            row,
            state: report.state,
            fault: report.fault,
            force: single(report.force),
            target_force: single(report.target_force),
            stiffness: report.stiffness.and_then(finite),
        };
        outcome.contact.iter().enumerate().map(contact).collect::<Vec<_>>()
    };
    tasks.iter().enumerate().flat_map(of_task).collect()
}

/// Returns achieved minus requested velocity of a task, per row.
fn residual(task: &wire::TaskOutcome) -> Vec<f32> {
    task.achieved.iter().zip(&task.requested).map(|(achieved, requested)| single(achieved - requested)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_histogram_has_ten_bins_per_decade() {
        let bin = |micros: f64| {
            let mut histogram = wire::TimeHistogram { counts: vec![0; BINS], worst_us: 0.0 };
            count_time(&mut histogram, micros);
            assert_eq!(histogram.worst_us, micros);
            histogram.counts.iter().position(|count| *count == 1).unwrap()
        };
        assert_eq!([0.0, 0.99, 1.0, 1.2, 1.26, 9.99, 10.0].map(bin), [0, 0, 1, 1, 2, 10, 11]);
        assert_eq!([99_999.0, 1e5, 1e9].map(bin), [50, 51, 51]);
    }
}
