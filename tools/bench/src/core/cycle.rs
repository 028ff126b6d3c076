//! Whole control periods along a trajectory.

use std::f64::consts::TAU;

use nalgebra::DVector;
use revprio::service::{Robots, controller as controller_of, stepper};
use revprio_api::wire;
use revprio_core::controller::{Command, Measurement, Memory, Stepper};
use revprio_core::resolution::Path;
use revprio_robot::kinematics::{Axis, AxisSelection};
use serde_json::json;

use super::plain::{self, Chain};
use crate::error::BenchError;
use crate::row::Row;
use crate::timing::{Budget, Subject, side_by_side};

/// Periods of a trajectory: four oscillations of 1 s at 1 kHz.
const PERIODS: usize = 4000;

/// The nominal posture of the paper's experiments.
pub const NOMINAL: [f64; 7] = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];

/// A controller with the states of a trajectory.
pub struct Cycle {
    stepper: Stepper,
    states: Vec<Measurement>,
    next: usize,
    memory: Option<Memory>,
    /// Share of the periods with an active limit.
    pub limited: f64,
    /// Largest joint speed, rad/s.
    pub fastest: f64,
    /// Share of the periods solved by a known active set.
    pub guessed: f64,
}

impl Cycle {
    /// Simulates an ideal arm from a posture and stores the states.
    pub fn along(
        controller: &wire::Controller,
        robots: &Robots,
        start: &[f64],
        periods: usize,
    ) -> Result<Self, BenchError> {
        let controller =
            controller_of(controller, robots).map_err(|problem| BenchError::defect(problem.into_wire()))?;
        let mut cycle = Self {
            stepper: stepper(controller).map_err(BenchError::defect)?,
            states: Vec::new(),
            next: 0,
            memory: None,
            limited: 0.0,
            fastest: 0.0,
            guessed: 0.0,
        };
        let period = cycle.stepper.controller().config().period_s;
        let mut q = start.to_vec();
        for i in 0..periods {
            let wrench = [0.0; 6];
            cycle.states.push(Measurement {
                channels: Vec::new(),
                chunks: Vec::new(),
                wrenches: Vec::new(),
                obstacles: Vec::new(),
                time_s: i as f64 * period,
                joint_position: q.clone(),
                joint_velocity: None,
                wrench,
                targets: Vec::new(),
            });
            let resolution = &cycle.step()?.resolution;
            q.iter_mut().zip(resolution.joint_velocity.iter()).for_each(|(q, qdot)| *q += period * qdot);
            let fastest = resolution.joint_velocity.amax();
            let [limited, guessed] =
                [resolution.active_limits().next().is_some(), resolution.solver.path == Path::ActiveSet];
            cycle.fastest = cycle.fastest.max(fastest);
            cycle.limited += f64::from(u8::from(limited)) / periods as f64;
            cycle.guessed += f64::from(u8::from(guessed)) / periods as f64;
        }
        Ok(cycle)
    }

    /// Runs the next period, for timing.
    pub fn repeat(&mut self) -> Result<f64, BenchError> {
        self.step().map(|command| command.resolution.joint_velocity[0])
    }

    /// Runs the next period; restarts after the last one.
    pub fn step(&mut self) -> Result<&Command, BenchError> {
        if self.next == self.states.len() {
            (self.next, self.memory) = (0, None);
        }
        let state = &self.states[self.next];
        self.next += 1;
        self.stepper.step(&mut self.memory, state).map_err(BenchError::defect)
    }
}

pub fn rows(budget: Budget) -> Result<Vec<Row>, BenchError> {
    let mut rows = without_limits(budget)?;
    rows.extend(with_limits(budget)?);
    Ok(rows)
}

/// Push along x, hold the rest, without damping and limits; compared with the printed formula.
fn without_limits(budget: Budget) -> Result<Vec<Row>, BenchError> {
    let mut ours = Cycle::along(&swing(wire::Solver::Auto, None)?, &Robots::built_in(), &NOMINAL, PERIODS)?;
    let chain = Chain::of(&ours.stepper.controller().config().robot);
    let states = ours.states.clone();
    let mut states = states.iter().cycle();
    let axes = [&[Axis::X][..], &[Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz]];
    let [first, second] = axes.map(AxisSelection::new);
    let axes = [first.map_err(BenchError::defect)?, second.map_err(BenchError::defect)?];
    let velocities = [DVector::from_element(1, 0.1), DVector::zeros(5)];
    let times = side_by_side(
        budget,
        vec![
            Subject::fallible("cycle, auto, nothing limited, two tasks", || ours.repeat()),
            Subject::new("4 × 4 matrices, Eq. (29) as printed, faer's pseudo-inverses", || {
                states
                    .next()
                    .map(|state| plain::reverse_priority(&chain.jacobian(&state.joint_position), &axes, &velocities))
            }),
        ],
    )?;
    Ok(Row::against_each(&times))
}

/// The same motion with active joint limits.
fn with_limits(budget: Budget) -> Result<Vec<Row>, BenchError> {
    let along = |solver| Cycle::along(&swing(solver, Some(0.35))?, &Robots::built_in(), &NOMINAL, PERIODS);
    let (mut auto, mut qp) = (along(wire::Solver::Auto)?, along(wire::Solver::Qp)?);
    let name = format!("cycle, auto, limits active in {:.0} % of the periods", 100.0 * auto.limited);
    let share = 100.0 * auto.guessed;
    let times = side_by_side(
        budget.stretched(2),
        vec![
            Subject::fallible(name, || auto.repeat()),
            Subject::fallible("cycle, qp: Clarabel at every level", || qp.repeat()),
        ],
    )?;
    let note = format!("{share:.0} % by active sets");
    Ok(vec![Row::of_times(&times[0], Some(&times[1])).with_note(note), Row::of_times(&times[1], None)])
}

/// Returns a controller that oscillates along x once per second at up to 0.4 m/s and holds the rest.
///
/// `limit`: limit of every joint, rad/s.
pub fn swing(solver: wire::Solver, limit: Option<f64>) -> Result<wire::Controller, BenchError> {
    let limits = limit.map_or(json!("none"), |limit| json!({"lower": vec![-limit; 7], "upper": vec![limit; 7]}));
    let sine = json!({"kind": "sine", "offset": 0, "amplitude": 0.4, "angular_frequency_rad_s": TAU});
    let hold = json!({"kind": "velocity", "target_velocity": {"kind": "constant", "value": 0}});
    serde_json::from_value(json!({
        "robot": "sawyer_dh", "period_s": 0.001, "solver": solver, "limits": limits, "damping": null,
        "tasks": [
            {"name": "swing", "axes": ["x"], "law": {"kind": "velocity", "target_velocity": sine}},
            {"name": "hold", "axes": ["y", "z", "rx", "ry", "rz"], "law": hold}
        ]
    }))
    .map_err(BenchError::defect)
}
