//! The value of `--robot`: a robot file with options.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use revprio_api::wire::{
    CollisionPairs, LinkShape, Pose, RegisteredTip, RobotRegistration, ShapeSource, StatedLimits, object,
};
use revprio_api::{Client, ClientError};
use revprio_local::json;
use revprio_robot::collision::MeshDirectory;
use revprio_robot::{Overrides, RobotFileError, RobotModel, UrdfOptions, UrdfTreeOptions, from_file, tree_from_file};
use serde::{Deserialize, Serialize};

use crate::service::{
    check_tip_names, frames_of_srdf, overrides, registered_tips, robot_answer, shapes_answer, with_shapes,
};

/// A robot file with options.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct RobotArgument {
    path: PathBuf,
    name: Option<String>,
    base: Option<String>,
    tip: Option<String>,
    overrides: Option<PathBuf>,
    srdf: Option<PathBuf>,
    /// Whether capsules that contain the `<collision>` elements cover the links.
    fits_shapes: bool,
}

/// The values of an overrides file: those of a registration besides its name and text.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct OverridesFile {
    base: Option<String>,
    tip: Option<String>,
    tips: Option<Vec<RegisteredTip>>,
    #[serde(default, deserialize_with = "object::optional_map")]
    limits: Option<BTreeMap<String, StatedLimits>>,
    #[serde(default, deserialize_with = "object::optional_texts")]
    joint_names: Option<BTreeMap<String, String>>,
    tool_offset: Option<Pose>,
    shapes: Option<ShapeSource>,
    shape_list: Option<Vec<LinkShape>>,
    collision_pairs: Option<CollisionPairs>,
}

