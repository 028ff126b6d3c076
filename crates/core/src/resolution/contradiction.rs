//! Minimal sets of demands that contradict each other.
//!
//! Where a level cannot keep its inequalities, the multipliers w of its residual prove it: Σ w_i a_i = 0 over its rows, the
//! rows of higher levels and the bounds, while Σ w_i b_i < 0 (Farkas). A proof with the fewest members is found by taking
//! members away along dependencies of the vectors a_i, as long as the rest still is a proof.

use revprio_problem::{Bound, BoundId, Contradiction, Problem, Side};

use super::engine::Solved;
use super::hierarchy::{Demand, Hierarchy, Level};
use super::solution::Solution;
use crate::linalg::Matrix;
use crate::tolerances::TOLERANCES;

/// A member of a proof: side · (a·x − b) ≤ 0, with its weight.
struct Member {
    name: Bound,
    coefficients: Vec<f64>,
    bound: f64,
    weight: f64,
}

/// Writes one contradiction for each level whose inequality rows are not all kept by the solution.
pub fn write_contradictions(
    problem: &Problem,
    levels: &Hierarchy,
    solution: &Solution,
    solved: &mut Solved,
    contradictions: &mut Vec<Contradiction>,
) {
    if levels.rows.iter().all(Demand::is_equation) {
        return;
    }
    for (level, own) in levels.levels.iter().enumerate() {
        let broken = own.rows().find(|&row| is_broken(levels, solution, row));
        let Some(broken) = broken else { continue };
        let task = match levels.rows[broken].origin {
            Some(BoundId::Task { index, .. }) => Some(index),
            Some(_) => None,
            None => continue,
        };
        let Some(mut members) = proof_members(problem, levels, solution, level, solved) else { continue };
        reduce(&mut members);
        if members.is_empty() {
            // What is missing is rounding.
            continue;
        }
        contradictions.push(Contradiction { task, members: members.iter().map(|member| member.name).collect() });
    }
}

/// Returns whether an inequality row misses its bounds by more than rounding.
fn is_broken(levels: &Hierarchy, solution: &Solution, row: usize) -> bool {
    let (value, Demand { lower, upper, .. }) = (solution.row_values[row], levels.rows[row]);
    if levels.rows[row].is_equation() {
        return false;
    }
    let missing = (value - upper).max(lower - value);
    if missing <= 0.0 {
        return false;
    }
    let level = levels.levels.iter().find(|level| row < level.end);
    let rows = level.map_or(0..0, Level::rows);
    let norm = |entries: &mut dyn Iterator<Item = f64>| entries.map(|entry| entry * entry).sum::<f64>().sqrt();
    let speed = norm(&mut solution.x.iter().copied());
    let bounds = rows.clone().flat_map(|row| [levels.rows[row].lower, levels.rows[row].upper]);
    let target = norm(&mut bounds.filter(|bound| bound.is_finite()));
    let size = norm(&mut rows.flat_map(|row| levels.row(row).iter().copied())) * speed + target;
    missing > TOLERANCES.proof_weight * size
}

/// Returns the members of the proof that the multipliers of a level give; `None` where damping rows hold the level back.
fn proof_members(
    problem: &Problem,
    levels: &Hierarchy,
    solution: &Solution,
    level: usize,
    solved: &mut Solved,
) -> Option<Vec<Member>> {
    let n = problem.tasks.joint_count();
    let size = |row: usize| norm(levels.row(row)).max(f64::MIN_POSITIVE);
    let own = levels.levels[level].rows();
    if let Some(zero) = own.clone().find(|&row| size(row) == f64::MIN_POSITIVE && is_broken(levels, solution, row)) {
        // A row of zeros contradicts itself.
        let (Some(id), side) = (levels.rows[zero].origin, solution.working_set.rows[zero]?) else { return None };
        return Some(vec![member(Bound { id, side }, &vec![0.0; n], -1.0, 1.0, Side::Upper)]);
    }
    let (rows, unknowns) = proof(levels, solution, level, solved);
    let negligible = negligible_force(levels, &rows, &unknowns);
    // With Σ w_i a_i = h: the rows with the sign of −w pull against the bounds with the sign of h.
    let side = |sign: f64| if sign < 0.0 { Side::Lower } else { Side::Upper };
    let mut members = Vec::new();
    for (row, &w) in rows.iter().enumerate().filter(|(row, w)| w.abs() * size(*row) > negligible) {
        let side = side(-w);
        let name = Bound { id: levels.rows[row].origin?, side };
        // What a higher level achieved is kept, whatever it asked for.
        let is_kept = row < own.start && (levels.rows[row].is_equation() || is_broken(levels, solution, row));
        let bound = if is_kept { solution.row_values[row] } else { levels.rows[row].bound(side) };
        members.push(member(name, &levels.row(row)[..n], bound, w.abs(), side));
    }
    for (joint, &h) in unknowns[..n].iter().enumerate().filter(|(_, h)| h.abs() > negligible) {
        if solution.working_set.unknowns[joint].is_none() && levels.lower[joint] < levels.upper[joint] {
            continue;
        }
        let side = side(h);
        let bound = if side == Side::Lower { levels.lower[joint] } else { levels.upper[joint] };
        let unit: Vec<f64> = (0..n).map(|j| if j == joint { 1.0 } else { 0.0 }).collect();
        members.push(member(Bound { id: BoundId::Joint(joint), side }, &unit, bound, h.abs(), side));
    }
    Some(members)
}

