//! Lexicographic least squares on one working set, by reflections.
//!
//! The rows of all levels are turned into a lower triangle by Householder reflections from the right, level by level, the
//! longest remaining row of a level first: A = L Qᵀ. A coordinate is an entry of y = Qᵀ (x − base). Section numbers refer to
//! `docs/solver.md`.

use super::problem_rows::ProblemRows;
use crate::linalg::{Row, write_singular_values};
use crate::resolution::level::{Side, WorkingSet, refill};

/// Relative size below which a number is rounding.
pub const ROUNDING: f64 = 1e-13;

/// A level whose rows depend on each other up to this fraction has an uncertain rank.
const CERTAIN_RANK: f64 = 1e-6;

/// A pivot below this fraction of ‖A_k‖ makes the singular values decide the rank: pivots are larger than the smallest
/// singular value, but seldom a hundred times.
const SUSPICIOUS_PIVOT: f64 = 1e-4;

/// Error of a row of length one after reflections.
const REFLECTION_ERROR: f64 = 4e-15;

/// A squared length that was kept up to date by subtraction is summed again below this fraction of the last sum.
const TRUSTED_SQUARE: f64 = 0.1;

/// The part of `order` that belongs to one level: first its pivots, then the rows that depend on them.
#[derive(Debug, Clone, Copy, Default)]
pub struct Span {
    pub start: usize,
    pub pivots_end: usize,
    pub end: usize,
    /// First coordinate of the level.
    pub first: usize,
    /// One after its last coordinate.
    pub rank_end: usize,
    /// Whether the level leaves a residual.
    pub has_residual: bool,
    /// ‖b_k‖ of the active rows.
    pub target: f64,
}

/// I − gain v vᵀ.
#[derive(Debug, Clone, Copy)]
struct Reflection<const N: usize> {
    v: Row<N>,
    gain: f64,
}

/// The factorisation on a working set and its least-squares solution.
#[derive(Debug, Default)]
pub struct Factorization<const N: usize> {
    /// Unknowns that no bound holds, ascending. Coordinate c occupies the place `free[c]`.
    pub free: Vec<usize>,
    /// Unknowns at a bound, ascending.
    pub held: Vec<usize>,
    /// Bounds on held unknowns, zero on free ones.
    pub base: Row<N>,
    /// Coordinates of the reference, Qᵀ ζ over the free unknowns.
    pub reference: Row<N>,
    /// The active rows, level by level, pivots first.
    pub order: Vec<usize>,
    pub spans: Vec<Span>,
    /// Residual b − a·x of each active row; 0 for inactive rows.
    pub residual: Vec<f64>,
    /// Row i of L: a_i over the coordinates.
    pub coordinates: Vec<Row<N>>,
    /// The row that each coordinate was taken from.
    pub pivots: Vec<usize>,
    /// 1 / pivot, per coordinate.
    pub inverse: Vec<f64>,
    /// Coordinates of x − base.
    pub y: Row<N>,
    /// The solution.
    pub x: Row<N>,
    /// Singular values of a level below this fraction of ‖A_k‖ count as zero.
    pub rank_tolerance: f64,
    /// Whether rounding may have decided a rank.
    pub rank_uncertain: bool,
    /// ‖base‖.
    pub base_norm: f64,
    /// The largest speed on the way to the solution, ‖base‖ + ‖y‖: the size of the terms whose difference x is.
    pub peak_speed: f64,
    /// What reflections have left of each row, over the unknowns.
    rest: Vec<Row<N>>,
    rest_square: Vec<f64>,
    /// `rest_square` when it was summed last.
    summed_square: Vec<f64>,
    reflections: Vec<Reflection<N>>,
    /// The largest rank that singular values allow each level.
    max_rank: Vec<usize>,
    /// F with F T = E, see [`Self::write_combinations`].
    combinations: Vec<Row<N>>,
    /// Cholesky factor of I + F Fᵀ.
    gram: Vec<f64>,
    /// Right-hand side of a level's dependent rows.
    dependent: Vec<f64>,
    /// A level's rows over its own coordinates, and their singular values.
    block: Vec<f64>,
    sigma: Vec<f64>,
}

