//! The shape of a contact: how deep the tool is, and the direction into the material.

use nalgebra::Vector3;

use super::contact::{Contact, ContactKind};
use super::field_error::{FieldError, number, positive};

/// Largest cosine of the angle between the normal of a cylinder and its axis.
const SQUARE: f64 = 1e-6;

/// A shape, placed relative to the start position of the tool, base axes, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// Unit vector into the material at the start, along which a motion moves the shape.
    pub inward: Vector3<f64>,
    /// Distance to the surface at the start, along `inward`, m.
    pub offset: f64,
    /// How the surface goes on from there.
    pub form: Form,
}

/// How a surface goes on from the place that is nearest to the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Form {
    /// Level.
    Flat,
    /// The outside of a cylinder with this axis, a unit vector, or of a sphere if `None`; radius in m.
    Round {
        /// The axis.
        axis: Option<Vector3<f64>>,
        /// The radius, m.
        radius: f64,
    },
}

/// The place of the tool with respect to a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Depth {
    /// Way into the material, m; the distance to the surface with a negative sign if the tool is outside.
    pub depth: f64,
    /// Unit vector into the material.
    pub inward: Vector3<f64>,
}

impl Shape {
    /// Returns the shape of the contact at a JSON pointer.
    pub fn new(contact: &Contact, pointer: &str) -> Result<Self, FieldError> {
        let at = |field: &str| format!("{pointer}/{field}");
        let offset = number(contact.offset_m, &at("offset_m"))?;
        let inward = direction(contact, pointer)?;
        let offset = if is_along_axis(contact.kind) { inward.sum() * offset } else { offset };
        let form = match (contact.kind, contact.radius_m) {
            (ContactKind::Cylinder | ContactKind::Sphere, None) => {
                return Err(FieldError::new(at("radius_m"), "is missing; a cylinder and a sphere have a radius"));
            }
            (ContactKind::Cylinder | ContactKind::Sphere, Some(radius)) => {
                Form::Round { axis: axis_of(contact, &inward, pointer)?, radius: positive(radius, &at("radius_m"))? }
            }
            (_, None) => Form::Flat,
            (_, Some(_)) => return Err(FieldError::new(at("radius_m"), "is for a cylinder or a sphere")),
        };
        Ok(Self { inward, offset, form })
    }

    /// Returns the depth of the tool at a displacement from its start, m.
    pub fn depth(&self, displacement: &Vector3<f64>) -> Depth {
        match self.form {
            Form::Flat => Depth { depth: self.inward.dot(displacement) - self.offset, inward: self.inward },
            Form::Round { axis, radius } => {
                let way = displacement - self.center(radius);
                let way = axis.map_or(way, |axis| way - axis * axis.dot(&way));
                let length = way.norm();
                // In the middle, every direction leads outwards.
                let inward = if length > 0.0 { -way / length } else { self.inward };
                Depth { depth: radius - length, inward }
            }
        }
    }

    /// Returns the middle of a round shape next to the start of the tool, m.
    pub fn center(&self, radius: f64) -> Vector3<f64> {
        self.inward * (self.offset + radius)
    }
}

/// Returns whether a kind lies along a base axis, in its positive or negative direction.
fn is_along_axis(kind: ContactKind) -> bool {
    matches!(kind, ContactKind::Spring | ContactKind::Wall)
}

/// Returns the unit vector into the material at the start.
fn direction(contact: &Contact, pointer: &str) -> Result<Vector3<f64>, FieldError> {
    let at = |field: &str| format!("{pointer}/{field}");
    if !is_along_axis(contact.kind) {
        let problem = "is missing; a plane, a cylinder or a sphere needs a normal, for example [0, 0, 1]";
        let normal = contact.normal.ok_or_else(|| FieldError::new(at("normal"), problem))?;
        normal.iter().enumerate().try_for_each(|(i, v)| number(*v, &format!("{pointer}/normal/{i}")).map(drop))?;
        if contact.axis.is_some() && contact.kind != ContactKind::Cylinder {
            return Err(FieldError::new(at("axis"), "is for a spring, a wall or a cylinder; others have a `normal`"));
        }
        let inward = (-Vector3::from(normal)).try_normalize(1e-9);
        return inward.ok_or_else(|| FieldError::new(at("normal"), "must not be zero"));
    }
    if contact.normal.is_some() {
        return Err(FieldError::new(at("normal"), "is not for a spring or a wall, which have an `axis`"));
    }
    let axis = contact.axis.ok_or_else(|| FieldError::new(at("axis"), "is missing; it is x, y or z"))?;
    let side = if contact.kind == ContactKind::Wall && contact.offset_m < 0.0 { -1.0 } else { 1.0 };
    Ok(base_axis(axis) * side)
}

