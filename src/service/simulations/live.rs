//! What a run shows while it goes on: a picture some twenty times a second, and samples for the curves.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use revprio_api::wire;
use revprio_core::controller::ControllerConfig;
use revprio_lab::simulator::Observed;
use tokio::sync::watch;

use crate::service::convert::{arm_view, finite, single};

/// Between two pictures.
const FRAME_TIME: Duration = Duration::from_millis(50);

/// Samples per picture, about.
const SAMPLES_PER_FRAME: u64 = 12;

/// Samples that are kept for readers that come late or read slowly: some five seconds.
const SAMPLES_KEPT: usize = 1200;

/// Bins of a time histogram: ten for each decade from 1 µs to 0.1 s, and those beyond.
const BINS: usize = 52;

/// The latest picture and the latest samples of one run.
pub struct Live {
    picture: watch::Sender<Arc<Picture>>,
    recent: Mutex<Recent>,
}

/// What is seen at one moment, without the samples that led to it.
#[derive(Clone)]
pub struct Picture {
    time_s: f64,
    done: u64,
    reached_speed: f64,
    external_force: [f64; 3],
    arm: wire::ArmView,
    paths: wire::PathCounts,
    solve_time: wire::TimeHistogram,
    round_trip: wire::TimeHistogram,
    cycle: Option<Arc<wire::StepRequest>>,
}

#[derive(Default)]
struct Recent {
    samples: VecDeque<Arc<wire::LiveSample>>,
    /// All that ever came.
    count: usize,
}

impl Live {
    /// Nothing has happened to the arm yet.
    pub fn new(arm: wire::ArmView) -> Self {
        let nothing = || wire::TimeHistogram { counts: vec![0; BINS], worst_us: 0.0 };
        let picture = Picture {
            time_s: 0.0,
            done: 0,
            reached_speed: 0.0,
            external_force: [0.0; 3],
            arm,
            paths: wire::PathCounts::default(),
            solve_time: nothing(),
            round_trip: nothing(),
            cycle: None,
        };
        Self { picture: watch::Sender::new(Arc::new(picture)), recent: Mutex::default() }
    }

    /// Hears of every picture.
    pub fn watch(&self) -> watch::Receiver<Arc<Picture>> {
        self.picture.subscribe()
    }

    /// The last period that was shown, as a request.
    pub fn cycle(&self) -> Option<wire::StepRequest> {
        self.picture.borrow().cycle.as_deref().cloned()
    }

    /// How many look.
    pub fn readers(&self) -> usize {
        self.picture.receiver_count()
    }

    /// Has the readers look again.
    pub fn touch(&self) {
        self.picture.send_modify(|_| ());
    }

    /// The picture with the samples that a reader has not seen, of which it has seen `seen`; counts those up.
    pub fn frame(&self, picture: &Picture, run: wire::Simulation, seen: &mut usize) -> wire::LiveFrame {
        let recent = self.recent.lock().unwrap_or_else(PoisonError::into_inner);
        let fresh = recent.count.saturating_sub(*seen).min(recent.samples.len());
        *seen = recent.count;
        let samples: Vec<_> = recent.samples.range(recent.samples.len() - fresh..).cloned().collect();
        drop(recent);
        wire::LiveFrame {
            run,
            time_s: picture.time_s,
            done: picture.done,
            reached_speed: picture.reached_speed,
            external_force: picture.external_force,
            arm: picture.arm.clone(),
            paths: picture.paths,
            solve_time: picture.solve_time.clone(),
            round_trip: picture.round_trip.clone(),
            samples: samples.iter().map(|sample| (**sample).clone()).collect(),
        }
    }

    fn keep(&self, sample: wire::LiveSample) {
        let mut recent = self.recent.lock().unwrap_or_else(PoisonError::into_inner);
        if recent.samples.len() == SAMPLES_KEPT {
            recent.samples.pop_front();
        }
        recent.samples.push_back(Arc::new(sample));
        recent.count += 1;
    }
}

/// Follows a run period by period and shows some of it.
pub struct Camera<'a> {
    live: &'a Live,
    config: &'a ControllerConfig,
    now: Picture,
    position: Vec<f64>,
    /// q̇ of the last command and of the one before it.
    velocity: [Vec<f64>; 2],
    waiting: Option<wire::LiveSample>,
    grouped: u64,
    group: u64,
    shown: Instant,
    shown_time_s: f64,
    shown_done: u64,
}

