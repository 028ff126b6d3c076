//! One level of the cascade as a quadratic program over what the levels above leave open, x + size Z z.
#![allow(non_snake_case)]

use revprio_problem::{Matrix, Side, Vector};

use crate::hierarchy::{Hierarchy, Level};
use crate::program::{Effort, QpAnswer, QuadraticProgram};

/// What a constraint bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bounded {
    /// An unknown.
    Unknown(usize),
    /// A satisfied inequality row of a higher level.
    Higher { level: usize, row: usize },
    /// An inequality row of the level itself, which may be violated: index of the row.
    Own(usize),
}

/// What a constraint g·z ≤ room of a program is about; g and room are its row of `G` and `rooms`. For a row of the level itself its
/// excess is minimised.
#[derive(Debug, Clone)]
pub struct Constraint {
    pub bounded: Bounded,
    pub side: Side,
    /// Factor of the multiplier from the program to the problem.
    pub unit: f64,
}

/// min ½ ‖C z − d‖² + ½ Σ excess² subject to the constraints, in units in which the level and its velocity have size one.
#[derive(Debug)]
pub struct LevelProgram {
    pub C: Matrix,
    pub d: Vector,
    pub constraints: Vec<Constraint>,
    /// The constraints G z ≤ rooms.
    pub G: Matrix,
    pub rooms: Vector,
    /// Size of z in the units of x.
    pub size: f64,
    /// Size of multipliers and of gradients: ‖b_k‖/‖A_k‖ + the speed, in units of `size`.
    pub scale: f64,
    /// Size of velocities, in units of `size`.
    pub speed: f64,
    /// Size of z relative to what the level misses.
    pub zoom: f64,
    /// Whether nothing that is open improves the level.
    pub is_decided: bool,
}

/// A level that moves by less than this fraction is decided by the levels above.
const DECIDED: f64 = 1e-10;

/// Rooms, in units of what the level misses, beyond which constraints are left out: Clarabel converges slowly, or not at all, where
/// far constraints stand next to near ones. [`LevelProgram::residual`] checks them all the same.
const FAR: f64 = 30.0;
const FAR_CAREFUL: f64 = 1e6;

/// What a level misses, relative to its velocities, that is rounding.
const ROUNDING: f64 = 4e-15;

/// An unknown that moves by less than this along the open directions is decided by the levels above.
const UNMOVED: f64 = 1e-11;

/// What the levels above have decided.
pub struct Decided<'a> {
    /// The solution so far, one entry for each unknown.
    pub x: &'a Vector,
    /// Z: orthonormal columns along which x may move.
    pub basis: &'a Matrix,
    /// Unknowns that are held at a bound.
    pub fixed: &'a [bool],
    /// Rows of each level that are kept at their value.
    pub kept: &'a [Vec<bool>],
}

/// The rows of a level over the open directions, in units in which the level has size one.
struct LevelRows<'a> {
    level: &'a Level,
    x: &'a Vector,
    /// 1/‖A_k‖.
    scale: f64,
    /// A_k Z/‖A_k‖.
    moved: Matrix,
}

impl<'a> LevelRows<'a> {
    fn new(level: &'a Level, decided: &Decided<'a>) -> Self {
        let norm = level.rows.norm();
        let scale = if norm.is_normal() { 1.0 / norm } else { 1.0 };
        Self { level, x: decided.x, scale, moved: &level.rows * decided.basis * scale }
    }

    /// Returns the equations of the level, or its inequality rows.
    fn of_kind(&self, is_equation: bool) -> impl Iterator<Item = usize> + '_ {
        (0..self.level.rows.nrows()).filter(move |&row| self.level.is_equation(row) == is_equation)
    }

    /// Returns by how much x misses the bounds of a row.
    fn missing_of(&self, row: usize) -> f64 {
        self.level.missing(row, self.level.value(row, self.x)) * self.scale
    }

    /// Returns whether the open directions change a row. What nothing changes says nothing of the size of a level.
    fn moves(&self, row: usize) -> bool {
        self.moved.row(row).amax() > UNMOVED
    }

    /// Returns what x misses of the rows that can be changed: the norm of the equations or the largest inequality row.
    fn missing(&self) -> f64 {
        let movable =
            |is_equation| self.of_kind(is_equation).filter(|&row| self.moves(row)).map(|row| self.missing_of(row));
        let equations = movable(true).fold(0.0, f64::hypot);
        movable(false).fold(equations, |size, missing| size.max(missing.abs()))
    }

    /// Returns the largest value that a row can have and shall have: its target or, of an inequality row, the nearest value
    /// inside its bounds. Bounds that are met say nothing of the size of a level.
    fn target(&self) -> f64 {
        let rows = (0..self.level.rows.nrows()).filter(|&row| self.moves(row));
        rows.map(|row| (self.level.value(row, self.x) * self.scale + self.missing_of(row)).abs()).fold(0.0, f64::max)
    }
}

