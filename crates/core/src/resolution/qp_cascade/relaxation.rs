//! A point inside all constraints, or, where they contradict each other, the one that breaks the inequalities least.
#![allow(non_snake_case)]

use super::active_set;
use super::constraints::Constraints;
use super::level::Level;
use super::minimiser::Minimiser;
use crate::linalg::{TaskMatrix, TaskVector};

/// A velocity inside the box that exceeds the inequalities as little as possible (sum of squares), near the slowest one.
///
/// min ‖t‖² over (q̇, t) s.t. lo ≤ q̇ ≤ hi, planes · q̇ − t ≤ bounds, as a level that starts at `slowest` and the t that it
/// needs. The box always wins: joint limits protect the arm.
///
/// `slowest`: the slowest q̇ of the box, n; `Z`: n × p, the directions in which joints can move.
pub fn least_excess(constraints: &Constraints, slowest: TaskVector, Z: &TaskMatrix) -> TaskVector {
    let excess = constraints.excess(&slowest);
    if excess.iter().all(|&excess| excess == 0.0) {
        return slowest;
    }
    let (n, p, planes) = (constraints.joints(), Z.ncols(), excess.len());
    let mut moved = TaskMatrix::default();
    constraints.write_rows_of(Z, &mut moved);
    let given = |i: usize, j: usize| if i >= n && i - n == j { -1.0 } else { 0.0 };
    let values = constraints.values(&slowest);
    let allowance = |i: usize| if i < n { 0.0 } else { excess[i - n] };
    let C = TaskMatrix::from_fn(planes, p + planes, |i, j| f64::from(u8::from(j == p + i)));
    let level = Level {
        d: -&excess,
        G: TaskMatrix::from_fn(n + planes, p + planes, |i, j| if j < p { moved[i][j] } else { given(i, j - p) }),
        lower: constraints.lower() - &values,
        upper: TaskVector::from_fn(n + planes, |i| (constraints.upper()[i] - values[i] + allowance(i)).max(0.0)),
        bounded: (0..n + planes).map(|row| row >= n || Z.row_norm(row) > 0.0).collect(),
        speed: slowest.norm() + excess.norm(),
        scale: C.norm(),
        base_size: excess.norm(),
        C,
    };
    let z = active_set::iterate(&level, &mut Minimiser::default()).z;
    constraints.clamp_joints(&slowest + &(Z * &TaskVector::from_slice(&z[..p])))
}
