//! The scene for a viewer: the arm as a line and as capsules, walls, obstacles, and the contact force as an arrow.

use std::sync::Arc;

use foxglove::messages::{
    ArrowPrimitive, Color, CubePrimitive, CylinderPrimitive, LinePrimitive, Point3, Pose, SceneEntity, SceneUpdate,
    SpherePrimitive, Vector3, line_primitive,
};
use nalgebra::{IsometryMatrix3, UnitQuaternion, Vector3 as Direction};
use revprio_api::wire;
use revprio_robot::kinematics::link_frames;
use revprio_robot::{RobotModel, built_in};

use super::super::{Recording, Sample};
use super::messages::{BASE, quaternion, timestamp, vector};
use super::shapes;
use crate::simulator::moving_obstacles::MovingObstacles;
use crate::simulator::shape::{Form, Shape};
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
    surfaces: Vec<Shape>,
    /// Names and primitives of the obstacles that stand.
    standing: Vec<(String, SceneEntity)>,
    moving: MovingObstacles,
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
            standing: setup.map(|setup| standing(&setup.controller)).unwrap_or_default(),
            // The scenario of a recording is valid.
            moving: setup
                .and_then(|setup| MovingObstacles::new(&setup.controller, &setup.obstacle_motions).ok())
                .unwrap_or_default(),
        }
    }

    /// Returns the surfaces. If there is one, its position is that of the sample, so that it may move.
    fn surfaces(&self, sample: &Sample) -> SceneEntity {
        let mut entity = SceneEntity::default();
        for shape in &self.surfaces {
            let moved = match (self.surfaces.len(), sample.wall_distance) {
                (1, Some(gap)) => gap + shape.depth(&sample.position_error.into()).depth,
                _ => 0.0,
            };
            add_surface(&mut entity, self.start + shape.inward * moved, shape);
        }
        entity
    }

    /// Returns the frames of the links; none if the robot is unknown.
    pub fn links(&self, sample: &Sample) -> Vec<IsometryMatrix3<f64>> {
        let links = self.robot.as_ref().and_then(|robot| link_frames(robot, &sample.joint_position).ok());
        links.unwrap_or_default()
    }

    /// Returns the scene of one period.
    pub fn scene(&self, sample: &Sample, links: &[IsometryMatrix3<f64>]) -> SceneUpdate {
        let entity = |id: String, content: SceneEntity| SceneEntity {
            timestamp: Some(timestamp(sample)),
            frame_id: BASE.to_owned(),
            id,
            ..content
        };
        let none = SceneEntity::default;
        let robot = self.robot.as_deref().filter(|robot| robot.collision().is_some());
        let mut entities = vec![
            entity("arm".to_owned(), SceneEntity { lines: arm(sample, links), ..none() }),
            entity("walls".to_owned(), self.surfaces(sample)),
            entity("force".to_owned(), SceneEntity { arrows: vec![arrow(sample)], ..none() }),
        ];
        entities
            .extend(robot.map(|robot| entity("shapes".to_owned(), shapes::of_robot(robot, &sample.joint_position))));
        let of_obstacle = |(name, shape): (String, SceneEntity)| entity(format!("obstacle {name}"), shape);
        entities.extend(self.standing.iter().cloned().map(of_obstacle));
        let moving =
            self.moving.shapes(sample.time_s).map(|obstacle| (obstacle.name.clone(), shapes::of_obstacle(&obstacle)));
        entities.extend(moving.map(of_obstacle));
        SceneUpdate { deletions: Vec::new(), entities }
    }
}

