//! The registry of the arms that requests can name.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::clock::Instant;
use revprio_robot::{RobotModel, built_in};

/// Maximum number of registered robots. Each uses at most about 100 kilobytes, mostly names.
const MAX_REGISTERED: usize = 64;

/// Maximum length of the name of a robot, bytes.
pub const MAX_NAME: usize = 64;

/// Maximum number of joints of a robot with those that follow others by `<mimic>`.
pub const MAX_MOVING_JOINTS: usize = 256;

/// Maximum number of joints of a robot and of a problem. It is enough for several humanoid robots.
pub const MAX_JOINTS: usize = 128;

/// The reason why a robot cannot be found, added or removed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RobotsError {
    /// The name cannot be a part of a URL.
    #[error(
        "`{0:.80}` cannot name a robot; use at most {MAX_NAME} letters, digits, `_`, `-` and `.`, and begin with a \
         letter or digit"
    )]
    Name(String),
    /// The robot has too many joints.
    #[error("{0} joints; a robot has at most {MAX_JOINTS}")]
    Joints(usize),
    /// The robot has too many joints that follow others.
    #[error("{0} joints with those that follow others by <mimic>; a robot has at most {MAX_MOVING_JOINTS}")]
    MovingJoints(usize),
    /// Another robot has the name.
    #[error("the name `{0}` is taken; choose another")]
    Taken(String),
    /// The maximum number of robots is registered.
    #[error("{MAX_REGISTERED} robots are registered already; delete one, or wait until an unused one ends")]
    Full,
    /// The robot came with the program or with `--robot`.
    #[error("`{0}` belongs to the service; only registered robots can be deleted")]
    Permanent(String),
    /// There is no such robot.
    #[error(
        "there is no robot `{name}`; register it (`revprio serve --robot FILE`, `POST /v1/robots`), or choose a known one: {known}"
    )]
    Unknown {
        /// The name.
        name: String,
        /// The names of all robots.
        known: String,
    },
}

/// All known robots: permanent robots, and robots that clients registered.
///
/// A registered robot ends when it is not used for the idle timeout. Every `Arc` of a robot counts as use, also with a tool
/// offset: while a session holds a robot, the robot does not end. Deleting a robot only frees its name.
#[derive(Debug)]
pub struct Robots {
    permanent: Vec<Arc<RobotModel>>,
    registered: Mutex<Vec<Registered>>,
    idle_timeout: Duration,
}

#[derive(Debug)]
struct Registered {
    robot: Arc<RobotModel>,
    /// Time of the first check that found no user; `None` while the robot is used.
    idle_since: Option<Instant>,
}

impl Registered {
    fn has_ended(&mut self, idle_timeout: Duration) -> bool {
        if Arc::strong_count(&self.robot) > 1 {
            self.idle_since = None;
            return false;
        }
        self.idle_since.get_or_insert_with(Instant::now).elapsed() >= idle_timeout
    }
}

/// Checks that a robot has at most [`MAX_JOINTS`] joints, and [`MAX_MOVING_JOINTS`] with those that follow others.
pub fn check_joints(robot: &RobotModel) -> Result<(), RobotsError> {
    match (robot.joint_count(), robot.moving_joints().len()) {
        (joints, _) if joints > MAX_JOINTS => Err(RobotsError::Joints(joints)),
        (_, moving) if moving > MAX_MOVING_JOINTS => Err(RobotsError::MovingJoints(moving)),
        _ => Ok(()),
    }
}

impl Robots {
    /// Creates a registry of the robots that ship with the program.
    pub fn built_in() -> Self {
        Self { permanent: built_in().to_vec(), ..Self::none() }
    }

    /// Creates an empty registry. Registered robots do not end before a service sets the idle timeout.
    pub fn none() -> Self {
        Self { permanent: Vec::new(), registered: Mutex::default(), idle_timeout: Duration::MAX }
    }

    /// Adds a permanent robot.
    pub fn with(mut self, robot: Arc<RobotModel>) -> Result<Self, RobotsError> {
        check_joints(&robot)?;
        self.check_name(robot.name(), &[])?;
        self.permanent.push(robot);
        Ok(self)
    }

