//! Lexicographic least squares within limits, with inequality rows at every level, compared with independent
//! references.
//!
//! Every problem is a function of a seed. A failure prints the seed.

#![allow(non_snake_case)]

mod contradictions;
mod enumeration;
mod feasibility;
mod findings;
mod hierarchy;
mod published;
mod random;
mod sizes;
#[path = "../solvers/mod.rs"]
mod solvers;
mod warm;
mod work;
