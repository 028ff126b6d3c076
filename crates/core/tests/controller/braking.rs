//! Position laws that brake before their target, on arms with drives that follow exactly or with lag and delay.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_core::controller::{
    Controller, ControllerConfig, JointRows, JointTarget, Limits, Measurement, Memory, Stepper, TargetPose, TaskConfig,
    TaskRows, ToolRows,
};
use revprio_core::law::{Braking, Law, PositionLaw};
use revprio_core::limits::LimitKind;
use revprio_core::linalg::Vector;
use revprio_robot::kinematics::{Axis, Configuration};
use revprio_robot::{JointLimits, RobotModel, built_in};

use super::arms::{Random, constant, gantry, position, task, tool_rows};

const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
const ANGULAR: [Axis; 3] = [Axis::Rx, Axis::Ry, Axis::Rz];

/// Length of a step, m.
const STEP: f64 = 0.3;

/// An arm whose joints follow the commands with a lag (s) and a delay (whole periods).
struct DrivenArm {
    q: Vec<f64>,
    velocity: Vec<f64>,
    queue: Vec<Vec<f64>>,
    lag_s: f64,
}

impl DrivenArm {
    fn at_rest(q: &[f64], lag_s: f64, delay_periods: usize) -> Self {
        let zero = vec![0.0; q.len()];
        Self { q: q.to_vec(), velocity: zero.clone(), queue: vec![zero; delay_periods], lag_s }
    }

    /// Moves for one period.
    fn follow(&mut self, command: &[f64], period: f64) {
        self.queue.push(command.to_vec());
        let acting = self.queue.remove(0);
        let left = if self.lag_s > 0.0 { (-period / self.lag_s).exp() } else { 0.0 };
        for ((q, v), u) in self.q.iter_mut().zip(&mut self.velocity).zip(&acting) {
            let gap = *v - u;
            *q += period * u + gap * self.lag_s * (1.0 - left);
            *v = u + gap * left;
        }
    }
}

/// The greatest excess over the target along the step, and the distance at the end, m.
#[derive(Debug, Clone, Copy)]
struct Approach {
    overshoot: f64,
    left: f64,
}

/// One step of the tool along a line that the arm can follow.
struct ToolStep {
    robot: Arc<RobotModel>,
    start: Vec<f64>,
    direction: Vector3<f64>,
}

fn pose(robot: &RobotModel, q: &[f64]) -> IsometryMatrix3<f64> {
    *Configuration::new(robot, q).unwrap().tool_pose()
}

impl ToolStep {
    fn goal(&self) -> IsometryMatrix3<f64> {
        let mut goal = pose(&self.robot, &self.start);
        goal.translation.vector += self.direction * STEP;
        goal
    }

    /// Returns the tasks of the step: one of six rows, or position above orientation.
    fn tasks(&self, gain: f64, split: bool, braking: &Braking) -> Vec<TaskConfig> {
        let rows: &[&[Axis]] = if split { &[&LINEAR, &ANGULAR] } else { &[&Axis::ALL] };
        let to_goal = |axes: &&[Axis]| {
            let law = PositionLaw::with_braking(vec![gain; axes.len()], braking.clone()).unwrap();
            let rows = ToolRows { target_pose: TargetPose::Fixed(self.goal()), ..tool_rows(axes) };
            TaskConfig { rows: TaskRows::Tool(rows), ..task(axes, Law::Position(law)) }
        };
        rows.iter().map(to_goal).collect()
    }

    fn controller(&self, tasks: Vec<TaskConfig>, period: f64) -> Controller {
        let limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);
        Controller::new(ControllerConfig { limits, ..ControllerConfig::new(Arc::clone(&self.robot), period, tasks) })
            .unwrap()
    }

    fn run(&self, controller: Controller, duration: f64, lag_s: f64, delay_periods: usize) -> Approach {
        let period = controller.config().period_s;
        let mut stepper = Stepper::new(controller).unwrap();
        let mut arm = DrivenArm::at_rest(&self.start, lag_s, delay_periods);
        let mut memory = None;
        let goal = self.goal().translation.vector;
        let mut found = Approach { overshoot: f64::NEG_INFINITY, left: 0.0 };
        for i in 0..(duration / period) as usize {
            step_arm(&mut stepper, &mut memory, &mut arm, i as f64 * period);
            let beyond = pose(&self.robot, &arm.q).translation.vector - goal;
            found.overshoot = found.overshoot.max(beyond.dot(&self.direction));
            found.left = beyond.norm();
        }
        found
    }
}

