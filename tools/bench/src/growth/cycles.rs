//! Control periods over the number of joints and the number of tasks.

use revprio::service::Robots;
use revprio_api::wire;
use revprio_robot::kinematics::Configuration;
use serde_json::{Value, json};

use super::arms;
use crate::core::cycle::Cycle;
use crate::error::BenchError;
use crate::plan::Plan;
use crate::series::{Growth, Series};
use crate::timing::{Subject, side_by_side};

const JOINTS: [usize; 9] = [3, 4, 5, 7, 10, 14, 18, 24, 30];
const TASKS: [usize; 8] = [1, 2, 3, 4, 5, 6, 7, 8];

/// Joints of the arm for the number of tasks: more than rows, so that every task is feasible.
const MANY_JOINTS: usize = 10;

/// Periods of the trajectory: a quarter of a second.
const PERIODS: usize = 250;

/// Joint limits as a share of the largest joint speed without limits, so that they are active.
const TIGHTNESS: f64 = 0.7;

/// Varies the number of joints, with two tasks of 1 + 2 rows.
pub fn joints(plan: &Plan) -> Result<Growth, BenchError> {
    let tasks = json!([swing("x", 0.4), hold("rest", &["y", "z"])]);
    let mut curves = Curves::default();
    for n in plan.sizes(&JOINTS) {
        curves.measure(plan, n, n, &tasks)?;
    }
    Ok(Growth {
        name: "growth_joints",
        title: "Control period over number of joints, two tasks of 1 + 2 rows",
        size: "joints n",
        value: "time of a control period (s)",
        series: curves.series(),
    })
}

/// Varies the number of tasks with one row each, on an arm of ten joints.
pub fn tasks(plan: &Plan) -> Result<Growth, BenchError> {
    let mut all = vec![swing("x", 0.4)];
    all.extend(["y", "z", "rx", "ry", "rz"].map(|axis| hold(axis, &[axis])));
    all.extend(["j0", "j9"].map(|joint| {
        let rest = json!({"kind": "constant", "value": 0.5});
        json!({"name": joint, "law": {"kind": "posture", "joints": [joint], "gain": 1, "target_position": rest}})
    }));
    let mut curves = Curves::default();
    for count in plan.sizes(&TASKS) {
        curves.measure(plan, count, MANY_JOINTS, &json!(all[..count]))?;
    }
    Ok(Growth {
        name: "growth_tasks",
        title: "Control period over number of tasks, one row each, ten joints",
        size: "tasks",
        value: "time of a control period (s)",
        series: curves.series(),
    })
}

fn swing(axis: &str, amplitude: f64) -> Value {
    let sine = json!({"kind": "sine", "offset": 0, "amplitude": amplitude, "angular_frequency_rad_s": 12});
    json!({"name": "swing", "axes": [axis], "law": {"kind": "velocity", "target_velocity": sine}})
}

fn hold(name: &str, axes: &[&str]) -> Value {
    let rest = json!({"kind": "constant", "value": 0});
    json!({"name": name, "axes": axes, "law": {"kind": "velocity", "target_velocity": rest}})
}

#[derive(Default)]
struct Curves {
    kinematics: Vec<(f64, f64)>,
    closed_form: Vec<(f64, f64)>,
    auto: Vec<(f64, f64)>,
    qp: Vec<(f64, f64)>,
}

impl Curves {
    /// Measures one size and adds a point to each curve.
    fn measure(&mut self, plan: &Plan, size: usize, joints: usize, tasks: &Value) -> Result<(), BenchError> {
        let (robots, posture) = (arms::with_joints(joints)?, arms::posture(joints));
        let robot = robots.get(arms::NAME).map_err(BenchError::defect)?;
        let mut closed_form = along(&robots, &posture, "closed_form", None, tasks)?;
        let limit = TIGHTNESS * closed_form.fastest;
        let mut auto = along(&robots, &posture, "auto", Some(limit), tasks)?;
        let mut qp = along(&robots, &posture, "qp", Some(limit), tasks)?;
        let times = side_by_side(
            plan.points(),
            vec![
                Subject::new("", || Configuration::new(&robot, &posture)),
                Subject::fallible("", || closed_form.repeat()),
                Subject::fallible("", || auto.repeat()),
                Subject::fallible("", || qp.repeat()),
            ],
        )?;
        let curves = [&mut self.kinematics, &mut self.closed_form, &mut self.auto, &mut self.qp];
        // The mean, because a few periods of a trajectory take much longer.
        curves.into_iter().zip(&times).for_each(|(curve, times)| curve.push((size as f64, times.mean())));
        Ok(())
    }

    fn series(self) -> Vec<Series> {
        vec![
            Series::new("kinematics", self.kinematics),
            Series::new("closed form", self.closed_form),
            Series::new("auto, limits active", self.auto),
            Series::new("qp", self.qp),
        ]
    }
}

fn along(
    robots: &Robots,
    posture: &[f64],
    solver: &str,
    limit: Option<f64>,
    tasks: &Value,
) -> Result<Cycle, BenchError> {
    let n = posture.len();
    let limits = limit.map_or(json!("none"), |limit| json!({"lower": vec![-limit; n], "upper": vec![limit; n]}));
    let controller = json!({
        "robot": arms::NAME, "period_s": 0.001, "solver": solver, "limits": limits, "damping": null, "tasks": tasks
    });
    let controller: wire::Controller = serde_json::from_value(controller).map_err(BenchError::defect)?;
    Cycle::along(&controller, robots, posture, PERIODS)
}
