//! The scene for a viewer: the arm as a line, walls, and the contact force as an arrow.

use std::sync::Arc;

use foxglove::messages::{
    ArrowPrimitive, Color, CubePrimitive, LinePrimitive, Point3, Pose, SceneEntity, SceneUpdate, Vector3,
    line_primitive,
};
use nalgebra::{IsometryMatrix3, UnitQuaternion, Vector3 as Direction};
use revprio_robot::kinematics::link_frames;
use revprio_robot::{RobotModel, built_in};

use super::super::{Recording, Sample};
use super::messages::{BASE, quaternion, timestamp, vector};
use crate::simulator::{Contact, ContactKind};

/// Length of the arrow, m per N.
const ARROW_SCALE: f64 = 0.002;

const ARM: Color = Color { r: 0.3, g: 0.3, b: 0.35, a: 1.0 };
const WALL: Color = Color { r: 0.34, g: 0.71, b: 0.91, a: 0.4 };
const FORCE: Color = Color { r: 0.84, g: 0.37, b: 0.0, a: 1.0 };

/// Draws the robot, if it ships with the program, and the surfaces.
pub struct SceneBuilder {
    robot: Option<Arc<RobotModel>>,
    start: Direction<f64>,
    /// Unit vector into each wall or plane, and the distance to it from the start, m.
    surfaces: Vec<(Direction<f64>, f64)>,
}

impl SceneBuilder {
    /// Returns the scene of a run.
    pub fn new(recording: &Recording) -> Self {
        let first = recording.samples.first();
        let start = first.map_or([0.0; 3], |first| [0, 1, 2].map(|i| first.position[i] - first.position_error[i]));
        let setup = recording.setup.as_ref();
        let robot = |name: &str| built_in().iter().find(|robot| robot.name() == name).cloned();
        Self {
            robot: setup.and_then(|setup| robot(&setup.controller.robot)),
            start: start.into(),
            surfaces: setup.map(|setup| setup.contacts.iter().filter_map(surface).collect()).unwrap_or_default(),
        }
    }

    /// Returns the walls as plates. If there is one wall, its position is that of the sample, so that it may move.
    fn walls(&self, sample: &Sample) -> Vec<CubePrimitive> {
        let visible = |(inward, distance): &(Direction<f64>, f64)| match (self.surfaces.len(), sample.wall_distance) {
            (1, Some(gap)) => plate(self.start, *inward, inward.dot(&Direction::from(sample.position_error)) + gap),
            _ => plate(self.start, *inward, *distance),
        };
        self.surfaces.iter().map(visible).collect()
    }

    /// Returns the frames of the links; none if the robot is unknown.
    pub fn links(&self, sample: &Sample) -> Vec<IsometryMatrix3<f64>> {
        let links = self.robot.as_ref().and_then(|robot| link_frames(robot, &sample.joint_position).ok());
        links.unwrap_or_default()
    }

    /// Returns the scene of one period.
    pub fn scene(&self, sample: &Sample, links: &[IsometryMatrix3<f64>]) -> SceneUpdate {
        let entity = |id: &str| SceneEntity {
            timestamp: Some(timestamp(sample)),
            frame_id: BASE.to_owned(),
            id: id.to_owned(),
            ..SceneEntity::default()
        };
        let entities = vec![
            SceneEntity { lines: arm(sample, links), ..entity("arm") },
            SceneEntity { cubes: self.walls(sample), ..entity("walls") },
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

/// Returns the direction into a wall or a plane and the distance to it from the start; `None` for a spring.
fn surface(contact: &Contact) -> Option<(Direction<f64>, f64)> {
    match (contact.kind, contact.axis, contact.normal) {
        (ContactKind::Wall, Some(axis), _) => {
            let side = if contact.offset_m < 0.0 { -1.0 } else { 1.0 };
            let mut inward = Direction::zeros();
            inward[axis] = side;
            Some((inward, side * contact.offset_m))
        }
        (ContactKind::Plane, _, Some(normal)) => Some((-Direction::from(normal).try_normalize(0.0)?, contact.offset_m)),
        _ => None,
    }
}

/// Returns a square plate of 60 cm whose front is the surface.
fn plate(start: Direction<f64>, inward: Direction<f64>, distance: f64) -> CubePrimitive {
    const THICKNESS: f64 = 0.02;
    let middle = start + inward * (distance + 0.5 * THICKNESS);
    CubePrimitive {
        pose: Some(Pose { position: Some(vector(middle.into())), orientation: Some(quaternion(&along(&inward))) }),
        size: Some(Vector3 { x: THICKNESS, y: 0.6, z: 0.6 }),
        color: Some(WALL),
    }
}

/// Returns the rotation of x into a direction.
fn along(direction: &Direction<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(&Direction::x(), direction)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Direction::z_axis(), std::f64::consts::PI))
}

/// Returns the force of the tool on the environment as an arrow from the tool point.
fn arrow(sample: &Sample) -> ArrowPrimitive {
    let force = Direction::from(sample.force);
    let length = ARROW_SCALE * force.norm();
    ArrowPrimitive {
        pose: Some(Pose { position: Some(vector(sample.position)), orientation: Some(quaternion(&along(&force))) }),
        shaft_length: 0.8 * length,
        shaft_diameter: 0.01,
        head_length: 0.2 * length,
        head_diameter: 0.02,
        color: Some(FORCE),
    }
}