/// Why a robot argument cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RobotArgumentError {
    /// The robot file is not valid.
    #[error(transparent)]
    File(#[from] RobotFileError),
    /// The file with the overrides of a robot is not valid.
    #[error("--robot FILE,overrides={path}: {message}")]
    Overrides {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// The SRDF file of a robot is not valid.
    #[error("{path}: {message}")]
    Srdf {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// The shapes of a robot cannot be made.
    #[error("{path}: {message}")]
    Shapes {
        /// The robot file.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
    /// The server has another robot of that name.
    #[error("{server} has another robot `{name}`; choose another name: `FILE,name=NAME`")]
    OtherRobot {
        /// The service.
        server: String,
        /// The name.
        name: String,
    },
    /// Only URDF robots can be registered at a server.
    #[error(
        "only URDF robots can be registered at a running server; start it with `revprio serve --robot {0}`, or leave out \
         --server"
    )]
    NotSent(String),
    /// The service did not answer.
    #[error(transparent)]
    Client(#[from] ClientError),
}

impl RobotArgument {
    pub const SYNTAX: &str = "FILE[,name=NAME][,base=LINK][,tip=LINK][,srdf=FILE][,shapes=fit][,overrides=FILE]";

    pub const HELP: &str = "Your own robot, as URDF (.urdf) or Denavit-Hartenberg rows (.toml, .json). For URDF, `tip` is the link \
         of the tool frame and `base` the link of the base frame, if the file has several candidates; `srdf` is the semantic \
         description that belongs to it; `shapes=fit` covers its links by capsules that contain its <collision> elements and their \
         meshes; `overrides` is a JSON file with any of `base`, `tip`, `tips`, `limits`, `joint_names`, `tool_offset`, `shapes`, \
         `shape_list` and `collision_pairs` of POST /v1/robots";

    /// Returns the robots of a directory in the order of their names. Each file is a robot with the name of the file,
    /// without the extension; a `.srdf` beside a `.urdf` of the same name is its semantic description. Subdirectories and hidden files are
    /// not read.
    pub fn in_directory(directory: &Path) -> Result<Vec<Self>, RobotFileError> {
        let read = |source| RobotFileError::Read { path: directory.to_owned(), source };
        let entries: Vec<_> = std::fs::read_dir(directory).and_then(Iterator::collect).map_err(read)?;
        let is_hidden = |path: &Path| path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        let paths = entries.iter().map(std::fs::DirEntry::path);
        let mut paths: Vec<PathBuf> = paths.filter(|path| !path.is_dir() && !is_hidden(path)).collect();
        paths.sort();
        let name = |path: &Path| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let srdf = |path: &Path| {
            Some(path.with_extension("srdf")).filter(|srdf| has_extension(path, "urdf") && paths.contains(srdf))
        };
        let is_robot = |path: &&PathBuf| !has_extension(path, "srdf") || !paths.contains(&path.with_extension("urdf"));
        let robot = |path: &PathBuf| Self { name: name(path), srdf: srdf(path), ..Self::of_file(path.clone()) };
        Ok(paths.iter().filter(is_robot).map(robot).collect())
    }

    /// Returns the argument of a file without options.
    fn of_file(path: PathBuf) -> Self {
        Self { path, name: None, base: None, tip: None, overrides: None, srdf: None, fits_shapes: false }
    }

    /// Returns the same argument, with capsules that contain the `<collision>` elements of the file.
    pub fn with_fitted_shapes(&self) -> Self {
        Self { fits_shapes: true, ..self.clone() }
    }

    /// Returns the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Reads the robot.
    pub fn read(&self) -> Result<Arc<RobotModel>, RobotArgumentError> {
        let registration = self.registration(String::new())?;
        let robot = self.read_without_shapes(&registration)?;
        let meshes = MeshDirectory::of_urdf(&self.path);
        let wrong = |message: String| RobotArgumentError::Shapes { path: self.path.clone(), message };
        if registration.shapes.is_some() && !self.is_urdf() {
            let message = "only .urdf has bodies; leave out `shapes`, and state `shape_list` in `overrides`";
            return Err(wrong(message.to_owned()));
        }
        let robot = with_shapes(robot, &registration, Some(&meshes)).map_err(|error| wrong(error.to_string()))?;
        Ok(Arc::new(robot))
    }

    fn read_without_shapes(&self, registration: &RobotRegistration) -> Result<RobotModel, RobotArgumentError> {
        let overrides = overrides(registration).map_err(|error| self.wrong_overrides(error.to_string()))?;
        if let Some(tips) = &registration.tips {
            return self.read_tree(tips, registration, &overrides);
        }
        let options = UrdfOptions {
            name: self.name.as_deref(),
            description: None,
            base: registration.base.as_deref(),
            tip: registration.tip.as_deref(),
            overrides: self.overrides.is_some().then_some(&overrides),
        };
        Ok(from_file(&self.path, &options)?)
    }

    /// Reads a robot with these tips: all that is below the base.
    fn read_tree(
        &self,
        tips: &[RegisteredTip],
        registration: &RobotRegistration,
        overrides: &Overrides,
    ) -> Result<RobotModel, RobotArgumentError> {
        let tips: Vec<_> = registered_tips(tips).map_err(|error| self.wrong_tips(error.to_string()))?;
        let options = UrdfTreeOptions {
            name: self.name.as_deref(),
            description: None,
            base: registration.base.as_deref(),
            tips: &tips,
            overrides: Some(overrides),
        };
        let robot = tree_from_file(&self.path, &options)?;
        check_tip_names(&robot).map_err(|error| self.wrong_tips(error.to_string()))?;
        Ok(robot)
    }

    /// Returns the registration of the robot; base and tip of the argument have priority over those of its overrides file.
    fn registration(&self, name: String) -> Result<RobotRegistration, RobotArgumentError> {
        let file = self.overrides_file()?;
        if file.tips.is_some() && (self.tip.is_some() || file.tip.is_some()) {
            return Err(self.wrong_overrides("give either `tip` or `tips`".to_owned()));
        }
        let registration = RobotRegistration {
            name,
            urdf: if self.is_urdf() { read_text(&self.path)? } else { String::new() },
            srdf: self.srdf.as_ref().map(|path| read_text(path)).transpose()?,
            shapes: file.shapes.or(self.fits_shapes.then_some(ShapeSource::Fit)),
            shape_list: file.shape_list,
            collision_pairs: file.collision_pairs,
            base: self.base.clone().or(file.base),
            tip: self.tip.clone().or(file.tip),
            tips: file.tips,
            limits: file.limits,
            joint_names: file.joint_names,
            tool_offset: file.tool_offset,
        };
        let with_frames = frames_of_srdf(&registration).map_err(|error| {
            let path = self.srdf.as_ref().unwrap_or(&self.path).clone();
            RobotArgumentError::Srdf { path, message: error.to_string().replacen("/srdf: ", "", 1) }
        })?;
        Ok(with_frames.unwrap_or(registration))
    }

    fn is_urdf(&self) -> bool {
        has_extension(&self.path, "urdf")
    }

    fn overrides_file(&self) -> Result<OverridesFile, RobotArgumentError> {
        let Some(path) = &self.overrides else { return Ok(OverridesFile::default()) };
        let text = std::fs::read_to_string(path).map_err(|error| self.wrong_overrides(error.to_string()))?;
        json::read(text.as_bytes()).map_err(|error| self.wrong_overrides(error.to_string()))
    }

    /// Returns an error of the tips, which the overrides or the SRDF file name.
    fn wrong_tips(&self, message: String) -> RobotArgumentError {
        match (&self.overrides, &self.srdf) {
            (None, Some(path)) => RobotArgumentError::Srdf { path: path.clone(), message },
            _ => self.wrong_overrides(message),
        }
    }

    fn wrong_overrides(&self, message: String) -> RobotArgumentError {
        RobotArgumentError::Overrides { path: self.overrides.clone().unwrap_or_default(), message }
    }

    /// Registers the robot at a server; `None` if the server already has it.
    pub fn register(
        &self,
        robot: &RobotModel,
        client: &Client,
        server: &str,
    ) -> Result<Option<Registration>, RobotArgumentError> {
        if let Some(known) = client.robots()?.robots.into_iter().find(|known| known.name == robot.name()) {
            return if known == robot_answer(robot) {
                Ok(None)
            } else {
                Err(RobotArgumentError::OtherRobot { server: server.to_owned(), name: known.name })
            };
        }
        if !self.is_urdf() {
            return Err(RobotArgumentError::NotSent(self.to_string()));
        }
        let mut registration = self.registration(robot.name().to_owned())?;
        if registration.shapes.take().is_some() {
            // The server does not have the meshes.
            registration.shape_list = shapes_answer(robot).map(|shapes| shapes.shape_list);
        }
        Ok(Some(Registration::new(&registration, client)?))
    }
}

impl FromStr for RobotArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut parts = text.split(',');
        let path = parts.next().filter(|path| !path.is_empty()).ok_or("give a file")?;
        let mut argument = Self::of_file(path.into());
        let (mut overrides, mut srdf, mut shapes) = (None, None, None);
        for part in parts {
            let slot = match part.split_once('=') {
                Some(("name", value)) => (&mut argument.name, value),
                Some(("base", value)) => (&mut argument.base, value),
                Some(("tip", value)) => (&mut argument.tip, value),
                Some(("overrides", value)) => (&mut overrides, value),
                Some(("srdf", value)) => (&mut srdf, value),
                Some(("shapes", value @ "fit")) => (&mut shapes, value),
                _ => {
                    return Err(format!("`{part}` is none of name=…, base=…, tip=…, srdf=…, shapes=fit, overrides=…"));
                }
            };
            if slot.0.replace(slot.1.to_owned()).is_some() {
                return Err(format!("`{part}` is given twice"));
            }
        }
        argument.overrides = overrides.map(PathBuf::from);
        argument.srdf = srdf.map(PathBuf::from);
        argument.fits_shapes = shapes.is_some();
        Ok(argument)
    }
}