/// Returns the names and primitives of the obstacles that stand.
fn standing(controller: &wire::Controller) -> Vec<(String, SceneEntity)> {
    let stated = controller.collisions.iter().flat_map(|collisions| &collisions.obstacles);
    let standing = stated.filter(|obstacle| !obstacle.moves);
    standing.map(|obstacle| (obstacle.name.clone(), shapes::of_obstacle(obstacle))).collect()
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

/// Returns the shape of a surface; `None` for a spring or a door.
fn surface(contact: &Contact) -> Option<Shape> {
    let is_surface = !matches!(contact.kind, ContactKind::Spring | ContactKind::Door);
    // The scenario of a recording is valid.
    is_surface.then(|| Shape::new(contact, "").ok()).flatten()
}

/// Adds a surface whose place is relative to a start: a plate, a bar of 60 cm or a ball.
fn add_surface(entity: &mut SceneEntity, start: Direction<f64>, shape: &Shape) {
    let pose = |middle: Direction<f64>, turn: &UnitQuaternion<f64>| {
        Some(Pose { position: Some(vector(middle.into())), orientation: Some(quaternion(turn)) })
    };
    match shape.form {
        Form::Flat | Form::Step { .. } => entity.cubes.push(plate(start, shape.inward, shape.offset)),
        Form::Round { axis, radius } => {
            let (middle, diameter) = (start + shape.center(radius), 2.0 * radius);
            let Some(axis) = axis else {
                let pose = pose(middle, &UnitQuaternion::identity());
                let size = Some(Vector3 { x: diameter, y: diameter, z: diameter });
                return entity.spheres.push(SpherePrimitive { pose, size, color: Some(WALL) });
            };
            let turn = UnitQuaternion::rotation_between(&Direction::z(), &axis).unwrap_or_default();
            entity.cylinders.push(CylinderPrimitive {
                pose: pose(middle, &turn),
                size: Some(Vector3 { x: diameter, y: diameter, z: 0.6 }),
                bottom_scale: 1.0,
                top_scale: 1.0,
                color: Some(WALL),
            });
        }
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

#[cfg(test)]
mod tests {
    use foxglove::{Decode, messages::SpherePrimitive};
    use mcap::MessageStream;
    use revprio_robot::collision::Segment;
    use revprio_robot::kinematics::Configuration;
    use serde_json::json;

    use super::super::super::writer::Writer;
    use super::super::McapWriter;
    use super::*;

    const POSTURE: [f64; 7] = [0.3, -0.6, 0.2, -2.2, 0.1, 1.6, 0.8];

    /// Returns the recording of one period of a Panda in a room.
    fn recording() -> Recording {
        let turn = json!({"w": 0.0, "x": 0.0, "y": 0.0, "z": 1.0});
        let scenario = json!({
            "name": "room", "description": "", "duration_s": 1.0, "start_joint_position": POSTURE,
            "obstacle_motions": [{"name": "ball", "displacement": {"kind": "constant", "value": [0.1, 0.2, 0.3]}}],
            "controller": {
                "robot": "panda", "period_s": 0.001,
                "tasks": [{"name": "hand", "axes": ["x"], "law": {"kind": "pose", "gain": 4}}],
                "collisions": {"obstacles": [
                    {"name": "table", "half_space": {"normal": [0, 0, 2], "offset_m": -0.05}},
                    {"name": "post", "capsule": {"start": [0.5, -0.4, 0], "end": [0.5, -0.4, 0.6], "radius": 0.05}},
                    {"name": "shelf", "box": {"size": [0.4, 0.3, 0.02], "pose": {"position": [0.5, 0.4, 0.6], "orientation": turn}}},
                    {"name": "lamp", "sphere": {"center": [0, 0, 1.5], "radius": 0.1}},
                    {"name": "ball", "sphere": {"radius": 0.08}, "moves": true},
                ]},
            },
        });
        let mut recording = Recording::empty();
        recording.setup = Some(serde_json::from_value(scenario).unwrap());
        recording.samples = vec![Sample { joint_position: POSTURE.to_vec(), ..Sample::zeros(7, [1, 0, 0, 0], false) }];
        recording
    }

    /// Writes a recording and returns the first scene of the file.
    fn first_scene(recording: &Recording) -> SceneUpdate {
        let mut file = Vec::new();
        let mut writer = Box::new(McapWriter::begin(recording, false, &mut file).unwrap());
        writer.write(recording, 0..recording.samples.len()).unwrap();
        writer.finish().unwrap();
        let scene =
            MessageStream::new(&file).unwrap().map(Result::unwrap).find(|message| message.channel.topic == "/scene");
        SceneUpdate::decode(scene.unwrap().data.as_ref()).unwrap()
    }

    fn entity(scene: &SceneUpdate, id: &str) -> SceneEntity {
        scene.entities.iter().find(|entity| entity.id == id).cloned().unwrap()
    }

    fn place(pose: Option<&Pose>) -> Direction<f64> {
        let position = pose.unwrap().position.unwrap();
        Direction::new(position.x, position.y, position.z)
    }

    #[test]
    fn obstacles_are_primitives_of_the_scene() {
        let scene = first_scene(&recording());
        let ids: Vec<_> = scene.entities.iter().map(|entity| entity.id.as_str()).collect();
        assert_eq!(
            ids,
            [
                "arm",
                "walls",
                "force",
                "shapes",
                "obstacle table",
                "obstacle post",
                "obstacle shelf",
                "obstacle lamp",
                "obstacle ball"
            ]
        );
        let ball = &entity(&scene, "obstacle ball").spheres[0];
        assert_eq!(place(ball.pose.as_ref()), Direction::new(0.1, 0.2, 0.3), "it moves");
        assert!(scene.entities.iter().all(|entity| entity.frame_id == "base"));
        let table = &entity(&scene, "obstacle table").cubes[0];
        let top = place(table.pose.as_ref()).z + 0.5 * table.size.unwrap().z;
        assert!((top + 0.05).abs() < 1e-12);
        let post = entity(&scene, "obstacle post");
        assert_eq!(post.cylinders[0].size, Some(vector([0.1, 0.1, 0.6])));
        assert_eq!(place(post.cylinders[0].pose.as_ref()), Direction::new(0.5, -0.4, 0.3));
        assert_eq!(post.spheres.len(), 2);
        let shelf = &entity(&scene, "obstacle shelf").cubes[0];
        assert_eq!(shelf.size, Some(vector([0.4, 0.3, 0.02])));
        assert_eq!(shelf.pose.as_ref().unwrap().orientation.unwrap().z, 1.0);
        let lamp = entity(&scene, "obstacle lamp");
        assert_eq!(lamp.spheres[0].size, Some(vector([0.2; 3])));
        assert!(lamp.cylinders.is_empty());
    }

    #[test]
    fn a_round_surface_is_a_bar_or_a_ball_that_touches_the_place_of_its_offset() {
        let mut recording = recording();
        let bar = json!({"kind": "cylinder", "axis": "y", "normal": [0, 0, 1], "offset_m": 0.02, "radius_m": 0.3,
            "stiffness": 1e4});
        recording.setup.as_mut().unwrap().contacts = vec![serde_json::from_value(bar).unwrap()];
        let first = &mut recording.samples[0];
        // The start is at (0.1, 0.2, 0.5). The bar has moved up by 5 mm.
        (first.position, first.position_error, first.wall_distance) = ([0.1, 0.2, 0.5], [0.0; 3], Some(0.015));
        let walls = entity(&first_scene(&recording), "walls");
        assert_eq!(walls.cylinders[0].size, Some(vector([0.6; 3])));
        let middle = place(walls.cylinders[0].pose.as_ref());
        assert!((middle - Direction::new(0.1, 0.2, 0.5 - 0.015 - 0.3)).norm() < 1e-12, "{middle}");
        let contact = &mut recording.setup.as_mut().unwrap().contacts[0];
        (contact.kind, contact.axis) = (ContactKind::Sphere, None);
        let ball = &entity(&first_scene(&recording), "walls").spheres[0];
        assert_eq!((ball.size, place(ball.pose.as_ref())), (Some(vector([0.6; 3])), middle));
    }

    #[test]
    fn the_capsules_of_the_robot_are_where_its_links_are() {
        let shapes = entity(&first_scene(&recording()), "shapes");
        let robot = built_in().iter().find(|robot| robot.name() == "panda").unwrap();
        let capsules = robot.collision().unwrap().capsules();
        let configuration = Configuration::new(robot, &POSTURE).unwrap();
        let is_at = |ball: &SpherePrimitive, point: Direction<f64>, radius: f64| {
            (place(ball.pose.as_ref()) - point).norm() < 1e-9 && (ball.size.unwrap().x - 2.0 * radius).abs() < 1e-12
        };
        for capsule in capsules {
            let Segment { from, to } = capsule.core;
            let frame = configuration.link_pose(capsule.link);
            for end in [from, to] {
                let point = frame.transform_point(&end.into()).coords;
                assert!(shapes.spheres.iter().any(|ball| is_at(ball, point, capsule.radius)));
            }
        }
        let long = capsules.iter().filter(|capsule| capsule.core.from != capsule.core.to).count();
        assert_eq!(shapes.cylinders.len(), long);
    }
}
