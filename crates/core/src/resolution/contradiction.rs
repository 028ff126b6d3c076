//! Minimal sets of demands that contradict each other.
//!
//! Where a level cannot keep its inequalities, the multipliers w of its residual prove it: Σ w_i a_i = 0 over its rows, the
//! rows of higher levels and the bounds, while Σ w_i b_i < 0 (Farkas). Weights are then moved along dependencies of the vectors
//! a_i, one member after the other as in the simplex method, until a dependency is a proof itself.

use revprio_problem::{Bound, BoundId, Contradiction, Problem, Side};

use super::engine::Solved;
use super::hierarchy::{Hierarchy, Level};
use super::solution::Solution;
use crate::linalg::dot;
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
    if levels.inequalities.is_empty() {
        return;
    }
    let mut broken = Vec::new();
    for (level, own) in levels.levels.iter().enumerate() {
        let known = broken.len();
        broken.extend(broken_rows(levels, solution, own));
        let Some(&first) = broken.get(known) else { continue };
        let task = match levels.rows[first].origin {
            Some(BoundId::Task { index, .. }) => Some(index),
            Some(_) => None,
            None => continue,
        };
        let Some(mut members) = proof_members(problem, levels, (solution, &broken), level, solved) else { continue };
        reduce(&mut members);
        if members.is_empty() {
            // What is missing is rounding.
            continue;
        }
        contradictions.push(Contradiction { task, members: members.iter().map(|member| member.name).collect() });
    }
}

/// Returns the inequality rows of a level that miss their bounds by more than rounding.
fn broken_rows(levels: &Hierarchy, solution: &Solution, level: &Level) -> impl Iterator<Item = usize> {
    let rounding = TOLERANCES.proof_weight * levels.size(level, norm(&solution.x));
    let missing = |row: usize| {
        let (value, demand) = (solution.row_values[row], &levels.rows[row]);
        (value - demand.upper).max(demand.lower - value)
    };
    level.rows().filter(move |&row| !levels.rows[row].is_equation() && missing(row) > rounding)
}

