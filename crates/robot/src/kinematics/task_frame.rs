//! The reference point and the axes of a task.

use std::borrow::Cow;

use nalgebra::{DMatrix, IsometryMatrix3, Rotation3, Vector3};

use super::{AxisSelection, BodyFrame, Configuration, Jacobian, TaskBody};
use crate::{RobotModel, Tip};

/// The axes along which the rows of a task are measured.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Frame {
    /// The axes of the base, or of the frame from which the body of the task is seen.
    #[default]
    Base,
    /// The axes of the tool, or of the body of the task, which turn with it. Displacements, velocities and forces of the task are measured
    /// along the present axes, even if the target rests in the base.
    Tool,
    /// The axes of a frame that is fixed in the base (m), or in the frame from which the body is seen.
    Fixed(IsometryMatrix3<f64>),
}

/// Body, reference point and axes of a task.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TaskFrame {
    /// The frame that moves; `None`: the tool, seen from the base.
    pub body: Option<TaskBody>,
    /// The axes.
    pub frame: Frame,
    /// The reference point in the frame of the tool or of the body, m; zero is its origin.
    pub reference_point: Vector3<f64>,
}

impl TaskFrame {
    /// Places the frame at a posture.
    pub fn at<'a>(&'a self, configuration: &'a Configuration) -> PlacedFrame<'a> {
        let body = self.body.as_ref();
        let rotation = body.map_or(configuration.tool_pose().rotation, |body| body.pose(configuration).rotation);
        let axes = match self.frame {
            Frame::Base => None,
            Frame::Tool => Some(rotation),
            Frame::Fixed(frame) => Some(frame.rotation),
        };
        let is_at_tool = self.reference_point.as_slice() == [0.0; 3];
        let lever = (!is_at_tool).then(|| rotation * self.reference_point);
        PlacedFrame { configuration, body, axes, lever }
    }

    /// Returns the index of the robot's tip that moves, seen from the base; `None`: another frame moves.
    pub fn tip(&self, robot: &RobotModel) -> Option<usize> {
        let Some(body) = &self.body else { return Some(0) };
        let is_body = |tip: &Tip| body.relative_to.is_none() && body.body == BodyFrame::from(tip);
        robot.tips().iter().position(is_body)
    }

    /// Returns the pose of the tool in the base frame, or of the body in the frame from which it is seen, m.
    pub fn body_pose(&self, configuration: &Configuration) -> IsometryMatrix3<f64> {
        self.body.map_or(*configuration.tool_pose(), |body| body.pose(configuration))
    }

    /// Returns the pose at the reference point, parallel to the frame of tool or body, for the pose of that frame, m.
    pub fn pose(&self, body_pose: &IsometryMatrix3<f64>) -> IsometryMatrix3<f64> {
        let mut pose = *body_pose;
        pose.translation.vector += body_pose.rotation * self.reference_point;
        pose
    }
}

/// A task frame at a posture. It converts twists, wrenches and the Jacobian to its point and axes.
///
/// Twist and wrench are converted together, so their product, the power, is the same in every frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedFrame<'a> {
    configuration: &'a Configuration,
    body: Option<&'a TaskBody>,
    /// Rotation from the frame's axes to the base axes; `None` for the base axes.
    axes: Option<Rotation3<f64>>,
    /// Vector from the tool point to the reference point, base axes, m; `None` at the tool point.
    lever: Option<Vector3<f64>>,
}

