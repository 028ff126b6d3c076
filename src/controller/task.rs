//! One task: its rows, its target, its law.

use nalgebra::{IsometryMatrix3, Rotation3, Vector3};

use super::null_space::mid_range_rate;
use crate::kinematics::{
    AxisSelection, Configuration, Frame, TaskFrame, Turning, half_range, joint_limit_gradient, orientation_error,
};
use crate::law::{Law, Profile, SetPoint, TaskState};
use crate::linalg::{Matrix, Vector};
use crate::robot::RobotModel;

/// One task with its law.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskConfig {
    /// Name, for people and answers.
    pub name: String,
    /// What the task is about.
    pub rows: TaskRows,
    /// How its velocity is made; as many rows as the task.
    pub law: Law,
}

/// What a task is about.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a few per controller, made once")]
pub enum TaskRows {
    /// Directions of the tool.
    Tool(ToolRows),
    /// Joints.
    Joints(JointRows),
}

/// Directions of the tool, at a point and along axes, and where it is to go.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolRows {
    /// The rows.
    pub axes: AxisSelection,
    /// Where and along which axes they count.
    pub frame: TaskFrame,
    /// X_d.
    pub target_pose: TargetPose,
    /// What is added to it, m rows, m and rad (rotation vector): along the axes of the frame, for those of the tool along
    /// the tool's axes in the target pose.
    pub target_displacement: Option<Profile>,
}

/// The pose that displacements ΔX are counted from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum TargetPose {
    /// Where the tool was at the first step.
    #[default]
    Initial,
    /// A pose of the reference point, parallel to the tool, m: in the stated frame where the task has one, else in the
    /// base.
    Fixed(IsometryMatrix3<f64>),
}

/// Joints, and where they are to go.
#[derive(Debug, Clone, PartialEq)]
pub struct JointRows {
    /// The joints, index from 0.
    pub joints: Vec<usize>,
    /// q_d.
    pub target: JointTarget,
}

/// Where joints are to go.
#[derive(Debug, Clone, PartialEq)]
pub enum JointTarget {
    /// To positions, rad or m, one row per joint.
    Position(Profile),
    /// To the middle of their ranges, along −∇H: the law's displacement is ∂H/∂q_i. Paper: Eq. (8).
    MidRange,
}

/// Why a task is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TaskConfigError {
    /// Law, target and rows differ in size.
    #[error("{given} values for {expected} rows; give one per row")]
    Rows {
        /// Rows of the task.
        expected: usize,
        /// Rows of the law or the target.
        given: usize,
    },
    /// Joints feel no force.
    #[error("joints take the laws velocity and position")]
    JointLaw,
    /// A joint that the robot does not have, stands twice, or has no middle.
    #[error("joints must exist and stand once; to be led to the middle of their ranges they need ranges")]
    Joints,
    /// From period to period the law would overshoot more than it corrects.
    #[error("a gain of {gain} overshoots from period to period; it must stay below {bound}")]
    Unstable {
        /// Row, from 0.
        row: usize,
        /// The gain.
        gain: f64,
        /// The smallest one that swings for ever.
        bound: f64,
    },
}

/// What all tasks of one period are seen against.
pub(super) struct Sensed<'a> {
    /// t, s.
    pub time_s: f64,
    pub robot: &'a RobotModel,
    pub configuration: &'a Configuration,
    /// q̇, n.
    pub joint_velocity: &'a [f64],
    /// Ẋ = J q̇, base axes, at the tool point.
    pub twist: [f64; 6],
    /// F_e on the environment, base axes, at the tool point.
    pub wrench: [f64; 6],
    /// Tool pose at the first step.
    pub initial_pose: IsometryMatrix3<f64>,
}

