//! Built-in arms compared with descriptions that others wrote (fixtures/golden/README.md).

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};
use revprio_robot::built_in;
use revprio_robot::kinematics::Configuration;

#[derive(serde::Deserialize)]
struct Arm {
    source: String,
    /// q, position (m) and rotation matrix row by row.
    rows: Vec<Vec<f64>>,
}

/// Largest deviation of position (m) and rotation matrix. Three of the descriptions round right angles to five or six digits.
const TOLERANCE: [(&str, f64); 5] = [("so101", 2e-5), ("fr3", 1e-9), ("xarm7", 2e-5), ("iiwa14", 1e-9), ("gen3", 2e-5)];

#[test]
fn tool_poses_are_those_of_descriptions_by_others() {
    let golden: BTreeMap<String, Arm> =
        serde_json::from_str(include_str!("../../../fixtures/golden/others.json")).unwrap();
    assert_eq!(golden.len(), TOLERANCE.len());
    for (name, tolerance) in TOLERANCE {
        let (arm, robot) = (&golden[name], built_in().iter().find(|robot| robot.name() == name).unwrap());
        assert_eq!(arm.rows.len(), 20);
        for row in &arm.rows {
            let (q, pose) = row.split_at(robot.joint_count());
            let ours = *Configuration::new(robot, q).unwrap().tool_pose();
            let position = (ours.translation.vector - Vector3::from_column_slice(&pose[..3])).amax();
            let rotation = (ours.rotation.matrix() - Matrix3::from_row_slice(&pose[3..])).amax();
            let source = &arm.source;
            assert!(
                position <= tolerance && rotation <= tolerance,
                "{name} at {q:?}: {position:e} {rotation:e}, {source}"
            );
        }
    }
}