impl PlacedFrame<'_> {
    /// Returns J at the frame's point along its axes, 6 × n.
    pub fn jacobian(&self) -> Cow<'_, Jacobian> {
        let at_tool_point = self.configuration.jacobian();
        if let Some(body) = self.body {
            let mut jacobian = Jacobian::zeros(at_tool_point.ncols());
            for (joint, column) in body.columns(self.configuration) {
                let column = self.twist(&column);
                jacobian.column_mut(joint).iter_mut().zip(column).for_each(|(entry, add)| *entry += add);
            }
            return Cow::Owned(jacobian);
        }
        if self.is_at_tool_along_base() {
            return Cow::Borrowed(at_tool_point);
        }
        let mut jacobian = at_tool_point.clone();
        for mut column in jacobian.column_iter_mut() {
            let twist = self.twist(&std::array::from_fn(|row| column[row]));
            column.copy_from_slice(&twist);
        }
        Cow::Owned(jacobian)
    }

    /// Overwrites `rows`, m × n, with the selected rows of J.
    pub fn write_rows(&self, axes: &AxisSelection, rows: &mut DMatrix<f64>) {
        if let Some(body) = self.body {
            rows.fill(0.0);
            for (joint, column) in body.columns(self.configuration) {
                let twist = self.twist(&column);
                let entries = rows.column_mut(joint);
                entries.into_iter().zip(axes.axes()).for_each(|(entry, axis)| *entry += twist[axis.index()]);
            }
            return;
        }
        let (columns, _) = self.configuration.jacobian().as_slice().as_chunks();
        for (entries, column) in rows.as_mut_slice().chunks_exact_mut(axes.len()).zip(columns) {
            let converted;
            let twist = if self.is_at_tool_along_base() {
                column
            } else {
                converted = self.twist(column);
                &converted
            };
            entries.iter_mut().zip(axes.axes()).for_each(|(entry, axis)| *entry = twist[axis.index()]);
        }
    }

    /// Overwrites `products`, m × n, with the product of each row (m of them, for the linear part, then the angular one) and J.
    pub fn write_products(&self, rows: &[[f64; 6]], products: &mut DMatrix<f64>) {
        products.fill(0.0);
        let mut add = |joint: usize, column: &[f64; 6]| {
            let twist = self.twist(column);
            for (entry, row) in products.column_mut(joint).iter_mut().zip(rows) {
                *entry += row.iter().zip(twist).map(|(a, b)| a * b).sum::<f64>();
            }
        };
        if let Some(body) = self.body {
            body.columns(self.configuration).for_each(|(joint, column)| add(joint, &column));
        } else {
            let (columns, _) = self.configuration.jacobian().as_slice().as_chunks();
            columns.iter().enumerate().for_each(|(joint, column)| add(joint, column));
        }
    }

    /// Returns the frame with axes that are turned by a rotation, base axes.
    #[must_use]
    pub fn turned(self, rotation: Option<&Rotation3<f64>>) -> Self {
        let Some(rotation) = rotation else { return self };
        Self { axes: Some(self.axes.map_or(*rotation, |axes| rotation * axes)), ..self }
    }

    /// Returns the frame with the axes of another one.
    #[must_use]
    pub fn along_axes_of(self, other: &Self) -> Self {
        Self { axes: other.axes, ..self }
    }

    /// Converts a vector from the axes of this frame to base axes.
    pub fn to_base(&self, vector: &Vector3<f64>) -> Vector3<f64> {
        self.axes.map_or(*vector, |axes| axes * vector)
    }

    /// Returns whether nothing has to be converted.
    fn is_at_tool_along_base(&self) -> bool {
        self.axes.is_none() && self.lever.is_none()
    }

    /// Returns the twist of the body in this frame for joint velocities q̇ (n), m/s and rad/s; `None`: the frame is that of the tool.
    pub fn body_twist(&self, joint_velocity: &[f64]) -> Option<[f64; 6]> {
        self.body.map(|body| self.twist(&body.twist(self.configuration, joint_velocity)))
    }

    /// Converts a twist (m/s, rad/s) from base axes at the tool point to this frame: v + ω × r, ω.
    pub fn twist(&self, twist: &[f64; 6]) -> [f64; 6] {
        let (linear, angular) = split(twist);
        let linear = self.lever.map_or(linear, |lever| linear + angular.cross(&lever));
        join(self.along_axes(linear), self.along_axes(angular))
    }

    /// Converts a wrench (N, N·m) from base axes at the tool point to this frame: f, τ − r × f.
    pub fn wrench(&self, wrench: &[f64; 6]) -> [f64; 6] {
        let (force, torque) = split(wrench);
        let torque = self.lever.map_or(torque, |lever| torque - lever.cross(&force));
        join(self.along_axes(force), self.along_axes(torque))
    }

    /// Converts a linear and an angular vector from base axes to the axes of this frame.
    pub fn components(&self, linear: Vector3<f64>, angular: Vector3<f64>) -> [f64; 6] {
        join(self.along_axes(linear), self.along_axes(angular))
    }

    fn along_axes(&self, vector: Vector3<f64>) -> Vector3<f64> {
        self.axes.map_or(vector, |axes| axes.inverse_transform_vector(&vector))
    }
}

