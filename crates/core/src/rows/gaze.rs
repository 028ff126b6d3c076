//! Rows that turn a direction of a body towards a point, as a camera looks at a part.
//!
//! Let a be the direction, u the unit vector from the reference point c to the target p, at the distance d, and b_1, b_2 orthogonal to a
//! and to each other. The rows are
//!
//! > b_i·(ω + u × ċ/d),
//!
//! the rate at which the body turns less the rate at which the line of sight turns while c moves. The displacement is −b_i·φ, where φ is
//! the rotation vector of the shortest turn from a to u. It is orthogonal to a, so both rows together have all of it, and a law that makes
//! the rows equal to k φ reduces the angle at the rate k at any angle.

use nalgebra::Vector3;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Configuration, TaskBody, TaskFrame};

use super::rows_error::RowsError;
use crate::arm_state::ArmAt;
use crate::law::{Law, Profile, TaskState, TaskVector};
use crate::linalg::Matrix;

/// Distance of a target below which the line of sight turns as at this distance, m. Nearer, small motions of the eye would turn it wildly.
const NEAREST: f64 = 0.1;

/// Number of rows: a line of sight turns about two axes.
const ROWS: usize = 2;

/// A direction of a body that looks at a point.
#[derive(Debug, Clone, PartialEq)]
pub struct GazeRows {
    /// Frame and point that look. Its axes are those of the base, or of the frame from which the body is seen; so is the target.
    frame: TaskFrame,
    /// a in the frame of the body, a unit vector.
    direction: Vector3<f64>,
    /// p over time, 3, m.
    target: Profile,
}

/// The line of sight at a posture.
struct Sight {
    /// b_1 and b_2.
    across: [Vector3<f64>; ROWS],
    /// u.
    line: Vector3<f64>,
    /// d, m, at least [`NEAREST`].
    distance: f64,
    /// φ, rad.
    turn: Vector3<f64>,
}

impl GazeRows {
    /// Builds rows that turn `direction`, of any length but zero, towards `target` (3, m). `body`: the frame that looks; `None`: the tool.
    /// `reference_point`: from where it looks, m. Direction and reference point are in the frame of the body.
    pub fn new(
        body: Option<TaskBody>,
        reference_point: Vector3<f64>,
        direction: Vector3<f64>,
        target: Profile,
    ) -> Result<Self, RowsError> {
        let direction = direction.try_normalize(1e-9).ok_or(RowsError::Direction)?;
        RowsError::unless_equal(3, target.rows())?;
        Ok(Self { frame: TaskFrame { body, reference_point, ..TaskFrame::default() }, direction, target })
    }

    /// Returns the number of rows.
    pub(super) fn count() -> usize {
        ROWS
    }

    /// Returns the target over time, 3, m.
    pub(super) fn target(&self) -> &Profile {
        &self.target
    }

    /// Returns the target point at the time of a posture, 3, m.
    pub(super) fn target_at(&self, at: ArmAt) -> TaskVector {
        let time_s = at.arm.profile_time(at.arm.known_time(&self.target, at.time_s));
        TaskVector::from_slice(&self.target.at(time_s).value)
    }

    /// Returns whether a body other than the tool looks, or looks at a point of another link than the base.
    pub(super) fn has_body(&self) -> bool {
        self.frame.body.is_some()
    }

    /// Checks that the robot has the links, and that a law can move the rows.
    pub(super) fn check(&self, robot: &RobotModel, law: &Law) -> Result<(), RowsError> {
        let is_known = |body: &TaskBody| body.last_link().index() < robot.links().len();
        if !self.frame.body.as_ref().is_none_or(is_known) {
            return Err(RowsError::Link);
        }
        if law.reads_wrench() { Err(RowsError::GazeLaw) } else { Ok(()) }
    }

    /// Overwrites `jacobian` with J_k, 2 × n.
    pub(super) fn write_jacobian(&self, at: ArmAt, jacobian: &mut Matrix) {
        let rows = self.sight(at).rows();
        self.frame.at(at.configuration).write_products(&rows, jacobian);
    }

    /// Returns J_k q̇, 2, rad/s.
    pub(super) fn velocity(&self, at: ArmAt) -> TaskVector {
        let placed = self.frame.at(at.configuration);
        let twist = placed.body_twist(&at.arm.joint_velocity).unwrap_or_else(|| placed.twist(&at.arm.twist));
        let rows = self.sight(at).rows();
        TaskVector::from_fn(ROWS, |row| rows[row].iter().zip(twist).map(|(entry, rate)| entry * rate).sum())
    }

    /// Returns the state for the law; `velocity`: J_k q̇, 2.
    pub(super) fn state(&self, velocity: TaskVector, at: ArmAt) -> TaskState {
        let sight = self.sight(at);
        let time_s = at.arm.profile_time(at.arm.known_time(&self.target, at.time_s));
        let rate = Vector3::from_column_slice(&self.target.at(time_s).rate);
        let turning = sight.line.cross(&rate) / sight.distance;
        let rows = |vector: Vector3<f64>| TaskVector::from_fn(ROWS, |row| sight.across[row].dot(&vector));
        TaskState {
            time_s: at.arm.profile_time(at.time_s),
            velocity,
            displacement: rows(-sight.turn),
            target_velocity: rows(turning),
            target_acceleration: TaskVector::zeros(ROWS),
            force: TaskVector::zeros(ROWS),
            streamed: None,
        }
    }

    /// Returns the line of sight at a posture.
    fn sight(&self, at: ArmAt) -> Sight {
        let target = self.target_at(at);
        self.sight_of(at.configuration, &Vector3::new(target[0], target[1], target[2]))
    }

    fn sight_of(&self, configuration: &Configuration, target: &Vector3<f64>) -> Sight {
        let pose = self.frame.pose(&self.frame.body_pose(configuration));
        let looks = pose.rotation * self.direction;
        let way = target - pose.translation.vector;
        let line = way.try_normalize(1e-9).unwrap_or(looks);
        // b_1 and b_2 turn with the body.
        let side = self.direction.cross(&Vector3::ith(self.direction.iamin(), 1.0)).normalize();
        let across = [side, self.direction.cross(&side)].map(|side| pose.rotation * side);
        let normal = looks.cross(&line);
        let angle = normal.norm().atan2(looks.dot(&line));
        // Opposite to the target, every turn is the shortest one.
        let turn = normal.try_normalize(1e-12).unwrap_or(across[0]) * angle;
        Sight { across, line, distance: way.norm().max(NEAREST), turn }
    }
}

impl Sight {
    /// Returns what each row takes of a twist: (b_i × u)/d of the linear part, b_i of the angular one.
    fn rows(&self) -> [[f64; 6]; ROWS] {
        self.across.map(|side| {
            let linear = side.cross(&self.line) / self.distance;
            [linear.x, linear.y, linear.z, side.x, side.y, side.z]
        })
    }
}