impl<'a> Camera<'a> {
    /// A run about to begin.
    pub fn new(live: &'a Live, config: &'a ControllerConfig) -> Self {
        let now = (**live.picture.borrow()).clone();
        Self {
            live,
            config,
            now,
            position: Vec::new(),
            velocity: [const { Vec::new() }; 2],
            waiting: None,
            grouped: 0,
            group: 1,
            shown: Instant::now(),
            shown_time_s: 0.0,
            shown_done: 0,
        }
    }

    /// Takes in a period, in which `external_force` (N) pushed.
    pub fn see(&mut self, done: u64, period: &Observed, external_force: [f64; 3]) {
        let Observed { sample, answer, round_trip, cycle } = period;
        self.now.cycle = cycle.map(|cycle| Arc::new(cycle.request()));
        count_path(&mut self.now.paths, sample.path);
        count_time(&mut self.now.solve_time, answer.elapsed_us);
        count_time(&mut self.now.round_trip, round_trip.as_secs_f64() * 1e6);
        self.now.time_s = sample.time_s + self.config.period_s;
        (self.now.done, self.now.external_force) = (done, external_force);
        self.position.clone_from(&sample.joint_position);
        self.velocity.swap(0, 1);
        self.velocity[1].clone_from(&sample.joint_velocity);
        let before = self.waiting.take();
        self.waiting = Some(live_sample(period, self.config, before.as_ref()));
        self.grouped += 1;
        if self.grouped >= self.group {
            self.keep();
        }
        if self.shown.elapsed() >= FRAME_TIME {
            self.show();
        }
    }

    fn keep(&mut self) {
        if let Some(sample) = self.waiting.take() {
            self.live.keep(sample);
        }
        self.grouped = 0;
    }

    /// Shows what is not shown yet.
    pub fn show(&mut self) {
        if self.now.done == self.shown_done {
            return;
        }
        self.keep();
        let seconds = self.shown.elapsed().as_secs_f64();
        self.now.reached_speed = (self.now.time_s - self.shown_time_s) / seconds.max(1e-9);
        self.group = ((self.now.done - self.shown_done) / SAMPLES_PER_FRAME).max(1);
        (self.shown, self.shown_time_s, self.shown_done) = (Instant::now(), self.now.time_s, self.now.done);
        let last = if self.velocity[0].is_empty() { &self.velocity[1] } else { &self.velocity[0] };
        if let Some(arm) = arm_view(self.config, &self.position, last) {
            self.now.arm = arm;
        }
        self.live.picture.send_replace(Arc::new(self.now.clone()));
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

/// A period for display; limits that were active since the sample before it count too.
fn live_sample(period: &Observed, config: &ControllerConfig, before: Option<&wire::LiveSample>) -> wire::LiveSample {
    let Observed { sample, answer, round_trip, .. } = period;
    let list = |values: &[f64]| values.iter().map(|&value| single([value])[0]).collect();
    let at = |side: wire::Side, earlier: Option<&Vec<usize>>| {
        let place = |name: &String| config.robot.joints().iter().position(|joint| joint.name == *name);
        let active = answer.active_limits.iter().filter(|limit| limit.side == side);
        let violated = answer.violated_limits.iter().filter(|limit| limit.side == side);
        let names = active.map(|limit| &limit.joint).chain(violated.map(|limit| &limit.joint));
        let mut joints: Vec<usize> = names.filter_map(place).chain(earlier.into_iter().flatten().copied()).collect();
        joints.sort_unstable();
        joints.dedup();
        joints
    };
    wire::LiveSample {
        time_s: sample.time_s,
        joint_position: list(&sample.joint_position),
        joint_velocity: list(&sample.joint_velocity),
        position: single(sample.position),
        force: single(sample.force),
        target_force: sample.target_force.map(|force| force.and_then(finite)),
        wall_distance_m: sample.wall_distance.and_then(finite),
        residual_norms: list(&sample.residual_norms),
        smallest_singular_value: single([sample.smallest_singular_value])[0],
        at_lower: at(wire::Side::Lower, before.map(|sample| &sample.at_lower)),
        at_upper: at(wire::Side::Upper, before.map(|sample| &sample.at_upper)),
        path: sample.path,
        status: sample.status,
        kkt_residual: sample.kkt_residual.and_then(finite),
        solve_us: single([answer.elapsed_us])[0],
        round_trip_us: single([round_trip.as_secs_f64() * 1e6])[0],
        answered: sample.answered,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_counted_in_bins_of_a_tenth_of_a_decade() {
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
