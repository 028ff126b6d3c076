//! What a viewer draws: the arm as a line, walls, and the contact force as an arrow.

use std::sync::Arc;

use foxglove::messages::{
    ArrowPrimitive, Color, CubePrimitive, LinePrimitive, Point3, Pose, SceneEntity, SceneUpdate, Vector3,
    line_primitive,
};
use nalgebra::{IsometryMatrix3, UnitQuaternion, Vector3 as Direction};

use super::super::{Recording, Sample};
use super::messages::{BASE, quaternion, timestamp, vector};
use crate::kinematics::link_frames;
use crate::robot::{RobotModel, built_in};
use crate::simulator::{Contact, ContactKind};

/// Length of the arrow, m per N.
const ARROW_SCALE: f64 = 0.002;

const ARM: Color = Color { r: 0.3, g: 0.3, b: 0.35, a: 1.0 };
const WALL: Color = Color { r: 0.34, g: 0.71, b: 0.91, a: 0.4 };
const FORCE: Color = Color { r: 0.84, g: 0.37, b: 0.0, a: 1.0 };

/// What stands still, and the arm if it is one that ships with the program.
pub struct Stage {
    robot: Option<Arc<RobotModel>>,
    walls: Vec<CubePrimitive>,
}

impl Stage {
    /// The stage of a run.
    pub fn of(recording: &Recording) -> Self {
        let (Some(setup), Some(first)) = (&recording.setup, recording.samples.first()) else {
            return Self { robot: None, walls: Vec::new() };
        };
        let start = [0, 1, 2].map(|i| first.position[i] - first.position_error[i]);
        let walls = setup.contacts.iter().filter(|contact| contact.kind == ContactKind::Wall);
        Self {
            robot: built_in().iter().find(|robot| robot.name() == setup.controller.robot).cloned(),
            walls: walls.map(|contact| wall(contact, start)).collect(),
        }
    }

    /// Frames of the links, as far as the arm is known.
    pub fn links(&self, sample: &Sample) -> Vec<IsometryMatrix3<f64>> {
        let links = self.robot.as_ref().and_then(|robot| link_frames(robot, &sample.joint_position).ok());
        links.unwrap_or_default()
    }

    /// One picture.
    pub fn scene(&self, sample: &Sample, links: &[IsometryMatrix3<f64>]) -> SceneUpdate {
        let entity = |id: &str| SceneEntity {
            timestamp: timestamp(sample),
            frame_id: BASE.to_owned(),
            id: id.to_owned(),
            ..SceneEntity::default()
        };
        let entities = vec![
            SceneEntity { lines: arm(sample, links), ..entity("arm") },
            SceneEntity { cubes: self.walls.clone(), ..entity("walls") },
            SceneEntity { arrows: vec![arrow(sample)], ..entity("force") },
        ];
        SceneUpdate { deletions: Vec::new(), entities }
    }
}

fn arm(sample: &Sample, links: &[IsometryMatrix3<f64>]) -> Vec<LinePrimitive> {
    if links.is_empty() {
        return Vec::new();
    }
    let point = |[x, y, z]: [f64; 3]| Point3 { x, y, z };
    let joints = links.iter().map(|link| link.translation.vector.into());
    let points = std::iter::once([0.0; 3]).chain(joints).chain([sample.position]).map(point).collect();
    let line = LinePrimitive {
        r#type: line_primitive::Type::LineStrip as i32,
        thickness: 0.03,
        points,
        color: Some(ARM),
        ..LinePrimitive::default()
    };
    vec![line]
}

/// A plate of 60 cm whose near side is the surface.
fn wall(contact: &Contact, start: [f64; 3]) -> CubePrimitive {
    const THICKNESS: f64 = 0.02;
    let mut middle = start;
    middle[contact.axis] += contact.offset_m + (0.5 * THICKNESS).copysign(contact.offset_m);
    let mut size = [0.6; 3];
    size[contact.axis] = THICKNESS;
    CubePrimitive { pose: Some(upright(middle)), size: Some(vector(size)), color: Some(WALL) }
}

fn upright(position: [f64; 3]) -> Pose {
    Pose { position: Some(vector(position)), orientation: Some(quaternion(&UnitQuaternion::identity())) }
}

/// The force of the tool on what it touches, from the tool point on.
fn arrow(sample: &Sample) -> ArrowPrimitive {
    let force = Direction::from(sample.force);
    let turn = UnitQuaternion::rotation_between(&Direction::x(), &force)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Direction::z_axis(), std::f64::consts::PI));
    let length = ARROW_SCALE * force.norm();
    let position: Vector3 = vector(sample.position);
    ArrowPrimitive {
        pose: Some(Pose { position: Some(position), orientation: Some(quaternion(&turn)) }),
        shaft_length: 0.8 * length,
        shaft_diameter: 0.01,
        head_length: 0.2 * length,
        head_diameter: 0.02,
        color: Some(FORCE),
    }
}