    /// Sets the idle timeout of registered robots.
    #[must_use]
    pub fn with_idle_timeout(self, idle_timeout: Duration) -> Self {
        Self { idle_timeout, ..self }
    }

    /// Registers a robot until it is deleted or unused for the idle timeout.
    pub fn register(&self, robot: Arc<RobotModel>) -> Result<(), RobotsError> {
        let mut registered = self.registered();
        self.check_name(robot.name(), &registered)?;
        if registered.len() >= MAX_REGISTERED {
            return Err(RobotsError::Full);
        }
        registered.push(Registered { robot, idle_since: None });
        Ok(())
    }

    /// Removes a registered robot.
    pub fn remove(&self, name: &str) -> Result<(), RobotsError> {
        if self.is_permanent(name) {
            return Err(RobotsError::Permanent(name.to_owned()));
        }
        let mut registered = self.registered();
        let index = registered.iter().position(|entry| entry.robot.name() == name);
        let removed = index.map(|index| registered.remove(index));
        drop(registered);
        removed.map(drop).ok_or_else(|| self.unknown(name))
    }

    /// Returns whether the robot is permanent.
    pub fn is_permanent(&self, name: &str) -> bool {
        self.permanent.iter().any(|robot| robot.name() == name)
    }

    /// Returns the robot with this name.
    pub fn get(&self, name: &str) -> Result<Arc<RobotModel>, RobotsError> {
        if let Some(robot) = self.permanent.iter().find(|robot| robot.name() == name) {
            return Ok(Arc::clone(robot));
        }
        let found = self.registered().iter_mut().find(|entry| entry.robot.name() == name).map(|entry| {
            entry.idle_since = None;
            Arc::clone(&entry.robot)
        });
        found.ok_or_else(|| self.unknown(name))
    }

    /// Returns all robots: permanent ones first, then the others in the order of registration.
    pub fn all(&self) -> Vec<Arc<RobotModel>> {
        let registered = self.registered();
        let registered = registered.iter().map(|entry| &entry.robot);
        self.permanent.iter().chain(registered).cloned().collect()
    }

    fn unknown(&self, name: &str) -> RobotsError {
        let known: Vec<String> = self.all().iter().map(|robot| format!("`{}`", robot.name())).collect();
        RobotsError::Unknown { name: name.to_owned(), known: known.join(", ") }
    }

    fn check_name(&self, name: &str, registered: &[Registered]) -> Result<(), RobotsError> {
        let is_word = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
        let starts_well = name.starts_with(|c: char| c.is_ascii_alphanumeric());
        if !(starts_well && name.len() <= MAX_NAME && name.chars().all(is_word)) {
            return Err(RobotsError::Name(name.to_owned()));
        }
        let mut others = self.permanent.iter().chain(registered.iter().map(|entry| &entry.robot));
        if others.any(|other| other.name() == name) { Err(RobotsError::Taken(name.to_owned())) } else { Ok(()) }
    }

    /// Removes the registered robots that have ended, and returns the others.
    fn registered(&self) -> MutexGuard<'_, Vec<Registered>> {
        let mut registered = self.registered.lock().unwrap_or_else(PoisonError::into_inner);
        registered.retain_mut(|entry| !entry.has_ended(self.idle_timeout));
        registered
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::IsometryMatrix3;
    use revprio_robot::{UrdfTip, UrdfTreeOptions};

    use super::*;

    fn named(name: &str) -> Arc<RobotModel> {
        Arc::new(RobotModel::clone(&built_in()[0]).renamed(name))
    }

    #[test]
    fn an_unused_registered_robot_ends() {
        let robots = Robots { idle_timeout: Duration::ZERO, ..Robots::built_in() };
        let held = named("held");
        robots.register(Arc::clone(&held)).unwrap();
        robots.register(named("forgotten")).unwrap();
        assert!(robots.get("held").is_ok());
        assert!(matches!(robots.get("forgotten"), Err(RobotsError::Unknown { .. })));
        drop(held);
        assert!(robots.get("held").is_err() && robots.get("sawyer_dh").is_ok());
    }

