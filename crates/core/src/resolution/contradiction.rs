//! Minimal sets of demands that contradict each other.
//!
//! Where a level leaves a residual, its multipliers w prove it: Σ w_i a_i = 0 over its rows, the rows of higher levels and the
//! bounds, with w_i ≥ 0 once each a_i points out of its demand (Farkas). All these demands are then held at the values that
//! they have, so that lower levels may use them as equations. This file keeps a basis of what is held. A level moves its
//! weights along dependencies of its vectors, one member after the other as in the simplex method, until a dependency has no
//! negative weight. Such a *face* is a proof of its own, up to vectors that higher levels hold; weights of these that have the
//! wrong sign become right by adding their own faces, from the last to the first.

use revprio_problem::{Bound, BoundId, Contradiction, Side};

use super::engine::Solved;
use super::hierarchy::{Hierarchy, Level};
use super::solution::Solution;
use crate::linalg::dot;
use crate::tolerances::TOLERANCES;

/// Writes one contradiction for each level whose inequality rows are not all kept by the solution. The first `joints` unknowns
/// are joint velocities.
pub fn write_contradictions(
    levels: &Hierarchy,
    joints: usize,
    solution: &Solution,
    solved: &mut Solved,
    contradictions: &mut Vec<Contradiction>,
) {
    let is_broken = |level: &Level| broken_row(levels, solution, level).is_some();
    let has_inequalities = !levels.inequalities.is_empty();
    let last = has_inequalities.then(|| levels.levels.iter().rposition(is_broken)).flatten();
    let Some(last) = last else { return };
    let mut proofs = Proofs::new(levels, solution);
    proofs.hold_pinned_unknowns();
    for (index, level) in levels.levels[..=last].iter().enumerate() {
        let proof = proofs.close(index, solved);
        let (Some(proof), Some(broken)) = (proof, broken_row(levels, solution, level)) else { continue };
        let Some(members) = names(levels, joints, &proof) else { continue };
        let task = match levels.rows[broken].origin {
            Some(BoundId::Task { index, .. }) => Some(index),
            Some(_) => None,
            None => continue,
        };
        contradictions.push(Contradiction { task, members });
    }
}

/// Returns an inequality row of a level that misses its bounds.
fn broken_row(levels: &Hierarchy, solution: &Solution, level: &Level) -> Option<usize> {
    let mut missing = levels.missing_rows(solution, level);
    missing.find(|(row, _)| !levels.rows[*row].is_equation()).map(|(row, _)| row)
}

/// Returns the names of the demands of a proof; `None` if one has no name, such as a row of damping.
fn names(levels: &Hierarchy, joints: usize, proof: &[(HalfSpace, f64)]) -> Option<Vec<Bound>> {
    let negligible = TOLERANCES.proof_weight * proof.iter().fold(0.0, |most, (_, weight)| f64::max(most, weight.abs()));
    let mut members: Vec<_> = proof.iter().filter(|(_, weight)| weight.abs() > negligible).collect();
    members.sort_unstable_by_key(|(half_space, _)| half_space.at);
    let name = |&&(HalfSpace { at, side }, weight): &&(HalfSpace, f64)| {
        let joint = at.checked_sub(levels.rows.len());
        let id = match joint {
            Some(joint) => (joint < joints).then_some(BoundId::Joint(joint))?,
            None => levels.rows[at].origin?,
        };
        // Equations have weights of both signs.
        Some(Bound { id, side: if side.sign() * weight < 0.0 { Side::Lower } else { Side::Upper } })
    };
    members.iter().map(name).collect()
}

/// A demand side · a·x ≤ side · b: of a row, or of the unknown `at` − m behind the m rows.
#[derive(Debug, Clone, Copy)]
struct HalfSpace {
    at: usize,
    side: Side,
}

/// A demand with a multiplier that is not zero.
struct Member {
    half_space: HalfSpace,
    /// What is missing, divided by ‖a‖.
    missing: f64,
    /// Its multiplier times ‖a‖.
    weight: f64,
    /// Whether its vector depends on those that are held.
    is_held: bool,
}

