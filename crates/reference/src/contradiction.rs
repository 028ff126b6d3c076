//! Minimal sets of demands that contradict each other, by deletion: a member stays if the others can hold without it.

use revprio_problem::{Bound, BoundId, Contradiction, Matrix, Side, Vector};

use crate::clarabel::least_excess;
use crate::hierarchy::{Hierarchy, Solution};
use crate::program::Unsolved;
use crate::svd::Svd;

/// Violation, relative to the sizes of row and velocity, up to which a row counts as kept.
const NEGLIGIBLE: f64 = 1e-9;

/// Violation, relative to that of all demands together, up to which demands can hold together; of all demands, relative to the
/// largest one at the solution.
const FEASIBLE: f64 = 1e-5;

/// Multiplier, relative to the largest one, up to which a demand takes no part.
const NO_PART: f64 = 1e-7;

/// Programs after which the search for a minimal set ends without one.
const MAX_PROGRAMS: usize = 100;

/// Rooms, in units of the largest violation, beyond which a demand is left out: no proof at the solution needs it.
const FAR: f64 = 1e3;

/// What Clarabel's programs add to each room, in units of the largest violation. Demands that can hold together then do so at more
/// than one point, so that it converges.
const WIDENED: f64 = 1e-4;

/// Singular value of rows that depend on each other; weight of a member that a proof does not need; sum of weighted rooms that may
/// be zero. Rows have length one, and rooms are in units of the largest violation.
const ROUNDING: f64 = 1e-9;

/// A demand a·z ≤ room on the distance z from the solution, with a of length one.
#[derive(Clone)]
struct Demand {
    member: Bound,
    row: Vec<f64>,
    room: f64,
}

/// Returns one contradiction for each level whose inequality rows are not all kept, as far as they are found before `is_stopped`.
pub fn contradictions(
    hierarchy: &Hierarchy,
    solution: &Solution,
    joints: usize,
    is_stopped: &impl Fn() -> bool,
) -> Vec<Contradiction> {
    let mut found = Vec::new();
    for (index, level) in hierarchy.levels.iter().enumerate() {
        let broken = (0..level.rows.nrows()).find(|&row| is_broken(hierarchy, solution, index, row));
        let task = match broken.map(|row| level.names[row]) {
            Some(Some(BoundId::Task { index, .. })) => Some(index),
            Some(Some(_)) => None,
            Some(None) | None => continue,
        };
        let members = minimal(demands(hierarchy, solution, index, joints), is_stopped).unwrap_or_default();
        if !members.is_empty() {
            found.push(Contradiction { task, members });
        }
    }
    found
}

/// Returns whether an inequality row misses its bounds by more than rounding.
fn is_broken(hierarchy: &Hierarchy, solution: &Solution, index: usize, row: usize) -> bool {
    let level = &hierarchy.levels[index];
    let missing = level.missing(row, level.value(row, &solution.x)).abs();
    let targets = level.lower.iter().chain(&level.upper).filter(|bound| bound.is_finite());
    let target = targets.map(|bound| bound * bound).sum::<f64>().sqrt();
    !level.is_equation(row) && missing > NEGLIGIBLE * (level.rows.norm() * solution.x.norm() + target)
}

