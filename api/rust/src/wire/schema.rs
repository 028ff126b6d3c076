//! Schemas of values that are read by hand, where no derive can know what is accepted.

use std::borrow::Cow;

use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, OneOfBuilder, Schema, SchemaType, Type};
use utoipa::openapi::{Ref, RefOr};
use utoipa::{PartialSchema, ToSchema};

use super::{Frame, JointVector, Pose, PostureTarget, Profile, TargetPose};

/// Implements the schema of a value that is one of some words or an object.
macro_rules! word_or_object {
    ($($name:ident: $words:expr, $object:ident, $description:expr;)+) => {$(
        impl PartialSchema for $name {
            fn schema() -> RefOr<Schema> {
                let words = ObjectBuilder::new()
                    .schema_type(SchemaType::Type(Type::String))
                    .enum_values(Some($words))
                    .description(Some("A word."));
                let object = Ref::from_schema_name($object::name());
                OneOfBuilder::new().item(words).item(object).description(Some($description)).into()
            }
        }

        impl ToSchema for $name {
            fn name() -> Cow<'static, str> {
                Cow::Borrowed(stringify!($name))
            }

            fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
                schemas.push(($object::name().into_owned(), $object::schema()));
                $object::schemas(schemas);
            }
        }
    )+};
}

word_or_object! {
    TargetPose: ["initial"], Pose,
        "The pose that displacements are counted from: `initial`, where the tool was at the first step, or a pose of the \
         reference point (m, unit quaternion), in the task's stated frame where it has one, else in the base.";
    Frame: ["base", "tool"], Pose,
        "Along which axes a task counts: those of the base, those of the tool, or those of a frame with this pose in the \
         base (m, unit quaternion); target poses are counted in such a frame.";
    PostureTarget: ["mid_range"], Profile,
        "Where a posture leads its joints: `mid_range`, the middle of their ranges, or positions over time, one per \
         joint, rad or m.";
}

impl PartialSchema for JointVector {
    fn schema() -> RefOr<Schema> {
        let number = |description| {
            ObjectBuilder::new().schema_type(SchemaType::Type(Type::Number)).description(Some(description))
        };
        let list = ArrayBuilder::new().items(number("Of one joint.")).description(Some("In the robot's joint order."));
        let named = ObjectBuilder::new()
            .schema_type(SchemaType::Type(Type::Object))
            .additional_properties(Some(Schema::Object(number("Of the joint of that name.").build())))
            .description(Some("By joint name, in any order, each once."));
        let description = "One number per joint of the robot, rad or m for positions, rad/s or m/s for velocities.";
        OneOfBuilder::new().item(list).item(named).description(Some(description)).into()
    }
}

impl ToSchema for JointVector {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("JointVector")
    }
}
