//! The plan of a sweep: a scenario, quantities and their values. Its cells are all combinations.

use revprio_api::wire::read_error::in_plain_words;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::path;
use super::values::Variation;
use crate::simulator::Scenario;

/// Largest number of cells of a sweep.
const MAX_CELLS: usize = 10_000_000;

/// The plan of a sweep.
pub struct Plan {
    base: Value,
    /// The varied quantities; the last one changes fastest.
    pub variations: Vec<Variation>,
}

/// Identifies a sweep in its files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// Version of the program.
    pub version: String,
    /// The quantities and their values as given.
    pub vary: Vec<String>,
    /// The scenario.
    pub scenario: Value,
    /// Number of all cells, including those of other shards.
    pub cells: usize,
}

/// One combination of values.
pub struct Cell {
    /// Its index.
    pub index: usize,
    /// A value of each quantity.
    pub values: Vec<Value>,
}

impl Plan {
    /// Returns the plan of all combinations. The error names a path or value that is not valid.
    pub fn new(scenario: &Scenario, variations: Vec<Variation>) -> Result<Self, String> {
        let base = serde_json::to_value(scenario).map_err(|error| error.to_string())?;
        for (i, variation) in variations.iter().enumerate() {
            if let Some(other) = variations[..i].iter().find(|other| path::overlap(&other.path, &variation.path)) {
                return Err(format!("`{}` is varied twice, also as `{}`; vary it once", variation.path, other.path));
            }
        }
        let cells = variations.iter().try_fold(1_usize, |cells, variation| cells.checked_mul(variation.values.len()));
        if cells.is_none_or(|cells| cells > MAX_CELLS) {
            return Err(format!("the sweep has more than {MAX_CELLS} combinations"));
        }
        let plan = Self { base, variations };
        plan.check()?;
        Ok(plan)
    }

    /// Checks every value once, so that errors are found before the first run.
    fn check(&self) -> Result<(), String> {
        for variation in &self.variations {
            for value in &variation.values {
                let mut scenario = self.base.clone();
                path::set(&mut scenario, &variation.path, value)?;
                let read: Result<Scenario, _> = serde_json::from_value(scenario);
                read.map_err(|error| {
                    format!(
                        "`{}` = {value}: {}; write values like 0,0.001 or lin:0..1:5 or log:1..1e6:10",
                        variation.path,
                        in_plain_words(&error.to_string())
                    )
                })?;
            }
        }
        Ok(())
    }

    /// Returns the number of cells.
    pub fn cells(&self) -> usize {
        self.variations.iter().map(|variation| variation.values.len()).product()
    }

    /// Returns a cell by index.
    pub fn cell(&self, index: usize) -> Cell {
        let mut rest = index;
        let mut values: Vec<Value> = self
            .variations
            .iter()
            .rev()
            .map(|variation| {
                let value = variation.values[rest % variation.values.len()].clone();
                rest /= variation.values.len();
                value
            })
            .collect();
        values.reverse();
        Cell { index, values }
    }

    /// Returns the scenario of a cell.
    pub fn scenario(&self, cell: &Cell) -> Result<Scenario, String> {
        let mut scenario = self.base.clone();
        for (variation, value) in self.variations.iter().zip(&cell.values) {
            path::set(&mut scenario, &variation.path, value)?;
        }
        serde_json::from_value(scenario).map_err(|error| in_plain_words(&error.to_string()))
    }

    /// Returns the identity of the sweep.
    pub fn identity(&self) -> Identity {
        Identity {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            vary: self.variations.iter().map(Variation::to_string).collect(),
            scenario: self.base.clone(),
            cells: self.cells(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_quantity_changes_fastest() {
        let scenario = Scenario::find("stiff_wall").unwrap();
        let vary = ["loop.lag_s=0,0.001", "solver=auto,qp,closed_form"].map(|text| text.parse().unwrap());
        let plan = Plan::new(&scenario, vary.into()).unwrap();
        assert_eq!(plan.cells(), 6);
        assert_eq!(plan.cell(1).values, [Value::from(0), "qp".into()]);
        assert_eq!(plan.cell(5).values, [Value::from(0.001), "closed_form".into()]);
        let changed = plan.scenario(&plan.cell(5)).unwrap();
        assert_eq!(
            (changed.velocity_loop.lag_s, changed.controller.solver),
            (0.001, revprio_api::wire::Solver::ClosedForm)
        );
    }

    #[test]
    fn invalid_paths_and_values_are_found_before_the_first_run() {
        let refusal = |text: &str| {
            let scenario = Scenario::find("stiff_wall").unwrap();
            Plan::new(&scenario, vec![text.parse().unwrap()]).err().unwrap()
        };
        assert!(refusal("environment.stifness=1,2").contains("stifness"));
        assert!(refusal("method=reverse_priority,newton").contains("newton"));
        assert!(refusal("controller.task.0.axes=1").contains("no field `task`"));
    }
}
