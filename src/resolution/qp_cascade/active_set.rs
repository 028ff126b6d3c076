//! Exact solutions on a set of active limits, and the search for the right set.
#![allow(non_snake_case)]

use super::level::Level;
use crate::linalg::{Matrix, Svd, SvdError, Vector};
use crate::resolution::certificate::relative;

/// Which bound of a joint; inequalities have an upper one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// q̇ ≥ lo.
    Lower,
    /// q̇ ≤ hi, a·q̇ ≤ b.
    Upper,
}

impl Side {
    /// Direction in which the bound is met.
    fn sign(self) -> f64 {
        match self {
            Self::Lower => -1.0,
            Self::Upper => 1.0,
        }
    }
}

/// The active limits of one level, in order: joints by index from 0, then inequalities, counted on; and the side.
pub type ActiveSet = Vec<(usize, Side)>;

/// Bounds count as kept up to this, relative to the speeds that the level deals with; the rest is clamped away.
const FEASIBILITY: f64 = 1e-13;

/// Residual of the optimality conditions, relative to the level's size, above which a set is not the right one.
///
/// Exact answers stay below 1e-14. Whatever is allowed here returns divided by the smallest singular value.
const OPTIMALITY: f64 = 1e-12;

/// Effect of a limit on ‖C z − d‖, relative to the norm of C, below which its multiplier is taken with a pinch of salt.
///
/// A multiplier carries rounding of 1e-16; the relief that it promises is the multiplier divided by this effect.
const SENSITIVITY: f64 = 1e-3;

/// Change of C z, relative to the level's size, that is rounding: a move that achieves no more is not made. In a corner it
/// would run into limits that depend on the active ones.
const ARRIVED: f64 = 1e-13;

/// Fraction of a move that, along a limit, is rounding and no approach.
const APPROACH: f64 = 1e-13;

/// A point with the optimality conditions evaluated.
pub struct Candidate {
    /// z, p.
    pub z: Vector,
    /// Signed multipliers, per row; positive at the upper bound.
    pub multipliers: Vector,
    /// By how much ‖C z − d‖ would fall, to first order and relative to its size, if only this limit were moved away,
    /// per row; ≥ 0.
    pub relief: Vector,
    /// The set that the point was computed on.
    pub active_set: ActiveSet,
    /// Relative residual of stationarity and multiplier signs; infinite where a bound is broken.
    pub kkt_residual: f64,
}

impl Candidate {
    /// Stays at z = 0: the solution of a level that nothing open can influence.
    pub fn stay(level: &Level) -> Self {
        Self {
            z: Vector::zeros(level.unknowns()),
            multipliers: Vector::zeros(level.G.nrows()),
            relief: Vector::zeros(level.G.nrows()),
            active_set: ActiveSet::new(),
            kkt_residual: 0.0,
        }
    }

    fn new(level: &Level, minimiser: Minimiser, active: ActiveSet, conditions: &Conditions) -> Self {
        let n = level.G.nrows();
        let (mut multipliers, mut relief) = (Vector::zeros(n), Vector::zeros(n));
        for (place, &(row, _)) in active.iter().enumerate() {
            if conditions.relief[place] > OPTIMALITY {
                multipliers[row] = conditions.multipliers[place];
                relief[row] = conditions.relief[place];
            }
        }
        let residual = conditions.relief.iter().fold(conditions.stationarity, |worst, relief| worst.max(-relief));
        let feasible = level.constraints().all(|constraint| keeps(level, &minimiser.z, constraint));
        Self {
            kkt_residual: if feasible { residual } else { f64::INFINITY },
            active_set: active,
            multipliers,
            relief,
            z: minimiser.z,
        }
    }

    /// Whether the point solves the level.
    pub fn is_optimal(&self) -> bool {
        self.kkt_residual <= OPTIMALITY
    }
}

/// The optimality conditions at a minimiser, measured as what could still be gained of ‖C z − d‖.
///
/// With the residual r = C z − d, a basis Q of the range of C N (what the set leaves open) and M = (I − Q Qᵀ) C G_W⁺
/// (how r changes with each bound of the set), the conditions are Qᵀ r = 0 and multipliers m = −Mᵀ r that point
/// outwards. Moving bound i alone changes ‖r‖ by m_i / ‖M_i‖ per unit of change in r: its relief. The usual gradient
/// Cᵀ r in place of these shrinks with the square of a small singular value and would call wrong sets right.
struct Conditions {
    /// Signed multipliers, in the order of the set; positive: pressed upwards.
    multipliers: Vector,
    /// Relative relief, in the order of the set; negative where the multiplier points inwards.
    relief: Vector,
    /// ‖Qᵀ r‖_∞, relative.
    stationarity: f64,
}

impl Conditions {
    fn new(level: &Level, minimiser: &Minimiser, active: &ActiveSet) -> Self {
        let (size, Q) = (level.size(&minimiser.z), &minimiser.range);
        let across = |M: &Matrix| M - Q * (Q.transpose() * M);
        let residual = &level.C * &minimiser.z - &level.d;
        let per_bound = minimiser.limits.pseudo_inverse();
        let M = across(&(&level.C * &per_bound));
        let multipliers = -(M.transpose() * &residual);
        let relief = Vector::from_fn(active.len(), |i, _| {
            let effect = M.column(i).norm().max(SENSITIVITY * level.scale * per_bound.column(i).norm());
            signed_relative(active[i].1.sign() * multipliers[i], effect * size)
        });
        Self { multipliers, relief, stationarity: relative(&(Q.transpose() * &residual), size) }
    }
}

