//! Reads a value that is written as a string or as an object.
//!
//! Its error texts name what is wrong. Untagged enums of serde say only "did not match any variant".

use std::fmt;
use std::marker::PhantomData;

use serde::Deserializer;
use serde::de::{Error, MapAccess, Visitor};

/// A value that is written as a string or as an object.
pub trait StringOrMap: Sized {
    /// What the text of an error names as expected.
    const EXPECTED: &'static str;

    /// Reads the value from a string.
    fn from_string<E: Error>(text: &str) -> Result<Self, E>;

    /// Reads the value from an object.
    fn from_map<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error>;
}

/// Reads the value from a string or an object.
pub fn deserialize<'de, D: Deserializer<'de>, T: StringOrMap>(deserializer: D) -> Result<T, D::Error> {
    deserializer.deserialize_any(StringOrMapVisitor(PhantomData))
}

struct StringOrMapVisitor<T>(PhantomData<T>);

impl<'de, T: StringOrMap> Visitor<'de> for StringOrMapVisitor<T> {
    type Value = T;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(T::EXPECTED)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<T, E> {
        T::from_string(text)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::from_map(map)
    }
}

/// Implements reading, writing and the schema of an enum that is written as one of several strings or as an object.
///
/// `TargetPose { Initial = "initial" } or Fixed(Pose), expected "…", "…"` writes `TargetPose::Initial` as `"initial"`,
/// and `TargetPose::Fixed` as the object of its `Pose`. The first text is what an error names as expected, the second
/// one is the description in the schema.
macro_rules! string_or_object {
    (
        $name:ident { $($variant:ident = $string:literal),+ } or $other:ident($object:ident),
        expected $expected:literal, $description:literal
    ) => {
        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                match self {
                    $(Self::$variant => serializer.serialize_str($string),)+
                    Self::$other(object) => object.serialize(serializer),
                }
            }
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                $crate::wire::string_or_map::deserialize(deserializer)
            }
        }

        impl $crate::wire::string_or_map::StringOrMap for $name {
            const EXPECTED: &'static str = $expected;

            fn from_string<E: serde::de::Error>(text: &str) -> Result<Self, E> {
                match text {
                    $($string => Ok(Self::$variant),)+
                    _ => Err(E::unknown_variant(text, &[$($string),+])),
                }
            }

            fn from_map<'de, A: serde::de::MapAccess<'de>>(map: A) -> Result<Self, A::Error> {
                $crate::wire::string_tags::from_map(map).map(Self::$other)
            }
        }

        impl utoipa::PartialSchema for $name {
            fn schema() -> utoipa::openapi::RefOr<utoipa::openapi::schema::Schema> {
                let strings = utoipa::openapi::schema::ObjectBuilder::new()
                    .schema_type(utoipa::openapi::schema::SchemaType::Type(utoipa::openapi::schema::Type::String))
                    .enum_values(Some([$($string),+]))
                    .description(Some("One of the fixed values."));
                let object = utoipa::openapi::Ref::from_schema_name(<$object as utoipa::ToSchema>::name());
                let either = utoipa::openapi::schema::OneOfBuilder::new().item(strings).item(object);
                either.description(Some($description)).into()
            }
        }

        impl utoipa::ToSchema for $name {
            fn schemas(schemas: &mut Vec<(String, utoipa::openapi::RefOr<utoipa::openapi::schema::Schema>)>) {
                let name = <$object as utoipa::ToSchema>::name().into_owned();
                schemas.push((name, <$object as utoipa::PartialSchema>::schema()));
                <$object as utoipa::ToSchema>::schemas(schemas);
            }
        }
    };
}

pub(super) use string_or_object;
