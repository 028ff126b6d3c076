//! Minimal sets of demands that contradict each other, by deletion: a member stays if the others can hold without it.

use revprio_problem::{Contradiction, Member, RowName, Side, Vector};

use crate::clarabel::{Clarabel, Effort, QuadraticProgram};
use crate::hierarchy::{Hierarchy, Solution};

/// Violation, relative to the sizes of row and velocity, up to which a row counts as kept.
const NEGLIGIBLE: f64 = 1e-9;

/// Violation, relative to that of all demands together, up to which demands can hold together.
const FEASIBLE: f64 = 1e-5;

/// Multiplier, relative to the largest one, up to which a demand takes no part.
const NO_PART: f64 = 1e-7;

/// A demand a·x ≤ b with a of length one.
#[derive(Clone)]
struct Demand {
    member: Member,
    row: Vec<f64>,
    bound: f64,
}

/// Returns one contradiction for each level whose inequality rows are not all kept.
pub fn contradictions(hierarchy: &Hierarchy, solution: &Solution, joints: usize) -> Vec<Contradiction> {
    let mut found = Vec::new();
    for (index, level) in hierarchy.levels.iter().enumerate() {
        let broken = (0..level.rows.nrows()).find(|&row| is_broken(hierarchy, solution, index, row));
        let task = match broken.map(|row| level.names[row]) {
            Some(RowName::Inequality(_)) => None,
            Some(RowName::Task { task, .. }) => Some(task),
            Some(RowName::Auxiliary) | None => continue,
        };
        let members = minimal(demands(hierarchy, solution, index, joints));
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
            push(Member::Limit { joint, side }, unit, hierarchy.bound(joint, side), side);
        }
    }
    for (above, level) in hierarchy.levels[..=index].iter().enumerate() {
        for row in 0..level.rows.nrows() {
            let value = level.value(row, &solution.x);
            let is_fixed = above < index && (level.is_equation(row) || is_broken(hierarchy, solution, above, row));
            for (side, bound) in [(Side::Lower, level.lower[row]), (Side::Upper, level.upper[row])] {
                let member = match level.names[row] {
                    RowName::Inequality(index) => Member::Inequality { index, side },
                    RowName::Task { task, row } => Member::Row { task, row, side },
                    RowName::Auxiliary => continue,
                };
                // What a higher level achieved is kept, whatever it asked for.
                let bound = if is_fixed { value } else { bound };
                push(member, level.rows.row(row).iter().copied().collect(), bound, side);
            }
        }
    }
    demands
}

/// Returns a set of demands that cannot hold together, and of which any one less can; empty if all can.
fn minimal(demands: Vec<Demand>) -> Vec<Member> {
    let mut clarabel = Clarabel::default();
    let Some(excess) = least_excess(&demands, &mut clarabel) else { return Vec::new() };
    let (total, largest) = (norm(&excess), excess.iter().copied().fold(0.0, f64::max));
    if total == 0.0 {
        return Vec::new();
    }
    // The excess of each demand is its multiplier in a proof that they contradict each other.
    let takes_part = |(demand, excess): (Demand, &f64)| (*excess > NO_PART * largest).then_some(demand);
    let mut members: Vec<Demand> = demands.into_iter().zip(&excess).filter_map(takes_part).collect();
    for place in (0..members.len()).rev() {
        let mut others = members.clone();
        others.remove(place);
        if least_excess(&others, &mut clarabel).is_some_and(|excess| norm(&excess) > FEASIBLE * total) {
            members = others;
        }
    }
    members.into_iter().map(|demand| demand.member).collect()
}

/// Returns the excess of each demand where Σ excess² is least; `None` where Clarabel finds no answer.
fn least_excess(demands: &[Demand], clarabel: &mut Clarabel) -> Option<Vec<f64>> {
    let count = demands.len();
    let n = demands.first().map_or(0, |demand| demand.row.len());
    if count == 0 {
        return Some(Vec::new());
    }
    let size = demands.iter().map(|demand| demand.bound.abs()).fold(0.0, f64::max);
    let size = if size.is_normal() { size } else { 1.0 };
    let unknowns = n + count;
    let entry = |i: usize, j: usize| {
        if j < n { demands[i].row[j] } else { -f64::from(u8::from(j - n == i)) }
    };
    let program = QuadraticProgram {
        unknowns,
        equations: 0,
        P: (0..unknowns).flat_map(|j| (0..=j).map(move |i| f64::from(u8::from(i == j && j >= n)))).collect(),
        q: vec![0.0; unknowns],
        A: (0..unknowns).flat_map(|j| (0..count).map(move |i| (i, j))).map(|(i, j)| entry(i, j)).collect(),
        b: demands.iter().map(|demand| demand.bound / size).collect(),
    };
    let answer = clarabel.solve(&program, Effort::Careful).ok()?;
    Some(answer.v[n..].iter().map(|excess| excess.max(0.0) * size).collect())
}

fn norm(entries: &[f64]) -> f64 {
    entries.iter().map(|entry| entry * entry).sum::<f64>().sqrt()
}
