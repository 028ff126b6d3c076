//! The shape of a contact: how deep the tool is, and the direction into the material.

use nalgebra::Vector3;

use super::contact::{Contact, ContactKind, Edge, Hole};
use super::field_error::{FieldError, number, positive};

/// Largest cosine of an angle that counts as a right one.
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
    /// Level, with a place that is lower by a depth, m.
    Step {
        /// Where it is lower.
        side: Side,
        /// Depth below the surface.
        depth: f64,
    },
    /// The outside of a cylinder with this axis, a unit vector, or of a sphere if `None`; radius in m.
    Round {
        /// The axis.
        axis: Option<Vector3<f64>>,
        /// The radius, m.
        radius: f64,
    },
}

/// The side of a block next to a lower place; lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Side {
    /// That of a round hole, into which the tool fits with a clearance.
    Hole {
        /// A point on its axis.
        center: Vector3<f64>,
        /// Play of the tool on each side.
        clearance: f64,
    },
    /// That of a straight edge.
    Edge {
        /// Unit vector from the block over the edge.
        over: Vector3<f64>,
        /// Distance from the start.
        distance: f64,
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
        for (is_stated, field) in [(contact.hole.is_some(), "hole"), (contact.edge.is_some(), "edge")] {
            if is_stated && contact.kind != ContactKind::Plane {
                return Err(FieldError::new(at(field), "is for a plane"));
            }
        }
        let form = match (contact.kind, contact.radius_m) {
            (ContactKind::Cylinder | ContactKind::Sphere | ContactKind::Door, None) => {
                return Err(FieldError::new(
                    at("radius_m"),
                    "is missing; a cylinder, a sphere and a door have a radius",
                ));
            }
            (ContactKind::Cylinder | ContactKind::Sphere | ContactKind::Door, Some(radius)) => {
                Form::Round { axis: axis_of(contact, &inward, pointer)?, radius: positive(radius, &at("radius_m"))? }
            }
            (_, None) => level(contact, &inward, pointer)?,
            (_, Some(_)) => return Err(FieldError::new(at("radius_m"), "is for a cylinder, a sphere or a door")),
        };
        Ok(Self { inward, offset, form })
    }

    /// Returns the depth of the tool at a displacement from its start, m.
    pub fn depth(&self, displacement: &Vector3<f64>) -> Depth {
        match self.form {
            Form::Flat => Depth { depth: self.inward.dot(displacement) - self.offset, inward: self.inward },
            Form::Step { side, depth } => {
                let (beside, into_side) = side.depth(displacement, &self.inward);
                let below = self.inward.dot(displacement) - self.offset;
                let [depth, inward, aside] = depth_at_step(below, beside, depth);
                Depth { depth, inward: self.inward * inward + into_side * aside }
            }
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

impl Side {
    fn of_hole(hole: &Hole, pointer: &str) -> Result<Self, FieldError> {
        let center = vector(hole.center, &format!("{pointer}/center"))?;
        Ok(Self::Hole { center, clearance: positive(hole.clearance_m, &format!("{pointer}/clearance_m"))? })
    }

    fn of_edge(edge: &Edge, inward: &Vector3<f64>, pointer: &str) -> Result<Self, FieldError> {
        let at = format!("{pointer}/direction");
        let over = vector(edge.direction, &at)?.try_normalize(1e-9);
        let over = over.ok_or_else(|| FieldError::new(&at, "must not be zero"))?;
        if over.dot(inward).abs() > SQUARE {
            return Err(FieldError::new(at, "must be square to the `normal`"));
        }
        Ok(Self::Edge { over, distance: number(edge.distance_m, &format!("{pointer}/distance_m"))? })
    }

    /// Returns the distance from the side (m), positive in the material, and the unit vector into it.
    fn depth(&self, displacement: &Vector3<f64>, inward: &Vector3<f64>) -> (f64, Vector3<f64>) {
        match self {
            Self::Hole { center, clearance } => {
                let way = displacement - center;
                let outward = way - inward * inward.dot(&way);
                let distance = outward.norm();
                (distance - clearance, outward.try_normalize(0.0).unwrap_or_default())
            }
            Self::Edge { over, distance } => (distance - over.dot(displacement), -over),
        }
    }
}

/// Returns the share of K_e that acts along a base axis at the start: the square of the component of the direction. The grip of a door
/// is as stiff in all directions.
pub fn share_along(contact: &Contact, axis: usize) -> f64 {
    if contact.kind == ContactKind::Door {
        return 1.0;
    }
    Shape::new(contact, "").map_or(0.0, |shape| shape.inward[axis].powi(2))
}

/// Returns the form of a spring, a wall or a plane.
fn level(contact: &Contact, inward: &Vector3<f64>, pointer: &str) -> Result<Form, FieldError> {
    let at = |field: &str| format!("{pointer}/{field}");
    let (field, side, depth) = match (&contact.hole, &contact.edge) {
        (None, None) => return Ok(Form::Flat),
        (Some(hole), None) => ("hole", Side::of_hole(hole, &at("hole"))?, hole.depth_m),
        (None, Some(edge)) => ("edge", Side::of_edge(edge, inward, &at("edge"))?, edge.depth_m),
        (Some(_), Some(_)) => return Err(FieldError::new(at("edge"), "is not for a plane with a `hole`")),
    };
    Ok(Form::Step { side, depth: positive(depth, &at(&format!("{field}/depth_m")))? })
}

fn vector(values: [f64; 3], pointer: &str) -> Result<Vector3<f64>, FieldError> {
    values.iter().enumerate().try_for_each(|(i, v)| number(*v, &format!("{pointer}/{i}")).map(drop))?;
    Ok(values.into())
}

/// Returns the depth of a point in a block with a lower place (m), and the direction into the material: its parts into the block and
/// into the side of that place. `below`: depth below the upper side, `beside`: distance from the side, positive in the material, `depth`:
/// depth of the lower place, m.
fn depth_at_step(below: f64, beside: f64, depth: f64) -> [f64; 3] {
    let under = below - depth;
    let is_in_material = below > 0.0 && (beside > 0.0 || under > 0.0);
    if is_in_material {
        // The way out leads upwards or aside.
        let aside = under.max(0.0).hypot(beside.max(0.0));
        if below <= aside {
            return [below, 1.0, 0.0];
        }
        return [aside, under.max(0.0) / aside, beside.max(0.0) / aside];
    }
    // The nearest place of the material is on the upper side, the rim, the side or the bottom.
    let bottom = [under, 1.0, 0.0];
    let other = match (below > 0.0, beside > 0.0) {
        (false, true) => return [below, 1.0, 0.0],
        (true, _) => [beside, 0.0, 1.0],
        (false, false) => {
            let rim = below.hypot(beside);
            if rim > 0.0 { [-rim, -below / rim, -beside / rim] } else { [0.0, 1.0, 0.0] }
        }
    };
    if bottom[0] > other[0] { bottom } else { other }
}

/// Returns whether a kind lies along a base axis, in its positive or negative direction.
fn is_along_axis(kind: ContactKind) -> bool {
    matches!(kind, ContactKind::Spring | ContactKind::Wall)
}

/// Returns the unit vector into the material at the start.
fn direction(contact: &Contact, pointer: &str) -> Result<Vector3<f64>, FieldError> {
    let at = |field: &str| format!("{pointer}/{field}");
    if !is_along_axis(contact.kind) {
        if contact.axis.is_some() && !matches!(contact.kind, ContactKind::Cylinder | ContactKind::Door) {
            return Err(FieldError::new(at("axis"), "is not for a plane or a sphere, which have a `normal`"));
        }
        let problem = "is missing; a plane, a cylinder, a sphere and a door need a normal, for example [0, 0, 1]";
        let normal = contact.normal.ok_or_else(|| FieldError::new(at("normal"), problem))?;
        normal.iter().enumerate().try_for_each(|(i, v)| number(*v, &format!("{pointer}/normal/{i}")).map(drop))?;
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

/// Returns the axis of a cylinder or a door; `None` for a sphere.
fn axis_of(contact: &Contact, inward: &Vector3<f64>, pointer: &str) -> Result<Option<Vector3<f64>>, FieldError> {
    if contact.kind == ContactKind::Sphere {
        return Ok(None);
    }
    let at = format!("{pointer}/axis");
    let axis = contact.axis.map(base_axis).ok_or_else(|| FieldError::new(&at, "is missing; it is x, y or z"))?;
    if axis.dot(inward).abs() > SQUARE {
        return Err(FieldError::new(at, "must be square to the `normal`"));
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

    fn contact(fields: &serde_json::Value) -> Contact {
        let mut whole = json!({"stiffness": 1000.0});
        whole.as_object_mut().unwrap().extend(fields.as_object().unwrap().clone());
        serde_json::from_value(whole).unwrap()
    }

    /// The distance to the axis of a cylinder, and to the middle of a sphere, is that of Pythagoras.
    #[test]
    fn depth_of_a_round_shape_is_its_radius_less_the_distance_to_its_middle() {
        let cylinder =
            contact(&json!({"kind": "cylinder", "axis": "y", "normal": [3, 0, 4], "offset_m": 0.1, "radius_m": 0.4}));
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

    /// A hole of 20 mm with a clearance of 1 mm, 5 mm beside the tool, which is 3 mm above the plane.
    #[test]
    fn depth_at_a_hole_is_the_way_to_the_nearest_free_place() {
        let plane = contact(&json!({"kind": "plane", "normal": [0, 0, 1], "offset_m": 0.003,
            "hole": {"center": [0.005, 0, 7], "clearance_m": 0.001, "depth_m": 0.02}}));
        let shape = Shape::new(&plane, "").unwrap();
        let (down, outward) = (-Vector3::z(), Vector3::x());
        // Distance from the axis of the hole and depth below the plane, mm; expected depth, mm, and direction.
        for (beside, below, depth, inward) in [
            (-5.0, -3.0, -3.0, down),
            (3.0, 0.2, 0.2, down),
            (1.5, 0.2, 0.2, down),
            (1.1, 0.2, 0.1, outward),
            (0.4, 5.0, -0.6, outward),
            (1.2, 5.0, 0.2, outward),
            (0.5, 19.7, -0.3, down),
            (0.5, 20.4, 0.4, down),
            (1.3, 20.4, 0.5, (down * 0.4 + outward * 0.3) / 0.5),
            (-2.0, -1.0, -1.0, down),
            (-0.4, -0.8, -1.0, down * 0.8 + outward * 0.6),
        ] {
            let place = Vector3::new(0.005 + 1e-3 * beside, 0.0, -0.003 - 1e-3 * below);
            let found = shape.depth(&place);
            assert!((found.depth - 1e-3 * depth).abs() < 1e-12, "{beside} {below}: {}", found.depth);
            let expected = if beside < 0.0 { Vector3::new(-inward.x, 0.0, inward.z) } else { inward };
            assert!((found.inward - expected).norm() < 1e-9, "{beside} {below}: {}", found.inward);
        }
    }

    /// An edge 8 mm in front of the tool along y, with a lower level 5 mm below it.
    #[test]
    fn plane_ends_at_its_edge() {
        let plane = contact(&json!({"kind": "plane", "normal": [0, 0, 1], "offset_m": 0.003,
            "edge": {"direction": [0, 2, 0], "distance_m": 0.008, "depth_m": 0.005}}));
        let shape = Shape::new(&plane, "").unwrap();
        let (down, back) = (-Vector3::z(), -Vector3::y());
        // Way beyond the edge and depth below the plane, mm; expected depth, mm, and direction.
        for (beyond, below, depth, inward) in [
            (-5.0, 0.1, 0.1, down),
            (-0.05, 0.1, 0.05, back),
            (0.2, 0.1, -0.2, back),
            (3.5, 2.0, -3.0, down),
            (3.0, 5.1, 0.1, down),
            (0.6, -0.8, -1.0, down * 0.8 + back * 0.6),
        ] {
            let found = shape.depth(&Vector3::new(0.3, 0.008 + 1e-3 * beyond, -0.003 - 1e-3 * below));
            assert!((found.depth - 1e-3 * depth).abs() < 1e-12, "{beyond} {below}: {}", found.depth);
            assert!((found.inward - inward).norm() < 1e-9, "{beyond} {below}: {}", found.inward);
        }
    }

    /// The force is that of a potential: ½ K depth², whose gradient is K depth times the direction.
    #[test]
    fn direction_at_a_hole_is_the_gradient_of_its_depth() {
        let step = 1e-7;
        for (below, beside) in
            [(2e-3, 3e-3), (2e-3, 1e-3), (21e-3, 0.5e-3), (21e-3, -0.5e-3), (-1e-3, -1e-3), (3e-3, -1e-3)]
        {
            let [_, inward, side] = depth_at_step(below, beside, 0.02);
            let along = |a: [f64; 3], b: [f64; 3]| (a[0] - b[0]) / (2.0 * step);
            let slope = [
                along(depth_at_step(below + step, beside, 0.02), depth_at_step(below - step, beside, 0.02)),
                along(depth_at_step(below, beside + step, 0.02), depth_at_step(below, beside - step, 0.02)),
            ];
            assert!((slope[0] - inward).abs() < 1e-5 && (slope[1] - side).abs() < 1e-5, "{below} {beside}: {slope:?}");
        }
    }

    #[test]
    fn errors_name_the_field_that_is_missing_or_out_of_place() {
        let problem = |fields| Shape::new(&contact(&fields), "/contacts/0").unwrap_err().to_string();
        for (fields, expected) in [
            (json!({"kind": "wall"}), "`contacts.0.axis` is missing"),
            (json!({"kind": "wall", "axis": "x", "normal": [1, 0, 0]}), "`contacts.0.normal` is not for"),
            (json!({"kind": "wall", "axis": "x", "radius_m": 1}), "`contacts.0.radius_m` is for a cylinder"),
            (json!({"kind": "plane"}), "`contacts.0.normal` is missing"),
            (json!({"kind": "plane", "normal": [0, 0, 0]}), "`contacts.0.normal` must not be zero"),
            (json!({"kind": "plane", "normal": [0, 0, 1], "axis": "z"}), "`contacts.0.axis` is not for"),
            (
                json!({"kind": "wall", "axis": "x", "hole": {"center": [0, 0, 0], "clearance_m": 1e-3, "depth_m": 0.02}}),
                "`contacts.0.hole` is for a plane",
            ),
            (
                json!({"kind": "plane", "normal": [0, 0, 1], "hole": {"center": [0, 0, 0], "clearance_m": 0, "depth_m": 0.02}}),
                "`contacts.0.hole.clearance_m` must be positive",
            ),
            (
                json!({"kind": "plane", "normal": [0, 0, 1], "edge": {"direction": [0, 1, 1], "distance_m": 0, "depth_m": 1}}),
                "`contacts.0.edge.direction` must be square",
            ),
            (
                json!({"kind": "plane", "normal": [0, 0, 1], "edge": {"direction": [0, 1, 0], "distance_m": 0, "depth_m": 1},
                "hole": {"center": [0, 0, 0], "clearance_m": 1e-3, "depth_m": 0.02}}),
                "`contacts.0.edge` is not for",
            ),
            (
                json!({"kind": "sphere", "normal": [0, 0, 1], "radius_m": 1,
                    "edge": {"direction": [0, 1, 0], "distance_m": 0, "depth_m": 1}}),
                "`contacts.0.edge` is for a plane",
            ),
            (json!({"kind": "sphere", "normal": [0, 0, 1]}), "`contacts.0.radius_m` is missing"),
            (json!({"kind": "sphere", "normal": [0, 0, 1], "radius_m": 0}), "`contacts.0.radius_m` must be positive"),
            (json!({"kind": "cylinder", "normal": [0, 0, 1], "radius_m": 1}), "`contacts.0.axis` is missing"),
            (json!({"kind": "cylinder", "normal": [0, 1, 1], "axis": "y", "radius_m": 1}), "axis` must be square"),
        ] {
            assert!(problem(fields).contains(expected), "{expected}");
        }
    }
}