impl LevelProgram {
    /// Poses level k of a problem; k = number of levels: min ‖x − ζ‖².
    ///
    /// `zoom`: the size of z relative to what the level misses; less than 1 where x is nearly the answer, so that small distances
    /// from bounds are seen.
    pub fn new(problem: &Hierarchy, k: usize, decided: &Decided, zoom: f64) -> Self {
        let last = (k == problem.levels.len()).then(|| last_objective(problem));
        let rows = LevelRows::new(last.as_ref().unwrap_or_else(|| &problem.levels[k]), decided);
        let speed = decided.x.norm();
        let (missing, target) = (rows.missing(), rows.target());
        let equations: Vec<usize> = rows.of_kind(true).collect();
        let C = rows.moved.select_rows(&equations);
        let d = Vector::from_iterator(equations.len(), equations.iter().map(|&row| rows.missing_of(row)));
        let keeps_own = rows.of_kind(false).all(|row| !rows.moves(row) || rows.missing_of(row) == 0.0);
        let has_rounding_alone = missing <= ROUNDING * (target + speed);
        let is_decided = has_rounding_alone || (keeps_own && C.norm() <= DECIDED);
        let size = zoom * if missing.is_normal() { missing } else { 1.0 };
        let speed = (speed / size).max(1.0);
        let mut program = Self {
            C,
            d: d / size,
            constraints: Vec::new(),
            G: Matrix::zeros(0, decided.basis.ncols()),
            rooms: Vector::zeros(0),
            size,
            scale: target / size + speed,
            speed,
            zoom,
            is_decided,
        };
        // A level that is posed again is solved also where its answer has met it: with its constraints.
        if !is_decided || zoom < 1.0 {
            program.push_constraints(problem, k, decided, size / rows.scale / rows.scale);
            program.push_own(&rows);
        }
        program
    }

    /// Adds the bounds of unknowns that move and of satisfied rows of higher levels. `unit`: that of the multipliers of unknowns.
    fn push_constraints(&mut self, problem: &Hierarchy, k: usize, decided: &Decided, unit: f64) {
        let Decided { x, basis, fixed, kept } = *decided;
        let (mut rows, mut rooms) = (Vec::new(), Vec::new());
        let (size, is_closer) = (self.size, self.zoom < 1.0);
        let mut push = |bounded, side: Side, room: f64, unit, row: &dyn Fn(usize) -> f64| {
            let moves = (0..basis.ncols()).any(|i| row(i).abs() > UNMOVED);
            if room.is_finite() && moves {
                self.constraints.push(Constraint { bounded, side, unit });
                rows.extend((0..basis.ncols()).map(|i| side.sign() * row(i)));
                // Rounding of higher levels breaks nothing. A closer look mends what the answer before broke.
                rooms.push(if is_closer { room } else { room.max(0.0) } / size);
            }
        };
        for j in (0..problem.unknowns()).filter(|&j| !fixed[j]) {
            let row = |i: usize| basis[(j, i)];
            push(Bounded::Unknown(j), Side::Lower, x[j] - problem.lower[j], unit, &row);
            push(Bounded::Unknown(j), Side::Upper, problem.upper[j] - x[j], unit, &row);
        }
        for (level, rows) in problem.levels[..k].iter().enumerate() {
            for row in (0..rows.rows.nrows()).filter(|&row| !rows.is_equation(row) && !kept[level][row]) {
                let norm = rows.rows.row(row).norm();
                let length = if norm.is_normal() { norm } else { 1.0 };
                let along = rows.rows.row(row) * basis / length;
                let (value, bounded) = (rows.value(row, x), Bounded::Higher { level, row });
                let entry = |i: usize| along[i];
                push(bounded, Side::Lower, (value - rows.lower[row]) / length, unit / length, &entry);
                push(bounded, Side::Upper, (rows.upper[row] - value) / length, unit / length, &entry);
            }
        }
        self.G = Matrix::from_row_slice(rooms.len(), basis.ncols(), &rows);
        self.rooms = Vector::from_vec(rooms);
    }

    /// Adds the inequality rows of the level itself.
    fn push_own(&mut self, rows: &LevelRows) {
        let LevelRows { level, scale, .. } = *rows;
        for row in rows.of_kind(false) {
            let value = level.value(row, rows.x);
            for (side, room) in [(Side::Lower, value - level.lower[row]), (Side::Upper, level.upper[row] - value)] {
                if room.is_finite() {
                    self.constraints.push(Constraint { bounded: Bounded::Own(row), side, unit: self.size / scale });
                    let count = self.constraints.len();
                    self.G.resize_vertically_mut(count, 0.0);
                    self.G.row_mut(count - 1).copy_from(&(rows.moved.row(row) * side.sign()));
                    self.rooms.resize_vertically_mut(count, room * scale / self.size);
                }
            }
        }
    }

