//! Vectors of joints, and null-space velocities.

use std::fmt;

use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use utoipa::openapi::RefOr;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, OneOfBuilder, Schema, SchemaType, Type};
use utoipa::{PartialSchema, ToSchema};

use super::object;

/// One number per joint of the robot.
#[derive(Debug, Clone, PartialEq)]
pub enum JointVector {
    /// Values in the robot's joint order.
    Ordered(Vec<f64>),
    /// Values by joint name, in any order, each joint once.
    Named(Vec<(String, f64)>),
}

impl From<Vec<f64>> for JointVector {
    fn from(values: Vec<f64>) -> Self {
        Self::Ordered(values)
    }
}

impl Serialize for JointVector {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Ordered(values) => values.serialize(serializer),
            Self::Named(values) => serializer.collect_map(values.iter().map(|(name, value)| (name, value))),
        }
    }
}

impl<'de> Deserialize<'de> for JointVector {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(JointVectorVisitor)
    }
}

impl PartialSchema for JointVector {
    fn schema() -> RefOr<Schema> {
        let number = |description| {
            ObjectBuilder::new().schema_type(SchemaType::Type(Type::Number)).description(Some(description))
        };
        let list = ArrayBuilder::new()
            .items(number("Value of one joint."))
            .description(Some("Values in the robot's joint order."));
        let named = ObjectBuilder::new()
            .schema_type(SchemaType::Type(Type::Object))
            .additional_properties(Some(Schema::Object(number("Value of the joint with this name.").build())))
            .description(Some("Values by joint name, each joint once."));
        let description = "One number per joint of the robot, rad or m for positions, rad/s or m/s for velocities.";
        OneOfBuilder::new().item(list).item(named).description(Some(description)).into()
    }
}

impl ToSchema for JointVector {}

struct JointVectorVisitor;

impl<'de> Visitor<'de> for JointVectorVisitor {
    type Value = JointVector;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a list of numbers in joint order or an object of numbers by joint name")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<JointVector, A::Error> {
        let mut values = Vec::with_capacity(list.size_hint().unwrap_or(8).min(64));
        while let Some(value) = list.next_element()? {
            values.push(value);
        }
        Ok(JointVector::Ordered(values))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<JointVector, A::Error> {
        let mut values: Vec<(String, f64)> = Vec::new();
        while let Some(entry) = map.next_entry()? {
            values.push(entry);
        }
        match repeated(&values) {
            Some(name) => Err(Error::custom(format!("joint `{name}` is given twice"))),
            None => Ok(JointVector::Named(values)),
        }
    }
}

/// Returns a repeated name. It sorts the names, because comparing all pairs of 100 000 names would be slow.
fn repeated(values: &[(String, f64)]) -> Option<&str> {
    let mut names: Vec<&str> = values.iter().map(|(name, _)| name.as_str()).collect();
    names.sort_unstable();
    names.windows(2).find(|pair| pair[0] == pair[1]).map(|pair| pair[0])
}

/// The null-space velocity ζ̇: a constant, or a motion computed from the posture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(
    untagged,
    expecting = "expected joint velocities, as a list or by joint name, or `kind` `joint_limits` with `gain`, `kind` \
                 `posture` with `joint_position` and `gain`, `kind` `initial_posture` with `gain`, or `kind` `rest`"
)]
pub enum NullSpaceVelocity {
    /// A motion computed from the posture.
    Motion(#[serde(deserialize_with = "object::deserialize")] NullSpaceMotion),
    /// A constant velocity ζ̇, rad/s or m/s.
    Constant(JointVector),
}

/// A null-space velocity computed from the posture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum NullSpaceMotion {
    /// The velocity −k ∇H, away from the position limits, with the joint-limit index H.
    JointLimits {
        /// Gain k, rad²/s or m²/s. A larger one leaves the limits faster.
        gain: f64,
    },
    /// The velocity K (q_d − q), towards a posture.
    Posture {
        /// Target posture q_d, rad or m: a posture that works well, such as one with a raised elbow.
        joint_position: JointVector,
        /// Gain K, 1/s: within 1/K seconds the distance to the posture decreases to 37 %.
        gain: f64,
    },
    /// The part of K (q_0 − q) in the null space of all tasks, towards the posture of the first state, with a norm of at
    /// most 0.5 rad/s; only in controllers.
    InitialPosture {
        /// Gain K, 1/s: within 1/K seconds the distance to the posture decreases to 37 %.
        gain: f64,
    },
    /// Rest, ζ̇ = 0.
    Rest {},
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_and_objects_are_read_and_written_back() {
        for text in ["[1.0,2.0]", r#"{"j2":2.0,"j1":1.0}"#] {
            let vector: JointVector = serde_json::from_str(text).unwrap();
            assert_eq!(serde_json::to_string(&vector).unwrap(), text);
        }
    }

    #[test]
    fn a_joint_given_twice_and_other_types_are_refused() {
        let refusal = |text| serde_json::from_str::<JointVector>(text).unwrap_err().to_string();
        assert!(refusal(r#"{"j1":1.0,"j1":2.0}"#).contains("`j1` is given twice"));
        assert!(refusal("3.0").contains("a list of numbers in joint order"));
    }
}
