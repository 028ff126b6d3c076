//! The polish of Clarabel's answer: one linear solve on its own active set.
#![allow(non_snake_case)]

use revprio_problem::Vector;

use crate::level_program::LevelProgram;
use crate::program::QpAnswer;
use crate::svd::{RANK_TOLERANCE, Svd, concatenate, stack};

/// Relative residual of the optimality conditions up to which an answer is sure.
pub const CERTIFIED: f64 = 1e-11;

/// Relative error of a level's answer, estimated from its residual and conditioning, up to which an answer is sure.
pub const CERTAIN: f64 = 1e-6;

/// Singular values of active constraints below this count as zero: their rows, of length one at most, depend.
const DEPENDENT: f64 = 1e-11;

/// Slack and ratio of multiplier and slack of a constraint that is met without a force: both go to zero together.
const WEAK: f64 = 1e-3;

/// Ratio of the slacks of an accurate and a less accurate answer below which the slack goes to zero.
const VANISHING: f64 = 0.2;

/// Relative residuals below this are rounding.
const ROUNDING: f64 = 1e-14;

/// Multipliers of active constraints below this, relative to their scale, may be zero.
const UNCLEAR: f64 = 1e-12;

/// A point of a level with its multipliers, and how far they are from the optimality conditions.
#[derive(Debug, Clone)]
pub struct LevelPoint {
    /// z.
    pub z: Vector,
    /// One for each constraint; of a row of the level itself its excess.
    pub multipliers: Vec<f64>,
    /// Largest relative residual.
    pub residual: f64,
    /// Estimate of the relative error of z, from the residual and the weakest singular value that decides.
    pub error: f64,
}

impl LevelPoint {
    /// Returns whether the level is solved surely.
    pub fn is_sure(&self) -> bool {
        self.error <= CERTAIN && self.residual <= CERTIFIED
    }

    /// Returns Clarabel's answer as it is, with its residual.
    pub fn of_clarabel(program: &LevelProgram, answer: &QpAnswer, residual: f64) -> Self {
        let z = Vector::from_row_slice(&answer.v[..program.C.ncols()]);
        let is_broken = |i: &usize| program.is_own(*i) && answer.multipliers[*i] > answer.slacks[*i];
        let broken: Vec<usize> = (0..program.constraints.len()).filter(is_broken).collect();
        let reach = Svd::new(&stack(&program.C, &program.G.select_rows(&broken)));
        let error = estimate(residual, &reach, reach.rank(RANK_TOLERANCE));
        Self { z, multipliers: answer.multipliers.clone(), residual, error }
    }

    /// Solves the level on Clarabel's active set:
    ///
    /// min ‖C z − d‖² subject to G_a z = rooms_a, then the multipliers ν of G_aᵀ ν = Cᵀ(d − C z).
    ///
    /// Where z is not unique, it is the shortest one, because Clarabel's answer lies far out between wide bounds; if other bounds
    /// exclude this one, it is the one next to Clarabel's answer. `before`: a less accurate answer of Clarabel to the same
    /// program, if there is one.
    pub fn polished(program: &LevelProgram, answer: &QpAnswer, before: Option<&QpAnswer>) -> Self {
        let active = active_set(program, answer, before);
        let shortest = Self::nearest(program, answer, &active, &Vector::zeros(program.C.ncols()));
        if shortest.residual <= ROUNDING {
            return shortest;
        }
        let start = Vector::from_row_slice(&answer.v[..program.C.ncols()]);
        let near = Self::nearest(program, answer, &active, &start);
        if near.residual < shortest.residual { near } else { shortest }
    }

