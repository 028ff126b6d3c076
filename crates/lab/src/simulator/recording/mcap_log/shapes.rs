//! Capsules of the robot and obstacles of the controller, as primitives of a scene.

use foxglove::messages::{Color, CubePrimitive, CylinderPrimitive, Pose, SceneEntity, SpherePrimitive};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use revprio_api::wire;
use revprio_robot::RobotModel;
use revprio_robot::collision::{PlacedBody, Segment};
use revprio_robot::kinematics::Configuration;

use super::messages::{quaternion, vector};

const LINK: Color = Color { r: 0.0, g: 0.55, b: 0.75, a: 0.35 };
const OBSTACLE: Color = Color { r: 0.7, g: 0.45, b: 0.24, a: 0.5 };

/// Width and thickness of the drawn part of a half-space, m.
const PLANE: [f64; 2] = [2.0, 0.01];

/// Returns the capsules of a robot at a posture; none if it has no shapes or no such posture.
pub fn of_robot(robot: &RobotModel, joint_position: &[f64]) -> SceneEntity {
    let mut entity = SceneEntity::default();
    let Some(model) = robot.collision() else { return entity };
    let Ok(configuration) = Configuration::new(robot, joint_position) else { return entity };
    let body = PlacedBody::new(model, &configuration);
    for (k, capsule) in model.capsules().iter().enumerate() {
        add_capsule(&mut entity, body.core(k), capsule.radius, LINK);
    }
    entity
}

/// Returns an obstacle.
pub fn of_obstacle(obstacle: &wire::RoomObstacle) -> SceneEntity {
    let mut entity = SceneEntity::default();
    if let Some(wire::Sphere { center, radius }) = obstacle.sphere {
        add_capsule(&mut entity, &Segment { from: center.into(), to: center.into() }, radius, OBSTACLE);
    }
    if let Some(wire::Capsule { start, end, radius }) = obstacle.capsule {
        add_capsule(&mut entity, &Segment { from: start.into(), to: end.into() }, radius, OBSTACLE);
    }
    if let Some(wire::Cuboid { size, pose }) = obstacle.cuboid {
        let wire::Orientation { w, x, y, z } = pose.orientation;
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        entity.cubes.push(cube(&pose.position.into(), &turn, size));
    }
    if let Some(plane) = obstacle.half_space {
        entity.cubes.extend(plate(&plane));
    }
    entity
}

/// Adds a capsule as a cylinder and two balls; a sphere is one ball.
fn add_capsule(entity: &mut SceneEntity, core: &Segment, radius: f64, color: Color) {
    let diameter = 2.0 * radius;
    let ball = |center: &Vector3<f64>| SpherePrimitive {
        pose: Some(pose(center, &UnitQuaternion::identity())),
        size: Some(vector([diameter; 3])),
        color: Some(color),
    };
    entity.spheres.push(ball(&core.from));
    let axis = core.to - core.from;
    let Some(direction) = axis.try_normalize(1e-9) else { return };
    entity.spheres.push(ball(&core.to));
    entity.cylinders.push(CylinderPrimitive {
        pose: Some(pose(&(0.5 * (core.from + core.to)), &along_z(&direction))),
        size: Some(vector([diameter, diameter, axis.norm()])),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: Some(color),
    });
}

/// Returns the part of a half-space's surface that is next to the base, as a plate below the surface.
fn plate(plane: &wire::HalfSpace) -> Option<CubePrimitive> {
    let [width, thickness] = PLANE;
    let direction = Vector3::from(plane.normal).try_normalize(0.0)?;
    let middle = direction * (plane.offset_m - 0.5 * thickness);
    Some(cube(&middle, &along_z(&direction), [width, width, thickness]))
}

fn cube(middle: &Vector3<f64>, turn: &UnitQuaternion<f64>, size: [f64; 3]) -> CubePrimitive {
    CubePrimitive { pose: Some(pose(middle, turn)), size: Some(vector(size)), color: Some(OBSTACLE) }
}

fn pose(position: &Vector3<f64>, turn: &UnitQuaternion<f64>) -> Pose {
    Pose { position: Some(vector((*position).into())), orientation: Some(quaternion(turn)) }
}

/// Returns the rotation of z into a direction.
fn along_z(direction: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(&Vector3::z(), direction)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI))
}