/// Returns the members of the proof that the multipliers of a level give; `None` where damping rows hold the level back.
fn proof_members(
    problem: &Problem,
    levels: &Hierarchy,
    (solution, broken): (&Solution, &[usize]),
    level: usize,
    solved: &mut Solved,
) -> Option<Vec<Member>> {
    let n = problem.tasks.joint_count();
    let own = levels.levels[level].rows();
    let is_broken = |row: usize| broken.binary_search(&row).is_ok();
    if let Some(zero) = own.clone().find(|&row| is_broken(row) && levels.row(row).iter().all(|entry| *entry == 0.0)) {
        // A row of zeros contradicts itself.
        let (Some(id), side) = (levels.rows[zero].origin, solution.working_set.rows[zero]?) else { return None };
        return Some(vec![member(Bound { id, side }, &vec![0.0; n], -1.0, 1.0, Side::Upper)]);
    }
    let (rows, unknowns) = proof(levels, solution, level, solved);
    let negligible = negligible_force(levels, &rows, &unknowns);
    // With Σ w_i a_i = h: the rows with the sign of −w pull against the bounds with the sign of h.
    let side = |sign: f64| if sign < 0.0 { Side::Lower } else { Side::Upper };
    let mut members = Vec::new();
    for (row, &w) in rows.iter().enumerate().filter(|(row, w)| w.abs() * length(levels, *row) > negligible) {
        let side = side(-w);
        let name = Bound { id: levels.rows[row].origin?, side };
        // What a higher level achieved is kept, whatever it asked for.
        let is_kept = row < own.start && (levels.rows[row].is_equation() || is_broken(row));
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
    let is_wrong = |side: Option<Side>, own: f64| side.is_some_and(|side| side.sign() * own < 0.0);
    for higher in (0..level).rev() {
        let wrong_unknowns = (0..unknowns.len()).filter(|&j| is_wrong(set.unknowns[j], unknowns[j]));
        let wrong_rows = (0..rows.len()).filter(|&row| is_wrong(set.rows[row], -rows[row]));
        let wrong: (Vec<usize>, Vec<usize>) = (wrong_unknowns.collect(), wrong_rows.collect());
        if wrong.0.is_empty() && wrong.1.is_empty() {
            break;
        }
        solved.write_level_multipliers(levels, higher, &mut higher_rows, &mut higher_unknowns);
        let negligible = negligible_force(levels, &higher_rows, &higher_unknowns);
        // How much of the higher level makes a wrong sign right; a sign that it does not decide stays.
        let needed = |own: f64, higher: f64, size: f64| {
            if own * higher < 0.0 && higher.abs() * size > negligible { -own / higher } else { 0.0 }
        };
        let of_unknowns = wrong.0.iter().map(|&j| needed(unknowns[j], higher_unknowns[j], 1.0));
        let of_rows = wrong.1.iter().map(|&row| needed(rows[row], higher_rows[row], length(levels, row)));
        let factor = of_unknowns.chain(of_rows).fold(0.0, f64::max);
        rows.iter_mut().zip(&higher_rows).for_each(|(w, higher)| *w += factor * higher);
        unknowns.iter_mut().zip(&higher_unknowns).for_each(|(h, higher)| *h += factor * higher);
    }
    (rows, unknowns)
}

/// Returns the size below which a multiplier, times the length of its row, is rounding of others.
fn negligible_force(levels: &Hierarchy, rows: &[f64], unknowns: &[f64]) -> f64 {
    let of_rows = rows.iter().enumerate().map(|(row, w)| w.abs() * length(levels, row));
    TOLERANCES.proof_weight * of_rows.chain(unknowns.iter().map(|h| h.abs())).fold(0.0, f64::max)
}

/// Turns a demand into side · a·x ≤ side · b with a of length one.
fn member(name: Bound, coefficients: &[f64], bound: f64, weight: f64, side: Side) -> Member {
    let length = norm(coefficients);
    let length = if length > 0.0 { length } else { 1.0 };
    let coefficients = coefficients.iter().map(|a| side.sign() * a / length).collect();
    Member { name, coefficients, bound: side.sign() * bound / length, weight: weight * length }
}

/// Replaces the members by a proof whose vectors depend on each other in one way only.
///
/// Members are added to a basis one after the other. If a_j = Σ t_p a_p depends on the basis, the weights move along this
/// dependency so that Σ w_i b_i does not rise, until one of them vanishes; what is left stays a basis. If none vanishes, the
/// dependency is a proof.
fn reduce(members: &mut Vec<Member>) {
    let mut basis = Basis::new(members.first().map_or(0, |member| member.coefficients.len()));
    let size = members.iter().fold(0.0, |size, member| f64::max(size, member.bound.abs()));
    // Joints are last: their unit vectors make the inverse sparse.
    for next in (0..members.len()).rev() {
        basis.decompose(&members[next].coefficients);
        if basis.add(next) {
            continue;
        }
        let negligible = TOLERANCES.proof_weight * basis.t.iter().fold(1.0, |most, t| f64::max(most, t.abs()));
        let others: f64 = basis.taken().map(|(_, member, t)| t * members[member].bound).sum();
        let direction = if others - members[next].bound > negligible * size { 1.0 } else { -1.0 };
        let falling = basis.taken().filter(|(.., t)| direction * t > negligible);
        let lengths = falling.map(|(place, member, t)| (members[member].weight / t.abs(), Some(place)));
        let own = (if direction > 0.0 { f64::INFINITY } else { members[next].weight }, None);
        let (length, vanishing) = lengths.fold(own, |least, other| if other.0 < least.0 { other } else { least });
        if length.is_infinite() {
            for member in members.iter_mut() {
                member.weight = 0.0;
            }
            basis.taken().for_each(|(_, member, t)| members[member].weight = -t);
            members[next].weight = 1.0;
            members.retain(|member| member.weight > negligible);
            return;
        }
        for (_, member, t) in basis.taken() {
            members[member].weight = (members[member].weight - direction * length * t).max(0.0);
        }
        members[next].weight += direction * length;
        if let Some(place) = vanishing {
            basis.exchange(place, next);
        }
    }
    members.clear();
}

/// Independent vectors of members, completed by unit vectors to a basis of n vectors.
struct Basis {
    /// The member at each place; `None`: the unit vector.
    members: Vec<Option<usize>>,
    /// The inverse of the matrix whose columns are the basis, row by row.
    inverse: Vec<f64>,
    /// The vector that was decomposed last is Σ t_p a_p.
    t: Vec<f64>,
    row: Vec<f64>,
}

impl Basis {
    fn new(n: usize) -> Self {
        let inverse = (0..n * n).map(|at| if at % (n + 1) == 0 { 1.0 } else { 0.0 }).collect();
        Self { members: vec![None; n], inverse, t: vec![0.0; n], row: vec![0.0; n] }
    }

    fn decompose(&mut self, vector: &[f64]) {
        let rows = self.inverse.chunks_exact(vector.len().max(1));
        self.t.iter_mut().zip(rows).for_each(|(t, row)| *t = dot(row, vector));
    }

    /// Returns the places of members, with t.
    fn taken(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        let places = self.members.iter().zip(&self.t).enumerate();
        places.filter_map(|(place, (member, t))| member.map(|member| (place, member, *t)))
    }

    /// Puts the member of the decomposed vector in the place of a unit vector, if it is independent of the other members; returns
    /// whether it is.
    fn add(&mut self, member: usize) -> bool {
        let is_unit = |place: &usize| self.members[*place].is_none();
        let by_size = |a: &usize, b: &usize| self.t[*a].abs().total_cmp(&self.t[*b].abs());
        let largest = (0..self.t.len()).filter(is_unit).max_by(by_size);
        let Some(place) = largest.filter(|&place| self.t[place].abs() > TOLERANCES.proof_weight) else { return false };
        self.exchange(place, member);
        true
    }

    /// Puts the member of the decomposed vector in a place.
    fn exchange(&mut self, place: usize, member: usize) {
        let Self { members, inverse, t, row } = self;
        let n = t.len();
        members[place] = Some(member);
        row.iter_mut().zip(&inverse[place * n..]).for_each(|(own, entry)| *own = entry / t[place]);
        for (other, factor) in inverse.chunks_exact_mut(n).zip(&*t).filter(|(_, factor)| **factor != 0.0) {
            other.iter_mut().zip(&*row).for_each(|(entry, own)| *entry -= factor * own);
        }
        inverse[place * n..][..n].copy_from_slice(row);
    }
}

/// Returns ‖a‖ of a row.
fn length(levels: &Hierarchy, row: usize) -> f64 {
    levels.rows[row].square.sqrt()
}

fn norm(entries: &[f64]) -> f64 {
    dot(entries, entries).sqrt()
}