/// Returns the axis of a cylinder; `None` for a sphere.
fn axis_of(contact: &Contact, inward: &Vector3<f64>, pointer: &str) -> Result<Option<Vector3<f64>>, FieldError> {
    if contact.kind == ContactKind::Sphere {
        return Ok(None);
    }
    let at = format!("{pointer}/axis");
    let axis = contact.axis.map(base_axis).ok_or_else(|| FieldError::new(&at, "is missing; it is x, y or z"))?;
    if axis.dot(inward).abs() > SQUARE {
        return Err(FieldError::new(at, "must be square to the `normal` of the cylinder"));
    }
    Ok(Some(axis))
}

fn base_axis(axis: usize) -> Vector3<f64> {
    Vector3::ith(axis, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn contact(fields: serde_json::Value) -> Contact {
        let mut whole = json!({"stiffness": 1000.0});
        whole.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
        serde_json::from_value(whole).unwrap()
    }

    /// The distance to the axis of a cylinder, and to the middle of a sphere, is that of Pythagoras.
    #[test]
    fn depth_of_a_round_shape_is_its_radius_less_the_distance_to_its_middle() {
        let cylinder =
            contact(json!({"kind": "cylinder", "axis": "y", "normal": [3, 0, 4], "offset_m": 0.1, "radius_m": 0.4}));
        let sphere = Contact { axis: None, kind: ContactKind::Sphere, ..cylinder.clone() };
        // The middle is 0.5 m from the start, against the normal.
        let middle = Vector3::new(-0.3, 0.0, -0.4);
        for (contact, is_cylinder) in [(cylinder, true), (sphere, false)] {
            let shape = Shape::new(&contact, "").unwrap();
            assert!((shape.depth(&Vector3::zeros()).depth + 0.1).abs() < 1e-15);
            for place in [Vector3::new(0.05, 0.02, -0.1), Vector3::new(-0.6, -0.3, -0.3), Vector3::new(-0.3, 0.7, 0.9)]
            {
                let [x, y, z] = (place - middle).into();
                let y = if is_cylinder { 0.0 } else { y };
                let distance = f64::sqrt(x * x + y * y + z * z);
                let Depth { depth, inward } = shape.depth(&place);
                assert!((depth - (0.4 - distance)).abs() < 1e-15);
                assert!((inward + Vector3::new(x, y, z) / distance).norm() < 1e-15);
            }
        }
    }

    #[test]
    fn errors_name_the_field_that_is_missing_or_out_of_place() {
        let problem = |fields| Shape::new(&contact(fields), "/contacts/0").unwrap_err().to_string();
        for (fields, expected) in [
            (json!({"kind": "wall"}), "`contacts.0.axis` is missing"),
            (json!({"kind": "wall", "axis": "x", "normal": [1, 0, 0]}), "`contacts.0.normal` is not for"),
            (json!({"kind": "wall", "axis": "x", "radius_m": 1}), "`contacts.0.radius_m` is for a cylinder"),
            (json!({"kind": "plane"}), "`contacts.0.normal` is missing"),
            (json!({"kind": "plane", "normal": [0, 0, 0]}), "`contacts.0.normal` must not be zero"),
            (json!({"kind": "plane", "normal": [0, 0, 1], "axis": "z"}), "`contacts.0.axis` is for"),
            (json!({"kind": "sphere", "normal": [0, 0, 1]}), "`contacts.0.radius_m` is missing"),
            (json!({"kind": "sphere", "normal": [0, 0, 1], "radius_m": 0}), "`contacts.0.radius_m` must be positive"),
            (json!({"kind": "cylinder", "normal": [0, 0, 1], "radius_m": 1}), "`contacts.0.axis` is missing"),
            (json!({"kind": "cylinder", "normal": [0, 1, 1], "axis": "y", "radius_m": 1}), "axis` must be square"),
        ] {
            assert!(problem(fields).contains(expected), "{expected}");
        }
    }
}
