//! Reads URDF files as whole trees and prints the frames of the outermost links, one line of JSON per file, for
//! `tools/robots/trees.py`, which compares them with Pinocchio's.
//!
//! ```sh
//! cargo run --release -p revprio-robot --example tree -- my_robot.urdf
//! ```

use std::hint::black_box;
use std::time::{Duration, Instant};

use revprio_robot::kinematics::{Configuration, Jacobian, LinkPoint};
use revprio_robot::{LinkId, RobotModel, UrdfTreeOptions};
use serde_json::{Value, json};

/// Number of postures of a robot.
const POSTURES: usize = 20;

/// Half of the range of a joint without limits, rad or m.
const UNLIMITED: f64 = std::f64::consts::PI;

/// Time in which the kinematics are repeated.
const BUDGET: Duration = Duration::from_millis(200);

fn main() {
    for file in std::env::args().skip(1) {
        let answer = match answer(&file) {
            Ok(answer) => answer,
            Err(error) => json!({"file": file, "error": error}),
        };
        println!("{answer}");
    }
}

fn answer(file: &str) -> Result<Value, String> {
    let text = std::fs::read_to_string(file).map_err(|error| error.to_string())?;
    let robot = RobotModel::from_urdf_tree(&text, &UrdfTreeOptions::default()).map_err(|error| error.to_string())?;
    let links = outermost(&robot);
    let points: Vec<LinkPoint> = links.iter().map(|link| LinkPoint::origin(*link)).collect();
    let mut jacobians = vec![Jacobian::zeros(robot.joint_count()); points.len()];
    let postures = postures(&robot);
    let mut configuration = Configuration::new(&robot, &postures[0]).map_err(|error| error.to_string())?;
    let mut frames = Vec::new();
    for posture in &postures {
        configuration.update(&robot, posture).map_err(|error| error.to_string())?;
        let of_links: Vec<Value> = points.iter().zip(&mut jacobians).map(|pair| frame(&configuration, pair)).collect();
        frames.push(json!({"posture": posture, "links": of_links}));
    }
    Ok(json!({
        "file": file,
        "base": robot.links()[LinkId::BASE.index()].name,
        "joints": robot.joints().iter().map(|joint| joint.name.as_str()).collect::<Vec<_>>(),
        "links": links.iter().map(|link| robot.links()[link.index()].name.as_str()).collect::<Vec<_>>(),
        "postures": frames,
        "tool": robot.tips().first().map(|tip| robot.links()[tip.link.index()].name.as_str()),
        "tool_time_ns": time_ns(&robot, &postures, &[], &mut []),
        "time_ns": time_ns(&robot, &postures, &points, &mut jacobians),
    }))
}

/// Returns the links that carry no other one.
fn outermost(robot: &RobotModel) -> Vec<LinkId> {
    let links = robot.links().iter().filter_map(|link| robot.link(&link.name));
    links.filter(|link| robot.links().iter().all(|other| other.parent != Some(*link))).collect()
}

/// Returns postures that are spread over the range of the joints, each n.
fn postures(robot: &RobotModel) -> Vec<Vec<f64>> {
    let mut state = 1_u64;
    let mut random = move || {
        // A multiplicative generator; its upper bits are random enough to spread postures.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(state >> 32).unwrap_or_default()) / f64::from(u32::MAX)
    };
    let ranges: Vec<[f64; 2]> = robot
        .joints()
        .iter()
        .map(|joint| [joint.limits.lower.max(-UNLIMITED), joint.limits.upper.min(UNLIMITED)])
        .collect();
    (0..POSTURES).map(|_| ranges.iter().map(|[low, high]| low + (high - low) * random()).collect()).collect()
}

/// Returns position, rotation by rows and Jacobian by rows of a point.
fn frame(configuration: &Configuration, (point, jacobian): (&LinkPoint, &mut Jacobian)) -> Value {
    let pose = configuration.point_pose(point);
    configuration.write_point_jacobian(point, jacobian);
    json!({
        "position": pose.translation.vector.as_slice(),
        "rotation": pose.rotation.matrix().transpose().as_slice(),
        "jacobian": jacobian.transpose().as_slice(),
    })
}

/// Returns the least mean time of one posture over repeated passes, ns: all frames, pose and Jacobian of the tool, and poses
/// and Jacobians of the points.
fn time_ns(robot: &RobotModel, postures: &[Vec<f64>], points: &[LinkPoint], jacobians: &mut [Jacobian]) -> Option<f64> {
    let mut configuration = Configuration::new(robot, &postures[0]).ok()?;
    let (mut least, start) = (f64::INFINITY, Instant::now());
    while start.elapsed() < BUDGET {
        let pass = Instant::now();
        for posture in postures {
            configuration.update(robot, black_box(posture)).ok()?;
            for (point, jacobian) in points.iter().zip(&mut *jacobians) {
                black_box(configuration.point_pose(point));
                configuration.write_point_jacobian(point, jacobian);
                black_box(&*jacobian);
            }
        }
        least = least.min(pass.elapsed().as_secs_f64() / postures.len() as f64);
    }
    Some(1e9 * least)
}
