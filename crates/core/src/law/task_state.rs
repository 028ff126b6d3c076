//! What a law reads, and the forces that it follows.

use revprio_robot::profile::Profile;
use smallvec::SmallVec;

use super::task_vector::TaskVector;

/// The measured state of one task: m entries each, along the axes of the task's frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TaskState {
    /// t, s.
    pub time_s: f64,
    /// Ẋ, measured velocity, m/s and rad/s.
    pub velocity: TaskVector,
    /// ΔX = X − X_d, displacement from the target, m and rad.
    pub displacement: TaskVector,
    /// Ẋ_d, velocity of the target, m/s and rad/s.
    pub target_velocity: TaskVector,
    /// Ẍ_d, acceleration of the target, m/s² and rad/s².
    pub target_acceleration: TaskVector,
    /// F_e, force and torque of the tool on the environment, N and N·m.
    pub force: TaskVector,
    /// Streamed values that replace the profile of the law: ẋ of the velocity law, F_d of the force and the hybrid law;
    /// `None`: the profile.
    pub streamed: Option<TaskVector>,
}

impl TaskState {
    /// Returns the streamed values, or those of the profile of the law.
    pub(super) fn set_point(&self, profile: &Profile) -> TaskVector {
        self.streamed.clone().unwrap_or_else(|| TaskVector::from_slice(&profile.at(self.time_s).value))
    }

    /// Returns ΔẊ = Ẋ − Ẋ_d, m/s and rad/s.
    pub fn relative_velocity(&self) -> TaskVector {
        &self.velocity - &self.target_velocity
    }
}

/// F_d per row, N and N·m; `None` on rows that follow no force.
pub type TargetForce = SmallVec<[Option<f64>; 8]>;
