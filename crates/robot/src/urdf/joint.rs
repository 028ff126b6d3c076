//! Reads one joint.

use nalgebra::{IsometryMatrix3, Vector3};
use roxmltree::Node;

use super::UrdfError;
use super::document::{Edge, child, numbers, pose};
use crate::tree_description::SHORTEST_AXIS;
use crate::{JointKind, JointLimits, JointMotion, LimitOverride, Mimic, TreeJoint, VelocityEnvelope};

const POSITION: &str = "\"position\": [lower, upper]";
const VELOCITY: &str = "\"velocity\": number";
const ACCELERATION: &str = "\"acceleration\": number";
const JERK: &str = "\"jerk\": number";
const SOFT_TAG: &str = "safety_controller";
const ENVELOPE_TAG: &str = "position_based_velocity_limits";
const ENVELOPE: &str = "\"velocity_envelope\": {\"deceleration_limit\": number, \"velocity_offset\": number}";

/// Which joints a robot may have.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Allowed {
    /// Those of a serial arm: each has its own position.
    InSerialArm,
    /// Mimic joints too.
    InTree,
}

/// Reads a joint; `stated` replaces limits of the text.
pub fn joint(edge: &Edge, stated: &LimitOverride, allowed: Allowed) -> Result<TreeJoint, UrdfError> {
    let reader = Reader { joint: edge.name, element: edge.element };
    let origin = reader.origin()?;
    let joint = |motion| {
        let [name, parent, child] = [edge.name, edge.parent, edge.child].map(str::to_owned);
        TreeJoint { name, parent, child, origin, motion }
    };
    let kind = match edge.element.attribute("type") {
        None => return Err(reader.missing("a type")),
        Some("fixed") => return Ok(joint(None)),
        Some(_) if edge.is_mimic() && allowed == Allowed::InSerialArm => return Err(reader.kind("mimic", allowed)),
        Some(name) => JointKind::from_urdf(name).ok_or_else(|| reader.kind(name, allowed))?,
    };
    let (axis, mimic) = (reader.axis()?, reader.mimic()?);
    let limits = reader.limits(stated, mimic.is_some())?;
    Ok(joint(Some(JointMotion { kind, axis, limits, mimic })))
}

/// Reads the pose of a joint's frame in that of its parent link, m.
pub fn origin(edge: &Edge) -> Result<IsometryMatrix3<f64>, UrdfError> {
    Reader { joint: edge.name, element: edge.element }.origin()
}

struct Reader<'a> {
    joint: &'a str,
    element: Node<'a, 'a>,
}