    /// Returns the program for Clarabel: v = (z, one excess for each constrained row of the level, and with `Effort::Careful`
    /// the residuals ρ = C z − d). With the residuals C is not squared, so that weak directions are seen. `posed`: the constraints
    /// that Clarabel gets.
    pub fn quadratic_program(&self, effort: Effort, posed: &[usize]) -> QuadraticProgram {
        let open = self.C.ncols();
        let equations = if effort == Effort::Careful { self.C.nrows() } else { 0 };
        let mut excess = Vec::with_capacity(self.constraints.len());
        let mut own: Vec<usize> = Vec::new();
        for constraint in &self.constraints {
            excess.push(match constraint.bounded {
                Bounded::Own(row) => {
                    if own.last() != Some(&row) {
                        own.push(row);
                    }
                    Some(own.len() - 1)
                }
                _ => None,
            });
        }
        let first_residual = open + own.len();
        let unknowns = first_residual + equations;
        let is_squared = equations == 0;
        let hessian = if is_squared { self.C.tr_mul(&self.C) } else { Matrix::zeros(open, open) };
        let gradient = if is_squared { -self.C.tr_mul(&self.d) } else { Vector::zeros(open) };
        let one_if = |is_one: bool| f64::from(u8::from(is_one));
        let P = |i: usize, j: usize| if i < open && j < open { hessian[(i, j)] } else { one_if(i == j) };
        let A = |i: usize, j: usize| match i.checked_sub(equations) {
            None if j < open => self.C[(i, j)],
            None => -one_if(j == first_residual + i),
            Some(i) if j < open => self.G[(posed[i], j)],
            Some(i) => -one_if(excess[posed[i]] == Some(j - open)),
        };
        let constraints = equations + posed.len();
        QuadraticProgram {
            unknowns,
            equations,
            P: (0..unknowns).flat_map(|j| (0..=j).map(move |i| (i, j))).map(|(i, j)| P(i, j)).collect(),
            q: (0..unknowns).map(|j| if j < open { gradient[j] } else { 0.0 }).collect(),
            A: (0..unknowns).flat_map(|j| (0..constraints).map(move |i| (i, j))).map(|(i, j)| A(i, j)).collect(),
            b: self.d.iter().take(equations).copied().chain(posed.iter().map(|&i| self.rooms[i])).collect(),
        }
    }

    /// Returns the constraints that Clarabel gets: those near enough to matter, and those that an answer without them breaks.
    pub fn posed(&self, effort: Effort, before: Option<&QpAnswer>) -> Vec<usize> {
        let far = if effort == Effort::Careful { FAR_CAREFUL } else { FAR };
        let is_broken = |i: usize| before.is_some_and(|before| before.slacks[i] < 0.0);
        (0..self.constraints.len()).filter(|&i| self.rooms[i] <= far || is_broken(i)).collect()
    }

    /// Returns Clarabel's answer with the constraints that were left out: no multiplier, and the slack that is left.
    pub fn complete(&self, answer: QpAnswer, posed: &[usize]) -> QpAnswer {
        let z = Vector::from_row_slice(&answer.v[..self.C.ncols()]);
        let mut slacks = (&self.rooms - &self.G * z).as_slice().to_vec();
        let mut multipliers = vec![0.0; slacks.len()];
        for (place, &i) in posed.iter().enumerate() {
            (multipliers[i], slacks[i]) = (answer.multipliers[place], answer.slacks[place]);
        }
        QpAnswer { multipliers, slacks, ..answer }
    }

    /// Returns whether a constraint is a row of the level itself.
    pub fn is_own(&self, constraint: usize) -> bool {
        matches!(self.constraints[constraint].bounded, Bounded::Own(_))
    }

    /// Returns the largest relative residual of the optimality conditions at z with these multipliers of the constraints.
    /// A row of the level itself has its excess as its multiplier.
    pub fn residual(&self, z: &Vector, multipliers: &[f64]) -> f64 {
        let slack = &self.rooms - &self.G * z;
        let mut gradient = self.C.tr_mul(&(&self.d - &self.C * z));
        let velocity = self.speed.max(z.norm());
        let mut largest = 0.0_f64;
        let mut note = |size: f64, scale: f64| {
            let relative = size / scale;
            largest = if relative.is_nan() { f64::INFINITY } else { largest.max(relative) };
        };
        for (i, &multiplier) in multipliers.iter().enumerate() {
            gradient.axpy(-multiplier, &self.G.row(i).transpose(), 1.0);
            if self.is_own(i) {
                note((multiplier - (-slack[i]).max(0.0)).abs(), self.scale);
                continue;
            }
            note(-slack[i], velocity);
            note(-multiplier, self.scale);
            // Either the multiplier or the slack is zero.
            note((multiplier.abs() / self.scale).min(slack[i].abs() / velocity), 1.0);
        }
        note(gradient.amax(), self.scale);
        largest
    }
}

fn last_objective(problem: &Hierarchy) -> Level {
    let n = problem.unknowns();
    let mut level = Level::new(n);
    let reference = problem.reference.as_slice();
    level.push(&Matrix::identity(n, n), reference, reference, |_| None);
    level
}
