//! Compares the computed maximum lag with the simulator: bisection finds the lag at which the oscillation of a simulated
//! contact begins to grow.

use std::ops::{ControlFlow, Range};

use revprio::service::{AppState, Robots, RunningServer, router};
use revprio_api::wire::{EnvironmentAxis, StabilityRequest};
use revprio_api::{Client, Service};
use revprio_lab::simulator::{CallMode, Scenario, run};

/// A force of 30 N against a stiff spring in x, everything else at rest.
const CONTACT: &str = r#"
name = "stiff_spring"
description = "force control against a stiff spring"
duration_s = 4.0
start_joint_position = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2]

[[contacts]]
axis = "x"
kind = "spring"
stiffness = 1e5

[controller]
robot = "sawyer_dh"
period_s = 0.001
solver = "closed_form"

[[controller.tasks]]
name = "push"
axes = ["x"]
law = { kind = "force", inertia = [15.0], damping = [150.0], target_force = { kind = "constant", value = [30.0] } }

[[controller.tasks]]
name = "rest"
axes = ["y", "z", "rx", "ry", "rz"]
law = { kind = "velocity", target_velocity = { kind = "constant", value = [0.0, 0.0, 0.0, 0.0, 0.0] } }
"#;

/// Returns the contact with the given lag and damping.
fn contact(lag_s: f64, damping: f64) -> Scenario {
    let text = CONTACT.replace("damping = [150.0]", &format!("damping = [{damping:?}]"));
    let mut scenario = Scenario::parse(&text, "stiff_spring.toml").unwrap();
    scenario.velocity_loop.lag_s = lag_s;
    scenario
}

/// Returns the peak-to-peak force in the second and in the fourth second, N.
fn amplitudes(client: &Client, scenario: &Scenario) -> [f64; 2] {
    amplitudes_in(client, scenario, [1000..2000, 3000..4000])
}

/// Returns the peak-to-peak force in some periods, N.
fn amplitudes_in<const N: usize>(client: &Client, scenario: &Scenario, periods: [Range<usize>; N]) -> [f64; N] {
    let recording = run(scenario, client, CallMode::Session, |_| ControlFlow::Continue(())).unwrap();
    periods.map(|periods| {
        let forces = recording.samples[periods].iter().map(|sample| sample.force[0]);
        let (low, high) = forces.fold((f64::MAX, f64::MIN), |(low, high), force| (low.min(force), high.max(force)));
        high - low
    })
}

/// Returns whether the oscillation grows between the second and the fourth second.
fn oscillation_grows(client: &Client, lag_s: f64) -> bool {
    let [early, late] = amplitudes(client, &contact(lag_s, 150.0));
    late > early
}

/// Returns the lag at which the oscillation begins to grow, by eight bisections of 0.5 … 1.5 times `estimate`.
fn simulated_largest_lag(client: &Client, estimate: f64) -> f64 {
    let (mut stable, mut unstable) = (0.5 * estimate, 1.5 * estimate);
    assert!(!oscillation_grows(client, stable) && oscillation_grows(client, unstable));
    for _ in 0..8 {
        let middle = f64::midpoint(stable, unstable);
        if oscillation_grows(client, middle) {
            unstable = middle;
        } else {
            stable = middle;
        }
    }
    f64::midpoint(stable, unstable)
}

#[test]
fn computed_maximum_lag_equals_the_simulated_one() {
    let server = RunningServer::start(router(AppState::new(Robots::built_in()))).unwrap();
    let client = Client::new(&server.url());
    let request = StabilityRequest {
        inertia: 15.0,
        damping: 150.0,
        stiffness: 0.0,
        environment: EnvironmentAxis { stiffness: 1e5, damping: 0.0, inertia: 0.0 },
        period_s: 0.001,
        lag_s: 0.0,
        delay_periods: 0,
        velocity_measured: true,
    };
    let margin = client.stability(&request).unwrap();
    assert!(margin.stable);
    let computed = margin.largest_lag_s.unwrap();
    let simulated = simulated_largest_lag(&client, computed);
    assert!((simulated / computed - 1.0).abs() < 0.02, "simulated {simulated}, computed {computed}");
}

#[test]
fn no_scenario_has_a_law_that_is_unstable_in_free_space() {
    let server = RunningServer::start(router(AppState::new(Robots::built_in()))).unwrap();
    let client = Client::new(&server.url());
    for name in Scenario::names().split(", ") {
        let scenario = Scenario::built_in(name).unwrap().unwrap();
        let warnings = client.create_controller(&scenario.controller).unwrap().warnings;
        assert!(warnings.iter().all(|warning| !warning.contains("free space")), "{name}: {warnings:?}");
    }
}

#[test]
fn controller_with_a_warning_is_unstable_and_the_recommended_damping_is_stable() {
    let server = RunningServer::start(router(AppState::new(Robots::built_in()))).unwrap();
    let client = Client::new(&server.url());
    let warnings =
        |scenario: &Scenario| client.create_controller(&scenario.controller_in_environment()).unwrap().warnings;
    let lagging = contact(0.005, 150.0);
    let warnings_of_lagging = warnings(&lagging);
    assert_eq!(warnings_of_lagging.len(), 1);
    // After about a second the oscillation is limited by the reach of the arm.
    let amplitudes_of_lagging = amplitudes_in(&client, &lagging, [100..200, 300..400, 1000..2000, 3000..4000]);
    assert!(amplitudes_of_lagging[1] > 3.0 * amplitudes_of_lagging[0], "{amplitudes_of_lagging:?} N");
    assert!(amplitudes_of_lagging[2..].iter().all(|amplitude| *amplitude > 1000.0), "{amplitudes_of_lagging:?} N");

    let (_, advice) = warnings_of_lagging[0].split_once("damping of at least ").unwrap();
    let recommended: f64 = advice.split(' ').next().unwrap().parse().unwrap();
    let corrected = contact(0.005, recommended);
    assert_eq!(warnings(&corrected), [""; 0]);
    let [early, late] = amplitudes(&client, &corrected);
    assert!(late < early, "{early} N, then {late} N");
    let [early, late] = amplitudes(&client, &contact(0.005, 1.5 * recommended));
    assert!(late < 0.01 * early, "{early} N, then {late} N");
    assert_eq!(warnings(&contact(0.005, 0.999 * recommended / 1.001)).len(), 1);
}