    /// A session with a `tool_offset` has a robot of its own.
    #[test]
    fn a_registered_robot_stays_while_one_with_another_tool_is_used() {
        let robots = Robots { idle_timeout: Duration::ZERO, ..Robots::built_in() };
        let robot = named("held");
        robots.register(Arc::clone(&robot)).unwrap();
        let longer = robot.with_tool_offset(&IsometryMatrix3::translation(0.0, 0.0, 0.1)).unwrap();
        drop(robot);
        assert!(robots.get("held").is_ok());
        drop(longer);
        assert!(robots.get("held").is_err());
    }

    #[test]
    fn a_robot_of_a_file_has_as_many_joints_as_a_registered_one() {
        let link = |i| format!("<link name='l{i}'/>");
        let robot = |joints: &[String]| {
            let links: Vec<String> = (0..=joints.len()).map(link).collect();
            let text = format!("<robot name='chain'>{}{}</robot>", links.concat(), joints.concat());
            let tips: Vec<String> = (1..=joints.len()).map(|i| format!("l{i}")).collect();
            let tip = |link| UrdfTip { name: link, link, offset: IsometryMatrix3::identity() };
            let tips: Vec<UrdfTip> = tips.iter().map(|link| tip(link.as_str())).collect();
            let options = UrdfTreeOptions { tips: &tips, ..UrdfTreeOptions::default() };
            Robots::none().with(Arc::new(RobotModel::from_urdf_tree(&text, &options).unwrap()))
        };
        let joint = |i: usize, parent: usize, mimic: &str| {
            let child = i + 1;
            format!(
                "<joint name='j{i}' type='continuous'><parent link='l{parent}'/><child link='l{child}'/><axis xyz='0 0 1'/>{mimic}</joint>"
            )
        };
        let chain = |joints: usize| (0..joints).map(|i| joint(i, i, "")).collect::<Vec<_>>();
        assert!(robot(&chain(MAX_JOINTS)).is_ok());
        assert_eq!(robot(&chain(MAX_JOINTS + 1)).unwrap_err(), RobotsError::Joints(MAX_JOINTS + 1));
        let mut hand = vec![joint(0, 0, "")];
        hand.extend((1..MAX_MOVING_JOINTS).map(|i| joint(i, 0, "<mimic joint='j0'/>")));
        assert!(robot(&hand).is_ok());
        hand.push(joint(MAX_MOVING_JOINTS, 0, "<mimic joint='j0'/>"));
        assert_eq!(robot(&hand).unwrap_err(), RobotsError::MovingJoints(MAX_MOVING_JOINTS + 1));
    }

    #[test]
    fn the_idle_time_counts_from_the_end_of_the_last_use() {
        let robots = Robots { idle_timeout: Duration::from_millis(50), ..Robots::none() };
        robots.register(named("arm")).unwrap();
        let held = robots.get("arm").unwrap();
        std::thread::sleep(Duration::from_millis(60));
        drop(held);
        assert_eq!(robots.all().len(), 1, "the robot was in use until now");
        std::thread::sleep(Duration::from_millis(60));
        assert_eq!(robots.all().len(), 0);
    }

    #[test]
    fn names_are_words_and_unique() {
        let robots = Robots::built_in();
        let too_long = "a".repeat(65);
        for name in ["", "..", "a/b", "a b", "-a", "ä", "a\n", too_long.as_str()] {
            assert_eq!(robots.register(named(name)), Err(RobotsError::Name(name.to_owned())));
        }
        assert_eq!(robots.register(named("sawyer")), Err(RobotsError::Taken("sawyer".to_owned())));
        assert_eq!(robots.register(named("cell-4.arm_2")), Ok(()));
        assert_eq!(robots.register(named("cell-4.arm_2")), Err(RobotsError::Taken("cell-4.arm_2".to_owned())));
        assert!(Robots::built_in().with(named("panda")).is_err() && Robots::none().with(named("panda")).is_ok());
    }
}