fn split([a, b, c, d, e, f]: &[f64; 6]) -> (Vector3<f64>, Vector3<f64>) {
    (Vector3::new(*a, *b, *c), Vector3::new(*d, *e, *f))
}

fn join(linear: Vector3<f64>, angular: Vector3<f64>) -> [f64; 6] {
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::built_in;

    const POSTURE: [f64; 7] = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];
    const TWIST: [f64; 6] = [0.3, -0.2, 0.5, 1.0, -0.4, 0.7];
    const WRENCH: [f64; 6] = [12.0, -7.0, 3.0, 0.4, 2.0, -1.5];

    fn configuration() -> Configuration {
        Configuration::new(&built_in()[0], &POSTURE).unwrap()
    }

    fn frames() -> Vec<TaskFrame> {
        let fixed = IsometryMatrix3::new(Vector3::new(0.5, 0.1, 0.2), Vector3::new(0.3, -1.0, 0.6));
        let mut frames = Vec::new();
        for frame in [Frame::Base, Frame::Tool, Frame::Fixed(fixed)] {
            for reference_point in [Vector3::zeros(), Vector3::new(0.05, -0.1, 0.3)] {
                frames.push(TaskFrame { frame, reference_point, ..TaskFrame::default() });
            }
        }
        frames
    }

    #[test]
    fn twist_and_wrench_have_the_same_power_in_every_frame() {
        let configuration = configuration();
        let power = |a: [f64; 6], b: [f64; 6]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for frame in frames() {
            let placed = frame.at(&configuration);
            let error = power(placed.twist(&TWIST), placed.wrench(&WRENCH)) - power(TWIST, WRENCH);
            assert!(error.abs() < 1e-13, "{frame:?}: {error:e}");
        }
    }

    #[test]
    fn the_jacobian_of_a_frame_gives_its_twist() {
        let configuration = configuration();
        let speeds = [0.1, -0.2, 0.05, 0.3, -0.1, 0.2, 0.4];
        for frame in frames() {
            let placed = frame.at(&configuration);
            let twist = placed.jacobian().as_ref() * nalgebra::DVector::from_row_slice(&speeds);
            for (row, speed) in placed.twist(&configuration.twist(&speeds)).into_iter().enumerate() {
                assert!((twist[row] - speed).abs() < 1e-15, "{frame:?}, row {row}");
            }
        }
    }

    #[test]
    fn the_jacobian_at_a_reference_point_equals_the_jacobian_of_a_longer_tool() {
        let point = Vector3::new(0.05, -0.1, 0.3);
        let longer = built_in()[0].with_tool_offset(&IsometryMatrix3::new(point, Vector3::zeros())).unwrap();
        let longer = Configuration::new(&longer, &POSTURE).unwrap();
        let frame = TaskFrame { reference_point: point, ..TaskFrame::default() };
        assert!((frame.at(&configuration()).jacobian().as_ref() - longer.jacobian()).amax() < 1e-14);
        assert!(
            (frame.pose(configuration().tool_pose()).to_homogeneous() - longer.tool_pose().to_homogeneous()).amax()
                < 1e-15
        );
    }

    #[test]
    fn the_jacobian_of_the_default_frame_equals_the_jacobian_of_the_configuration() {
        assert_eq!(*TaskFrame::default().at(&configuration()).jacobian(), *configuration().jacobian());
    }
}