fn step_arm(stepper: &mut Stepper, memory: &mut Option<Memory>, arm: &mut DrivenArm, time_s: f64) {
    let period = stepper.controller().config().period_s;
    let measurement = Measurement {
        time_s,
        joint_position: arm.q.clone(),
        joint_velocity: Some(arm.velocity.clone()),
        wrench: [0.0; 6],
    };
    let command = stepper.step(memory, &measurement).unwrap().resolution.joint_velocity.clone();
    arm.follow(command.as_slice(), period);
}

/// Returns whether the arm can follow the line far from singularities and from its position limits.
fn is_free(step: &ToolStep) -> bool {
    let period = 0.01;
    let mut stepper = Stepper::new(step.controller(step.tasks(3.0, false, &Braking::Joints), period)).unwrap();
    let (mut arm, mut memory) = (DrivenArm::at_rest(&step.start, 0.0, 0), None);
    for i in 0..400 {
        step_arm(&mut stepper, &mut memory, &mut arm, f64::from(i) * period);
        let command = stepper.step(&mut memory.clone(), &Measurement {
            time_s: 0.0,
            joint_position: arm.q.clone(),
            joint_velocity: None,
            wrench: [0.0; 6],
        });
        let smallest = command.unwrap().resolution.singularity.smallest_singular_value();
        let inside = |(joint, q): (&revprio_robot::Joint, &f64)| {
            (joint.limits.upper - q).min(q - joint.limits.lower) > 0.3
        };
        if smallest < 0.08 || !step.robot.joints().iter().zip(&arm.q).all(inside) {
            return false;
        }
    }
    (pose(&step.robot, &arm.q).translation.vector - step.goal().translation.vector).norm() < 1e-3
}

fn robot(name: &str) -> Arc<RobotModel> {
    Arc::clone(built_in().iter().find(|robot| robot.name() == name).unwrap())
}

/// Returns steps of a robot from random postures in random directions.
fn steps(name: &str, count: usize) -> Vec<ToolStep> {
    let mut random = Random(17);
    let mut found = Vec::new();
    while found.len() < count {
        let robot = robot(name);
        let start = |joint: &revprio_robot::Joint| {
            let (lower, upper) = (joint.limits.lower.max(-3.0), joint.limits.upper.min(3.0));
            0.5 * (lower + upper + random.signed() * (upper - lower))
        };
        let start = robot.joints().iter().map(start).collect();
        let direction = Vector3::from_fn(|_, _| random.signed()).normalize();
        let step = ToolStep { robot, start, direction };
        if is_free(&step) {
            found.push(step);
        }
    }
    found
}

#[test]
#[ignore = "a table for the documentation"]
fn overshoot_table() {
    for name in ["panda", "ur5e", "sawyer"] {
        let steps = steps(name, 4);
        for (lag, delay) in [(0.0, 0), (0.02, 1), (0.03, 2)] {
            for period in [4e-3, 1e-2] {
                for gain in [5.0, 10.0, 20.0, 50.0] {
                    for braking in [Braking::Joints] {
                        let mut worst = Approach { overshoot: f64::NEG_INFINITY, left: 0.0 };
                        for step in &steps {
                            for split in [false, true] {
                                let controller = step.controller(step.tasks(gain, split, &braking), period);
                                let found = step.run(controller, 3.0, lag, delay);
                                worst.overshoot = worst.overshoot.max(found.overshoot);
                                worst.left = worst.left.max(found.left);
                            }
                        }
                        println!(
                            "{name} lag {lag} delay {delay} T {period} K {gain} {braking:?}: {:.2} % left {:.2e}",
                            worst.overshoot / STEP * 100.0,
                            worst.left
                        );
                    }
                }
            }
        }
    }
}
