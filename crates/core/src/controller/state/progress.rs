//! How a task follows its requests over time.

/// How long the arm moves towards the middle of its ranges to leave a posture, s: eight time constants of that motion.
pub const LEAVING_TIME: f64 = 4.0;

/// The request below which a task has reached its target, m/s. A gain of 5/s requests it 1 mm before the target.
pub const REACHED: f64 = 5e-3;

/// The same, rad/s, for a lever of 0.2 m to 0.25 m.
pub const ANGULAR_REACHED: f64 = 2e-2;

/// How a task follows its requests over time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Filtered share of the requested velocity that the task achieves, 0 to 1.
    pub share: f64,
    /// Time since which the share is below one half, s; `None`: it is not.
    pub slow_since_s: Option<f64>,
    /// Time at which the arm began to leave the posture, s; `None`: it does not leave.
    pub leaving_since_s: Option<f64>,
    /// How often the arm has left since a target changed.
    pub attempts: u32,
    /// Distance of the task from its target when the arm left last, m and rad together; `None`: it has not left since a target changed.
    pub left_at: Option<f64>,
}

impl Progress {
    /// A task that follows its requests.
    pub const FREE: Self = Self { share: 1.0, slow_since_s: None, leaving_since_s: None, attempts: 0, left_at: None };

    /// Returns whether the numbers are finite and in their ranges.
    pub(in crate::controller) fn is_valid(&self) -> bool {
        let times = [self.slow_since_s, self.leaving_since_s, self.left_at];
        (0.0..=1.0).contains(&self.share) && times.iter().flatten().all(|time| time.is_finite())
    }

    /// Returns whether the arm leaves a posture at a time (s).
    pub(in crate::controller) fn is_leaving(&self, time: f64) -> bool {
        self.leaving_since_s.is_some_and(|since| (0.0..LEAVING_TIME).contains(&(time - since)))
    }
}
