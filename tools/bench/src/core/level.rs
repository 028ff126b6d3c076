//! The QP solver Clarabel alone: one level, min ‖J q̇ − ẋ‖² inside the joint limits, 7 unknowns and 14 bounds.

#![allow(non_snake_case)]

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT};
use nalgebra::{DMatrix, DVector};
use revprio_robot::built_in;
use revprio_robot::kinematics::Configuration;

use super::postures::postures;
use crate::error::BenchError;
use crate::row::Row;
use crate::timing::{Budget, Subject, side_by_side};

/// Limit of every joint, rad/s.
const LIMIT: f64 = 0.3;

/// Tolerance of the solver.
const TOLERANCE: f64 = 1e-8;

pub fn rows(budget: Budget) -> Result<Vec<Row>, BenchError> {
    let levels: Vec<Level> = postures(64).iter().map(Level::at).collect::<Result<_, _>>()?;
    let mut persistent = levels[0].solver(settings(false))?;
    let [mut by_default, mut fresh, mut updated] = [(); 3].map(|()| levels.iter().cycle());
    let times = side_by_side(
        budget,
        vec![
            Subject::new("Clarabel alone, one level, fresh", || {
                by_default.next().map(|level| level.solver(settings(true)).map(|mut solver| solver.solve()))
            }),
            Subject::new("fresh, without equilibration and refinement", || {
                fresh.next().map(|level| level.solver(settings(false)).map(|mut solver| solver.solve()))
            }),
            Subject::new("persistent, updated in place, without both", || {
                updated.next().map(|level| {
                    let updated = persistent.update_P(&level.P.nzval).and(persistent.update_q(&level.q));
                    updated.map(|()| persistent.solve())
                })
            }),
        ],
    )?;
    Ok(Row::against_each(&times))
}

/// ½ q̇ᵀP q̇ + qᵀq̇.
struct Level {
    P: CscMatrix<f64>,
    q: Vec<f64>,
}

impl Level {
    /// Returns a level with active limits at a posture of Sawyer.
    fn at(posture: &[f64; 7]) -> Result<Self, BenchError> {
        let configuration = Configuration::new(&built_in()[0], posture).map_err(BenchError::defect)?;
        let J = DMatrix::from_column_slice(6, 7, configuration.jacobian().as_slice());
        let xdot = DVector::from_row_slice(&[0.2, -0.1, 0.3, 0.5, -0.4, 0.2]);
        let P = J.tr_mul(&J);
        let q = (J.tr_mul(&xdot) * -1.0).as_slice().to_vec();
        let n = P.ncols();
        let upper = (0..n).flat_map(|j| (0..=j).map(move |i| (i, j)));
        Ok(Self {
            P: CscMatrix::new(
                n,
                n,
                (0..=n).map(|j| j * (j + 1) / 2).collect(),
                (0..n).flat_map(|j| 0..=j).collect(),
                upper.map(|(i, j)| P[(i, j)]).collect(),
            ),
            q,
        })
    }

    fn solver(&self, settings: DefaultSettings<f64>) -> Result<DefaultSolver<f64>, BenchError> {
        let n = self.q.len();
        // Two rows per joint: q̇ ≤ LIMIT and −q̇ ≤ LIMIT.
        let A = CscMatrix::new(
            2 * n,
            n,
            (0..=n).map(|j| 2 * j).collect(),
            (0..n).flat_map(|j| [j, n + j]).collect(),
            [1.0, -1.0].repeat(n),
        );
        let cones = [NonnegativeConeT(2 * n)];
        DefaultSolver::new(&self.P, &self.q, &A, &vec![LIMIT; 2 * n], &cones, settings).map_err(BenchError::defect)
    }
}

fn settings(careful: bool) -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        presolve_enable: false,
        equilibrate_enable: careful,
        iterative_refinement_enable: careful,
        tol_gap_abs: TOLERANCE,
        tol_gap_rel: TOLERANCE,
        tol_feas: TOLERANCE,
        ..DefaultSettings::default()
    }
}