/// Demands whose vectors depend on each other with positive weights, up to what was held before.
struct Face {
    /// The one that is not in the basis; its weight is 1.
    outside: HalfSpace,
    /// The places of the others.
    places: Vec<usize>,
    /// The weight of each place of the basis.
    weights: Vec<f64>,
}

/// The proofs of the levels, from the highest one on.
struct Proofs<'a> {
    levels: &'a Hierarchy,
    solution: &'a Solution,
    /// What each row misses, divided by its length; 0 where that is rounding.
    missing: Vec<f64>,
    /// Whether the vector of each row and of each unknown depends on those that are held.
    is_held: Vec<bool>,
    basis: Basis,
    faces: Vec<Face>,
}

impl<'a> Proofs<'a> {
    fn new(levels: &'a Hierarchy, solution: &'a Solution) -> Self {
        let mut missing = vec![0.0; levels.rows.len()];
        for level in &levels.levels {
            levels.missing_rows(solution, level).for_each(|(row, off)| missing[row] = off / length(levels, row));
        }
        let (is_held, basis) = (vec![false; levels.rows.len() + levels.unknowns], Basis::new(levels.unknowns));
        Self { levels, solution, missing, is_held, basis, faces: Vec::new() }
    }

    /// Holds the unknowns that have one value.
    fn hold_pinned_unknowns(&mut self) {
        let levels = self.levels;
        let pinned = (0..levels.unknowns).filter(|&j| levels.lower[j] >= levels.upper[j]);
        pinned.for_each(|j| self.hold(levels.rows.len() + j));
    }

    /// Holds an equation: a row, or an unknown.
    fn hold(&mut self, at: usize) {
        let half_space = HalfSpace { at, side: Side::Upper };
        self.basis.decompose(self.levels, half_space);
        self.basis.add(Place::Held(half_space));
        self.is_held[at] = true;
    }

    /// Holds what a level decides; returns the members of a proof that its inequality rows contradict each other, with weights.
    fn close(&mut self, level: usize, solved: &mut Solved) -> Option<Vec<(HalfSpace, f64)>> {
        let (levels, own) = (self.levels, self.levels.levels[level].rows());
        own.clone().filter(|&row| levels.rows[row].is_equation()).for_each(|row| self.hold(row));
        if own.clone().all(|row| self.missing[row] == 0.0) {
            return None;
        }
        let mut members = self.members(level, solved);
        let mut proof = None;
        // Weights can leave vectors that no face contains. These begin again with the weights that they had. Each face holds a
        // place of the basis, so that all levels together begin again n times at most.
        while self.pass(&mut members, &mut proof) {}
        self.basis.leave_members();
        for member in members.iter().filter(|member| member.is_held) {
            self.is_held[member.half_space.at] = true;
        }
        proof
    }

    /// Returns the demands that are not held and that the multipliers of a level need.
    fn members(&self, level: usize, solved: &mut Solved) -> Vec<Member> {
        let (levels, set) = (self.levels, &self.solution.working_set);
        let (mut rows, mut unknowns) = (Vec::new(), Vec::new());
        solved.write_level_multipliers(levels, level, &mut rows, &mut unknowns);
        let own = levels.levels[level].rows();
        let of_rows = (0..own.end).map(|row| (row, set.rows[row], -rows[row] * length(levels, row)));
        let of_unknowns = (0..levels.unknowns).map(|j| (levels.rows.len() + j, set.unknowns[j], unknowns[j]));
        let forces = of_rows.chain(of_unknowns);
        let largest = forces.clone().fold(0.0, |most, (.., force)| f64::max(most, force.abs()));
        let not_held = forces.filter(|(at, ..)| !self.is_held[*at]);
        let members = not_held.filter_map(|(at, side, force)| {
            let side = side?;
            let (weight, missing) = (side.sign() * force, if own.contains(&at) { self.missing[at] } else { 0.0 });
            let counts = missing > 0.0 || weight > TOLERANCES.proof_weight * largest;
            counts.then_some(Member {
                half_space: HalfSpace { at, side },
                missing,
                weight: weight.max(0.0),
                is_held: false,
            })
        });
        members.collect()
    }