impl TaskConfig {
    /// Checks that the parts fit together, fit the robot, and settle at this period (s).
    pub(super) fn check(&self, robot: &RobotModel, period: f64) -> Result<(), TaskConfigError> {
        let expected = self.rows.len();
        let fits =
            |given: usize| if given == expected { Ok(()) } else { Err(TaskConfigError::Rows { expected, given }) };
        fits(self.law.rows())?;
        match &self.rows {
            TaskRows::Tool(rows) => fits(rows.target_displacement.as_ref().map_or(expected, Profile::rows))?,
            TaskRows::Joints(rows) => {
                rows.check(robot)?;
                if let JointTarget::Position(profile) = &rows.target {
                    fits(profile.rows())?;
                }
                if self.law.integrates() {
                    return Err(TaskConfigError::JointLaw);
                }
            }
        }
        self.check_gain(robot, period)
    }

    /// A displacement is multiplied by 1 − K T each period: |1 − K T| must be below 1, or equal for K = 0.
    fn check_gain(&self, robot: &RobotModel, period: f64) -> Result<(), TaskConfigError> {
        let Law::Position(law) = &self.law else { return Ok(()) };
        let rate = |row: usize| match &self.rows {
            TaskRows::Joints(JointRows { joints, target: JointTarget::MidRange }) => mid_range_rate(robot, joints[row]),
            _ => 1.0,
        };
        let bounds = (0..law.rows()).map(|row| 2.0 / (rate(row) * period));
        match bounds.zip(law.gain().iter()).enumerate().find(|(_, (bound, gain))| *gain >= bound) {
            Some((row, (bound, &gain))) => Err(TaskConfigError::Unstable { row, gain, bound }),
            None => Ok(()),
        }
    }
}

impl TaskRows {
    /// m, the number of rows.
    #[expect(clippy::len_without_is_empty, reason = "a task has at least one row")]
    pub fn len(&self) -> usize {
        match self {
            Self::Tool(rows) => rows.axes.len(),
            Self::Joints(rows) => rows.joints.len(),
        }
    }

    /// J_k, m × n.
    pub(super) fn jacobian(&self, configuration: &Configuration) -> Matrix {
        match self {
            Self::Tool(rows) => rows.axes.rows_of(&rows.frame.at(configuration).jacobian()),
            Self::Joints(rows) => {
                let n = configuration.joint_position().len();
                Matrix::from_fn(rows.joints.len(), n, |i, j| f64::from(u8::from(rows.joints[i] == j)))
            }
        }
    }

    /// J_k q̇, m, m/s and rad/s.
    pub(super) fn velocity(&self, sensed: &Sensed) -> Vector {
        match self {
            Self::Tool(rows) => rows.axes.entries_of(&rows.frame.at(sensed.configuration).twist(&sensed.twist)),
            Self::Joints(rows) => rows.entries_of(sensed.joint_velocity),
        }
    }

    /// What the law sees.
    pub(super) fn state(&self, sensed: &Sensed) -> TaskState {
        match self {
            Self::Tool(rows) => rows.state(self.velocity(sensed), sensed),
            Self::Joints(rows) => rows.state(self.velocity(sensed), sensed),
        }
    }
}

impl ToolRows {
    /// All rows along the base at the tool point, about the pose at the first step.
    pub fn new(axes: AxisSelection) -> Self {
        Self { axes, frame: TaskFrame::default(), target_pose: TargetPose::Initial, target_displacement: None }
    }

    fn state(&self, velocity: Vector, sensed: &Sensed) -> TaskState {
        let placed = self.frame.at(sensed.configuration);
        let rows = |[linear, angular]: [Vector3<f64>; 2]| self.axes.entries_of(&placed.components(linear, angular));
        let target = self.target(sensed);
        let actual = self.frame.pose(sensed.configuration.tool_pose());
        let displacement = [
            actual.translation.vector - target.pose.translation.vector,
            orientation_error(&actual.rotation, &target.pose.rotation),
        ];
        TaskState {
            time_s: sensed.time_s,
            velocity,
            displacement: rows(displacement),
            target_velocity: rows(target.velocity),
            target_acceleration: rows(target.acceleration),
            force: self.axes.entries_of(&placed.wrench(&sensed.wrench)),
        }
    }

