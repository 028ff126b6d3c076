//! The service is killed in the middle of a run into the limits, and the arm stays inside its ranges.

use std::ops::ControlFlow;

use revprio::service::{AppState, Robots, RunningServer, router};
use revprio_api::Client;
use revprio_lab::simulator::{CallMode, Outage, Scenario, run};
use revprio_robot::{JointLimits, RobotModel, built_in};
use serde_json::json;

/// T, s.
const PERIOD: f64 = 0.01;

/// Number of periods of a run into the limits. The fastest joints need less from the middle of their ranges.
const PERIODS: u32 = 240;

/// Time after the kill, s: longer than any hold and any braking.
const AFTER: f64 = 1.0;

/// Returns a scenario in which all joints move to one end of their ranges at their speed limits.
fn into_the_limits(robot: &RobotModel, limits: &str, upper: bool) -> Scenario {
    let end = |limits: &JointLimits| if upper { limits.upper.min(3.0) + 1.0 } else { limits.lower.max(-3.0) - 1.0 };
    let middle = |limits: &JointLimits| 0.5 * (limits.lower.max(-3.0) + limits.upper.min(3.0));
    let all =
        |of: &dyn Fn(&JointLimits) -> f64| robot.joints().iter().map(|joint| of(&joint.limits)).collect::<Vec<_>>();
    let law = json!({"kind": "posture", "gain": 30, "target_position": {"kind": "constant", "value": all(&end)}});
    let scenario = json!({"name": "kill", "description": "", "duration_s": f64::from(PERIODS) * PERIOD, "start_joint_position": all(&middle),
        "controller": {"robot": robot.name(), "period_s": PERIOD, "limits": limits,
            "tasks": [{"name": "run", "law": law}]}});
    serde_json::from_value(scenario).unwrap()
}

/// Returns the largest distances of a joint outside the range in which it may rest, and outside its range, over a run, rad, and the number
/// of unanswered periods.
fn furthest(robot: &RobotModel, client: &Client, scenario: &Scenario) -> ([f64; 2], usize) {
    let recording = run(scenario, client, CallMode::Session, |_| ControlFlow::Continue(())).unwrap();
    let outside = |range: fn(&JointLimits) -> [f64; 2]| {
        let postures = recording.samples.iter().flat_map(|sample| robot.joints().iter().zip(&sample.joint_position));
        let distances = postures.map(|(joint, q)| {
            let [lower, upper] = range(&joint.limits);
            (q - upper).max(lower - q)
        });
        distances.fold(f64::MIN, f64::max)
    };
    let unanswered = recording.samples.iter().filter(|sample| !sample.answered).count();
    let last = recording.samples.last().unwrap();
    assert!(unanswered == 0 || last.joint_velocity.iter().all(|v| *v == 0.0), "the arm is not at rest");
    ([outside(JointLimits::resting_range), outside(|limits| [limits.lower, limits.upper])], unanswered)
}

#[test]
fn a_service_killed_at_any_20th_period_leaves_every_joint_of_every_robot_inside_its_range() {
    let server = RunningServer::start(router(AppState::new(Robots::built_in()))).unwrap();
    let client = Client::new(&server.url());
    for robot in built_in() {
        for limits in ["position_velocity", "position_velocity_acceleration"] {
            for upper in [false, true] {
                let whole = into_the_limits(robot, limits, upper);
                let ([reached, _], _) = furthest(robot, &client, &whole);
                assert!((-1e-3..=1e-6).contains(&reached), "{} {limits}: {reached}", robot.name());
                for kill in (20..PERIODS).step_by(20) {
                    let start_s = (f64::from(kill) - 0.5) * PERIOD;
                    let mut killed = Scenario { duration_s: start_s + AFTER, ..whole.clone() };
                    killed.faults.outages = vec![Outage { start_s, duration_s: 10.0 }];
                    let ([_, outside], unanswered) = furthest(robot, &client, &killed);
                    assert!(unanswered >= 50, "{unanswered}");
                    assert!(outside <= 1e-6, "{} {limits}, killed at period {kill}: {outside} rad", robot.name());
                }
            }
        }
    }
}
