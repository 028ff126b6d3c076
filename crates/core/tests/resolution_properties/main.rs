//! The resolution over random and adversarial problems: what must hold for every one of them, as sentences.
//!
//! Every problem is a function of a seed; a failure names the seed that shows it.
#![allow(non_snake_case)]

mod bulk;
mod equations;
mod inequalities;
mod limits;
mod problems;
mod reference;
mod scaling;
