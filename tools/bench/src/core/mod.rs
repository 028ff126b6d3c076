//! The mathematics, in one process.

pub mod cycle;
mod kinematics;
mod level;
mod plain;
pub mod postures;
mod pseudo_inverse;

use super::error::BenchError;
use super::row::Row;
use super::timing::Budget;

/// Returns a row per measurement and peer.
pub fn rows(budget: Budget) -> Result<Vec<Row>, BenchError> {
    let mut rows = kinematics::rows(budget)?;
    rows.extend(pseudo_inverse::rows(budget)?);
    rows.extend(cycle::rows(budget)?);
    rows.extend(level::rows(budget)?);
    Ok(rows)
}
