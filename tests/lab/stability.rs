//! The stability margin against the simulator: the lag at which a simulated contact begins to swing up, found by bisection
//! over runs through the service, is the computed one.

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

/// The contact with so much lag and damping.
fn contact(lag_s: f64, damping: f64) -> Scenario {
    let text = CONTACT.replace("damping = [150.0]", &format!("damping = [{damping:?}]"));
    let mut scenario = Scenario::parse(&text, "stiff_spring.toml").unwrap();
    scenario.velocity_loop.lag_s = lag_s;
    scenario
}

/// Width of the swing of the force in the second and in the fourth second, N.
fn swings(client: &Client, scenario: &Scenario) -> [f64; 2] {
    swings_in(client, scenario, [1000..2000, 3000..4000])
}

/// Width of the swing of the force in some periods, N.
fn swings_in<const N: usize>(client: &Client, scenario: &Scenario, periods: [Range<usize>; N]) -> [f64; N] {
    let recording = run(scenario, client, CallMode::Session, |_| ControlFlow::Continue(())).unwrap();
    periods.map(|periods| {
        let forces = recording.samples[periods].iter().map(|sample| sample.force[0]);
        let (low, high) = forces.fold((f64::MAX, f64::MIN), |(low, high), force| (low.min(force), high.max(force)));
        high - low
    })
}

/// Whether the force swings wider in the last second than in the second one.
fn swings_up(client: &Client, lag_s: f64) -> bool {
    let [early, late] = swings(client, &contact(lag_s, 150.0));
    late > early
}

/// The lag at which the swing begins to grow, by eight halvings of 0.5 … 1.5 times `about`.
fn simulated_largest_lag(client: &Client, about: f64) -> f64 {
    let (mut calm, mut wild) = (0.5 * about, 1.5 * about);
    assert!(!swings_up(client, calm) && swings_up(client, wild));
    for _ in 0..8 {
        let middle = f64::midpoint(calm, wild);
        if swings_up(client, middle) {
            wild = middle;
        } else {
            calm = middle;
        }
    }
    f64::midpoint(calm, wild)
}

#[test]
fn the_largest_lag_is_the_one_at_which_a_simulated_contact_swings_up() {
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
fn a_warned_controller_swings_up_and_the_recommended_damping_settles() {
    let server = RunningServer::start(router(AppState::new(Robots::built_in()))).unwrap();
    let client = Client::new(&server.url());
    let warnings =
        |scenario: &Scenario| client.create_controller(&scenario.controller_in_environment()).unwrap().warnings;
    let lagging = contact(0.005, 150.0);
    let warnings_of_lagging = warnings(&lagging);
    assert_eq!(warnings_of_lagging.len(), 1);
    // From about a second on it swings through the whole reach of the arm, and cannot swing wider.
    let swings_of_lagging = swings_in(&client, &lagging, [100..200, 300..400, 1000..2000, 3000..4000]);
    assert!(swings_of_lagging[1] > 3.0 * swings_of_lagging[0], "{swings_of_lagging:?} N");
    assert!(swings_of_lagging[2..].iter().all(|swing| *swing > 1000.0), "{swings_of_lagging:?} N");

    let (_, advice) = warnings_of_lagging[0].split_once("damping of at least ").unwrap();
    let recommended: f64 = advice.split(' ').next().unwrap().parse().unwrap();
    let mended = contact(0.005, recommended);
    assert_eq!(warnings(&mended), [""; 0]);
    let [early, late] = swings(&client, &mended);
    assert!(late < early, "{early} N, then {late} N");
    let [early, late] = swings(&client, &contact(0.005, 1.5 * recommended));
    assert!(late < 0.01 * early, "{early} N, then {late} N");
    assert_eq!(warnings(&contact(0.005, 0.999 * recommended / 1.001)).len(), 1);
}