    /// X_d with its derivatives.
    fn target(&self, sensed: &Sensed) -> MovingPose {
        let resting = match (self.target_pose, self.frame.frame) {
            (TargetPose::Initial, _) => self.frame.pose(&sensed.initial_pose),
            (TargetPose::Fixed(pose), Frame::Fixed(frame)) => frame * pose,
            (TargetPose::Fixed(pose), Frame::Base | Frame::Tool) => pose,
        };
        let Some(displacement) = &self.target_displacement else { return MovingPose::resting(resting) };
        let axes = match self.frame.frame {
            Frame::Base => Rotation3::identity(),
            Frame::Tool => resting.rotation,
            Frame::Fixed(frame) => frame.rotation,
        };
        MovingPose::displaced(&resting, &displacement.at(sensed.time_s), |entries| {
            let [x, y, z, rx, ry, rz] = self.axes.spread(entries);
            [axes * Vector3::new(x, y, z), axes * Vector3::new(rx, ry, rz)]
        })
    }
}

/// A pose with its derivatives, linear and angular, base axes.
struct MovingPose {
    pose: IsometryMatrix3<f64>,
    velocity: [Vector3<f64>; 2],
    acceleration: [Vector3<f64>; 2],
}

impl MovingPose {
    fn resting(pose: IsometryMatrix3<f64>) -> Self {
        Self { pose, velocity: [Vector3::zeros(); 2], acceleration: [Vector3::zeros(); 2] }
    }

    /// The pose moved by a displacement, which `vectors` makes linear and angular in base axes.
    fn displaced(
        pose: &IsometryMatrix3<f64>,
        displacement: &SetPoint,
        vectors: impl Fn(&Vector) -> [Vector3<f64>; 2],
    ) -> Self {
        let [moved, turned] = vectors(&displacement.value);
        let [linear_rate, angular_rate] = vectors(&displacement.rate);
        let [linear_acceleration, angular_acceleration] = vectors(&displacement.acceleration);
        let turning = Turning::new(turned, angular_rate, angular_acceleration);
        let position = pose.translation.vector + moved;
        Self {
            pose: IsometryMatrix3::from_parts(position.into(), turning.rotation * pose.rotation),
            velocity: [linear_rate, turning.velocity],
            acceleration: [linear_acceleration, turning.acceleration],
        }
    }
}

impl JointRows {
    fn check(&self, robot: &RobotModel) -> Result<(), TaskConfigError> {
        let ranged = |joint: usize| half_range(&robot.joints()[joint].limits).is_some();
        let sound = |(i, &joint): (usize, &usize)| {
            joint < robot.joint_count()
                && !self.joints[..i].contains(&joint)
                && (self.target != JointTarget::MidRange || ranged(joint))
        };
        let all = !self.joints.is_empty() && self.joints.iter().enumerate().all(sound);
        if all { Ok(()) } else { Err(TaskConfigError::Joints) }
    }

    fn entries_of(&self, joints: &[f64]) -> Vector {
        Vector::from_iterator(self.joints.len(), self.joints.iter().map(|&joint| joints[joint]))
    }

    fn state(&self, velocity: Vector, sensed: &Sensed) -> TaskState {
        let position = sensed.configuration.joint_position();
        let rest = Vector::zeros(velocity.len());
        let (displacement, target) = match &self.target {
            JointTarget::Position(profile) => {
                let target = profile.at(sensed.time_s);
                (self.entries_of(position) - &target.value, target)
            }
            JointTarget::MidRange => {
                let gradient = joint_limit_gradient(sensed.robot, position);
                (self.entries_of(gradient.as_slice()), SetPoint::resting(rest.clone()))
            }
        };
        TaskState {
            time_s: sensed.time_s,
            velocity,
            displacement,
            target_velocity: target.rate,
            target_acceleration: target.acceleration,
            force: rest,
        }
    }
}
