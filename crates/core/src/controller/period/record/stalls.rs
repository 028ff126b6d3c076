//! Which joints do not follow their commands.

use crate::controller::config::ControllerConfig;
use crate::controller::state::{Memory, Stall, StalledJoint};

/// Time that a joint has to follow, in addition to that of its drive, s: at the lowest speed that counts it is commanded 25 mrad
/// (mm) then, far above noise.
const MIN_TIME: f64 = 0.5;

/// Updates the memory to the measured position of a state (q, n), and lists the joints that stall. All begin again if the state
/// does not come `in_time`. The memory is that before the command for this state.
pub(super) fn update(
    memory: &mut Memory,
    config: &ControllerConfig,
    joint_position: &[f64],
    in_time: bool,
    stalled: &mut Vec<StalledJoint>,
) {
    stalled.clear();
    let Memory { answered, stalls, drive, .. } = memory;
    let Some(answered) = answered.as_ref().filter(|_| in_time) else { return stalls.clear() };
    stalls.resize(joint_position.len(), Stall::NONE);
    let window = MIN_TIME + config.drive.time_to_rest(config.period_s);
    for (joint, stall) in stalls.iter_mut().enumerate() {
        let moved = joint_position[joint] - answered.joint_position[joint];
        if stall.update(drive.velocity[joint], moved, config.period_s, window) {
            stalled.push(StalledJoint { joint, stall: *stall });
        }
    }
}
