//! What the position tasks gain in a period.

use crate::controller::state::{Gained, RestState, TaskGain};
use crate::law::TaskVector;
use crate::streaming::TargetValue;

/// What the position tasks gain in a period.
#[derive(Debug, Default)]
pub struct Gains {
    /// Σ g.
    pub earned: f64,
    /// Σ d, the ways of the targets, m and rad together.
    pub way: f64,
    /// Whether a target is another one.
    pub has_new_target: bool,
    /// Distance of each task from its target, m and rad together; 0 if it follows no position.
    pub distances: Vec<f64>,
    /// The target of each task in this period.
    targets: Vec<TargetValue>,
    /// What each task has gained.
    pub tasks: Vec<Option<TaskGain>>,
}

impl Gains {
    /// Starts a period from what the tasks gained before it.
    pub(super) fn start(&mut self, previous: Option<&RestState>, tasks: usize) {
        (self.earned, self.way, self.has_new_target) = (0.0, 0.0, previous.is_none());
        self.distances.clear();
        self.distances.resize(tasks, 0.0);
        self.targets.resize(tasks, TargetValue::Rows(TaskVector::zeros(0)));
        self.tasks.resize(tasks, None);
        match previous {
            Some(rest) => self.tasks.clone_from(&rest.tasks),
            None => self.tasks.fill(None),
        }
    }

    /// Adds the task `k` with its displacement from the target (m and rad); `write_target` overwrites its target.
    pub(super) fn add(&mut self, k: usize, displacement: &[f64], write_target: impl FnOnce(&mut TargetValue)) {
        self.distances[k] = displacement.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        write_target(&mut self.targets[k]);
        match TaskGain::update(&mut self.tasks[k], self.distances[k], &self.targets[k]) {
            Gained::NewTarget => self.has_new_target = true,
            Gained::Earned { gain, way } => (self.earned, self.way) = (self.earned + gain, self.way + way),
        }
    }
}