/// Returns all demands that a level's inequality rows could contradict: the limits, what higher levels achieved, and the rows. Their
/// rooms are in units of the largest violation.
fn demands(hierarchy: &Hierarchy, solution: &Solution, index: usize, joints: usize) -> Vec<Demand> {
    let mut demands = Vec::new();
    let n = hierarchy.unknowns();
    let mut push = |member: Bound, row: Vec<f64>, room: f64| {
        let length = Vector::from_row_slice(&row).norm();
        let length = if length.is_normal() { length } else { 1.0 };
        let row = row.iter().map(|a| member.side.sign() * a / length).collect();
        demands.push(Demand { member, row, room: member.side.sign() * room / length });
    };
    for joint in 0..joints {
        for side in [Side::Lower, Side::Upper] {
            let unit = (0..n).map(|j| if j == joint { 1.0 } else { 0.0 }).collect();
            push(Bound { id: BoundId::Joint(joint), side }, unit, hierarchy.bound(joint, side) - solution.x[joint]);
        }
    }
    for (above, level) in hierarchy.levels[..=index].iter().enumerate() {
        for row in 0..level.rows.nrows() {
            let value = level.value(row, &solution.x);
            for (side, bound) in [(Side::Lower, level.lower[row]), (Side::Upper, level.upper[row])] {
                let Some(id) = level.names[row] else { continue };
                let room = bound - value;
                // What equations and higher levels achieved is kept, whatever they asked for.
                let is_kept = level.is_equation(row) || (above < index && side.sign() * room < 0.0);
                let room = if is_kept { 0.0 } else { room };
                push(Bound { id, side }, level.rows.row(row).iter().copied().collect(), room);
            }
        }
    }
    let size = demands.iter().map(|demand| -demand.room).fold(0.0, f64::max);
    demands.retain(|demand| demand.room <= FAR * size);
    for demand in &mut demands {
        demand.room /= size;
    }
    demands
}

/// Returns a set of demands that cannot hold together, and of which any one less can; empty if all can, if the search takes too long,
/// or if Clarabel was too inexact.
fn minimal(demands: Vec<Demand>, is_stopped: &impl Fn() -> bool) -> Result<Vec<Bound>, Unsolved> {
    if is_stopped() {
        return Ok(Vec::new());
    }
    let Some((mut members, total)) = proof(demands, FEASIBLE)? else { return Ok(Vec::new()) };
    let mut programs = 0;
    let mut place = members.len();
    while place > 0 {
        place -= 1;
        programs += 1;
        if programs > MAX_PROGRAMS || is_stopped() {
            return Ok(Vec::new());
        }
        let mut others = members.clone();
        others.remove(place);
        if let Some((fewer, _)) = proof(others, FEASIBLE * total)? {
            // Members behind this place are needed by every smaller set, so that the order stays.
            let needed = |demand: &Demand| fewer.iter().any(|other| other.member == demand.member);
            place = members[..place].iter().filter(|demand| needed(demand)).count();
            members = fewer;
        }
    }
    let members = if is_minimal(&members) { members } else { Vec::new() };
    Ok(members.into_iter().map(|demand| demand.member).collect())
}

/// Returns whether these demands cannot hold together and any one less can: their rows depend on each other in one way only, Σ w a = 0
/// with w > 0, and Σ w room < 0.
fn is_minimal(members: &[Demand]) -> bool {
    let Some(first) = members.first() else { return false };
    let svd = Svd::new(&Matrix::from_fn(first.row.len(), members.len(), |i, j| members[j].row[i]));
    let dependencies = svd.null_space(svd.rank(ROUNDING));
    if dependencies.ncols() != 1 {
        return false;
    }
    let weights = dependencies.column(0) * dependencies.sum().signum();
    let sum: f64 = weights.iter().zip(members).map(|(weight, member)| weight * member.room).sum();
    weights.iter().all(|&weight| weight > ROUNDING) && sum < -ROUNDING
}

/// Returns the demands that take part in a proof that these cannot hold together, and the size of what they miss; `None` if that is
/// not above `feasible`.
///
/// The least excess of each demand is its multiplier in the proof: Σ excess a = 0 and Σ excess room < 0.
fn proof(demands: Vec<Demand>, feasible: f64) -> Result<Option<(Vec<Demand>, f64)>, Unsolved> {
    let Some(first) = demands.first() else { return Ok(None) };
    let n = first.row.len();
    let rows: Vec<f64> = demands.iter().flat_map(|demand| demand.row.iter().copied()).collect();
    let rooms: Vec<f64> = demands.iter().map(|demand| demand.room + WIDENED).collect();
    let excess = least_excess(&rows, &rooms, n)?;
    let largest = excess.iter().copied().fold(0.0, f64::max);
    let takes_part = |(demand, excess): (Demand, &f64)| (*excess > NO_PART * largest).then_some(demand);
    let total = excess.iter().map(|excess| excess * excess).sum::<f64>().sqrt();
    Ok((total > feasible).then(|| (demands.into_iter().zip(&excess).filter_map(takes_part).collect(), total)))
}
