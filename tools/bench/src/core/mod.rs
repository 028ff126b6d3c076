//! The mathematics, in one process.

pub mod cycle;
mod kinematics;
mod level;
mod plain;
mod pseudo_inverse;

use super::BenchError;
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

/// Returns postures of Sawyer, spread over the joint ranges by irrational strides.
pub fn postures(count: usize) -> Vec<[f64; 7]> {
    const STRIDES: [f64; 7] = [0.754_878, 0.569_840, 0.430_160, 0.324_718, 0.245_122, 0.185_037, 0.139_681];
    let posture = |i: usize| STRIDES.map(|stride| 4.0 * ((i as f64 * stride).fract() - 0.5));
    (1..=count).map(posture).collect()
}
