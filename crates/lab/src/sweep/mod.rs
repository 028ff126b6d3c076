//! Sweeps: one scenario with many values of some quantities, and one run for each combination.
//!
//! [`Plan`] lists the combinations (cells). [`row`] runs one cell against a service; cells are independent of each other, so
//! they can run in parallel or on several machines. [`Partial`] keeps completed rows, so that an interrupted sweep
//! continues. [`write()`] writes the table, [`merge`] joins the parts of several machines, [`figures`] draws measures.
//!
//! ```text
//! scenario, variations ─→ Plan (cells) ─→ a row per cell ─→ one Parquet file ─→ figures
//!                                          └→ partial file, one line per row
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
pub use file::{Written, is_table_of, merge, write};
pub use partial::{Partial, Rows};
pub use plan::{Identity, Plan};
pub use table::{MEASURES, columns};
pub use values::{Seeds, Variation};
