//! The arms that requests can name.

use std::sync::Arc;

use crate::robot::{RobotModel, built_in};

/// Known robots by name.
#[derive(Debug, Clone)]
pub struct Robots(Vec<Arc<RobotModel>>);

impl Robots {
    /// Those that ship with the crate.
    pub fn built_in() -> Self {
        Self(built_in().to_vec())
    }

    /// The robot of that name.
    pub fn get(&self, name: &str) -> Option<&Arc<RobotModel>> {
        self.0.iter().find(|robot| robot.name() == name)
    }

    /// All, in a fixed order.
    pub fn iter(&self) -> impl Iterator<Item = &Arc<RobotModel>> {
        self.0.iter()
    }

    /// All names, for error messages.
    pub fn names(&self) -> String {
        self.0.iter().map(|robot| format!("`{}`", robot.name())).collect::<Vec<_>>().join(", ")
    }
}
