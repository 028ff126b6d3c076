//! Schemas of the types with a hand-written `Deserialize`, which a derive cannot know.

use std::borrow::Cow;

use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, OneOfBuilder, Schema, SchemaType, Type};
use utoipa::openapi::{Ref, RefOr};
use utoipa::{PartialSchema, ToSchema};

use super::{Frame, JointVector, Pose, PostureTarget, Profile, TargetPose};

/// Implements the schema of a value that is one of several strings or an object.
macro_rules! string_or_object {
    ($($name:ident: $strings:expr, $object:ident, $description:expr;)+) => {$(
        impl PartialSchema for $name {
            fn schema() -> RefOr<Schema> {
                let strings = ObjectBuilder::new()
                    .schema_type(SchemaType::Type(Type::String))
                    .enum_values(Some($strings))
                    .description(Some("One of the fixed values."));
                let object = Ref::from_schema_name($object::name());
                OneOfBuilder::new().item(strings).item(object).description(Some($description)).into()
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

string_or_object! {
    TargetPose: ["initial"], Pose,
        "Target pose, from which displacements are measured: `initial` (the pose at the first step), or a pose of the \
         reference point (m, unit quaternion), in the task's `frame` if that is a pose, otherwise in the base frame.";
    Frame: ["base", "tool"], Pose,
        "Axes of a task: of the base, of the tool, or of a frame with this pose in the base (m, unit quaternion). In the \
         last case, target poses are given in that frame.";
    PostureTarget: ["mid_range"], Profile,
        "Target of the joints of a posture: `mid_range` (the middle of their ranges), or positions over time, one per \
         joint, rad or m.";
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

impl ToSchema for JointVector {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("JointVector")
    }
}