fn signed_relative(value: f64, scale: f64) -> f64 {
    relative(&Vector::from_element(1, value), scale).copysign(value)
}

fn keeps(level: &Level, z: &Vector, (row, side, bound): (usize, Side, f64)) -> bool {
    let excess = side.sign() * ((level.G.row(row) * z)[0] - bound);
    excess <= FEASIBILITY * (level.speed + z.norm())
}

fn active_rows(level: &Level, active: &ActiveSet) -> Matrix {
    level.G.select_rows(active.iter().map(|(row, _)| row))
}

fn active_bounds(level: &Level, active: &ActiveSet) -> Vector {
    Vector::from_iterator(active.len(), active.iter().map(|&(row, side)| level.bound(row, side)))
}

/// The minimiser of ‖C z − d‖² with the limits of a set as equalities.
struct Minimiser {
    /// z, p; the one nearest to where the search began, if there are many.
    z: Vector,
    /// Decomposition of G_W, the set's rows of G.
    limits: Svd,
    /// Orthonormal basis of the range of C N, with N the null space of G_W.
    range: Matrix,
}

impl Minimiser {
    fn new(level: &Level, near: &Vector, active: &ActiveSet) -> Result<Self, SvdError> {
        let G_W = active_rows(level, active);
        let limits = Svd::with_scale(&G_W, 1.0)?;
        let on_limits = near + limits.solve(&(active_bounds(level, active) - &G_W * near));
        let N = limits.null_space();
        let open = Svd::with_scale(&(&level.C * &N), level.scale)?;
        let z = &on_limits + N * open.solve(&(&level.d - &level.C * &on_limits));
        Ok(Self { z, limits, range: open.range() })
    }
}

/// Solves the level on a guessed set, as near to z = 0 as it leaves open, and says whether the guess was right.
///
/// Limits of the guess that are no constraints of this level, or follow from the others, are left out.
pub fn polish(level: &Level, guess: &ActiveSet) -> Result<Candidate, SvdError> {
    let mut active = ActiveSet::new();
    for &(row, side) in guess {
        if level.constraints().any(|(j, s, _)| (j, s) == (row, side)) {
            active.push((row, side));
            if Svd::with_scale(&active_rows(level, &active), 1.0)?.rank() < active.len() {
                active.pop();
            }
        }
    }
    let minimiser = Minimiser::new(level, &Vector::zeros(level.unknowns()), &active)?;
    let conditions = Conditions::new(level, &minimiser, &active);
    Ok(Candidate::new(level, minimiser, active, &conditions))
}

/// A primal active-set method from z = 0: exact, finite, used where a guess fails.
///
/// Ties are broken by the smallest index (Bland), so that degenerate corners do not cycle.
pub fn iterate(level: &Level) -> Result<Candidate, SvdError> {
    #[cfg(test)]
    if super::clarabel_level::fault::strikes_search() {
        return polish(level, &ActiveSet::new());
    }
    let mut z = Vector::zeros(level.unknowns());
    let mut active = ActiveSet::new();
    let mut best: Option<Candidate> = None;
    // Far more than the 2n changes that problems of this size take; only rounding could ask for more.
    for _ in 0..20 * (level.G.nrows() + 1) {
        let mut target = Minimiser::new(level, &z, &active)?;
        if (&level.C * (&target.z - &z)).norm() <= ARRIVED * level.size(&z) {
            target.z.copy_from(&z);
        } else if let Some((step, limit)) = blocking(level, &z, &target.z, &active) {
            z += (target.z - &z) * step;
            active.push(limit);
            active.sort_by_key(|&(row, _)| row);
            continue;
        }
        z.copy_from(&target.z);
        let conditions = Conditions::new(level, &target, &active);
        let candidate = Candidate::new(level, target, active.clone(), &conditions);
        if best.as_ref().is_none_or(|best| candidate.kkt_residual < best.kkt_residual) {
            best = Some(candidate);
        }
        match conditions.relief.iter().position(|&relief| relief < -OPTIMALITY) {
            Some(wrong) => drop(active.remove(wrong)),
            None => break,
        }
    }
    best.map_or_else(|| polish(level, &active), Ok)
}

/// The first limit met on the way from `z` to `target`, and how far along.
fn blocking(level: &Level, z: &Vector, target: &Vector, active: &ActiveSet) -> Option<(f64, (usize, Side))> {
    let way = target - z;
    let (position, direction) = (&level.G * z, &level.G * &way);
    let mut first: Option<(f64, (usize, Side))> = None;
    for (row, side, bound) in level.constraints() {
        let approach = side.sign() * direction[row];
        // A limit that the move does not approach, or that the set holds already, cannot block.
        if approach <= APPROACH * way.norm() || active.iter().any(|&(held, _)| held == row) {
            continue;
        }
        let step = (side.sign() * (bound - position[row])).max(0.0) / approach;
        if step < first.map_or(1.0, |(nearest, _)| nearest) {
            first = Some((step, (row, side)));
        }
    }
    first
}