impl<const N: usize> Factorization<N> {
    /// Returns the number of coordinates.
    #[inline]
    pub fn rank(&self) -> usize {
        self.pivots.len()
    }

    /// Factorises the active rows of the first `levels` levels over the free unknowns and solves (section 4).
    pub fn solve(&mut self, problem: &ProblemRows<N>, set: &WorkingSet, levels: usize) {
        self.rank_uncertain = false;
        refill(&mut self.max_rank, std::iter::repeat_n(usize::MAX, levels));
        loop {
            self.start(problem, set, levels);
            if self.factorize(problem) {
                break;
            }
        }
        self.place_reference(problem);
        self.peak_speed = self.peak_speed.max(self.base_norm + self.y.norm());
        self.x = self.base.plus(&self.apply_q(&self.y));
    }

    /// Sets the coordinates that no row sees to those of the reference. The rows do not see the reference at all, so that a
    /// large one costs them no digits.
    fn place_reference(&mut self, problem: &ProblemRows<N>) {
        self.reference = Row::ZERO;
        if problem.reference == Row::ZERO {
            return;
        }
        let mut zeta = Row::ZERO;
        self.free.iter().for_each(|&j| zeta.0[j] = problem.reference.0[j]);
        for Reflection { v, gain } in &self.reflections {
            zeta.add_scaled(-gain * v.dot(&zeta), v);
        }
        let rank = self.rank();
        for (c, &place) in self.free.iter().enumerate() {
            self.reference.0[c] = zeta.0[place];
            if c >= rank {
                self.y.0[c] = zeta.0[place];
            }
        }
    }

    /// Writes the active rows over the free unknowns, and what held unknowns leave of their targets.
    fn start(&mut self, problem: &ProblemRows<N>, set: &WorkingSet, levels: usize) {
        let n = problem.unknowns;
        self.free.clear();
        self.held.clear();
        self.base = Row::ZERO;
        let mut mask = Row([1.0; N]);
        for j in 0..n {
            let bound = match set.unknowns[j] {
                _ if problem.is_pinned(j) => problem.lower.0[j],
                None => {
                    self.free.push(j);
                    continue;
                }
                Some(Side::Lower) => problem.lower.0[j],
                Some(Side::Upper) => problem.upper.0[j],
            };
            self.held.push(j);
            self.base.0[j] = bound;
            mask.0[j] = 0.0;
        }
        self.base_norm = self.base.norm();
        self.peak_speed = self.base_norm;
        let m = problem.rows.len();
        self.rest.resize(m, Row::ZERO);
        self.coordinates.resize(m, Row::ZERO);
        self.rest_square.resize(m, 0.0);
        self.residual.resize(m, 0.0);
        self.order.clear();
        self.spans.clear();
        for level in &problem.levels[..levels] {
            let start = self.order.len();
            let mut target_square = 0.0;
            for row in level.start..level.end {
                self.coordinates[row] = Row::ZERO;
                self.residual[row] = 0.0;
                if problem.is_active(set, row) {
                    self.order.push(row);
                    let coefficients = &problem.rows[row];
                    let target = problem.target(set, row);
                    target_square += target * target;
                    if self.held.is_empty() {
                        self.rest[row] = *coefficients;
                        self.rest_square[row] = problem.squares[row];
                        self.residual[row] = target;
                    } else {
                        let rest = Row(std::array::from_fn(|j| coefficients.0[j] * mask.0[j]));
                        self.rest[row] = rest;
                        self.rest_square[row] = rest.dot(&rest);
                        self.residual[row] = target - coefficients.dot(&self.base);
                    }
                }
            }
            let target = target_square.sqrt();
            self.spans.push(Span { start, end: self.order.len(), target, ..Span::default() });
        }
        self.summed_square.clone_from(&self.rest_square);
        self.pivots.clear();
        self.inverse.clear();
        self.reflections.clear();
        self.y = Row::ZERO;
    }