/// Returns weights of the rows (sign of b − A x) and of the unknowns with Σ w_i a_i = h, in which every active bound has the
/// sign of its side: the multipliers of the level, plus multiples of those of higher levels for bounds that these decide.
fn proof(levels: &Hierarchy, solution: &Solution, level: usize, solved: &mut Solved) -> (Vec<f64>, Vec<f64>) {
    let (mut rows, mut unknowns, mut higher_rows, mut higher_unknowns) = (vec![], vec![], vec![], vec![]);
    solved.write_level_multipliers(levels, level, &mut rows, &mut unknowns);
    let set = &solution.working_set;
    for higher in (0..level).rev() {
        solved.write_level_multipliers(levels, higher, &mut higher_rows, &mut higher_unknowns);
        let negligible = negligible_force(levels, &higher_rows, &higher_unknowns);
        // How much of the higher level makes a wrong sign right; a sign that it does not decide stays.
        let needed = |side: Option<Side>, own: f64, higher: f64, size: f64| {
            let sign = side.map_or(0.0, Side::sign);
            if sign * own < 0.0 && sign * higher * size > negligible { -own / higher } else { 0.0 }
        };
        let of_unknowns = (0..unknowns.len()).map(|j| needed(set.unknowns[j], unknowns[j], higher_unknowns[j], 1.0));
        let of_rows =
            (0..rows.len()).map(|row| needed(set.rows[row], -rows[row], -higher_rows[row], norm(levels.row(row))));
        let factor = of_unknowns.chain(of_rows).fold(0.0, f64::max);
        rows.iter_mut().zip(&higher_rows).for_each(|(w, higher)| *w += factor * higher);
        unknowns.iter_mut().zip(&higher_unknowns).for_each(|(h, higher)| *h += factor * higher);
    }
    (rows, unknowns)
}

/// Returns the size below which a multiplier, times the length of its row, is rounding of others.
fn negligible_force(levels: &Hierarchy, rows: &[f64], unknowns: &[f64]) -> f64 {
    let of_rows = rows.iter().enumerate().map(|(row, w)| w.abs() * norm(levels.row(row)));
    TOLERANCES.proof_weight * of_rows.chain(unknowns.iter().map(|h| h.abs())).fold(0.0, f64::max)
}

/// Turns a demand into side · a·x ≤ side · b with a of length one.
fn member(name: Bound, coefficients: &[f64], bound: f64, weight: f64, side: Side) -> Member {
    let length = norm(coefficients);
    let length = if length > 0.0 { length } else { 1.0 };
    let coefficients = coefficients.iter().map(|a| side.sign() * a / length).collect();
    Member { name, coefficients, bound: side.sign() * bound / length, weight: weight * length }
}

/// Takes members away until the vectors a_i depend on each other in one way only.
///
/// Dependencies among a few members are found faster than among all, so the members are reduced group by group first.
fn reduce(members: &mut Vec<Member>) {
    let Some(first) = members.first() else { return };
    let most = 2 * first.coefficients.len() + 2;
    while members.len() > most {
        let rest = members.split_off(most);
        let is_proof = reduce_group(members, false);
        if !is_proof {
            let is_stuck = members.len() == most;
            members.extend(rest);
            if is_stuck {
                break;
            }
        }
    }
    reduce_group(members, true);
}

