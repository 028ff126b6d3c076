//! Minimal sets of demands that contradict each other, by deletion: a member stays if the others can hold without it.

use revprio_problem::{Bound, BoundId, Contradiction, Side, Vector};

use crate::clarabel::least_excess;
use crate::hierarchy::{Hierarchy, Solution};

/// Violation, relative to the sizes of row and velocity, up to which a row counts as kept.
const NEGLIGIBLE: f64 = 1e-9;

/// Violation, relative to that of all demands together, up to which demands can hold together.
const FEASIBLE: f64 = 1e-5;

/// Multiplier, relative to the largest one, up to which a demand takes no part.
const NO_PART: f64 = 1e-7;

/// Programs after which the search for a minimal set ends without one.
const MAX_PROGRAMS: usize = 100;

/// A demand a·x ≤ b with a of length one.
#[derive(Clone)]
struct Demand {
    member: Bound,
    row: Vec<f64>,
    bound: f64,
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
        let members = minimal(demands(hierarchy, solution, index, joints), is_stopped);
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

/// Returns all demands that a level's inequality rows could contradict: the limits, what higher levels achieved, and the rows.
fn demands(hierarchy: &Hierarchy, solution: &Solution, index: usize, joints: usize) -> Vec<Demand> {
    let mut demands = Vec::new();
    let n = hierarchy.unknowns();
    let mut push = |member, row: Vec<f64>, bound: f64, side: Side| {
        if bound.is_finite() {
            let length = Vector::from_row_slice(&row).norm();
            let length = if length.is_normal() { length } else { 1.0 };
            let row = row.iter().map(|a| side.sign() * a / length).collect();
            demands.push(Demand { member, row, bound: side.sign() * bound / length });
        }
    };
    for joint in 0..joints {
        for side in [Side::Lower, Side::Upper] {
            let unit = (0..n).map(|j| if j == joint { 1.0 } else { 0.0 }).collect();
            push(Bound { id: BoundId::Joint(joint), side }, unit, hierarchy.bound(joint, side), side);
        }
    }
    for (above, level) in hierarchy.levels[..=index].iter().enumerate() {
        for row in 0..level.rows.nrows() {
            let value = level.value(row, &solution.x);
            let is_fixed = above < index && (level.is_equation(row) || is_broken(hierarchy, solution, above, row));
            for (side, bound) in [(Side::Lower, level.lower[row]), (Side::Upper, level.upper[row])] {
                let Some(id) = level.names[row] else { continue };
                // What a higher level achieved is kept, whatever it asked for.
                let bound = if is_fixed { value } else { bound };
                push(Bound { id, side }, level.rows.row(row).iter().copied().collect(), bound, side);
            }
        }
    }
    demands
}

/// Returns a set of demands that cannot hold together, and of which any one less can; empty if all can, or if the search takes too
/// long.
fn minimal(demands: Vec<Demand>, is_stopped: &impl Fn() -> bool) -> Vec<Bound> {
    if is_stopped() {
        return Vec::new();
    }
    let Some((mut members, total)) = proof(demands) else { return Vec::new() };
    let mut programs = 0;
    let mut place = members.len();
    while place > 0 {
        place -= 1;
        programs += 1;
        if programs > MAX_PROGRAMS || is_stopped() {
            return Vec::new();
        }
        let mut others = members.clone();
        others.remove(place);
        if let Some((fewer, _)) = proof(others).filter(|(_, excess)| *excess > FEASIBLE * total) {
            // Members behind this place are needed by every smaller set, so that the order stays.
            let needed = |demand: &Demand| fewer.iter().any(|other| other.member == demand.member);
            place = members[..place].iter().filter(|demand| needed(demand)).count();
            members = fewer;
        }
    }
    members.into_iter().map(|demand| demand.member).collect()
}

/// Returns the demands that take part in a proof that these cannot hold together, and the size of what they miss; `None` if they can.
///
/// The least excess of each demand is its multiplier in the proof: Σ excess a = 0 and Σ excess b < 0.
fn proof(demands: Vec<Demand>) -> Option<(Vec<Demand>, f64)> {
    let n = demands.first()?.row.len();
    let size = demands.iter().map(|demand| demand.bound.abs()).fold(0.0, f64::max);
    let size = if size.is_normal() { size } else { 1.0 };
    let rows: Vec<f64> = demands.iter().flat_map(|demand| demand.row.iter().copied()).collect();
    let bounds: Vec<f64> = demands.iter().map(|demand| demand.bound / size).collect();
    let excess = least_excess(&rows, &bounds, n)?;
    let largest = excess.iter().copied().fold(0.0, f64::max);
    let takes_part = |(demand, excess): (Demand, &f64)| (*excess > NO_PART * largest).then_some(demand);
    let total = excess.iter().map(|excess| excess * excess).sum::<f64>().sqrt() * size;
    // Less is the inaccuracy of the program.
    (total > NEGLIGIBLE * size).then(|| (demands.into_iter().zip(&excess).filter_map(takes_part).collect(), total))
}
