//! Quadratic programs and their answers.
#![allow(non_snake_case)]
#![cfg_attr(not(feature = "clarabel"), expect(dead_code, reason = "nothing solves the programs"))]

/// min ½ vᵀP v + qᵀv subject to A v + s = b, with s = 0 in the first `equations` rows and s ≥ 0 in the others.
#[derive(Debug, Default)]
pub struct QuadraticProgram {
    pub unknowns: usize,
    pub equations: usize,
    /// Upper triangle, column by column, with zeros.
    pub P: Vec<f64>,
    pub q: Vec<f64>,
    /// Column by column, with zeros.
    pub A: Vec<f64>,
    pub b: Vec<f64>,
}

/// Clarabel's answer to a program.
#[derive(Debug, Clone, Default)]
pub struct QpAnswer {
    /// v.
    pub v: Vec<f64>,
    /// Multipliers of the inequalities, ≥ 0.
    pub multipliers: Vec<f64>,
    /// s of the inequalities.
    pub slacks: Vec<f64>,
    pub iterations: u32,
}

/// Clarabel found no answer.
#[derive(Debug, Clone, Copy)]
pub struct Unsolved {
    /// Iterations until it gave up.
    pub iterations: u32,
}

/// How hard Clarabel tries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// Without scaling and refinement, which are most of the time of a small program.
    Quick,
    /// With both, and down to a gap near rounding.
    Careful,
}
