//! Properties of the resolution that must hold for all random and adversarial problems.
//!
//! Every problem is a function of a seed. A failure prints the seed.
#![allow(non_snake_case)]

mod bulk;
mod continuity;
mod distant_bounds;
mod equations;
mod extremes;
mod inequalities;
mod jumps;
mod limits;
mod memory;
mod problems;
mod ranks;
mod reference;
mod scaling;
mod smooth_paths;
#[path = "../solvers/mod.rs"]
mod solvers;
