//! The live view of a run: a picture about 20 times a second, and samples for the plots.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use revprio_api::wire;
use tokio::sync::watch;

/// Number of samples that are kept for late or slow watchers: about five seconds.
const MAX_SAMPLES: usize = 1200;

/// Number of bins of a time histogram: ten per decade from 1 µs to 0.1 s, one below and one above.
pub const BINS: usize = 52;

/// The latest picture and the latest samples of one run.
pub struct LiveView {
    picture: watch::Sender<Arc<Picture>>,
    recent: Mutex<RecentSamples>,
}

/// The state of a run at one moment, without samples.
#[derive(Clone)]
pub struct Picture {
    pub(super) time_s: f64,
    pub(super) done: u64,
    pub(super) reached_speed: f64,
    pub(super) external_force: [f64; 3],
    pub(super) arm: wire::ArmView,
    pub(super) paths: wire::PathCounts,
    pub(super) solve_time: wire::TimeHistogram,
    pub(super) round_trip: wire::TimeHistogram,
    pub(super) cycle: Option<Arc<wire::StepRequest>>,
}

#[derive(Default)]
struct RecentSamples {
    samples: VecDeque<Arc<wire::LiveSample>>,
    /// Number of all samples since the start.
    count: usize,
}

impl LiveView {
    /// Creates the view of an arm before the first period.
    pub fn new(arm: wire::ArmView) -> Self {
        let empty = || wire::TimeHistogram { counts: vec![0; BINS], worst_us: 0.0 };
        let picture = Picture {
            time_s: 0.0,
            done: 0,
            reached_speed: 0.0,
            external_force: [0.0; 3],
            arm,
            paths: wire::PathCounts::default(),
            solve_time: empty(),
            round_trip: empty(),
            cycle: None,
        };
        Self { picture: watch::Sender::new(Arc::new(picture)), recent: Mutex::default() }
    }

    /// Subscribes to the pictures.
    pub fn watch(&self) -> watch::Receiver<Arc<Picture>> {
        self.picture.subscribe()
    }

    /// Returns the last shown period as a request.
    pub fn cycle(&self) -> Option<wire::StepRequest> {
        self.picture.borrow().cycle.as_deref().cloned()
    }

    /// Number of watchers.
    pub fn watchers(&self) -> usize {
        self.picture.receiver_count()
    }

    /// Sends the current picture again.
    pub fn notify_watchers(&self) {
        self.picture.send_modify(|_| ());
    }

    /// Returns a picture with the samples after the first `seen` samples, and updates `seen`.
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

    /// Returns the latest picture.
    pub fn picture(&self) -> Arc<Picture> {
        Arc::clone(&self.picture.borrow())
    }

    /// Publishes a picture.
    pub fn publish(&self, picture: Picture) {
        self.picture.send_replace(Arc::new(picture));
    }

    /// Adds a sample.
    pub fn push(&self, sample: wire::LiveSample) {
        let mut recent = self.recent.lock().unwrap_or_else(PoisonError::into_inner);
        if recent.samples.len() == MAX_SAMPLES {
            recent.samples.pop_front();
        }
        recent.samples.push_back(Arc::new(sample));
        recent.count += 1;
    }
}