impl Reader<'_> {
    /// Reads the pose of the joint's frame in the parent link's frame: x y z; roll, pitch, yaw about fixed axes.
    fn origin(&self) -> Result<IsometryMatrix3<f64>, UrdfError> {
        let position = self.numbers("origin", "xyz")?.unwrap_or_default();
        let angles = self.numbers("origin", "rpy")?.unwrap_or_default();
        if child(self.element, "origin").is_some_and(|origin| origin.has_attribute("quat_xyzw")) {
            return Err(self.missing("its orientation as `rpy`; `quat_xyzw` is not supported"));
        }
        Ok(pose(position, angles))
    }

    /// Reads the axis, which may have any length but zero; x by default.
    fn axis(&self) -> Result<Vector3<f64>, UrdfError> {
        let axis = Vector3::from(self.numbers("axis", "xyz")?.unwrap_or([1.0, 0.0, 0.0]));
        let has_direction = axis.norm() > SHORTEST_AXIS;
        if has_direction { Ok(axis) } else { Err(UrdfError::Axis { joint: self.joint.to_owned() }) }
    }

    /// Reads which joint this one follows.
    fn mimic(&self) -> Result<Option<Mimic>, UrdfError> {
        let Some(mimic) = child(self.element, "mimic") else { return Ok(None) };
        let leader = mimic.attribute("joint").ok_or_else(|| self.missing("<mimic joint=\"…\"/>"))?.to_owned();
        let [multiplier] = self.numbers("mimic", "multiplier")?.unwrap_or([1.0]);
        let [offset] = self.numbers("mimic", "offset")?.unwrap_or([0.0]);
        Ok(Some(Mimic { leader, multiplier, offset }))
    }

    /// Reads the limits; `is_optional`: what the text lacks has no limit.
    fn limits(&self, stated: &LimitOverride, is_optional: bool) -> Result<JointLimits, UrdfError> {
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
            (None, _) => {
                let [lower, upper] = self.within_soft_limits([limit("lower", None)?, limit("upper", None)?])?;
                let without = |infinity: f64| is_optional.then_some(infinity);
                [lower.or(without(f64::NEG_INFINITY)), upper.or(without(f64::INFINITY))]
            }
        };
        let mut velocity = limit("velocity", stated.velocity)?;
        if is_optional || self.element.attribute("type") == Some("continuous") {
            velocity = velocity.or(Some(f64::INFINITY));
        }
        let (Some(lower), Some(upper)) = (lower, upper) else {
            return Err(self.limit("<limit> needs `lower` and `upper`, or the type must be `continuous`", POSITION));
        };
        let velocity = velocity.ok_or_else(|| self.limit("<limit> needs `velocity`", VELOCITY))?;
        let jerk = limit("jerk", stated.jerk)?.unwrap_or(f64::INFINITY);
        self.check(JointLimits { lower, upper, velocity, acceleration, jerk, envelope: self.envelope(stated)? })
    }

    /// Returns the part of a range that the soft limits leave: beyond them, a safety controller of the robot does not follow. Soft limits that
    /// leave none, as some programs write them, do not count.
    fn within_soft_limits(&self, range: [Option<f64>; 2]) -> Result<[Option<f64>; 2], UrdfError> {
        if child(self.element, SOFT_TAG).is_none() {
            return Ok(range);
        }
        let soft = |field| Ok::<_, UrdfError>(self.numbers(SOFT_TAG, field)?.map(|[value]: [f64; 1]| value));
        let (lower, upper) = (soft("soft_lower_limit")?, soft("soft_upper_limit")?);
        let within = match range {
            [Some(least), Some(most)] => {
                [lower.map_or(least, |soft| soft.max(least)), upper.map_or(most, |soft| soft.min(most))]
            }
            _ => return Ok(range),
        };
        Ok(if within[0] < within[1] { within.map(Some) } else { range })
    }

    /// Reads the velocity limits that shrink towards the ends of the range, an element of the URDF texts of Franka's arms.
    fn envelope(&self, stated: &LimitOverride) -> Result<VelocityEnvelope, UrdfError> {
        if let Some(stated) = stated.envelope {
            return Ok(stated);
        }
        if child(self.element, ENVELOPE_TAG).is_none() {
            return Ok(VelocityEnvelope::NONE);
        }
        let number = |field| Ok::<_, UrdfError>(self.numbers(ENVELOPE_TAG, field)?.map(|[value]: [f64; 1]| value));
        match (number("deceleration_limit")?, number("velocity_offset")?) {
            (Some(deceleration), Some(offset)) => Ok(VelocityEnvelope { deceleration, offset }),
            _ => {
                Err(self.limit(format!("<{ENVELOPE_TAG}> needs `deceleration_limit` and `velocity_offset`"), ENVELOPE))
            }
        }
    }

    /// Refuses limits that no motion obeys.
    fn check(&self, limits: JointLimits) -> Result<JointLimits, UrdfError> {
        let JointLimits { lower, upper, velocity, acceleration, jerk, envelope } = limits;
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
        if !envelope.is_valid() {
            let VelocityEnvelope { deceleration, offset } = envelope;
            let cause = format!(
                "the velocity envelope has the deceleration {deceleration}, which must be positive, and the offset {offset}, which must not be negative"
            );
            return Err(self.limit(cause, ENVELOPE));
        }
        if !limits.leaves_a_range() {
            let cause = format!(
                "its velocity envelope allows no motion nearer than {} to its ends, which leaves no range",
                envelope.margin()
            );
            return Err(self.limit(cause, ENVELOPE));
        }
        Ok(limits)
    }

    fn limit(&self, cause: impl Into<String>, remedy: &'static str) -> UrdfError {
        UrdfError::Limit { joints: vec![self.joint.to_owned()], cause: cause.into(), remedy }
    }

    /// Reads the numbers of an attribute of the joint's first child with this tag; `None` without the attribute.
    fn numbers<const N: usize>(&self, tag: &str, field: &'static str) -> Result<Option<[f64; N]>, UrdfError> {
        let Some(text) = child(self.element, tag).and_then(|node| node.attribute(field)) else { return Ok(None) };
        let error = || UrdfError::Number { joint: self.joint.to_owned(), field, text: text.to_owned(), count: N };
        numbers(text).map(Some).ok_or_else(error)
    }

    fn kind(&self, kind: &str, allowed: Allowed) -> UrdfError {
        let (joint, kind) = (self.joint.to_owned(), kind.to_owned());
        match allowed {
            Allowed::InSerialArm => UrdfError::Kind { joint, kind },
            Allowed::InTree => UrdfError::TreeKind { joint, kind },
        }
    }

    fn missing(&self, what: &'static str) -> UrdfError {
        UrdfError::Missing { joint: self.joint.to_owned(), what }
    }
}