    /// Factorises and solves level by level; `false` where singular values allow a level less than its pivots, so that the
    /// factorisation has to start again with that rank.
    fn factorize(&mut self, problem: &ProblemRows<N>) -> bool {
        // The smallest pivot of the levels above, relative to its level: what depends on it carries that much more error.
        let mut weakest = 1.0_f64;
        for k in 0..self.spans.len() {
            let Span { start, end, .. } = self.spans[k];
            let square = problem.levels[k].square;
            let tolerance = self.rank_tolerance.max(REFLECTION_ERROR / weakest);
            let max_rank = self.max_rank[k];
            let (first, mut place) = (self.rank(), start);
            let (mut smallest, mut refused) = (square, 0.0);
            while place < end && self.rank() < self.free.len() && place - start < max_rank {
                let length_square = self.bring_longest(place, end);
                if !(length_square > tolerance * tolerance * square) {
                    refused = length_square;
                    break;
                }
                self.reflect(place, length_square);
                smallest = smallest.min(length_square);
                place += 1;
            }
            let span = &mut self.spans[k];
            (span.first, span.rank_end, span.pivots_end) = (first, first + place - start, place);
            let suspicious = SUSPICIOUS_PIVOT * SUSPICIOUS_PIVOT * square;
            if (smallest < suspicious || refused > ROUNDING * ROUNDING * square)
                && !self.confirm_rank(k, tolerance * square.sqrt(), square.sqrt(), refused)
            {
                return false;
            }
            if smallest < suspicious {
                weakest = weakest.min((smallest / square).sqrt());
            }
            if self.spans[k].pivots_end < end {
                self.solve_dependent_rows(problem, k);
            }
        }
        true
    }

    /// Compares a level's rank with its singular values: all of its pivots, or the number that `max_rank` then holds.
    #[cold]
    fn confirm_rank(&mut self, k: usize, tolerance: f64, norm: f64, refused: f64) -> bool {
        let Span { first, rank_end, .. } = self.spans[k];
        let own = self.pivots[first..rank_end].iter().flat_map(|&row| &self.coordinates[row].0[first..rank_end]);
        refill(&mut self.block, own.copied());
        write_singular_values(&mut self.block, rank_end - first, &mut self.sigma);
        let sigma = &self.sigma;
        let is_uncertain = |sigma: f64| sigma > ROUNDING * norm && sigma < CERTAIN_RANK * norm;
        self.rank_uncertain |= sigma.iter().any(|&sigma| is_uncertain(sigma)) || is_uncertain(refused.sqrt());
        let rank = sigma.iter().filter(|&&sigma| sigma > tolerance).count();
        let is_confirmed = rank == rank_end - first;
        if !is_confirmed {
            self.max_rank[k] = rank;
        }
        is_confirmed
    }

    /// Moves the longest remaining row of a level to `place`; returns its squared length.
    #[inline]
    fn bring_longest(&mut self, place: usize, end: usize) -> f64 {
        self.swap_longest(place, end);
        let row = self.order[place];
        if self.rest_square[row] <= TRUSTED_SQUARE * self.summed_square[row] {
            for &row in &self.order[place..end] {
                self.rest_square[row] = self.rest[row].dot(&self.rest[row]);
                self.summed_square[row] = self.rest_square[row];
            }
            self.swap_longest(place, end);
        }
        self.rest_square[self.order[place]]
    }

    #[inline]
    fn swap_longest(&mut self, place: usize, end: usize) {
        let mut longest = place;
        for at in place + 1..end {
            if self.rest_square[self.order[at]] > self.rest_square[self.order[longest]] {
                longest = at;
            }
        }
        self.order.swap(place, longest);
    }

