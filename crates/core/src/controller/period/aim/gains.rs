//! What the position tasks gain in a period.

use crate::controller::state::{Gained, RestState, TaskGain};
use crate::streaming::TargetValue;

/// What the position tasks gain in a period.
#[derive(Debug, Default)]
pub(in crate::controller::period) struct Gains {
    /// Σ g.
    pub earned: f64,
    /// Whether a target is another one.
    pub has_new_target: bool,
    /// Distance of each task from its target, m and rad together; 0 if it follows no position.
    pub distances: Vec<f64>,
    /// What each task has gained.
    pub tasks: Vec<Option<TaskGain>>,
}

impl Gains {
    /// Starts a period from what the tasks gained before it.
    pub(super) fn start(&mut self, previous: Option<&RestState>, tasks: usize) {
        (self.earned, self.has_new_target) = (0.0, previous.is_none());
        self.distances.clear();
        self.distances.resize(tasks, 0.0);
        self.tasks.resize(tasks, None);
        match previous {
            Some(rest) => self.tasks.clone_from(&rest.tasks),
            None => self.tasks.fill(None),
        }
    }

    /// Adds the task `k` with its displacement from the target (m and rad).
    pub(super) fn add(&mut self, k: usize, displacement: &[f64], target: TargetValue) {
        self.distances[k] = displacement.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        match TaskGain::update(&mut self.tasks[k], self.distances[k], target) {
            Gained::NewTarget => self.has_new_target = true,
            Gained::Earned(gain) => self.earned += gain,
        }
    }
}
