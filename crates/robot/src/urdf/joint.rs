//! Reads one joint of the chain.

use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Translation3, Vector3};
use roxmltree::Node;

use super::UrdfError;
use super::document::{Edge, child};
use crate::{Joint, JointKind, JointLimits, LimitOverride};

/// Maximum absolute value of a number, m or rad. An axis shorter than its inverse has no direction.
const MAX_NUMBER: f64 = 1e9;

const POSITION: &str = "\"position\": [lower, upper]";
const VELOCITY: &str = "\"velocity\": number";
const ACCELERATION: &str = "\"acceleration\": number";
const JERK: &str = "\"jerk\": number";

/// The part of the chain that a joint makes.
pub enum Segment {
    /// A constant transform.
    Fixed(IsometryMatrix3<f64>),
    /// A joint of the model.
    Moving(Box<Moving>),
}

/// A joint of the model, and the transform from its frame to the frame of the child link.
pub struct Moving {
    /// The joint; its `placement` is in the frame of the parent link.
    pub joint: Joint,
    pub after: IsometryMatrix3<f64>,
}

/// Reads a joint of the chain; `stated` replaces limits of the text.
pub fn segment(edge: &Edge, stated: &LimitOverride) -> Result<Segment, UrdfError> {
    let reader = Reader { joint: edge.name, element: edge.element };
    let origin = reader.origin()?;
    let kind = match edge.element.attribute("type") {
        None => return Err(reader.missing("a type")),
        Some("fixed") => return Ok(Segment::Fixed(origin)),
        Some(_) if edge.is_mimic() => return Err(reader.kind("mimic")),
        Some(name) => JointKind::from_urdf(name).ok_or_else(|| reader.kind(name))?,
    };
    let to_axis = rotation_from_z(&reader.axis()?);
    let joint = Joint {
        name: edge.name.to_owned(),
        kind,
        placement: origin * to_axis,
        limits: reader.limits(stated)?,
        published_range: None,
        denavit_hartenberg: None,
    };
    let after = IsometryMatrix3::from_parts(Translation3::identity(), to_axis.inverse());
    Ok(Segment::Moving(Box::new(Moving { joint, after })))
}

/// Returns a rotation that maps z to a direction of unit length.
///
/// It is free of rounding if the direction is an axis of the frame, and the identity for z itself.
fn rotation_from_z(direction: &Vector3<f64>) -> Rotation3<f64> {
    let across = if direction.y.abs() <= 0.8 { Vector3::y() } else { Vector3::z() };
    let x = across.cross(direction).normalize();
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, direction.cross(&x), *direction]))
}

struct Reader<'a> {
    joint: &'a str,
    element: Node<'a, 'a>,
}

impl Reader<'_> {
    /// Reads the pose of the joint's frame in the parent link's frame: x y z; roll, pitch, yaw about fixed axes.
    fn origin(&self) -> Result<IsometryMatrix3<f64>, UrdfError> {
        let [x, y, z] = self.numbers("origin", "xyz")?.unwrap_or_default();
        let [roll, pitch, yaw] = self.numbers("origin", "rpy")?.unwrap_or_default();
        if child(self.element, "origin").is_some_and(|origin| origin.has_attribute("quat_xyzw")) {
            return Err(self.missing("its orientation as `rpy`; `quat_xyzw` is not supported"));
        }
        let rotation = Rotation3::from_euler_angles(roll, pitch, yaw);
        Ok(IsometryMatrix3::from_parts(Translation3::new(x, y, z), rotation))
    }

    /// Reads the axis as a unit vector; x by default.
    fn axis(&self) -> Result<Vector3<f64>, UrdfError> {
        let axis = Vector3::from(self.numbers("axis", "xyz")?.unwrap_or([1.0, 0.0, 0.0]));
        axis.try_normalize(1.0 / MAX_NUMBER).ok_or_else(|| UrdfError::Axis { joint: self.joint.to_owned() })
    }

    fn limits(&self, stated: &LimitOverride) -> Result<JointLimits, UrdfError> {
        let limit = |field, stated: Option<f64>| match stated {
            Some(value) => Ok(Some(value)),
            None => Ok::<_, UrdfError>(self.numbers("limit", field)?.map(|[value]: [f64; 1]| value)),
        };
        let infinite = |field| limit(field, None).map(|value| value.unwrap_or(f64::INFINITY));
        let acceleration = match stated.acceleration {
            Some(value) => value,
            None => infinite("acceleration")?.min(infinite("deceleration")?),
        };
        let [lower, upper] = match (stated.position, self.element.attribute("type")) {
            (Some([lower, upper]), _) => [Some(lower), Some(upper)],
            (None, Some("continuous")) => [Some(f64::NEG_INFINITY), Some(f64::INFINITY)],
            (None, _) => [limit("lower", None)?, limit("upper", None)?],
        };
        let mut velocity = limit("velocity", stated.velocity)?;
        if self.element.attribute("type") == Some("continuous") {
            velocity = velocity.or(Some(f64::INFINITY));
        }
        let (Some(lower), Some(upper)) = (lower, upper) else {
            return Err(self.limit("<limit> needs `lower` and `upper`, or the type must be `continuous`", POSITION));
        };
        let velocity = velocity.ok_or_else(|| self.limit("<limit> needs `velocity`", VELOCITY))?;
        let jerk = limit("jerk", stated.jerk)?.unwrap_or(f64::INFINITY);
        self.check(JointLimits { lower, upper, velocity, acceleration, jerk })
    }

    /// Refuses limits that no motion obeys.
    fn check(&self, limits: JointLimits) -> Result<JointLimits, UrdfError> {
        let JointLimits { lower, upper, velocity, acceleration, jerk } = limits;
        let not_positive = |name: &str, value: f64| format!("the {name} limit {value} is not positive");
        if !(lower <= upper) {
            let cause = format!("the position range from {lower} to {upper} is empty");
            return Err(self.limit(cause, POSITION));
        }
        if !(velocity > 0.0) {
            return Err(self.limit(not_positive("velocity", velocity), VELOCITY));
        }
        if !(acceleration > 0.0) {
            return Err(self.limit(not_positive("acceleration", acceleration), ACCELERATION));
        }
        if !(jerk > 0.0) {
            return Err(self.limit(not_positive("jerk", jerk), JERK));
        }
        Ok(limits)
    }

    fn limit(&self, cause: impl Into<String>, remedy: &'static str) -> UrdfError {
        UrdfError::Limit { joints: vec![self.joint.to_owned()], cause: cause.into(), remedy }
    }

    /// Reads the numbers of an attribute of the joint's first child with this tag; `None` without the attribute.
    fn numbers<const N: usize>(&self, tag: &str, field: &'static str) -> Result<Option<[f64; N]>, UrdfError> {
        let Some(text) = child(self.element, tag).and_then(|node| node.attribute(field)) else { return Ok(None) };
        let number = |word: &str| word.parse().ok().filter(|value: &f64| value.abs() <= MAX_NUMBER);
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
        let numbers = numbers.and_then(|numbers| <[f64; N]>::try_from(numbers).ok());
        let error = || UrdfError::Number { joint: self.joint.to_owned(), field, text: text.to_owned(), count: N };
        numbers.map(Some).ok_or_else(error)
    }

    fn kind(&self, kind: &str) -> UrdfError {
        UrdfError::Kind { joint: self.joint.to_owned(), kind: kind.to_owned() }
    }

    fn missing(&self, what: &'static str) -> UrdfError {
        UrdfError::Missing { joint: self.joint.to_owned(), what }
    }
}
