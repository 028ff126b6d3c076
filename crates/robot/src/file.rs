//! Robots read from files.

use std::path::{Path, PathBuf};

use super::{FixtureError, RobotModel, UrdfError, UrdfOptions, from_json, from_toml};

/// Why a robot file is refused.
#[derive(Debug, thiserror::Error)]
pub enum RobotFileError {
    /// The file cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The ending of the name does not say what is in it.
    #[error("{0}: robots are described in .urdf, .toml or .json")]
    Ending(PathBuf),
    /// Base or tip for a description that has but one chain.
    #[error("{0}: `base` and `tip` are for .urdf; the joints of this file are the chain")]
    Chain(PathBuf),
    /// No robot in URDF.
    #[error("{path}: {source}")]
    Urdf {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: UrdfError,
    },
    /// No robot in TOML or JSON.
    #[error("{path}: {source}")]
    Fixture {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: FixtureError,
    },
}

/// Reads a robot from a file, in URDF, TOML or JSON by the ending of its name.
pub fn from_file(path: &Path, options: &UrdfOptions) -> Result<RobotModel, RobotFileError> {
    let owned = || path.to_owned();
    let read = || std::fs::read_to_string(path).map_err(|source| RobotFileError::Read { path: owned(), source });
    let ending = path.extension().and_then(|ending| ending.to_str());
    let described = match ending {
        Some("urdf") => {
            let robot = RobotModel::from_urdf(&read()?, options);
            return robot.map_err(|source| RobotFileError::Urdf { path: owned(), source });
        }
        Some("toml" | "json") if options.base.is_some() || options.tip.is_some() => {
            return Err(RobotFileError::Chain(owned()));
        }
        Some("toml") => from_toml(&read()?),
        Some("json") => from_json(&read()?),
        _ => return Err(RobotFileError::Ending(owned())),
    };
    let robot = described.map_err(|source| RobotFileError::Fixture { path: owned(), source })?;
    Ok(match options.name {
        Some(name) => robot.renamed(name),
        None => robot,
    })
}