    /// Takes the row x at `place` as the next coordinate and removes that coordinate from all later rows.
    ///
    /// With α = ∓‖x‖ and v = x − α e, H = I − g v vᵀ gives H x = α e. A row r gets the coordinate x·r/α, and v·r = x·r − α r_e,
    /// so that the products x·r do not wait for the square root.
    #[inline]
    fn reflect(&mut self, place: usize, square: f64) {
        let (c, pivot) = (self.pivots.len(), self.order[place]);
        let head = self.free[c];
        let x = self.rest[pivot];
        let length = square.sqrt();
        let entry = x.0[head];
        let alpha = -length.copysign(entry);
        let inverse = 1.0 / alpha;
        let mut v = x;
        v.add_at(head, -alpha);
        let gain = 1.0 / (length * (length + entry.abs()));
        let y = self.residual[pivot] * inverse;
        for &row in &self.order[place + 1..] {
            let rest = &mut self.rest[row];
            let (product, at_head) = (x.dot(rest), rest.0[head]);
            rest.add_scaled(gain * (alpha * at_head - product), &v);
            rest.0[head] = 0.0;
            let coordinate = product * inverse;
            self.coordinates[row].0[c] = coordinate;
            self.residual[row] -= coordinate * y;
            self.rest_square[row] -= coordinate * coordinate;
        }
        self.coordinates[pivot].0[c] = alpha;
        self.residual[pivot] = 0.0;
        self.y.0[c] = y;
        self.reflections.push(Reflection { v, gain });
        self.inverse.push(inverse);
        self.pivots.push(pivot);
    }

    /// Solves least squares of a level whose last rows depend on its pivots and on higher levels (Peters and Wilkinson).
    ///
    /// With c the residuals of the dependent rows after the pivots are met: r = (I + F Fᵀ)⁻¹ c remains, the pivots give up
    /// e = Fᵀ r, and the coordinates change by δ, T δ = e.
    fn solve_dependent_rows(&mut self, problem: &ProblemRows<N>, k: usize) {
        let Span { start, pivots_end, end, first, rank_end, target, .. } = self.spans[k];
        let rounding = ROUNDING * (target + problem.levels[k].norm * (self.base_norm + self.y.norm()));
        if self.order[pivots_end..end].iter().all(|&row| self.residual[row].abs() <= rounding) {
            self.order[pivots_end..end].iter().for_each(|&row| self.residual[row] = 0.0);
            return;
        }
        self.spans[k].has_residual = true;
        if pivots_end == start {
            return;
        }
        self.write_combinations(k);
        refill(&mut self.dependent, self.order[pivots_end..end].iter().map(|&row| self.residual[row]));
        let given_up = self.share_dependent();
        let mut change = Row::ZERO;
        for c in first..rank_end {
            let row = self.pivots[c];
            change.0[c] = (given_up.0[c] - self.coordinates[row].dot(&change)) * self.inverse[c];
            self.residual[row] = -given_up.0[c];
        }
        self.peak_speed = self.peak_speed.max(self.base_norm + self.y.norm() + change.norm());
        self.y = self.y.plus(&change);
        for &row in &self.order[end..] {
            self.residual[row] -= self.coordinates[row].dot(&change);
        }
        for (&row, residual) in self.order[pivots_end..end].iter().zip(&self.dependent) {
            self.residual[row] = *residual;
        }
    }

    /// Writes each dependent row of a level as a combination of its pivots, F T = E. F is bounded, since pivots are longest.
    fn write_combinations(&mut self, k: usize) {
        let Span { pivots_end, end, first, rank_end, .. } = self.spans[k];
        self.combinations.clear();
        for &row in &self.order[pivots_end..end] {
            let (mut rest, mut combination) = (self.coordinates[row], Row::ZERO);
            for c in (first..rank_end).rev() {
                combination.0[c] = rest.0[c] * self.inverse[c];
                rest.add_scaled(-combination.0[c], &self.coordinates[self.pivots[c]]);
            }
            self.combinations.push(combination);
        }
    }