impl TryFrom<String> for RobotArgument {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<RobotArgument> for String {
    fn from(argument: RobotArgument) -> Self {
        argument.to_string()
    }
}

impl fmt::Display for RobotArgument {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{}", self.path.display())?;
        let options = [("name", &self.name), ("base", &self.base), ("tip", &self.tip)];
        for (key, value) in options.into_iter().filter_map(|(key, value)| Some((key, value.as_ref()?))) {
            write!(formatter, ",{key}={value}")?;
        }
        for (key, path) in [("srdf", &self.srdf), ("overrides", &self.overrides)] {
            if let Some(path) = path {
                write!(formatter, ",{key}={}", path.display())?;
            }
        }
        if self.fits_shapes { formatter.write_str(",shapes=fit") } else { Ok(()) }
    }
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|ending| ending == extension)
}

fn read_text(path: &Path) -> Result<String, RobotFileError> {
    std::fs::read_to_string(path).map_err(|source| RobotFileError::Read { path: path.to_owned(), source })
}

/// A robot that is registered at a server until this value is dropped.
pub struct Registration {
    client: Client,
    name: String,
}

impl Registration {
    fn new(registration: &RobotRegistration, client: &Client) -> Result<Self, ClientError> {
        let name = client.register_robot(registration)?.name;
        Ok(Self { client: client.clone(), name })
    }
}

impl Drop for Registration {
    /// If this fails, the server removes the unused robot itself.
    fn drop(&mut self) {
        let _ = self.client.delete_robot(&self.name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_accepted_in_any_order() {
        let text = "arms/my.urdf,tip=hand,name=mine,shapes=fit,srdf=my.srdf,overrides=my.json";
        let robot: RobotArgument = text.parse().unwrap();
        assert_eq!((robot.path.to_str(), robot.name.as_deref()), (Some("arms/my.urdf"), Some("mine")));
        assert_eq!((robot.tip.as_deref(), robot.base.as_deref()), (Some("hand"), None));
        assert_eq!(robot.to_string().parse(), Ok(robot));
        for wrong in ["", ",tip=a", "a.urdf,tool=b", "a.urdf,tip", "a.urdf,tip=a,tip=b", "a.urdf,shapes=none"] {
            assert!(wrong.parse::<RobotArgument>().is_err(), "{wrong}");
        }
    }
}