    /// Moves the weights of the members that are not held, and holds the faces that this finds; returns whether it found one.
    /// The first one in which something is missing becomes the proof.
    ///
    /// Members are added to the basis one after the other. If a_j = Σ t_p a_p depends on the basis, the weights move along this
    /// dependency so that Σ w_i s_i of what is missing does not fall, until one of them vanishes; what is left stays a basis.
    fn pass(&mut self, members: &mut [Member], proof: &mut Option<Vec<(HalfSpace, f64)>>) -> bool {
        let mut weights: Vec<f64> = members.iter().map(|member| member.weight).collect();
        let size = members.iter().fold(0.0, |size, member| f64::max(size, member.missing));
        let known = self.faces.len();
        // Unknowns are last: their unit vectors make the inverse sparse.
        for next in (0..members.len()).rev() {
            if members[next].is_held || self.basis.has(next) {
                continue;
            }
            if proof.is_some() && self.basis.is_held() {
                return false;
            }
            self.basis.decompose(self.levels, members[next].half_space);
            if self.basis.add(Place::Member(next)) {
                continue;
            }
            let negligible = TOLERANCES.proof_weight * self.basis.t.iter().fold(1.0, |most, t| f64::max(most, t.abs()));
            let others: f64 = self.basis.members().map(|(_, member, t)| t * members[member].missing).sum();
            let is_gain = members[next].missing - others > negligible * size;
            if self.basis.members().all(|(.., t)| t <= negligible) {
                let face = self.hold_face(members, next, negligible);
                if is_gain && proof.is_none() {
                    *proof = Some(self.with_right_signs(&face));
                }
                if !face.places.is_empty() {
                    self.faces.push(face);
                }
                continue;
            }
            if let Some(place) = self.move_weights(&mut weights, next, is_gain, negligible) {
                self.basis.exchange(place, Place::Member(next));
            }
        }
        self.faces.len() > known
    }

    /// Moves weights along the dependency of `next` on the basis, towards `next` or away from it, until one of them vanishes;
    /// returns its place, `None` if it is that of `next`.
    fn move_weights(&self, weights: &mut [f64], next: usize, towards: bool, negligible: f64) -> Option<usize> {
        let direction = if towards { 1.0 } else { -1.0 };
        let falling = self.basis.members().filter(|(.., t)| direction * t > negligible);
        let lengths = falling.map(|(place, member, t)| (weights[member] / t.abs(), Some(place)));
        let own = (if towards { f64::INFINITY } else { weights[next] }, None);
        let (length, vanishing) = lengths.fold(own, |least, other| if other.0 < least.0 { other } else { least });
        for (_, member, t) in self.basis.members() {
            weights[member] = (weights[member] - direction * length * t).max(0.0);
        }
        weights[next] += direction * length;
        vanishing
    }

    /// Holds the members whose dependency was found: `next`, and those with negative t in the basis.
    fn hold_face(&mut self, members: &mut [Member], next: usize, negligible: f64) -> Face {
        let found: Vec<_> = self.basis.members().filter(|(.., t)| *t < -negligible).collect();
        for &(place, member, _) in &found {
            members[member].is_held = true;
            self.basis.places[place] = Place::Held(members[member].half_space);
        }
        members[next].is_held = true;
        let weights = self.basis.t.iter().map(|t| -t).collect();
        Face {
            outside: members[next].half_space,
            places: found.into_iter().map(|(place, ..)| place).collect(),
            weights,
        }
    }

    /// Returns the members of the proof that a face is, with weights. Those of earlier faces are not negative.
    fn with_right_signs(&self, face: &Face) -> Vec<(HalfSpace, f64)> {
        let mut weights = face.weights.clone();
        let mut proof = vec![(face.outside, 1.0)];
        for face in self.faces.iter().rev() {
            let needed = face.places.iter().map(|&place| -weights[place] / face.weights[place]);
            let factor = needed.fold(0.0, f64::max);
            weights.iter_mut().zip(&face.weights).for_each(|(weight, own)| *weight += factor * own);
            proof.push((face.outside, factor));
        }
        proof.extend(self.basis.held().map(|(place, half_space)| (half_space, weights[place])));
        proof
    }
}