/// Takes members away along their dependencies; returns whether those that are left are a proof without any others. `is_all`: the
/// weights are a dependency themselves.
fn reduce_group(members: &mut Vec<Member>, is_all: bool) -> bool {
    let mut dependencies = dependencies(members);
    loop {
        let next = if is_all { other_dependency(&dependencies, members) } else { dependencies.first().cloned() };
        let Some(mut dependency) = next else { return is_all };
        let largest = dependency.iter().fold(0.0, |largest, d| f64::max(largest, d.abs()));
        let has =
            |dependency: &[f64], sign: f64| dependency.iter().any(|d| sign * d > TOLERANCES.proof_weight * largest);
        // Along the dependency Σ w_i b_i must not rise, and a weight must fall.
        let parts = || dependency.iter().zip(&*members).map(|(d, member)| d * member.bound);
        let (gain, size): (f64, f64) = (parts().sum(), parts().map(f64::abs).sum());
        let is_proof = gain.abs() > TOLERANCES.proof_weight * size && !has(&dependency, gain.signum());
        if !is_all && is_proof {
            // All signs agree: the dependency is a proof itself.
            members.iter_mut().zip(&dependency).for_each(|(member, d)| member.weight = d.abs());
            members.retain(|member| member.weight > TOLERANCES.proof_weight * largest);
            return true;
        }
        if gain < 0.0 || !has(&dependency, 1.0) {
            for d in &mut dependency {
                *d = -*d;
            }
        }
        // One weight vanishes first.
        let step = |(d, member): (&f64, &Member)| {
            if *d > TOLERANCES.proof_weight * largest { member.weight / d } else { f64::INFINITY }
        };
        let steps = dependency.iter().zip(&*members).map(step).enumerate();
        let Some((vanishing, length)) = steps.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, step)| step.is_finite())
        else {
            return is_all;
        };
        for (member, d) in members.iter_mut().zip(&dependency) {
            member.weight = (member.weight - length * d).max(0.0);
        }
        members[vanishing].weight = 0.0;
        let largest = members.iter().map(|member| member.weight).fold(0.0, f64::max);
        for member in (0..members.len()).rev() {
            if members[member].weight > TOLERANCES.proof_weight * largest {
                continue;
            }
            members.remove(member);
            drop_member(&mut dependencies, member);
        }
    }
}

/// Returns a basis of all dependencies Σ d_i a_i = 0, from a factorisation A P = Q [R_1, R_2]: the columns of
/// P [−R_1⁻¹R_2; I].
fn dependencies(members: &[Member]) -> Vec<Vec<f64>> {
    let Some(first) = members.first() else { return Vec::new() };
    let (n, count) = (first.coefficients.len(), members.len());
    let factors = Matrix::from_fn(n, count, |i, j| members[j].coefficients[i]).col_piv_qr();
    let r = factors.r();
    let is_pivot = |&i: &usize| r[(i, i)].abs() > TOLERANCES.proof_weight * r[(0, 0)].abs();
    let rank = (0..n.min(count)).take_while(is_pivot).count();
    let others = -r.view((0, rank), (rank, count - rank));
    let Some(top) = r.view((0, 0), (rank, rank)).solve_upper_triangular(&others) else { return Vec::new() };
    let mut basis = Matrix::identity(count, count).columns(rank, count - rank).into_owned();
    basis.rows_mut(0, rank).copy_from(&top);
    factors.p().inv_permute_rows(&mut basis);
    basis.column_iter().map(|column| column.iter().copied().collect()).collect()
}

/// Returns a dependency without its part along the weights, which are a dependency themselves; `None` if there is no other.
fn other_dependency(dependencies: &[Vec<f64>], members: &[Member]) -> Option<Vec<f64>> {
    let weight_square: f64 = members.iter().map(|member| member.weight * member.weight).sum();
    dependencies.iter().find_map(|dependency| {
        let along = dependency.iter().zip(members).map(|(d, member)| d * member.weight).sum::<f64>() / weight_square;
        let other: Vec<f64> = dependency.iter().zip(members).map(|(d, member)| d - along * member.weight).collect();
        (norm(&other) > TOLERANCES.proof_distinct * norm(dependency)).then_some(other)
    })
}

/// Removes a member from the dependencies: those that are left do not contain it.
fn drop_member(dependencies: &mut Vec<Vec<f64>>, member: usize) {
    let share = |dependency: &[f64]| dependency[member].abs() / norm(dependency);
    let by_share = |a: &usize, b: &usize| share(&dependencies[*a]).total_cmp(&share(&dependencies[*b]));
    let most =
        (0..dependencies.len()).max_by(by_share).filter(|&most| share(&dependencies[most]) > TOLERANCES.proof_weight);
    if let Some(most) = most {
        let pivot = dependencies.swap_remove(most);
        for dependency in &mut *dependencies {
            let factor = dependency[member] / pivot[member];
            dependency.iter_mut().zip(&pivot).for_each(|(d, pivot)| *d -= factor * pivot);
        }
    }
    for dependency in dependencies {
        dependency.remove(member);
    }
}

fn norm(entries: &[f64]) -> f64 {
    entries.iter().map(|entry| entry * entry).sum::<f64>().sqrt()
}
