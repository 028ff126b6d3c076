//! Robots read from files, and the robots that ship with the crate.

use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use super::built_in_shapes::with_built_in_shapes;
use super::{DescriptionError, Overrides, RobotModel, UrdfError, UrdfOptions, UrdfTreeOptions, from_json, from_toml};

/// Why a robot file is refused.
#[derive(Debug, thiserror::Error)]
pub enum RobotFileError {
    /// The file cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The extension of the file name is unknown.
    #[error("{0}: robots are described in .urdf, .toml or .json")]
    Extension(PathBuf),
    /// Base, tip or overrides are given for a description that has only one chain.
    #[error("{0}: `base` and `tip` are for .urdf, also those in `overrides`; change this file itself")]
    BaseOrTip(PathBuf),
    /// The URDF text is not a robot.
    #[error("{path}: {source}")]
    Urdf {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: UrdfError,
    },
    /// The TOML or JSON text is not a robot.
    #[error("{path}: {source}")]
    Description {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: DescriptionError,
    },
}

/// Reads a robot from a file. The extension of its name decides between URDF, TOML and JSON.
pub fn from_file(path: &Path, options: &UrdfOptions) -> Result<RobotModel, RobotFileError> {
    let owned = || path.to_owned();
    let read = || std::fs::read_to_string(path).map_err(|source| RobotFileError::Read { path: owned(), source });
    let extension = path.extension().and_then(|extension| extension.to_str());
    let described = match extension {
        Some("urdf") => {
            let robot = RobotModel::from_urdf(&read()?, options);
            return robot.map_err(|source| RobotFileError::Urdf { path: owned(), source });
        }
        Some("toml" | "json") if is_chosen(options) => {
            return Err(RobotFileError::BaseOrTip(owned()));
        }
        Some("toml") => from_toml(&read()?),
        Some("json") => from_json(&read()?),
        _ => return Err(RobotFileError::Extension(owned())),
    };
    let robot = described.map_err(|source| RobotFileError::Description { path: owned(), source })?;
    Ok(match options.name {
        Some(name) => robot.renamed(name),
        None => robot,
    })
}

/// Reads the whole tree of a URDF file, `.urdf`.
pub fn tree_from_file(path: &Path, options: &UrdfTreeOptions) -> Result<RobotModel, RobotFileError> {
    if path.extension().is_none_or(|extension| extension != "urdf") {
        return Err(RobotFileError::BaseOrTip(path.to_owned()));
    }
    let text =
        std::fs::read_to_string(path).map_err(|source| RobotFileError::Read { path: path.to_owned(), source })?;
    RobotModel::from_urdf_tree(&text, options).map_err(|source| RobotFileError::Urdf { path: path.to_owned(), source })
}

/// Whether the options say more than a name.
fn is_chosen(options: &UrdfOptions) -> bool {
    let overrides = options.overrides.is_some_and(|overrides| *overrides != Overrides::default());
    options.base.is_some() || options.tip.is_some() || overrides
}

macro_rules! urdf {
    ($name:literal, $description:literal) => {
        (include_str!(concat!("../robots/", $name, ".urdf")), $description)
    };
}

const SAWYER_DH: &str = include_str!("../robots/sawyer_dh.toml");

/// URDF text and description of each robot.
const URDF: [(&str, &str); 9] = [
    urdf!(
        "sawyer",
        "Sawyer, 7 joints, joint positions and limits of the manufacturer's description; base and tool frame are those \
         of Table 1 of Su et al. 2022"
    ),
    urdf!("ur5e", "UR5e-like, 6 joints, Denavit-Hartenberg parameters of the manufacturer, tool at the flange"),
    urdf!("panda", "Panda-like, 7 joints, Denavit-Hartenberg parameters of the manufacturer, tool at the flange"),
    urdf!("planar_3r", "three links of 0.5, 0.4 and 0.3 m in the horizontal plane, redundant for positions in it"),
    urdf!(
        "so101",
        "SO-101-like, 5 joints, dimensions of the makers, tool between the jaws; the gripper is no joint: give it a channel"
    ),
    urdf!(
        "fr3",
        "Franka Research 3-like, 7 joints, Denavit-Hartenberg parameters and limits of the manufacturer with their velocity limits near \
         the ends of the joints, tool at the flange"
    ),
    urdf!("xarm7", "xArm 7-like, 7 joints, Denavit-Hartenberg parameters of the manufacturer, tool at the flange"),
    urdf!("iiwa14", "LBR iiwa 14 R820-like, 7 joints, dimensions of the data sheet, tool at the flange"),
    urdf!(
        "gen3",
        "Kinova Gen3-like, 7 joints of which 4 turn without end, dimensions of the manufacturer, tool at the interface"
    ),
];

/// Returns the robots that ship with the crate: `sawyer_dh`, `sawyer`, `ur5e`, `panda`, `planar_3r`, `so101`, `fr3`,
/// `xarm7`, `iiwa14`, `gen3`, in this order.
pub fn built_in() -> &'static [Arc<RobotModel>] {
    static ROBOTS: LazyLock<Vec<Arc<RobotModel>>> = LazyLock::new(|| {
        const VALID: &str = "the tests read every built-in robot";
        let from_urdf = |(text, description): &(&str, &str)| {
            let options = UrdfOptions { description: Some(description), ..UrdfOptions::default() };
            Arc::new(with_built_in_shapes(RobotModel::from_urdf(text, &options).expect(VALID)))
        };
        let sawyer_dh = Arc::new(from_toml(SAWYER_DH).expect(VALID));
        std::iter::once(sawyer_dh).chain(URDF.iter().map(from_urdf)).collect()
    });
    &ROBOTS
}
