//! The target `urdf`: registers a robot, then uses it.

use revprio_api::wire::{KinematicsAnswer, Robot, StepAnswer};
use serde_json::{Value, json};

use crate::Defect;
use crate::answers::{command, value};
use crate::budget::Work;
use crate::limits::SpeedLimits;
use crate::target::split_line;
use crate::timed_service::TimedService;

const NAME: &str = "fuzzed";

/// Registers the robot of an input, computes its kinematics, steps a controller with it, and deletes it.
pub fn check(service: &TimedService, input: &[u8]) -> Result<(), Defect> {
    let registration = registration(input).to_string();
    let answer = service.post("/v1/robots", registration.as_bytes(), Work::default())?;
    let Some(robot) = value::<Robot>(&answer, false)? else { return Ok(()) };
    let used = step(service, &robot);
    let deleted = service.untimed().delete("/v1/robots/fuzzed")?;
    used?;
    if deleted.status == 204 { Ok(()) } else { Err(Defect::Wrong(format!("deleted with {}", deleted.status))) }
}

/// Reads an input: the text, or a line with base and tip before the text.
fn registration(input: &[u8]) -> Value {
    let lossy = String::from_utf8_lossy;
    match split_line(input) {
        Some((line, text)) if !line.starts_with(b"<") => {
            let line = lossy(line);
            let mut names = line.split(' ').filter(|name| !name.is_empty());
            json!({"name": NAME, "urdf": lossy(text), "base": names.next(), "tip": names.next()})
        }
        _ => json!({"name": NAME, "urdf": lossy(input)}),
    }
}

fn step(service: &TimedService, robot: &Robot) -> Result<(), Defect> {
    let joints = robot.joints.len();
    let middle = |range: Option<[f64; 2]>| range.map_or(0.1, |[lower, upper]| lower + 0.5 * (upper - lower));
    let position: Vec<f64> = robot.joints.iter().map(|joint| middle(joint.position_limit)).collect();
    let work = Work { price: 9 * joints.pow(3), ..Work::default() };
    let body = json!({"robot": NAME, "joint_position": position}).to_string();
    value::<KinematicsAnswer>(&service.post("/v1/kinematics", body.as_bytes(), work)?, false)?;
    let velocity = json!({"kind": "velocity", "target_velocity": {"kind": "constant", "value": 1e3}});
    let body = json!({
        "controller": {"robot": NAME, "period_s": 0.001,
            "tasks": [{"name": "move", "axes": ["x", "y", "z", "rx"], "law": velocity}]},
        "state": {"sequence": 1, "time_s": 0, "joint_position": position}
    });
    let answer = service.post("/v1/step", body.to_string().as_bytes(), work)?;
    let Some(answer) = value::<StepAnswer>(&answer, work.exceeds_arm())? else { return Ok(()) };
    let bound = |limit: Option<f64>| limit.map_or((-f64::MAX, f64::MAX), |limit| (-limit, limit));
    let limits: SpeedLimits = robot.joints.iter().map(|joint| bound(joint.velocity_limit)).collect();
    command(&answer, Some(&limits))
}
