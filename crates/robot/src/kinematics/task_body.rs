//! The frame that a task moves, if it is not the tool seen from the base.

use nalgebra::{IsometryMatrix3, Vector3};

use super::{Configuration, LinkPoint};
use crate::{LinkId, Tip};

/// A frame that a link carries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyFrame {
    /// The link.
    pub link: LinkId,
    /// Pose of the frame in that of the link, m.
    pub offset: IsometryMatrix3<f64>,
}

impl BodyFrame {
    /// Returns its origin, seen from the base.
    pub fn origin(&self) -> LinkPoint {
        LinkPoint::new(self.link, self.offset.translation.vector)
    }

    /// Returns its pose in the base frame, m.
    fn pose(&self, configuration: &Configuration) -> IsometryMatrix3<f64> {
        configuration.link_pose(self.link) * self.offset
    }
}

impl From<LinkId> for BodyFrame {
    fn from(link: LinkId) -> Self {
        Self { link, offset: IsometryMatrix3::identity() }
    }
}

impl From<&Tip> for BodyFrame {
    fn from(tip: &Tip) -> Self {
        Self { link: tip.link, offset: tip.offset }
    }
}

/// The frame that a task moves, and the frame from which its motion is seen.
///
/// Poses, twists and Jacobians are those of [`Self::body`] in the frame [`Self::relative_to`], along its axes, as if that frame
/// stood still: a relative pose X = X_r⁻¹ X_b, and the rate of its change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TaskBody {
    /// The frame that moves.
    pub body: BodyFrame,
    /// The frame from which it is seen; `None`: the base.
    pub relative_to: Option<BodyFrame>,
}

impl TaskBody {
    /// Returns the pose X, m.
    ///
    /// # Panics
    ///
    /// Panics if the robot has no such link.
    pub fn pose(&self, configuration: &Configuration) -> IsometryMatrix3<f64> {
        let pose = self.body.pose(configuration);
        self.relative_to.map_or(pose, |frame| frame.pose(configuration).inv_mul(&pose))
    }

    /// Returns the twist Ẋ at the origin of the frame for joint velocities q̇ (n): m/s, then rad/s.
    pub(super) fn twist(&self, configuration: &Configuration, joint_velocity: &[f64]) -> [f64; 6] {
        let mut twist = [0.0; 6];
        for (joint, column) in self.columns(configuration) {
            twist.iter_mut().zip(column).for_each(|(entry, slope)| *entry += slope * joint_velocity[joint]);
        }
        twist
    }

    /// Returns the joints (index from 0) that move the frame, and what each adds to its column of the Jacobian. A joint that others mimic
    /// has several.
    pub(super) fn columns<'a>(
        &self,
        configuration: &'a Configuration,
    ) -> impl Iterator<Item = (usize, [f64; 6])> + use<'a> {
        let observer = self.relative_to.map(|frame| frame.pose(configuration).rotation);
        let seen = move |[a, b, c, d, e, f]: [f64; 6]| {
            let Some(rotation) = observer else { return [a, b, c, d, e, f] };
            let [linear, angular] =
                [Vector3::new(a, b, c), Vector3::new(d, e, f)].map(|vector| rotation.inverse_transform_vector(&vector));
            [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
        };
        configuration.point_columns(&self.point()).map(move |(joint, column)| (joint, seen(column)))
    }

    /// Returns the largest index of the links that it names.
    pub fn last_link(&self) -> LinkId {
        self.relative_to.map_or(self.body.link, |frame| frame.link.max(self.body.link))
    }

    fn point(&self) -> LinkPoint {
        let observer = self.relative_to.map_or(LinkId::BASE, |frame| frame.link);
        self.body.origin().relative_to(observer)
    }
}
