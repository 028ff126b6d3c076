//! The exact solution of a level on a set of active limits, with the optimality conditions there.
#![allow(non_snake_case)]

use super::active_set::{ActiveSet, Side};
use super::level::Level;
use crate::linalg::{Decomposition, TaskMatrix, TaskVector};
use crate::resolution::certificate::relative;

/// Effect of a limit on ‖C z − d‖, relative to the norm of C, below which its multiplier is taken with a pinch of salt.
///
/// A multiplier carries rounding of 1e-16; the relief that it promises is the multiplier divided by this effect.
const SENSITIVITY: f64 = 1e-3;

/// The minimiser of ‖C z − d‖² with the limits of a set as equalities.
#[derive(Default)]
pub struct Minimiser {
    /// z, p; the one nearest to where the search began, if there are many.
    pub z: TaskVector,
    /// The set.
    pub active: ActiveSet,
    /// G_W, the set's rows of G, and its decomposition.
    G_W: TaskMatrix,
    limits: Decomposition,
    /// C in that frame, and its decomposition from the first coordinate on that the set leaves open.
    C: TaskMatrix,
    open: Decomposition,
}

/// The optimality conditions at a minimiser, measured as what could still be gained of ‖C z − d‖.
///
/// With the residual r = C z − d, the projector P onto what C N (the part that the set leaves open) does not reach and
/// M = P C G_W⁺ (how r changes with each bound of the set), the conditions are r = P r and multipliers m = −Mᵀ r that
/// point outwards. Moving bound i alone changes ‖r‖ by m_i / ‖M_i‖ per unit of change in r: its relief. The usual gradient
/// Cᵀ r in place of these shrinks with the square of a small singular value and would call wrong sets right.
pub struct Conditions {
    /// Signed multipliers, in the order of the set; positive: pressed upwards.
    pub multipliers: TaskVector,
    /// Relative relief, in the order of the set; negative where the multiplier points inwards.
    pub relief: TaskVector,
    /// ‖r − P r‖_∞, relative.
    pub stationarity: f64,
}

impl Minimiser {
    /// Becomes the minimiser nearest to z = 0 on a set that was guessed, without limits that follow from those before them.
    pub fn try_set(&mut self, level: &Level, guess: &[(usize, Side)]) {
        self.hold(level, guess);
        if self.limits.rank() < guess.len() {
            self.active.clear();
            for &limit in guess {
                self.active.push(limit);
                self.decompose_limits(level);
                if self.limits.rank() < self.active.len() {
                    self.active.pop();
                }
            }
            self.decompose_limits(level);
        }
        self.minimise(level, None);
    }

    /// Becomes the minimiser nearest to `near` on a set of limits that hold there.
    pub fn find(&mut self, level: &Level, near: &TaskVector, active: &[(usize, Side)]) {
        self.hold(level, active);
        self.minimise(level, Some(near));
    }

    fn minimise(&mut self, level: &Level, near: Option<&TaskVector>) {
        let Self { z, active, G_W, limits, C, open, .. } = self;
        let mut bounds = TaskVector::from_fn(active.len(), |i| level.bound(active[i].0, active[i].1));
        if let Some(near) = near {
            bounds -= &(&*G_W * near);
        }
        *z = limits.solve(&bounds);
        if let Some(near) = near {
            *z += near;
        }
        C.copy_from(&level.C);
        limits.rows_to_frame(C);
        open.decompose(C, limits.rank(), level.scale);
        let mut way = open.solve(&(&level.d - &(&level.C * &*z)));
        limits.from_frame(&mut way);
        *z += &way;
    }

    fn hold(&mut self, level: &Level, active: &[(usize, Side)]) {
        self.active.clear();
        self.active.extend_from_slice(active);
        self.decompose_limits(level);
    }

    fn decompose_limits(&mut self, level: &Level) {
        self.G_W.reset(0, level.unknowns());
        self.active.iter().for_each(|&(row, _)| self.G_W.push_row(&level.G[row]));
        self.limits.decompose(&self.G_W, 0, 1.0);
    }

    /// The optimality conditions of the level at z.
    pub fn conditions(&self, level: &Level) -> Conditions {
        let size = level.size(&self.z);
        let residual = &(&level.C * &self.z) - &level.d;
        let count = self.active.len();
        let (multipliers, relief) = (TaskVector::zeros(count), TaskVector::zeros(count));
        if self.open.rank() == level.C.nrows() {
            // What is open reaches all there is to reach: no limit costs anything.
            return Conditions { multipliers, relief, stationarity: relative(residual.amax(), size) };
        }
        let left = self.open.unreachable(&residual);
        let stationarity = relative((&residual - &left).amax(), size);
        let mut conditions = Conditions { multipliers, relief, stationarity };
        for (place, &(_, side)) in self.active.iter().enumerate() {
            let per_bound = self.limits.solve_in_frame(&TaskVector::unit(count, place));
            let M = self.open.unreachable(&(&self.C * &per_bound));
            let multiplier = -M.dot(&left);
            let effect = M.norm().max(SENSITIVITY * level.scale * per_bound.norm());
            conditions.multipliers[place] = multiplier;
            let outwards = side.sign() * multiplier;
            conditions.relief[place] = relative(outwards.abs(), effect * size).copysign(outwards);
        }
        conditions
    }

    /// Z ← Z N with an orthonormal basis N of what changes neither the limits of the set nor C z.
    pub fn close(&self, Z: &mut TaskMatrix) {
        self.limits.rows_to_frame(Z);
        self.open.to_null_space(Z);
    }
}
