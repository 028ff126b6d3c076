//! Random controllers, and what the tests know about their robots.

use std::sync::Arc;

use revprio_api::wire;
use revprio_robot::{RobotModel, built_in};
use serde_json::{Value, json};

use crate::random::Random;

/// A controller, and the facts about it that decide what may be demanded of its answers.
#[derive(Debug, Clone)]
pub struct Design {
    pub wire: Arc<wire::Controller>,
    pub robot: Arc<RobotModel>,
    /// Whether its steps may run in another thread: its tasks are many, or its solver is one of those to compare with.
    pub is_large: bool,
}

impl Design {
    /// Chooses a controller.
    pub fn random(random: &mut Random) -> Self {
        let robots = built_in();
        let robot = Arc::clone(&robots[random.below(robots.len())]);
        let is_large = random.one_in(15) && robot.joint_count() >= 6;
        let mut controller = json!({
            "robot": robot.name(),
            "period_s": random.pick(&[0.001, 0.002, 0.004, 0.01]),
            "method": random.weighted(&[(5, "reverse_priority"), (1, "strict_reverse_priority"), (1, "task_priority"),
                (1, "singularity_robust")]),
            "solver": random.weighted(&[(6, "auto"), (2, "qp"), (1, "closed_form")]),
            "limits": random.weighted(&[(5, "position_velocity"), (4, "position_velocity_acceleration"), (1, "velocity")]),
            "valid_for_ms": random.pick(&[1, 20, 100, 100, 1000]),
            "tasks": if is_large { large_tasks(&robot) } else { tasks(random, &robot) },
        });
        if is_large {
            controller["method"] = json!("reverse_priority");
            controller["solver"] = json!("auto");
        }
        if random.one_in(4) {
            controller["state_checks"] = json!({"max_force_n": 100, "position_tolerance": 0.05});
        }
        let is_large = is_large || controller["solver"] != "auto";
        let wire = serde_json::from_value(controller).unwrap();
        Self { wire: Arc::new(wire), robot, is_large }
    }

    /// Whether the answers keep every joint inside its range.
    pub fn keeps_positions(&self) -> bool {
        let wire::Limits::Robot(kind) = self.wire.limits else { return false };
        kind.includes_position() && self.wire.solver != wire::Solver::ClosedForm
    }

    pub fn needs_wrench(&self) -> bool {
        self.wire.tasks.iter().any(|task| task.law.as_ref().is_some_and(wire::Law::reads_wrench))
    }
}

/// Tasks whose targets drive the arm into its limits.
fn tasks(random: &mut Random, robot: &RobotModel) -> Value {
    let planar = robot.joint_count() < 6;
    let axes: &[&str] = if planar { &["x", "y", "rz"] } else { &["x", "y", "z", "rx", "ry", "rz"] };
    let count = 1 + random.below(3);
    let task = |random: &mut Random, k: usize| {
        let first = random.below(axes.len());
        let axes = &axes[first..axes.len().min(first + 1 + random.below(3))];
        match random.below(6) {
            0 => json!({"name": format!("t{k}"), "axes": axes, "law": {"kind": "velocity",
                "target_velocity": {"kind": "constant", "value": random.between(-2.0, 2.0)}}}),
            1 => json!({"name": format!("t{k}"), "axes": axes, "law": {"kind": "force", "inertia": 15, "damping": 150,
                "target_force": {"kind": "constant", "value": random.between(-60.0, 60.0)}}}),
            2 => json!({"name": format!("t{k}"), "axes": axes, "law": {"kind": "impedance", "inertia": 15,
                "damping": 150, "stiffness": 500, "target_displacement": {"kind": "sine", "offset": 0,
                "amplitude": random.between(0.0, 1.0), "angular_frequency_rad_s": random.between(0.1, 20.0)}}}),
            3 => {
                json!({"name": format!("t{k}"), "axes": axes, "law": {"kind": "pose", "gain": random.between(0.5, 20.0),
                "target_displacement": {"kind": "constant", "value": random.between(-0.5, 0.5)}}})
            }
            4 => json!({"name": format!("t{k}"), "axes": axes, "lower": vec![random.between(-1.0, 0.2); axes.len()],
                "upper": vec![random.between(0.3, 1.0); axes.len()]}),
            _ => json!({"name": format!("t{k}"), "law": {"kind": "posture", "gain": random.between(0.5, 10.0),
                "target_position": {"kind": "constant", "value": random.between(-3.0, 3.0)}}}),
        }
    };
    let tasks: Vec<Value> = (0..count).map(|k| task(random, k)).collect();
    json!(tasks)
}

/// So many tasks that a step is above the budget of the thread that answers requests.
fn large_tasks(robot: &RobotModel) -> Value {
    let row = |k: usize| (0..robot.joint_count()).map(|j| f64::from(u8::from(j == k % robot.joint_count()))).collect();
    let task = |k: usize| {
        let row: Vec<f64> = row(k);
        json!({"name": format!("t{k}"), "jacobian": [row], "law": {"kind": "velocity",
            "target_velocity": {"kind": "constant", "value": 0.1}}})
    };
    json!((0..20).map(task).collect::<Vec<_>>())
}
