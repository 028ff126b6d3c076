//! Prints which chain of a URDF file is taken for the arm, one line of JSON per file.
//!
//! ```sh
//! cargo run -p revprio-robot --example chain -- my_arm.urdf
//! ```

use std::path::Path;

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
    json!({"base": base, "tip": tip, "joints": joints, "left_out": left_out})
}
