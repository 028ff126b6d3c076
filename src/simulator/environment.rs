//! What the tool touches: Eq. (36) on each axis.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Whether a contact also pulls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContactKind {
    /// Bilateral: pushes and pulls.
    Spring,
    /// Unilateral: no force without penetration, never pulling.
    Wall,
}

/// A contact on one axis: F_e = M_e Ẍ + B_e Ẋ + K_e (X − X_0).
///
/// Paper: Eq. (36). Departs: X_0, where the surface is, is not printed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Base axis: 0 = x, 1 = y, 2 = z.
    #[serde(with = "axis_name")]
    #[schema(schema_with = axis_name::schema)]
    pub axis: usize,
    /// Whether it also pulls.
    pub kind: ContactKind,
    /// X_0 from the tool's start position, m. A wall with a negative offset stands in the negative direction.
    #[serde(default)]
    pub offset_m: f64,
    /// K_e, N/m.
    pub stiffness: f64,
    /// B_e, N·s/m.
    #[serde(default)]
    pub damping: f64,
    /// M_e, kg.
    #[serde(default)]
    pub inertia: f64,
}

mod axis_name {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    use utoipa::openapi::schema::{Object, ObjectBuilder, SchemaType, Type};

    const NAMES: [&str; 3] = ["x", "y", "z"];

    pub fn schema() -> Object {
        let words = ObjectBuilder::new().schema_type(SchemaType::Type(Type::String)).enum_values(Some(NAMES));
        words.description(Some("Axis of the base.")).build()
    }

    // serde hands over a reference.
    #[expect(clippy::trivially_copy_pass_by_ref)]
    pub fn serialize<S: Serializer>(axis: &usize, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(NAMES[*axis])
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<usize, D::Error> {
        let name = String::deserialize(deserializer)?;
        NAMES.iter().position(|known| *known == name).ok_or_else(|| Error::unknown_variant(&name, &NAMES))
    }
}

impl Contact {
    /// Direction in which the material lies, ±1.
    fn side(&self) -> f64 {
        if self.offset_m < 0.0 { -1.0 } else { 1.0 }
    }

    /// F_e on this axis, N, for displacement from the start (m), velocity (m/s) and acceleration (m/s²).
    fn force(&self, displacement: f64, velocity: f64, acceleration: f64) -> f64 {
        let depth = displacement - self.offset_m;
        let force = self.inertia * acceleration + self.damping * velocity + self.stiffness * depth;
        match self.kind {
            ContactKind::Spring => force,
            ContactKind::Wall if self.side() * depth <= 0.0 => 0.0,
            ContactKind::Wall => self.side() * (self.side() * force).max(0.0),
        }
    }
}

/// All contacts, with what is needed for accelerations.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    contacts: Vec<Contact>,
    start: [f64; 3],
    last_velocity: [f64; 3],
}

impl Environment {
    /// Contacts placed relative to the tool's start position (base frame, m).
    pub fn new(contacts: Vec<Contact>, start: [f64; 3]) -> Self {
        Self { contacts, start, last_velocity: [0.0; 3] }
    }

    /// F_e on the environment (N, base axes) at a tool position (m) and velocity (m/s), once per period T (s).
    pub fn force(&mut self, position: [f64; 3], velocity: [f64; 3], period: f64) -> [f64; 3] {
        let mut force = [0.0; 3];
        for contact in &self.contacts {
            let i = contact.axis;
            let acceleration = (velocity[i] - self.last_velocity[i]) / period;
            force[i] += contact.force(position[i] - self.start[i], velocity[i], acceleration);
        }
        self.last_velocity = velocity;
        force
    }

    /// Way to the nearest wall along its axis, m, negative in contact; `None` without a wall.
    pub fn wall_distance(&self, position: [f64; 3]) -> Option<f64> {
        let walls = self.contacts.iter().filter(|contact| contact.kind == ContactKind::Wall);
        let distance = |wall: &Contact| wall.side() * (wall.offset_m - (position[wall.axis] - self.start[wall.axis]));
        walls.map(distance).min_by(f64::total_cmp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contact(kind: ContactKind, offset_m: f64) -> Contact {
        Contact { axis: 0, kind, offset_m, stiffness: 1000.0, damping: 10.0, inertia: 2.0 }
    }

    #[test]
    fn a_spring_pushes_and_pulls() {
        let mut spring = Environment::new(vec![contact(ContactKind::Spring, 0.0)], [1.0, 2.0, 3.0]);
        assert!((spring.force([0.9, 2.5, 3.0], [0.0; 3], 0.01)[0] + 100.0).abs() < 1e-9);
        let force = spring.force([1.1, 2.5, 3.0], [0.5, 9.0, 0.0], 0.01);
        assert!((force[0] - (100.0 + 5.0 + 2.0 * 50.0)).abs() < 1e-9);
        assert_eq!(force[1..], [0.0, 0.0]);
    }

    #[test]
    fn a_wall_never_pulls_on_either_side() {
        for side in [1.0, -1.0] {
            let mut wall = Environment::new(vec![contact(ContactKind::Wall, 0.05 * side)], [0.0; 3]);
            assert_eq!(wall.force([0.04 * side, 0.0, 0.0], [0.0; 3], 0.01)[0], 0.0);
            assert!((wall.force([0.06 * side, 0.0, 0.0], [0.0; 3], 0.01)[0] - 10.0 * side).abs() < 1e-9);
            // Fast withdrawal: damping alone would pull.
            assert_eq!(wall.force([0.051 * side, 0.0, 0.0], [-side, 0.0, 0.0], 0.01)[0], 0.0);
            assert!((wall.wall_distance([0.02 * side, 0.0, 0.0]).unwrap() - 0.03).abs() < 1e-15);
        }
    }
}
