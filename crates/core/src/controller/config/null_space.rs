//! Which joint motion fills the null space of the tasks.

use revprio_robot::RobotModel;
use revprio_robot::kinematics::joint_limit_slopes;

use super::task::TaskConfig;
use crate::law::Law;
use crate::limits::Drive;
use crate::linalg::Vector;
use crate::rows::mid_range_rate;

/// The null-space velocity ζ̇: a joint velocity that the answer follows as far as the tasks permit.
#[derive(Debug, Clone, PartialEq)]
pub enum NullSpaceMotion {
    /// A constant velocity, n, rad/s or m/s.
    Constant(Vector),
    /// −k ∇H, towards the middle of the joints' ranges. Paper: Eq. (8).
    JointLimits {
        /// k, rad²/s or m²/s.
        gain: f64,
    },
    /// f K (q_d − p), towards a posture; p is the position of rest behind the drive, and f ≤ 1 brakes what of the
    /// motion is in the null space, as the laws `pose` and `posture` brake.
    Posture {
        /// q_d, n, rad or m.
        joint_position: Vec<f64>,
        /// K, 1/s.
        gain: f64,
    },
    /// f N K (q_0 − p), towards the posture of the first step in the null space of all tasks (projector N), with a norm of
    /// at most [`HOLDING_SPEED`]: on repeated paths the arm returns to the same postures. p and f are as for `Posture`. The
    /// motion fades out near singularities of the tasks, where N turns quickly with the posture.
    InitialPosture {
        /// K, 1/s.
        gain: f64,
    },
}

/// Maximum norm of [`NullSpaceMotion::InitialPosture`], rad/s and m/s. Postures drift along a circle of 10 cm in 5 s with
/// 0.03 rad/s. With the default gain joints need no more than 1 rad/s² to stop from it.
pub const HOLDING_SPEED: f64 = 0.5;

/// K of [`NullSpaceMotion::default_for`], 1/s, for drives that are fast enough: a drift decays to 5 % in 1.5 s.
const HOLDING_GAIN: f64 = 2.0;

/// K of [`NullSpaceMotion::default_for`] times the delay of the loop, for slow drives. A loop with a dead time does not
/// oscillate below 1/e.
const HOLDING_MARGIN: f64 = 1.0 / 3.0;

/// Why a null-space motion is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NullSpaceError {
    /// The motion does not have one finite number per joint.
    #[error("the null-space motion needs {expected} finite entries, one per joint")]
    Size {
        /// Joints of the robot.
        expected: usize,
    },
    /// The gain is negative or not finite.
    #[error("{0} is out of range; a gain must not be negative")]
    Gain(f64),
    /// With this gain and period the motion oscillates without decay.
    #[error("a gain of {gain} makes the motion unstable at this period; it must be below {bound}")]
    Unstable {
        /// The gain.
        gain: f64,
        /// The smallest unstable gain.
        bound: f64,
    },
}

impl NullSpaceMotion {
    /// Returns the motion of a controller that states none; `period_s`: T, s.
    ///
    /// A redundant arm whose tasks all follow positions returns to its initial posture; bounds may be among the tasks.
    /// Otherwise the arm rests in the null space (`None`).
    pub fn default_for(robot: &RobotModel, tasks: &[TaskConfig], drive: Drive, period_s: f64) -> Option<Self> {
        let mut equations = tasks.iter().filter(|task| task.law.bounds().is_none()).peekable();
        let follow = equations.peek().is_some() && equations.all(|task| matches!(task.law, Law::Position(_)));
        let delay = drive.time_to_rest(period_s) + period_s;
        let gain = HOLDING_GAIN.min(HOLDING_MARGIN / delay);
        (follow && is_redundant(robot, tasks)).then_some(Self::InitialPosture { gain })
    }

    /// Returns ζ̇ of the first step, at its posture (`joint_position`: q, n), n, rad/s or m/s.
    pub fn velocity(&self, robot: &RobotModel, joint_position: &[f64]) -> Vector {
        let mut velocity = Vector::zeros(robot.joint_count());
        self.write(robot, joint_position, joint_position, &mut velocity);
        velocity
    }

    /// Returns K of the motions that brake before a posture, 1/s.
    pub(in crate::controller) fn braking_gain(&self) -> Option<f64> {
        match self {
            Self::Posture { gain, .. } | Self::InitialPosture { gain } => Some(*gain),
            Self::Constant(_) | Self::JointLimits { .. } => None,
        }
    }

    /// Overwrites `velocity` with ζ̇ of an arm that stops at once in a posture (`joint_position`: q; `initial`: q_0), n
    /// each, rad/s or m/s. It does not brake, and that of [`Self::InitialPosture`] is neither projected nor limited.
    pub(in crate::controller) fn write(
        &self,
        robot: &RobotModel,
        joint_position: &[f64],
        initial: &[f64],
        velocity: &mut Vector,
    ) {
        match self {
            Self::Constant(constant) => velocity.copy_from(constant),
            Self::JointLimits { gain } => {
                let slopes = joint_limit_slopes(robot, joint_position);
                velocity.iter_mut().zip(slopes).for_each(|(speed, slope)| *speed = slope * -gain);
            }
            Self::Posture { joint_position: target, gain } => {
                for (speed, (target, q)) in velocity.iter_mut().zip(target.iter().zip(joint_position)) {
                    *speed = (target - q) * gain;
                }
            }
            Self::InitialPosture { gain } => {
                for (speed, (target, q)) in velocity.iter_mut().zip(initial.iter().zip(joint_position)) {
                    *speed = (target - q) * gain;
                }
            }
        }
    }

    /// Checks that the motion fits the robot and is stable at this period (s).
    pub(in crate::controller) fn check(&self, robot: &RobotModel, period: f64) -> Result<(), NullSpaceError> {
        let expected = robot.joint_count();
        let fits = |values: &[f64]| values.len() == expected && values.iter().all(|value| value.is_finite());
        let (gain, rate) = match self {
            Self::Constant(velocity) if fits(velocity.as_slice()) => return Ok(()),
            Self::Posture { joint_position, gain } if fits(joint_position) => (*gain, 1.0),
            Self::InitialPosture { gain } => (*gain, 1.0),
            Self::Constant(_) | Self::Posture { .. } => return Err(NullSpaceError::Size { expected }),
            Self::JointLimits { gain } => (*gain, (0..expected).map(|i| mid_range_rate(robot, i)).fold(0.0, f64::max)),
        };
        if !(gain.is_finite() && gain >= 0.0) {
            return Err(NullSpaceError::Gain(gain));
        }
        let bound = 2.0 / (rate * period);
        if gain < bound { Ok(()) } else { Err(NullSpaceError::Unstable { gain, bound }) }
    }
}

/// Returns whether an arm has more joints than its tasks have rows, and no task moves single joints.
pub(in crate::controller) fn is_redundant(robot: &RobotModel, tasks: &[TaskConfig]) -> bool {
    let equality = tasks.iter().filter(|task| task.law.bounds().is_none());
    let rows: usize = equality.map(|task| task.rows.len()).sum();
    rows < robot.joint_count() && tasks.iter().all(|task| task.rows.joints().is_empty())
}
