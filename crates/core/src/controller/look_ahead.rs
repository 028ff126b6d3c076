//! The posture of the next period, at which planes hold.

use revprio_robot::kinematics::{Configuration, ConfigurationError};

use super::ControllerConfig;
use crate::limits::{Ahead, Barrier, JointMotion};

/// The workspace of a controller with planes: the arm at m = p + ½ T q̇⁻; see
/// [`Ahead`].
pub(super) struct LookAhead {
    configuration: Configuration,
    /// m, n.
    position: Vec<f64>,
    /// m − p, n.
    half_way: Vec<f64>,
}

impl LookAhead {
    /// Returns the workspace of a controller; `None` if it has no plane. `configuration`: of its robot, at any posture.
    pub fn new(config: &ControllerConfig, configuration: &Configuration) -> Option<Self> {
        let zeros = vec![0.0; config.robot.joint_count()];
        let has_planes = config.barriers.iter().any(|barrier| matches!(barrier, Barrier::Plane(_)));
        has_planes.then(|| Self { configuration: configuration.clone(), position: zeros.clone(), half_way: zeros })
    }

    /// Updates to a motion.
    pub fn update<'a>(
        &'a mut self,
        config: &ControllerConfig,
        motion: JointMotion<'a>,
    ) -> Result<Ahead<'a>, ConfigurationError> {
        for (joint, position) in self.position.iter_mut().enumerate() {
            self.half_way[joint] = 0.5 * config.period_s * motion.last_command[joint];
            *position = motion.position[joint] + motion.distance_to_rest[joint] + self.half_way[joint];
        }
        self.configuration.update(&config.robot, &self.position)?;
        Ok(Ahead { configuration: &self.configuration, half_way: &self.half_way, last_command: motion.last_command })
    }
}
