//! A direct implementation as a peer: homogeneous matrices, and pseudo-inverses from a library.

#![allow(non_snake_case)]

use nalgebra::{DMatrix, DVector, Matrix4};
use revprio_robot::RobotModel;
use revprio_robot::kinematics::AxisSelection;

/// Singular values below this count as zero.
const CUT: f64 = 1e-10;

/// The chain of an arm of revolute joints as 4 × 4 matrices.
pub struct Chain {
    placements: Vec<Matrix4<f64>>,
    tool: Matrix4<f64>,
}

impl Chain {
    pub fn of(robot: &RobotModel) -> Self {
        let placements = robot.joints().iter().map(|joint| joint.placement.to_homogeneous()).collect();
        Self { placements, tool: robot.tool().to_homogeneous() }
    }

    /// Returns the tool Jacobian, 6 × n.
    pub fn jacobian(&self, q: &[f64]) -> DMatrix<f64> {
        let mut frame = Matrix4::identity();
        let mut frames = Vec::new();
        for (placement, q) in self.placements.iter().zip(q) {
            frame *= placement;
            frames.push(frame);
            frame *= Matrix4::from_axis_angle(&nalgebra::Vector3::z_axis(), *q);
        }
        let end = (frame * self.tool).fixed_view::<3, 1>(0, 3).into_owned();
        let mut J = DMatrix::zeros(6, frames.len());
        for (i, frame) in frames.iter().enumerate() {
            let (axis, origin) = (frame.fixed_view::<3, 1>(0, 2), frame.fixed_view::<3, 1>(0, 3));
            J.fixed_view_mut::<3, 1>(0, i).copy_from(&axis.cross(&(end - origin)));
            J.fixed_view_mut::<3, 1>(3, i).copy_from(&axis);
        }
        J
    }
}

/// Returns A⁺ by the singular value decomposition of faer.
pub fn pseudo_inverse(A: &DMatrix<f64>) -> DMatrix<f64> {
    let (m, n) = A.shape();
    let inverse = faer::MatRef::from_column_major_slice(A.as_slice(), m, n).svd().map(|svd| svd.pseudoinverse());
    inverse.map_or_else(|_| DMatrix::zeros(n, m), |inverse| DMatrix::from_fn(n, m, |i, j| inverse[(i, j)]))
}

/// Returns A⁺ by the singular value decomposition of nalgebra.
pub fn nalgebra_pseudo_inverse(A: &DMatrix<f64>) -> DMatrix<f64> {
    A.clone().pseudo_inverse(CUT).unwrap_or_else(|_| DMatrix::zeros(A.ncols(), A.nrows()))
}

/// Two tasks by reverse priority as printed: q̇_2 = J_2⁺ẋ_2, q̇_1 = q̇_2 + T_1 (J_1 T_1)⁺ (ẋ_1 − J_1 q̇_2).
///
/// Paper: Eqs. (25), (29).
pub fn reverse_priority(J: &DMatrix<f64>, axes: &[AxisSelection; 2], xdot: &[DVector<f64>; 2]) -> DVector<f64> {
    let rows = |k: usize| J.select_rows(axes[k].axes().iter().map(|axis| axis.index()).collect::<Vec<_>>().iter());
    let (J_1, J_2) = (rows(0), rows(1));
    let mut J_rp = DMatrix::zeros(J_1.nrows() + J_2.nrows(), J.ncols());
    J_rp.rows_mut(0, J_1.nrows()).copy_from(&J_1);
    J_rp.rows_mut(J_1.nrows(), J_2.nrows()).copy_from(&J_2);
    let q_2 = pseudo_inverse(&J_2) * &xdot[1];
    let T_1 = pseudo_inverse(&J_rp).columns(0, J_1.nrows()).into_owned();
    &q_2 + &T_1 * pseudo_inverse(&(&J_1 * &T_1)) * (&xdot[0] - &J_1 * &q_2)
}