    /// Writes w of level k with Aᵀw = 0 over the level's coordinates: 1 at one dependent row, −F at the pivots.
    pub fn write_left_null_vector(&mut self, k: usize, dependent: usize, w: &mut [f64]) {
        let Span { pivots_end, end, first, rank_end, .. } = self.spans[k];
        self.write_combinations(k);
        self.order[pivots_end..end].iter().for_each(|&row| w[row] = 0.0);
        (first..rank_end).for_each(|c| w[self.pivots[c]] = -self.combinations[dependent].0[c]);
        w[self.order[pivots_end + dependent]] = 1.0;
    }

    /// Replaces c in `dependent` by r = (I + F Fᵀ)⁻¹ c; returns Fᵀ r.
    fn share_dependent(&mut self) -> Row<N> {
        let (f, r, count) = (&self.combinations, &mut self.dependent, self.combinations.len());
        if let [single] = f.as_slice() {
            r[0] /= 1.0 + single.dot(single);
        } else {
            let g = &mut self.gram;
            g.resize(count * count, 0.0);
            for i in 0..count {
                for j in 0..=i {
                    let sum = f[i].dot(&f[j]) - (0..j).map(|l| g[i * count + l] * g[j * count + l]).sum::<f64>();
                    g[i * count + j] = if i == j { (1.0 + sum).sqrt() } else { sum / g[j * count + j] };
                }
            }
            for i in 0..count {
                let sum: f64 = (0..i).map(|j| g[i * count + j] * r[j]).sum();
                r[i] = (r[i] - sum) / g[i * count + i];
            }
            for i in (0..count).rev() {
                let sum: f64 = (i + 1..count).map(|j| g[j * count + i] * r[j]).sum();
                r[i] = (r[i] - sum) / g[i * count + i];
            }
        }
        let mut given_up = Row::ZERO;
        f.iter().zip(r).for_each(|(f, r)| given_up.add_scaled(*r, f));
        given_up
    }

    /// Makes the multipliers w of a level with dependent rows the shortest ones with the same Aᵀw, and updates their sum
    /// g = Σ w_i coordinates[i] (section 5).
    pub fn shorten_multipliers(&mut self, k: usize, w: &mut [f64], g: &mut Row<N>) {
        let Span { pivots_end, end, first, rank_end, .. } = self.spans[k];
        self.order[pivots_end..end].iter().for_each(|&row| w[row] = 0.0);
        if first == rank_end {
            return;
        }
        self.write_combinations(k);
        let mut basic = Row::ZERO;
        (first..rank_end).for_each(|c| basic.0[c] = w[self.pivots[c]]);
        refill(&mut self.dependent, self.combinations.iter().map(|f| f.dot(&basic)));
        let shared = self.share_dependent();
        for c in first..rank_end {
            let row = self.pivots[c];
            w[row] -= shared.0[c];
            g.add_scaled(-shared.0[c], &self.coordinates[row]);
        }
        for (&row, &share) in self.order[pivots_end..end].iter().zip(&self.dependent) {
            w[row] = share;
            g.add_scaled(share, &self.coordinates[row]);
        }
    }

    /// Returns Q u for coordinates u; coordinates beyond the rank stand for directions that no row sees.
    #[inline]
    pub fn apply_q(&self, coordinates: &Row<N>) -> Row<N> {
        let mut u = Row::ZERO;
        for (c, &place) in self.free.iter().enumerate() {
            u.0[place] = coordinates.0[c];
        }
        for Reflection { v, gain } in self.reflections.iter().rev() {
            u.add_scaled(-gain * v.dot(&u), v);
        }
        u
    }
}
