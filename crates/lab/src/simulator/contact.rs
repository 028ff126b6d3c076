//! What the tool touches, as a scenario says it.

use nalgebra::Vector3;
use revprio_api::wire::{Profile, object};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What kind of thing is touched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContactKind {
    /// Bilateral along an axis: pushes and pulls.
    Spring,
    /// Unilateral across an axis: no force without penetration, never pulling.
    Wall,
    /// The same across any direction.
    Plane,
}

/// A contact: F_e = M_e Ẍ + B_e Ẋ + K_e (X − X_0) along one direction, and friction across it.
///
/// Paper: Eq. (36). Departs: X_0, where the surface is, is not printed; it may move, and velocity and acceleration count
/// relative to it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Base axis of a spring or a wall: 0 = x, 1 = y, 2 = z.
    #[serde(default, with = "axis_name", skip_serializing_if = "Option::is_none")]
    #[schema(schema_with = axis_name::schema)]
    pub axis: Option<usize>,
    /// Direction out of a plane's material, base axes; of any length but zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f64; 3]>,
    /// What it is.
    pub kind: ContactKind,
    /// X_0 from the tool's start position, m: along the axis, where a wall with a negative offset stands in the negative
    /// direction; of a plane, the tool's way to it against the normal.
    #[serde(default)]
    pub offset_m: f64,
    /// Added to `offset_m` over time, m, one value.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub motion: Option<Profile>,
    /// K_e, N/m.
    pub stiffness: f64,
    /// B_e, N·s/m.
    #[serde(default)]
    pub damping: f64,
    /// M_e, kg.
    #[serde(default)]
    pub inertia: f64,
    /// Along a wall or a plane; none if left out.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
}

impl Contact {
    /// Part of K_e that is felt along a base axis: the square of the direction's component.
    pub fn share_along(&self, axis: usize) -> f64 {
        match (self.axis, self.normal) {
            (Some(own), _) => f64::from(u8::from(own == axis)),
            (None, Some(normal)) => {
                let length = Vector3::from(normal).norm();
                if length > 0.0 { (normal[axis] / length).powi(2) } else { 0.0 }
            }
            (None, None) => 0.0,
        }
    }
}

/// Friction of a tool with velocity v along a surface that it presses with F_n: (μ F_n/√(v² + v_s²) + B_t) v.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// μ.
    #[serde(default)]
    pub coulomb: f64,
    /// B_t, N·s/m, wherever the tool touches.
    #[serde(default)]
    pub viscous: f64,
    /// v_s, m/s: below it dry friction falls towards zero, so that a tool at rest feels none.
    #[serde(default = "slowest_slide")]
    pub sticking_speed_m_s: f64,
}

fn slowest_slide() -> f64 {
    1e-3
}

mod axis_name {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use utoipa::openapi::schema::{Object, ObjectBuilder, SchemaType, Type};

    const NAMES: [&str; 3] = ["x", "y", "z"];

    pub fn schema() -> Object {
        let words = ObjectBuilder::new().schema_type(SchemaType::Type(Type::String)).enum_values(Some(NAMES));
        words.description(Some("Base axis of a spring or a wall.")).build()
    }

    // serde hands over a reference.
    #[expect(clippy::ref_option)]
    pub fn serialize<S: Serializer>(axis: &Option<usize>, serializer: S) -> Result<S::Ok, S::Error> {
        axis.map(|axis| NAMES[axis]).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<usize>, D::Error> {
        let name = String::deserialize(deserializer)?;
        let axis = NAMES.iter().position(|known| *known == name);
        axis.map(Some).ok_or_else(|| Error::unknown_variant(&name, &NAMES))
    }
}
