//! Compares settings of Clarabel for one level: min ‖J q̇ − ẋ‖² inside joint limits, 7 unknowns and 14 bounds, at 200 postures
//! of Sawyer. `cargo bench --bench clarabel` prints time per solve (relative to a new solver with default
//! settings), iterations, and the share of levels whose multipliers show the right active limits.
#![allow(non_snake_case)]

use std::hint::black_box;
use std::time::Instant;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};
use nalgebra::{DMatrix, DVector};
use revprio_robot::built_in;
use revprio_robot::kinematics::Configuration;

/// Joints of Sawyer.
const N: usize = 7;

/// Limit of every joint, rad/s.
const LIMIT: f64 = 0.3;

/// Number of rounds per setting; the fastest counts.
const ROUNDS: usize = 15;

/// ½ q̇ᵀP q̇ + qᵀq̇, P as its upper triangle by columns.
struct Level {
    P: Vec<f64>,
    q: Vec<f64>,
}

/// One line of the table.
#[derive(Clone, Copy)]
#[expect(clippy::struct_excessive_bools, reason = "each is a switch of the solver")]
struct Setting {
    name: &'static str,
    persistent: bool,
    equilibrate: bool,
    refine: bool,
    presolve: bool,
    tolerance: f64,
    max_iter: u32,
}

const DEFAULT: Setting = Setting {
    name: "fresh, the solver's defaults",
    persistent: false,
    equilibrate: true,
    refine: true,
    presolve: true,
    tolerance: 1e-8,
    max_iter: 200,
};

/// The settings of the resolution.
const CHOSEN: Setting = Setting {
    name: "persistent, none of them, 1e-10, at most 40: chosen",
    persistent: true,
    equilibrate: false,
    refine: false,
    presolve: false,
    tolerance: 1e-10,
    max_iter: 40,
};

const SETTINGS: [Setting; 11] = [
    DEFAULT,
    Setting { name: "fresh, no presolve", presolve: false, ..DEFAULT },
    Setting { name: "fresh, no equilibration", equilibrate: false, ..DEFAULT },
    Setting { name: "fresh, no refinement", refine: false, ..DEFAULT },
    Setting { name: "fresh, as chosen", persistent: false, ..CHOSEN },
    Setting { name: "persistent, equilibration and refinement", equilibrate: true, refine: true, ..CHOSEN },
    Setting { name: "persistent, refinement alone", refine: true, ..CHOSEN },
    Setting { name: "persistent, 1e-6", tolerance: 1e-6, ..CHOSEN },
    Setting { name: "persistent, 1e-8", tolerance: 1e-8, ..CHOSEN },
    CHOSEN,
    Setting { name: "persistent, 1e-12", tolerance: 1e-12, ..CHOSEN },
];

fn main() {
    let levels: Vec<Level> = (1..=200).map(level).collect();
    let exact: Vec<_> = levels.iter().map(|level| active_bounds(&mut CHOSEN.with(1e-12).solver(level))).collect();
    let mut of_default = None;
    println!("{:<54} {:>8} {:>6} {:>10} {:>6}", "settings", "µs", "ratio", "iterations", "right");
    for setting in SETTINGS {
        let time = setting.time(&levels);
        let ratio = time / *of_default.get_or_insert(time);
        let mut solvers = levels.iter().map(|level| setting.solver(level));
        let (mut iterations, mut right) = (0, 0);
        for (expected, solver) in exact.iter().zip(&mut solvers) {
            let mut solver = solver;
            right +=
                u32::from(active_bounds(&mut solver) == *expected && solver.solution.status == SolverStatus::Solved);
            iterations += solver.solution.iterations;
        }
        let mean = f64::from(iterations) / 200.0;
        println!("{:<54} {:>8.1} {ratio:>6.2} {mean:>10.1} {:>5.1}%", setting.name, time * 1e6, f64::from(right) / 2.0);
    }
}

/// Returns a level with active limits at a posture of Sawyer.
fn level(i: usize) -> Level {
    const STRIDES: [f64; N] = [0.754_878, 0.569_840, 0.430_160, 0.324_718, 0.245_122, 0.185_037, 0.139_681];
    let posture = STRIDES.map(|stride| 4.0 * ((i as f64 * stride).fract() - 0.5));
    let configuration = Configuration::new(&built_in()[0], &posture).unwrap();
    let J = DMatrix::from_column_slice(6, N, configuration.jacobian().as_slice());
    let xdot = DVector::from_row_slice(&[0.2, -0.1, 0.3, 0.5, -0.4, 0.2]);
    let gram = J.tr_mul(&J);
    let P = (0..N).flat_map(|j| (0..=j).map(move |i| (i, j))).map(|place| gram[place]).collect();
    Level { P, q: (J.tr_mul(&xdot) * -1.0).as_slice().to_vec() }
}

/// Returns the bounds whose multiplier exceeds their slack.
fn active_bounds(solver: &mut DefaultSolver<f64>) -> Vec<usize> {
    solver.solve();
    let pairs = solver.solution.z.iter().zip(&solver.solution.s).enumerate();
    pairs.filter(|(_, (multiplier, slack))| multiplier > slack).map(|(row, _)| row).collect()
}

impl Setting {
    fn with(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    fn solver(self, level: &Level) -> DefaultSolver<f64> {
        let P = CscMatrix::new(
            N,
            N,
            (0..=N).map(|j| j * (j + 1) / 2).collect(),
            (0..N).flat_map(|j| 0..=j).collect(),
            level.P.clone(),
        );
        let A = CscMatrix::new(
            2 * N,
            N,
            (0..=N).map(|j| 2 * j).collect(),
            (0..N).flat_map(|j| [j, N + j]).collect(),
            [1.0, -1.0].repeat(N),
        );
        let settings = DefaultSettings {
            verbose: false,
            presolve_enable: self.presolve,
            equilibrate_enable: self.equilibrate,
            iterative_refinement_enable: self.refine,
            max_iter: self.max_iter,
            tol_gap_abs: self.tolerance,
            tol_gap_rel: self.tolerance,
            tol_feas: self.tolerance,
            ..DefaultSettings::default()
        };
        DefaultSolver::new(&P, &level.q, &A, &[LIMIT; 2 * N], &[NonnegativeConeT(2 * N)], settings).unwrap()
    }

    /// Returns the time per level, s.
    fn time(self, levels: &[Level]) -> f64 {
        let mut kept = self.solver(&levels[0]);
        let mut fastest = f64::INFINITY;
        for _ in 0..ROUNDS {
            let start = Instant::now();
            for level in levels {
                if self.persistent {
                    kept.update_P(&level.P).and(kept.update_q(&level.q)).unwrap();
                    kept.solve();
                } else {
                    black_box(self.solver(level)).solve();
                }
            }
            fastest = fastest.min(start.elapsed().as_secs_f64());
        }
        fastest / levels.len() as f64
    }
}
