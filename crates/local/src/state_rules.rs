//! The rules for the states of a controller: bounds beyond which a state is refused, and warnings about the others.

use std::f64::consts::TAU;

use revprio_api::wire;
use revprio_core::controller::{Command, Controller, ControllerConfig, Measurement, Stall, StalledJoint};
use revprio_robot::{Joint, RobotModel};

use super::error::{ApiError, escape_pointer};

/// Distance outside the range that is reported, rad or m. Sensors of joints are more exact.
const REPORTED_DISTANCE: f64 = 1e-3;

/// Force (N) or torque (N·m) above which a state has a warning if there is no bound. Wrist sensors of arms measure less.
const REPORTED_WRENCH: f64 = 1e4;

/// Number of periods between two states above which a jump of the time or of the sequence number is reported.
const MAX_GAP_PERIODS: f64 = 100.0;

/// A joint may move at this multiple of its speed limit between two states, because limits apply to commands.
const SPEED_MARGIN: f64 = 1.5;

/// Distance between two states that is plausible at any time, rad or m. It covers noise and bends of the joint.
const POSITION_MARGIN: f64 = 0.02;

/// A jump that differs from a whole turn by less, rad, is that of an encoder that begins anew.
const WRAP_TOLERANCE: f64 = 0.2;

/// The rules for the states of a controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateRules {
    /// Maximum validity of an answer, ms.
    pub valid_for_ms: u64,
    /// Whether answers have `why`.
    pub why: bool,
    /// Bounds of a plausible state.
    pub checks: wire::StateChecks,
}

/// The parts of the last state with which the next state is compared.
#[derive(Debug, Clone, PartialEq)]
pub struct LastState {
    /// Sequence number.
    pub sequence: u64,
    /// Time, s.
    pub time_s: f64,
    /// Joint position, n.
    pub joint_position: Vec<f64>,
}

impl StateRules {
    /// Refuses a state beyond a bound.
    pub fn check(&self, state: &Measurement, controller: &Controller) -> Result<(), ApiError> {
        self.check_position(&state.joint_position, controller.config(), "/joint_position")?;
        for (tip, wrench) in measured_wrenches(state) {
            let field = tip.map_or("/wrench".to_owned(), |tip| {
                format!("/wrenches/{}", escape_pointer(&controller.config().robot.tips()[tip].name))
            });
            let (force, torque) = wrench.split_at(3);
            check_wrench(force, self.checks.max_force_n, &format!("{field}/force"), "N", "max_force_n")?;
            check_wrench(torque, self.checks.max_torque_nm, &format!("{field}/torque"), "N·m", "max_torque_nm")?;
        }
        Ok(())
    }

    /// Refuses a posture outside the ranges of the joints; `field`: its place in the body.
    pub fn check_position(&self, position: &[f64], config: &ControllerConfig, field: &str) -> Result<(), ApiError> {
        let tolerance = self.checks.position_tolerance;
        if !config.keeps_positions() {
            return Ok(());
        }
        check_positions(&config.robot, position, tolerance).map_err(|detail| {
            let more = format!("set `state_checks.position_tolerance`, now {tolerance}");
            let detail = format!("{detail} If the arm is really there, move it back by hand or {more}");
            ApiError::implausible(field, detail)
        })
    }

    /// Refuses a reading beyond the range of its sensor; `field`: its place in the body.
    pub fn check_wrench(&self, wrench: &wire::Wrench, field: &str) -> Result<(), ApiError> {
        check_wrench(&wrench.force, self.checks.max_force_n, &format!("{field}/force"), "N", "max_force_n")?;
        check_wrench(&wrench.torque, self.checks.max_torque_nm, &format!("{field}/torque"), "N·m", "max_torque_nm")
    }

