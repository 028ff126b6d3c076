//! A sweep: one scenario with many values of some quantities, a run for each combination.
//!
//! ```text
//! scenario, variations ─→ Plan (cells) ─→ a row per cell ─→ one Parquet file ─→ figures
//!                                          └→ partial file, line by line: an interrupted sweep continues
//! ```

mod cell_run;
pub mod figures;
mod file;
mod partial;
mod path;
mod plan;
mod table;
mod values;

pub use cell_run::row;
pub use file::{Written, merge, write};
pub use partial::{Partial, Rows};
pub use plan::{Identity, Plan};
pub use table::{MEASURES, columns};
pub use values::{Seeds, Variation};
