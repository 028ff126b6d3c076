//! Prints which chain of a URDF file is taken for the arm and where its tool is at three postures, one line of JSON per
//! file.
//!
//! ```sh
//! cargo run -p revprio-robot --example chain -- my_arm.urdf
//! ```

use std::path::Path;

use revprio_robot::kinematics::Configuration;
use revprio_robot::{RobotFileError, RobotModel, UrdfError, UrdfOptions, from_file};
use serde_json::{Value, json};

fn main() {
    for file in std::env::args().skip(1) {
        let answer = match read(&file, None) {
            Ok(robot) => json!({"file": file, "arms": [arm(&robot)]}),
            Err(RobotFileError::Urdf { source: UrdfError::Arms { tips, .. }, .. }) => several(&file, &tips),
            Err(error) => json!({"file": file, "error": error.to_string()}),
        };
        println!("{answer}");
    }
}

/// Returns the arms that a refusal names.
fn several(file: &str, tips: &[String]) -> Value {
    let arms: Result<Vec<Value>, _> = tips.iter().map(|tip| read(file, Some(tip)).map(|robot| arm(&robot))).collect();
    match arms {
        Ok(arms) => json!({"file": file, "arms": arms}),
        Err(error) => json!({"file": file, "error": error.to_string()}),
    }
}

fn read(file: &str, tip: Option<&str>) -> Result<RobotModel, RobotFileError> {
    from_file(Path::new(file), &UrdfOptions { tip, ..UrdfOptions::default() })
}

fn arm(robot: &RobotModel) -> Value {
    let joints: Vec<&str> = robot.joints().iter().map(|joint| joint.name.as_str()).collect();
    let chosen = robot.selection().map(|selection| {
        let left_out: Vec<&str> = selection.left_out.iter().map(|joint| joint.joint.as_str()).collect();
        (selection.base.as_str(), selection.tip.as_str(), left_out)
    });
    let (base, tip, left_out) = chosen.unwrap_or_default();
    let poses: Vec<Value> = (1..=3).map(|i| pose(robot, f64::from(i))).collect();
    json!({"base": base, "tip": tip, "joints": joints, "left_out": left_out, "poses": poses})
}

/// Returns a posture, rad or m, and the pose of the tool there: position, and rotation by rows.
fn pose(robot: &RobotModel, seed: f64) -> Value {
    let joints = robot.joints().iter().zip(1_u32..);
    let posture: Vec<f64> = joints.map(|(_, i)| 3.0 * (12.9898 * seed * f64::from(i)).sin()).collect();
    let Ok(configuration) = Configuration::new(robot, &posture) else { return Value::Null };
    let pose = configuration.tool_pose();
    let rotation: Vec<f64> = pose.rotation.matrix().transpose().iter().copied().collect();
    json!({"posture": posture, "position": pose.translation.vector.as_slice(), "rotation": rotation})
}
