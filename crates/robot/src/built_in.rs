//! The robots that ship with the crate.

use std::sync::{Arc, LazyLock};

use super::{RobotModel, UrdfOptions, from_toml};

macro_rules! urdf {
    ($name:literal, $description:literal) => {
        (include_str!(concat!("../robots/", $name, ".urdf")), $description)
    };
}

const DENAVIT_HARTENBERG: [&str; 1] = [include_str!("../robots/sawyer_dh.toml")];

/// Text and description.
const URDF: [(&str, &str); 4] = [
    urdf!(
        "sawyer",
        "Sawyer, 7 joints, joint positions and limits of the manufacturer's description; base and tool frame are those \
         of Table 1 of Su et al. 2022"
    ),
    urdf!("ur5e", "UR5e-like, 6 joints, Denavit-Hartenberg parameters of the manufacturer, tool at the flange"),
    urdf!("panda", "Panda-like, 7 joints, Denavit-Hartenberg parameters of the manufacturer, tool at the flange"),
    urdf!("planar_3r", "three links of 0.5, 0.4 and 0.3 m in the horizontal plane, redundant for positions in it"),
];

/// The robots that ship with the crate; the first is `sawyer_dh`.
pub fn built_in() -> &'static [Arc<RobotModel>] {
    static ROBOTS: LazyLock<Vec<Arc<RobotModel>>> = LazyLock::new(|| {
        const READ: &str = "built-in robots are read by every test";
        let from_urdf = |(text, description): &(&str, &str)| {
            let options = UrdfOptions { description: Some(description), ..UrdfOptions::default() };
            Arc::new(RobotModel::from_urdf(text, &options).expect(READ))
        };
        let toml = DENAVIT_HARTENBERG.iter().map(|text| Arc::new(from_toml(text).expect(READ)));
        toml.chain(URDF.iter().map(from_urdf)).collect()
    });
    &ROBOTS
}
