//! A point that a link carries.

use nalgebra::Vector3;

use crate::LinkId;

/// A point that a link carries, and the link from which its motion is seen.
///
/// [`Configuration::point_pose`](super::Configuration::point_pose) and its neighbours compute pose, Jacobian and twist.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkPoint {
    /// The link that carries the point.
    pub link: LinkId,
    /// The point in the frame of the link, m.
    pub point: Vector3<f64>,
    /// The link from which its motion is seen; the base if nothing else is said.
    pub relative_to: LinkId,
}

impl LinkPoint {
    /// Returns the origin of a link's frame, seen from the base.
    pub fn origin(link: LinkId) -> Self {
        Self { link, point: Vector3::zeros(), relative_to: LinkId::BASE }
    }

    /// Returns a point of a link (in its frame, m), seen from the base.
    pub fn new(link: LinkId, point: Vector3<f64>) -> Self {
        Self { point, ..Self::origin(link) }
    }

    /// Returns the same point, seen from another link.
    #[must_use]
    pub fn relative_to(self, link: LinkId) -> Self {
        Self { relative_to: link, ..self }
    }
}
