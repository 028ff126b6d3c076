//! Exact solutions on a set of active limits, and the search for the right set.
#![allow(non_snake_case)]

use super::level::Level;
use crate::linalg::{Matrix, Svd, SvdError, Vector};
use crate::resolution::certificate::relative;

/// A bound of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// q̇ ≥ lo.
    Lower,
    /// q̇ ≤ hi.
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

/// The active limits of one level: joint index from 0, side; ordered by joint.
pub type ActiveSet = Vec<(usize, Side)>;

/// Bounds count as kept up to this, relative to their size (at least 1 rad/s); the rest is clamped away.
const FEASIBILITY: f64 = 1e-12;

/// Approach to a bound, relative to the move (at least 1 rad/s), that is rounding: taken for real, a limit that the set
/// implies already would join it and leave multipliers without a meaning.
const ROUNDING: f64 = 1e-14;

/// Relative residual above which a set is not the right one.
const OPTIMALITY: f64 = 1e-11;

/// A point with the optimality conditions evaluated.
pub struct Candidate {
    /// z, p.
    pub z: Vector,
    /// Signed multipliers, n; positive at the upper bound.
    pub multipliers: Vector,
    /// The set that the point was computed on.
    pub active_set: ActiveSet,
    /// Relative residual of stationarity and multiplier signs.
    pub kkt_residual: f64,
    /// Whether all bounds are kept.
    pub feasible: bool,
}

impl Candidate {
    /// The only point of a level without unknowns.
    pub fn nothing_open(level: &Level) -> Self {
        Self {
            z: Vector::zeros(0),
            multipliers: Vector::zeros(level.G.nrows()),
            active_set: ActiveSet::new(),
            kkt_residual: 0.0,
            feasible: true,
        }
    }

    /// Evaluates the optimality conditions at `z` with the limits of `active` taken as equalities:
    /// Cᵀ(C z − d) + Gᵀ m = 0 with m_i ≥ 0 at upper, m_i ≤ 0 at lower bounds.
    fn new(level: &Level, z: Vector, active: &ActiveSet) -> Result<Self, SvdError> {
        let gradient = level.C.transpose() * (&level.C * &z - &level.d);
        let G_W = active_rows(level, active);
        let m = Svd::with_scale(&G_W.transpose(), 1.0)?.solve(&-&gradient);
        let mut multipliers = Vector::zeros(level.G.nrows());
        let mut wrong_sign = 0.0_f64;
        for (&(joint, side), &value) in active.iter().zip(m.iter()) {
            if side.sign() * value > OPTIMALITY * level.gradient_scale {
                multipliers[joint] = value;
            }
            wrong_sign = wrong_sign.max(-side.sign() * value);
        }
        let stationarity = gradient + G_W.transpose() * m;
        Ok(Self {
            kkt_residual: relative(&stationarity, level.gradient_scale)
                .max(relative(&Vector::from_element(1, wrong_sign), level.gradient_scale)),
            feasible: level.constraints().all(|constraint| keeps(level, &z, constraint)),
            active_set: active.clone(),
            multipliers,
            z,
        })
    }

    /// Whether the point solves the level.
    pub fn is_optimal(&self) -> bool {
        self.feasible && self.kkt_residual <= OPTIMALITY
    }
}

fn keeps(level: &Level, z: &Vector, (joint, side, bound): (usize, Side, f64)) -> bool {
    let excess = side.sign() * ((level.G.row(joint) * z)[0] - bound);
    excess <= FEASIBILITY * bound.abs().max(1.0)
}

fn active_rows(level: &Level, active: &ActiveSet) -> Matrix {
    level.G.select_rows(active.iter().map(|(joint, _)| joint))
}

fn active_bounds(level: &Level, active: &ActiveSet) -> Vector {
    Vector::from_iterator(
        active.len(),
        active.iter().map(|&(joint, side)| match side {
            Side::Lower => level.lower[joint],
            Side::Upper => level.upper[joint],
        }),
    )
}

/// The minimiser of ‖C z − d‖² with the limits of `active` as equalities, the one nearest to `near` if there are many.
fn minimise_on(level: &Level, near: &Vector, active: &ActiveSet) -> Result<Vector, SvdError> {
    let G_W = active_rows(level, active);
    let svd = Svd::with_scale(&G_W, 1.0)?;
    let on_limits = near + svd.solve(&(active_bounds(level, active) - &G_W * near));
    let N = svd.null_space();
    let step = Svd::with_scale(&(&level.C * &N), level.C.norm())?.solve(&(&level.d - &level.C * &on_limits));
    Ok(on_limits + N * step)
}

/// Solves the level on a guessed set and says whether the guess was right.
///
/// Limits of the guess that are no constraints of this level are left out.
pub fn polish(level: &Level, near: &Vector, guess: &ActiveSet) -> Result<Candidate, SvdError> {
    let active: ActiveSet = guess
        .iter()
        .copied()
        .filter(|&(joint, side)| level.constraints().any(|(j, s, _)| (j, s) == (joint, side)))
        .collect();
    Candidate::new(level, minimise_on(level, near, &active)?, &active)
}

/// A primal active-set method from z = 0: exact, finite, used where a guess fails.
///
/// Ties are broken by the smallest joint index (Bland), so that degenerate corners do not cycle.
pub fn iterate(level: &Level) -> Result<Candidate, SvdError> {
    let mut z = Vector::zeros(level.unknowns());
    let mut active = ActiveSet::new();
    // Far more than the 2n changes that problems of this size take; only rounding could ask for more.
    for _ in 0..20 * (level.G.nrows() + 1) {
        let target = minimise_on(level, &z, &active)?;
        match blocking(level, &z, &target, &active) {
            Some((step, limit)) => {
                z += (target - &z) * step;
                active.push(limit);
                active.sort_by_key(|&(joint, _)| joint);
            }
            None => {
                z = target;
                match wrongly_active(level, &z, &active)? {
                    Some(place) => drop(active.remove(place)),
                    None => break,
                }
            }
        }
    }
    Candidate::new(level, z, &active)
}

/// The first limit met on the way from `z` to `target`, and how far along.
fn blocking(level: &Level, z: &Vector, target: &Vector, active: &ActiveSet) -> Option<(f64, (usize, Side))> {
    let (position, direction) = (&level.G * z, &level.G * (target - z));
    let mut first: Option<(f64, (usize, Side))> = None;
    for (joint, side, bound) in level.constraints() {
        let approach = side.sign() * direction[joint];
        // A limit that the move does not approach, or that the set holds already, cannot block.
        if approach <= ROUNDING * direction.amax().max(1.0) || active.iter().any(|&(held, _)| held == joint) {
            continue;
        }
        let step = (side.sign() * (bound - position[joint])).max(0.0) / approach;
        if step < first.map_or(1.0, |(nearest, _)| nearest) {
            first = Some((step, (joint, side)));
        }
    }
    first
}

/// Place in the set of the first limit that the minimiser would rather leave.
fn wrongly_active(level: &Level, z: &Vector, active: &ActiveSet) -> Result<Option<usize>, SvdError> {
    let gradient = level.C.transpose() * (&level.C * z - &level.d);
    let m = Svd::with_scale(&active_rows(level, active).transpose(), 1.0)?.solve(&-gradient);
    let least = OPTIMALITY * level.gradient_scale;
    Ok(active.iter().zip(m.iter()).position(|(&(_, side), &value)| side.sign() * value < -least))
}
