//! Contacts of the tool, as in a scenario.

use revprio_api::wire::{Profile, object};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Kind of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContactKind {
    /// Bilateral along an axis: it pushes and pulls.
    Spring,
    /// Unilateral, normal to an axis: it only pushes, and only under penetration.
    Wall,
    /// Unilateral, normal to any direction.
    Plane,
    /// Unilateral: the outside of a round bar along an axis.
    Cylinder,
    /// Unilateral: the outside of a ball.
    Sphere,
    /// Bilateral: a handle on a circle about a hinge, which the tool holds.
    Door,
}

/// A contact: F_e = M_e Ẍ + B_e Ẋ + K_e (X − X_0) along its normal, with friction along the surface.
///
/// Paper: Eq. (36). Departs: the paper does not print X_0, the position of the surface. It may move; velocity and
/// acceleration are relative to it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Base axis of a spring or a wall, along a cylinder, or of the hinge of a door: 0 = x, 1 = y, 2 = z.
    #[serde(default, with = "axis_name", skip_serializing_if = "Option::is_none")]
    #[schema(schema_with = axis_name::schema)]
    pub axis: Option<usize>,
    /// Normal of a plane, a cylinder or a sphere at the place that is nearest to the start position of the tool, out of the
    /// material, base axes; of any length except zero. For a door: from the hinge to the handle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<[f64; 3]>,
    /// Kind of contact.
    pub kind: ContactKind,
    /// X_0 relative to the start position of the tool, m, along the axis. A wall with a negative offset is in the negative
    /// direction. With a `normal`: the distance of the tool to the surface, against the normal.
    #[serde(default)]
    pub offset_m: f64,
    /// Radius of a cylinder or a sphere, or distance from the hinge of a door to its handle, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// Motion that is added to `offset_m`, m, one value.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub motion: Option<Profile>,
    /// Stiffness K_e, N/m.
    pub stiffness: f64,
    /// Damping B_e, N·s/m.
    #[serde(default)]
    pub damping: f64,
    /// Inertia M_e, kg.
    #[serde(default)]
    pub inertia: f64,
    /// Friction along a surface; none by default. A spring has no surface.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
    /// A hole in a plane for a peg at the tool; none by default.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub hole: Option<Hole>,
    /// An edge at which a plane ends; none by default.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub edge: Option<Edge>,
    /// What resists a door; nothing by default.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub hinge: Option<Hinge>,
}

/// A round hole for a round peg that stays upright. The tool point is the middle of its lower end.
///
/// A peg above the rim presses on the plane with its whole force. Where it is less deep in the side of the hole than in the plane, the
/// force is that of the side, towards the hole.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Hole {
    /// A point on the axis of the hole, relative to the start position of the tool, base axes, m.
    pub center: [f64; 3],
    /// Radius of the hole less that of the peg, m.
    pub clearance_m: f64,
    /// Depth of the hole, m.
    pub depth_m: f64,
}

/// A straight edge at which a plane ends, with a lower level beyond it. A peg presses on the plane until its whole lower end is beyond the
/// edge of a block: for a peg with a radius, `distance_m` is that to the edge, and its radius.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Edge {
    /// Direction from the plane over the edge, square to the normal, base axes; of any length except zero.
    pub direction: [f64; 3],
    /// Distance of the edge from the start position of the tool, along the direction, m.
    pub distance_m: f64,
    /// Depth of the lower level below the plane, m.
    pub depth_m: f64,
}

/// The hinge of a door with the angle θ: torque I θ̈ + b θ̇ and friction.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Hinge {
    /// Moment of inertia I of the door about the hinge, kg·m².
    pub inertia: f64,
    /// Damping b, N·m·s/rad.
    pub damping: f64,
    /// Torque of dry friction, N·m. The door does not move while the tool turns it with less.
    pub friction: f64,
}

/// Friction of a tool with velocity v along a surface that it presses with F_n: (μ F_n/√(v² + v_s²) + B_t) v.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// Coefficient μ of dry friction.
    #[serde(default)]
    pub coulomb: f64,
    /// Viscous friction B_t, N·s/m, during contact.
    #[serde(default)]
    pub viscous: f64,
    /// Speed v_s, m/s. Below it, dry friction decreases to zero, so that a tool at rest has none.
    #[serde(default = "default_sticking_speed")]
    pub sticking_speed_m_s: f64,
}

fn default_sticking_speed() -> f64 {
    1e-3
}

mod axis_name {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use utoipa::openapi::schema::{Object, ObjectBuilder, SchemaType, Type};

    const NAMES: [&str; 3] = ["x", "y", "z"];

    pub fn schema() -> Object {
        let words = ObjectBuilder::new().schema_type(SchemaType::Type(Type::String)).enum_values(Some(NAMES));
        words.description(Some("Base axis of a spring or a wall, along a cylinder, or of the hinge of a door.")).build()
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