    /// Adds warnings about a state and its command.
    pub fn warn(&self, warnings: &mut Vec<String>, state: &Measurement, controller: &Controller, command: &Command) {
        let reported =
            if controller.config().keeps_positions() { REPORTED_DISTANCE } else { self.checks.position_tolerance };
        let robot = &controller.config().robot;
        for (joint, q, _) in outside(robot, &state.joint_position).filter(|(_, _, distance)| *distance > reported) {
            let (name, lower, upper) = (&joint.name, joint.limits.lower, joint.limits.upper);
            let effect = if controller.config().keeps_positions() {
                "the service drives it back at up to its speed limit"
            } else {
                "this controller does not keep positions inside"
            };
            warnings.push(format!("joint `{name}` at {q} is outside its range {lower} … {upper}; {effect}"));
        }
        if controller.config().keeps_positions() {
            warnings.extend(within_margins(controller, &state.joint_position));
        }
        let bounds = [self.checks.max_force_n, self.checks.max_torque_nm];
        let tips = controller.config().robot.tips();
        let entries = measured_wrenches(state)
            .flat_map(|(tip, wrench)| wrench.iter().enumerate().map(move |(entry, value)| (tip, entry, value)));
        let unbounded = entries.filter(|(_, entry, _)| bounds[entry / 3].is_none());
        for (tip, _, value) in unbounded.filter(|(_, _, value)| value.abs() > REPORTED_WRENCH) {
            let name = &tips[tip.unwrap_or(0)].name;
            warnings.push(format!(
                "the wrench at `{name}` has an entry of {value} N or N·m; check the sensor and its unit, and set \
                 `state_checks.max_force_n` and `max_torque_nm` to the range of the sensor"
            ));
        }
        for &joint in &command.hold.too_fast {
            let Joint { name, limits, .. } = &controller.config().robot.joints()[joint];
            let exceeded = if limits.envelope.is_finite() {
                "is faster than its velocity envelope allows near the end of its range"
            } else {
                "is too fast to stop inside its range at its deceleration"
            };
            warnings.push(format!("joint `{name}` {exceeded}; stop the arm, and check limits, units and the solver"));
        }
        warnings.extend(stall_warning(&command.stalled, controller));
    }
}

/// Returns a warning for each joint whose measured speed is more than it can have. The first command starts from the measured
/// speed, but from rest if there is such a joint.
pub fn implausible_speeds(state: &Measurement, robot: &RobotModel, is_first: bool) -> Vec<String> {
    let speeds = robot.joints().iter().zip(state.joint_velocity.iter().flatten());
    let fast = speeds.filter(|(joint, v)| v.abs() > SPEED_MARGIN * joint.limits.velocity);
    let effect = if is_first { ", so that it is not believed, and the command starts from rest" } else { "" };
    fast.map(|(Joint { name, limits, kind, .. }, v)| {
        let (limit, unit) = (limits.velocity, kind.unit());
        format!("joint `{name}` moves at {v} {unit}/s, and its speed limit is {limit} {unit}/s{effect}; check the sensor and its unit")
    })
    .collect()
}

impl LastState {
    /// Adds warnings about the change from this state to the next one.
    pub fn compare(&self, warnings: &mut Vec<String>, sequence: u64, state: &Measurement, controller: &Controller) {
        let period = controller.config().period_s;
        let elapsed = state.time_s - self.time_s;
        let periods = elapsed / period;
        if elapsed < 0.0 {
            warnings.push(format!(
                "time_s went back from {} to {}; set-points over time went back too. Use a clock that never goes back, or \
                 open a new session",
                self.time_s, state.time_s
            ));
        } else if periods > MAX_GAP_PERIODS {
            warnings.push(format!(
                "time_s advanced by {elapsed} s, {periods:.0} periods; set-points over time jumped. Send a state in every \
                 period, or open a new session after a pause"
            ));
        }
        let skipped = sequence.saturating_sub(self.sequence);
        if skipped as f64 > MAX_GAP_PERIODS.max(2.0 * periods) {
            warnings.push(format!(
                "sequence advanced by {skipped}, from {} to {sequence}; increase it by one with every state",
                self.sequence
            ));
        }
        // If the client's clock stands still, its sequence numbers count the time.
        let moving_time = elapsed.abs().max(skipped as f64 * period);
        for (joint, (&q, &before)) in
            controller.config().robot.joints().iter().zip(state.joint_position.iter().zip(&self.joint_position))
        {
            let moved = (q - before).abs();
            if moved > POSITION_MARGIN + SPEED_MARGIN * joint.limits.velocity * moving_time {
                let name = &joint.name;
                let is_turn = !joint.kind.is_translation() && (moved - TAU).abs() < WRAP_TOLERANCE;
                let advice = if is_turn {
                    "a whole turn; send positions that go on where the encoder begins anew"
                } else {
                    "further than its speed limit allows; check the sensor, and that one client alone steps this controller"
                };
                warnings.push(format!("joint `{name}` jumped from {before} to {q}, {advice}"));
            }
        }
    }
}