/// What stands at a place of a basis.
#[derive(Debug, Clone, Copy)]
enum Place {
    /// A vector that only completes the basis.
    Free,
    /// A member of the level.
    Member(usize),
    /// A demand that is held.
    Held(HalfSpace),
}

/// n independent vectors.
struct Basis {
    places: Vec<Place>,
    /// The inverse of the matrix whose columns are the basis, row by row.
    inverse: Vec<f64>,
    /// The vector that was decomposed last is Σ t_p a_p.
    t: Vec<f64>,
    vector: Vec<f64>,
}

impl Basis {
    fn new(n: usize) -> Self {
        let inverse = (0..n * n).map(|at| if at % (n + 1) == 0 { 1.0 } else { 0.0 }).collect();
        Self { places: vec![Place::Free; n], inverse, t: vec![0.0; n], vector: vec![0.0; n] }
    }

    /// Decomposes side · a/‖a‖.
    fn decompose(&mut self, levels: &Hierarchy, HalfSpace { at, side }: HalfSpace) {
        let (vector, n) = (&mut self.vector, self.t.len());
        if let Some(j) = at.checked_sub(levels.rows.len()) {
            let column = self.inverse.chunks_exact(n).map(|row| side.sign() * row[j]);
            self.t.iter_mut().zip(column).for_each(|(t, entry)| *t = entry);
            return;
        }
        let factor = side.sign() / length(levels, at);
        vector.iter_mut().zip(levels.row(at)).for_each(|(entry, a)| *entry = factor * a);
        let rows = self.inverse.chunks_exact(n);
        self.t.iter_mut().zip(rows).for_each(|(t, row)| *t = dot(row, vector));
    }

    /// Returns the places of members, with t.
    fn members(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        let places = self.places.iter().zip(&self.t).enumerate();
        places.filter_map(
            |(at, (place, t))| if let Place::Member(member) = place { Some((at, *member, *t)) } else { None },
        )
    }

    /// Returns the places that are held.
    fn held(&self) -> impl Iterator<Item = (usize, HalfSpace)> {
        let places = self.places.iter().enumerate();
        places
            .filter_map(|(at, place)| if let Place::Held(half_space) = place { Some((at, *half_space)) } else { None })
    }

    fn has(&self, next: usize) -> bool {
        self.members().any(|(_, member, _)| member == next)
    }

    /// Returns whether all places are held.
    fn is_held(&self) -> bool {
        self.held().count() == self.places.len()
    }

    /// Puts the vector that was decomposed last in a free place, if it is independent of the others; returns whether it is.
    fn add(&mut self, content: Place) -> bool {
        let is_free = |place: &usize| matches!(self.places[*place], Place::Free);
        let by_size = |a: &usize, b: &usize| self.t[*a].abs().total_cmp(&self.t[*b].abs());
        let largest = (0..self.t.len()).filter(is_free).max_by(by_size);
        let Some(place) = largest.filter(|&place| self.t[place].abs() > TOLERANCES.proof_weight) else { return false };
        self.exchange(place, content);
        true
    }

    /// Puts the vector that was decomposed last in a place.
    fn exchange(&mut self, place: usize, content: Place) {
        let Self { places, inverse, t, vector: row } = self;
        let n = t.len();
        places[place] = content;
        row.iter_mut().zip(&inverse[place * n..]).for_each(|(own, entry)| *own = entry / t[place]);
        for (other, factor) in inverse.chunks_exact_mut(n).zip(&*t).filter(|(_, factor)| **factor != 0.0) {
            other.iter_mut().zip(&*row).for_each(|(entry, own)| *entry -= factor * own);
        }
        inverse[place * n..][..n].copy_from_slice(row);
    }

    /// Leaves the places of members to others.
    fn leave_members(&mut self) {
        for place in self.places.iter_mut().filter(|place| matches!(place, Place::Member(_))) {
            *place = Place::Free;
        }
    }
}

/// Returns ‖a‖ of a row, or 1 for a row of zeros.
fn length(levels: &Hierarchy, row: usize) -> f64 {
    let square = levels.rows[row].square;
    if square > 0.0 { square.sqrt() } else { 1.0 }
}