    /// Solves the level on an active set, as near to a point as possible.
    fn nearest(program: &LevelProgram, answer: &QpAnswer, active: &[usize], start: &Vector) -> Self {
        let (own, bounds): (Vec<usize>, Vec<usize>) = active.iter().partition(|&&i| program.is_own(i));
        // A violated row of the level itself is an equation.
        let C = stack(&program.C, &program.G.select_rows(&own));
        let d = concatenate(&program.d, &program.rooms.select_rows(&own));
        let G = program.G.select_rows(&bounds);
        let constraints = Svd::new(&G);
        let rank = constraints.rank(DEPENDENT);
        let inverse = constraints.inverse(rank, 0.0);
        let z = start + &inverse * (program.rooms.select_rows(&bounds) - &G * start);
        let free = constraints.null_space(rank);
        let reach = Svd::new(&(&C * free));
        let reached = reach.rank(RANK_TOLERANCE);
        let z = &z + free * reach.solve(reached, 0.0, &(&d - &C * &z));
        let excess = &C * &z - &d;
        // Where active constraints depend on each other, their multipliers are not unique: the ones next to Clarabel's, or the
        // smallest ones.
        let clarabels = Vector::from_iterator(bounds.len(), bounds.iter().map(|&i| answer.multipliers[i]));
        let starts = if rank < bounds.len() { vec![clarabels, Vector::zeros(bounds.len())] } else { vec![clarabels] };
        let candidates = starts.into_iter().map(|start| {
            let found = &start + inverse.tr_mul(&(-C.tr_mul(&excess) - G.tr_mul(&start)));
            let mut multipliers = vec![0.0; program.constraints.len()];
            for (i, &constraint) in own.iter().enumerate() {
                multipliers[constraint] = excess[program.C.nrows() + i];
            }
            for (multiplier, &constraint) in found.iter().zip(&bounds) {
                multipliers[constraint] = *multiplier;
            }
            let residual = program.residual(&z, &multipliers);
            // A bound without a clear multiplier: on either side of it, the level is as good up to rounding.
            let is_unclear = |&i: &usize| multipliers[i].abs() <= UNCLEAR * program.scale;
            let is_met = excess.norm() <= ROUNDING * program.scale;
            let doubt = if !is_met && bounds.iter().any(is_unclear) { residual.max(ROUNDING) } else { 0.0 };
            let doubt = if residual > ROUNDING { residual } else { doubt };
            // Where rows contradict each other, their rounding counts with the square of the condition number.
            let doubt = doubt.max(f64::EPSILON * excess.norm() / program.scale);
            let error = estimate(doubt, &reach, reached).max(f64::EPSILON * estimate(1.0, &reach, reached).sqrt());
            Self { z: z.clone(), multipliers, residual, error }
        });
        let multipliers = answer.multipliers.clone();
        let failed = Self { z: z.clone(), multipliers, residual: f64::INFINITY, error: f64::INFINITY };
        candidates.fold(failed, |best, next| if next.residual < best.residual { next } else { best })
    }
}

/// Returns the relative error that a residual of the optimality conditions allows.
fn estimate(residual: f64, reach: &Svd, rank: usize) -> f64 {
    let weakest = if rank == 0 { 1.0 } else { reach.singular_values()[rank - 1].min(1.0) };
    residual / (weakest * weakest)
}

/// Returns the constraints whose multipliers exceed their slacks, and those whose slack goes to zero without a multiplier; of the
/// two sides of one row or unknown the stronger one.
fn active_set(program: &LevelProgram, answer: &QpAnswer, before: Option<&QpAnswer>) -> Vec<usize> {
    let mut active: Vec<usize> = Vec::new();
    let is_active = |i: &usize| {
        let (multiplier, slack) = (answer.multipliers[*i], answer.slacks[*i]);
        let vanishes = before.is_some_and(|before| slack < VANISHING * before.slacks[*i]);
        multiplier > slack || (slack < WEAK && (multiplier > slack * WEAK || vanishes))
    };
    for i in (0..program.constraints.len()).filter(is_active) {
        match active.last().copied() {
            Some(before) if program.constraints[before].bounded == program.constraints[i].bounded => {
                if answer.multipliers[i] > answer.multipliers[before] {
                    active.pop();
                    active.push(i);
                }
            }
            _ => active.push(i),
        }
    }
    active
}