/// Returns the warning about joints that do not follow their commands, if there are any.
fn stall_warning(stalled: &[StalledJoint], controller: &Controller) -> Option<String> {
    let joints = controller.config().robot.joints();
    let StalledJoint { joint, stall: Stall { commanded, moved, time_s } } = *stalled.first()?;
    let (name, unit, speed) = (&joints[joint].name, joints[joint].kind.unit(), commanded / time_s);
    let names: Vec<&str> = stalled.iter().map(|stalled| joints[stalled.joint].name.as_str()).collect();
    Some(format!(
        "joints that do not follow their commands: `{}`; `{name}` was commanded {speed:.3} {unit}/s for {time_s:.2} s and moved \
         by {moved:.4} {unit}. Check brakes, emergency stop and obstacles, and that the arm gets the commands",
        names.join("`, `")
    ))
}

/// Refuses positions that are farther outside the ranges of the joints than a tolerance, rad or m.
pub fn check_positions(robot: &RobotModel, position: &[f64], tolerance: f64) -> Result<(), String> {
    let Some((joint, q, _)) = outside(robot, position).find(|(_, _, distance)| *distance > tolerance) else {
        return Ok(());
    };
    let (name, lower, upper) = (&joint.name, joint.limits.lower, joint.limits.upper);
    Err(format!(
        "joint `{name}` at {q} is outside its range {lower} … {upper}; positions are in rad or m, not in degrees or mm."
    ))
}

/// Returns the joints outside their ranges, with their positions and distances.
fn outside<'a>(robot: &'a RobotModel, position: &'a [f64]) -> impl Iterator<Item = (&'a Joint, f64, f64)> {
    let distance = |(joint, &q): (&'a Joint, &'a f64)| {
        let distance = (q - joint.limits.upper).max(joint.limits.lower - q);
        (distance > 0.0).then_some((joint, q, distance))
    };
    robot.joints().iter().zip(position).filter_map(distance)
}

/// Returns a warning for each joint inside its range that is nearer to an end than its velocity envelope lets it rest.
fn within_margins<'a>(controller: &'a Controller, position: &'a [f64]) -> impl Iterator<Item = String> {
    let joints = controller.config().robot.joints().iter().zip(position);
    joints.filter_map(|(Joint { name, limits, kind, .. }, &q)| {
        let [lowest, highest] = limits.resting_range();
        let is_inside = (limits.lower..=limits.upper).contains(&q);
        let is_near = (q - highest).max(lowest - q) > REPORTED_DISTANCE;
        let (margin, unit) = (limits.envelope.margin(), kind.unit());
        (is_inside && is_near).then(|| {
            format!(
                "joint `{name}` at {q} is nearer to the end of its range than {margin:.4} {unit}, where its velocity envelope \
                 lets it move away only; the service moves it away"
            )
        })
    })
}

/// Returns the measured wrenches; `None`: that of the tool.
fn measured_wrenches(state: &Measurement) -> impl Iterator<Item = (Option<usize>, &[f64; 6])> {
    let others = state.wrenches.iter().map(|measured| (Some(measured.tip), &measured.wrench));
    [(None, &state.wrench)].into_iter().chain(others)
}

fn check_wrench(values: &[f64], bound: Option<f64>, pointer: &str, unit: &str, field: &str) -> Result<(), ApiError> {
    let Some(bound) = bound else { return Ok(()) };
    match values.iter().find(|value| value.abs() > bound) {
        None => Ok(()),
        Some(value) => Err(ApiError::implausible(
            pointer,
            format!(
                "{value} {unit} is beyond {bound} {unit}; check the sensor and its unit, or set `state_checks.{field}`"
            ),
        )),
    }
}
