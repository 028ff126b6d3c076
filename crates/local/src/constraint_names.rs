//! Names of the rows of constraints.

use std::sync::Arc;

use revprio_core::collision::CollisionReport;
use revprio_core::constraint::Constraint;
use revprio_core::controller::{Command, ControllerConfig};
use revprio_core::resolution::BoundId;

/// The names of constraints, and of the rows that watch distances.
#[derive(Debug, Clone, Default)]
pub struct ConstraintNames<'a> {
    names: Vec<&'a str>,
    distances: Option<(usize, &'a [Arc<str>])>,
}

impl<'a> ConstraintNames<'a> {
    /// Returns the names of the constraints of a controller; `command`: of the period.
    pub fn of_command(config: &'a ControllerConfig, command: &'a Command) -> Self {
        let rows = |report: &'a CollisionReport| report.row_names.as_slice();
        let index = config.constraints.iter().position(|constraint| constraint.distances().is_some());
        Self {
            names: config.constraints.iter().map(Constraint::name).collect(),
            distances: index.zip(command.collisions.as_ref().map(rows)),
        }
    }

    /// Returns the names of the rows that watch distances.
    pub fn of_distances(&self) -> impl Iterator<Item = &'a str> {
        self.distances.into_iter().flat_map(|(_, rows)| rows).map(|name| &**name)
    }

    /// Returns the name of a row of a constraint; `None`: the bound is none.
    pub fn get(&self, id: BoundId) -> Option<&'a str> {
        let BoundId::Constraint { index, row } = id else { return None };
        let of_row = self.distances.filter(|(distances, _)| *distances == index).and_then(|(_, rows)| rows.get(row));
        of_row.map(|name| &**name).or_else(|| self.names.get(index).copied())
    }
}

impl<'a> From<Vec<&'a str>> for ConstraintNames<'a> {
    fn from(names: Vec<&'a str>) -> Self {
        Self { names, distances: None }
    }
}
