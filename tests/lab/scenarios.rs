//! The expected result of each scenario, through a service over HTTP.

use std::ops::ControlFlow;

use revprio::service::{AppState, Robots, RunningServer, router};
use revprio_api::Client;
use revprio_api::wire::{self, Method, Solver};
use revprio_lab::report::metrics::{Metrics, largest_difference};
use revprio_lab::simulator::recording::{AtLimit, ContactEvent, ContactWord, Energy, Recording, Sample};
use revprio_lab::simulator::replay::replay;
use revprio_lab::simulator::{CallMode, Scenario, run};

fn scenario(name: &str) -> Scenario {
    Scenario::find(name).unwrap()
}

fn with_solver(name: &str, solver: Solver) -> Scenario {
    let mut scenario = scenario(name);
    scenario.controller.solver = solver;
    scenario
}

fn with_method(name: &str, method: Method) -> Scenario {
    let mut scenario = scenario(name);
    scenario.controller.method = method;
    scenario
}

/// Runs a scenario against a new service.
fn run_in(scenario: &Scenario, mode: CallMode) -> Recording {
    let server = RunningServer::start(router(AppState::new(Robots::built_in()))).unwrap();
    run(scenario, &Client::new(&server.url()), mode, |_| ControlFlow::Continue(())).unwrap()
}

fn served(scenario: &Scenario) -> Recording {
    run_in(scenario, CallMode::Session)
}

/// Returns the samples from one time to another, s.
fn between(run: &Recording, from_s: f64, to_s: f64) -> &[Sample] {
    let index = |time_s: f64| run.samples.partition_point(|sample| sample.time_s < time_s);
    &run.samples[index(from_s)..index(to_s)]
}

fn largest(samples: &[Sample], of: impl Fn(&Sample) -> f64) -> f64 {
    samples.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
}

fn final_force(run: &Recording) -> f64 {
    Metrics::of(run).final_force.unwrap()
}

fn speed(sample: &Sample) -> f64 {
    sample.joint_velocity.iter().map(|v| v.abs()).fold(0.0, f64::max)
}

/// Returns the distance between two places, m.
fn distance(from: [f64; 3], to: [f64; 3]) -> f64 {
    (0..3).map(|i| (from[i] - to[i]).powi(2)).sum::<f64>().sqrt()
}

fn exceeds_a_limit(sample: &Sample) -> bool {
    sample.limits.iter().any(|limit| matches!(limit, AtLimit::Below | AtLimit::Above))
}

/// Returns the largest deviation of F_x from 30 N after the impact.
fn force_error(run: &Recording) -> f64 {
    largest(between(run, 2.0, 5.0), |s| (s.force[0] - 30.0).abs())
}

/// The ball passes through the place of the hand. Its middle stays away from the tool point, and the hand returns.
#[test]
fn a_hand_goes_out_of_the_way_of_a_ball_and_returns() {
    let scenario = scenario("examples/scenarios/passing_ball.toml");
    let run = served(&scenario);
    let start = run.samples[0].position;
    let far = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| (a[i] - b[i]).powi(2)).iter().sum::<f64>().sqrt();
    let ball = |time_s: f64| [0.31, 0.6 - 0.2 * (time_s - 0.5).clamp(0.0, 6.0), 0.59];
    let mut nearest = f64::INFINITY;
    for sample in &run.samples {
        nearest = nearest.min(far(sample.position, ball(sample.time_s)));
    }
    let nearest_of_start =
        run.samples.iter().map(|sample| far(start, ball(sample.time_s))).fold(f64::INFINITY, f64::min);
    assert!(nearest_of_start < 0.05, "the ball passes the hand at {nearest_of_start} m");
    assert!(nearest > 0.1, "{nearest} m");
    let kept = scenario.controller.collisions.as_ref().unwrap().min_distance_m;
    let least = Metrics::of(&run).least_distance_m.unwrap();
    assert!(least > kept && least < nearest, "{least} of {kept} m, tool {nearest} m");
    assert!(largest(&run.samples, |sample| far(sample.position, start)) > 0.1, "the hand moves");
    let end = far(run.samples.last().unwrap().position, start);
    assert!(end < 2e-3, "{end} m");
}

#[test]
fn a_motion_that_a_controller_would_refuse_is_refused_before_the_run() {
    let mut scenario = scenario("examples/scenarios/passing_ball.toml");
    let mut refusal = |displacement: serde_json::Value| {
        scenario.obstacle_motions[0].displacement = serde_json::from_value(displacement).unwrap();
        scenario.check().map_err(|error| error.pointer)
    };
    let pointer = Err("/obstacle_motions/0/displacement".to_owned());
    let point = |time_s: f64, y: f64| serde_json::json!({"time_s": time_s, "value": [0, y, 0]});
    let path = |points: &[serde_json::Value]| serde_json::json!({"kind": "waypoints", "points": points});
    assert_eq!(refusal(serde_json::json!({"kind": "constant", "value": [0, 999, 0]})), Ok(()));
    assert_eq!(refusal(serde_json::json!({"kind": "constant", "value": [0, 1001, 0]})), pointer);
    assert_eq!(refusal(path(&[point(0.0, 0.0), point(1.0, 19.0)])), Ok(()));
    assert_eq!(refusal(path(&[point(0.0, 0.0), point(1.0, 54.0)])), pointer);
    assert_eq!(refusal(path(&[point(0.0, 0.0), point(1e-4, 0.1)])), pointer);
}

#[test]
fn cascade_keeps_limits_and_force_while_the_sweep_gives_way() {
    for solver in [Solver::Auto, Solver::Qp] {
        let cascade = served(&with_solver("stiff_wall_limits", solver));
        assert!(force_error(&cascade) < 0.2, "{}", force_error(&cascade));
        assert!(largest(&cascade.samples, |s| s.residual_norms[0]) < 1e-9);
        assert!(largest(&cascade.samples, speed) <= 0.35 + 1e-12 && !cascade.samples.iter().any(exceeds_a_limit));
        let held = cascade.samples.iter().filter(|s| s.limits.contains(&AtLimit::Upper)).count();
        assert!(held > 100 && largest(&cascade.samples, |s| s.residual_norms[1]) > 0.01, "{held}");
    }
}

#[test]
fn closed_form_exceeds_limits_and_clamping_drives_lose_the_force() {
    let closed = served(&with_solver("stiff_wall_limits", Solver::ClosedForm));
    assert!(closed.samples.iter().any(exceeds_a_limit) && largest(&closed.samples, speed) > 0.7);
    assert!(force_error(&closed) < 0.2);
    let clamped = served(&scenario("stiff_wall_limits_clamped"));
    let fastest = largest(&clamped.samples, |s| s.actual_velocity.iter().map(|v| v.abs()).fold(0.0, f64::max));
    assert!(fastest <= 0.35, "{fastest}");
    assert!(force_error(&clamped) > 5.0 * force_error(&closed), "{} {}", force_error(&clamped), force_error(&closed));
}

#[test]
fn lag_above_the_margin_bounces_and_more_damping_settles() {
    let lagging = served(&scenario("stiff_wall_lag"));
    let contacts = |run: &Recording| Metrics::of(run).contacts;
    assert!(contacts(&lagging) > 10, "{}", contacts(&lagging));
    let swing = largest(between(&lagging, 4.0, 5.0), |s| s.force[0]);
    assert!(swing > 60.0, "{swing}");
    let damped = served(&scenario("stiff_wall_lag_damped"));
    assert!((final_force(&damped) - 30.0).abs() < 0.3, "{}", final_force(&damped));
}

#[test]
fn acceleration_limits_increase_the_peak_of_a_fast_impact_only() {
    let fast = served(&scenario("stiff_wall_acceleration"));
    let peak = |run: &Recording| Metrics::of(run).peak_force;
    let free = served(&scenario("stiff_wall"));
    assert!((1.15..1.25).contains(&(peak(&fast) / peak(&free))), "{} {}", peak(&fast), peak(&free));
    let slow = served(&scenario("stiff_wall_acceleration_slow"));
    assert!(peak(&slow) < 32.0, "{}", peak(&slow));
    assert!((final_force(&slow) - 30.0).abs() < 1.0, "{}", final_force(&slow));
}

#[test]
fn joint_stops_at_the_end_of_its_range_and_the_orientation_gives_way() {
    let closed = served(&with_solver("joint_limits", Solver::ClosedForm));
    let kept = served(&scenario("joint_limits"));
    let furthest = |run: &Recording| largest(&run.samples, |s| s.joint_position[5].abs());
    assert!(furthest(&closed) > 2.9761 + 0.01, "{}", furthest(&closed));
    assert!(furthest(&kept) <= 2.9761 + 1e-9 && furthest(&kept) > 2.976, "{}", furthest(&kept));
    assert!(largest(&kept.samples, |s| s.residual_norms[0]) < 1e-6);
    assert!(largest(&kept.samples, |s| s.residual_norms[1]) > 1e-3);
    assert!((kept.samples.last().unwrap().position_error[2] - 0.25).abs() < 1e-3);
}

#[test]
fn reverse_priority_shares_a_conflict_that_the_strict_hierarchy_orders() {
    let residuals = |method| served(&with_method("task_conflict", method)).samples[0].residual_norms.clone();
    let (shared, strict) = (residuals(Method::ReversePriority), residuals(Method::StrictReversePriority));
    assert!(shared[0] < 1e-9 && strict[0] < 1e-9, "{shared:?} {strict:?}");
    assert!(shared[1] > 0.01 && shared[2] > 0.01, "{shared:?}");
    assert!(strict[1] < 1e-9 && strict[2] > 0.05, "{strict:?}");
}

#[test]
fn tool_follows_a_moving_wall_without_losing_contact() {
    let run = served(&scenario("moving_wall"));
    let steady = between(&run, 2.0, 6.0);
    assert!(steady.iter().all(|s| s.wall_distance.unwrap() < 0.0));
    let error = largest(steady, |s| (s.force[0] - 20.0).abs());
    assert!((1.0..5.0).contains(&error), "{error}");
}

#[test]
fn polishing_keeps_a_steady_force_against_friction() {
    let run = served(&scenario("polishing"));
    let normal = [0.5, 0.0, 0.75_f64.sqrt()];
    let steady = between(&run, 3.0, 8.0);
    let pressed = |s: &Sample| -(0..3).map(|i| s.force[i] * normal[i]).sum::<f64>();
    assert!(largest(steady, |s| (pressed(s) - 15.0).abs()) < 0.5);
    let friction = largest(steady, |s| s.force[1].abs());
    assert!((4.0..5.0).contains(&friction), "{friction}");
    let sweep = largest(steady, |s| s.position_error[1]);
    assert!((sweep - 0.05).abs() < 1e-3, "{sweep}");
    assert!(
        run.energy.dissipated_j > 0.5 && run.energy.imbalance_j().abs() < 0.02 * run.energy.work_j,
        "{:?}",
        run.energy
    );
}

#[test]
fn press_touches_a_wall_of_unknown_stiffness_once_and_settles() {
    let run = served(&scenario("press"));
    let touches: Vec<f64> = run
        .samples
        .windows(2)
        .filter(|pair| pair[0].force[0] == 0.0 && pair[1].force[0] > 0.0)
        .map(|pair| pair[1].time_s)
        .collect();
    let peak = largest(&run.samples, |s| s.force[0]);
    // The law keeps 1.2 F_d; the moment of the touch in its period decides how much of it.
    assert!(touches.len() == 1 && (30.0..36.0).contains(&peak), "{touches:?} {peak}");
    let settled = largest(between(&run, touches[0] + 0.1, 3.0), |s| (s.force[0] - 30.0).abs());
    assert!(settled < 1.5, "{settled}");
}

/// Returns a scenario whose law `contact` does not follow the surface.
fn without_surface(scenario: &Scenario) -> Scenario {
    let mut fixed = scenario.clone();
    let Some(wire::Law::Contact { surface, .. }) = &mut fixed.controller.tasks[0].law else {
        unreachable!("it presses with the law `contact`")
    };
    *surface = None;
    fixed
}

#[test]
fn wiping_keeps_the_normal_force_after_5_mm_because_it_follows_the_plane() {
    let followed = scenario("wiping");
    let fixed = without_surface(&followed);
    let normal = followed.contacts[0].normal.unwrap();
    let pressed = |s: &Sample| -(0..3).map(|i| s.force[i] * normal[i]).sum::<f64>();
    let error = |s: &Sample| (pressed(s) - 20.0).abs();
    let lost = |run: &Recording| run.samples.iter().filter(|s| s.contacts.event[0] == ContactEvent::Loss).count();

    let run = served(&followed);
    assert!((pressed(&between(&run, 1.9, 2.0)[0]) - 22.07).abs() < 0.1);
    let slides = &run.samples[2000..];
    let slid = |s: &Sample| distance(s.position_error, slides[0].position_error);
    let first_5_mm = slides.iter().position(|s| slid(s) > 5e-3).unwrap();
    let least = -largest(&slides[..first_5_mm], |s| -pressed(s));
    assert!((16.0..18.0).contains(&least), "{least}");
    let later = &slides[first_5_mm..];
    assert!(largest(later, error) < 1.0, "{}", largest(later, error));
    let speed = later.windows(2).map(|pair| distance(pair[0].position_error, pair[1].position_error) / 1e-3);
    let speed = speed.fold(0.0, f64::max);
    assert!((0.05..0.055).contains(&speed), "{speed}");
    assert_eq!(lost(&run), 0);

    let run = served(&fixed);
    let off = largest(&run.samples[2000..], error);
    assert!(off > 8.0, "{off}");
}

/// The middle of the cylinder is 0.153 m from the start. The tool goes over its crest, which is x = 51 mm.
#[test]
fn wiping_a_curved_surface_keeps_the_normal_force_because_it_follows_the_normal() {
    let followed = scenario("wiping_curved");
    let outward = followed.contacts[0].normal.unwrap();
    let middle = outward.map(|part| -0.153 * part);
    let normal = |s: &Sample| {
        let [x, z] = [0, 2].map(|i| s.position_error[i] - middle[i]);
        let distance = x.hypot(z);
        [x / distance, z / distance]
    };
    let pressed = |s: &Sample| -(s.force[0] * normal(s)[0] + s.force[2] * normal(s)[1]);
    let slope_deg = |s: &Sample| normal(s)[0].asin().to_degrees();
    let later = |run: &Recording| {
        let slides = &run.samples[2000..];
        let slid = |s: &Sample| distance(s.position_error, slides[0].position_error);
        slides[slides.iter().position(|s| slid(s) > 5e-3).unwrap()..].to_vec()
    };
    let error = |samples: &[Sample]| largest(samples, |s| (pressed(s) - 20.0).abs());

    let run = later(&served(&followed));
    assert!(error(&run) < 2.0, "{}", error(&run));
    let slopes = [-largest(&run, |s| -slope_deg(s)), largest(&run, slope_deg)];
    assert!((-19.5..-18.5).contains(&slopes[0]) && (18.0..19.0).contains(&slopes[1]), "{slopes:?}");
    let speed = run.windows(2).map(|pair| distance(pair[0].position_error, pair[1].position_error) / 1e-3);
    let speed = speed.fold(0.0, f64::max);
    assert!((0.045..0.06).contains(&speed), "{speed}");
    // The reported normal is a mean over the last 5 mm, in which the surface turns by 1.9 degrees.
    let off = largest(&run, |s| {
        let [x, _, z] = s.contacts.surface.normal[0].map(Option::unwrap);
        (x * normal(s)[1] - z * normal(s)[0]).asin().abs().to_degrees()
    });
    assert!(off < 4.0, "{off}");

    let run = later(&served(&without_surface(&followed)));
    assert!(error(&run) > 4.0, "{}", error(&run));
}

/// The hinge is 0.3 m from the handle in the direction of y. Without the program, the force stays along x.
#[test]
fn door_opens_without_a_force_across_its_motion_because_the_force_turns_with_it() {
    let turning = scenario("door");
    let mut fixed = Scenario { duration_s: 15.0, ..turning.clone() };
    fixed.target_programs.clear();
    let arm = |s: &Sample| {
        let [x, y, _] = s.position_error;
        [x, y - 0.3]
    };
    let angle = |s: &Sample| arm(s)[0].atan2(-arm(s)[1]);
    let across = |s: &Sample| (s.force[0] * arm(s)[0] + s.force[1] * arm(s)[1]).abs() / arm(s)[0].hypot(arm(s)[1]);
    let until_open = |run: &Recording| {
        let open = run.samples.iter().position(|s| angle(s) > 60.0_f64.to_radians());
        run.samples[..open.expect("the door opens")].to_vec()
    };

    let run = served(&turning);
    let opening = until_open(&run);
    assert!(largest(&opening, across) < 1.0, "{}", largest(&opening, across));
    let off_circle = largest(&run.samples, |s| (arm(s)[0].hypot(arm(s)[1]) - 0.3).abs());
    assert!(off_circle < 2e-4, "{off_circle}");
    let Energy { work_j, dissipated_j, .. } = run.energy;
    assert!(dissipated_j > 1.0 && run.energy.imbalance_j().abs() < 0.02 * work_j, "{:?}", run.energy);

    let opening = until_open(&served(&fixed));
    assert!(largest(&opening, across) > 12.0, "{}", largest(&opening, across));
}

/// The hole is 2.8 mm beside the peg, 3 mm below it, and 20 mm deep.
#[test]
fn peg_falls_into_a_hole_because_a_spiral_finds_it() {
    let searching = scenario("peg");
    let mut straight = searching.clone();
    straight.target_programs.clear();
    let height = |s: &Sample| s.position_error[2];
    let pressed = |run: &Recording| {
        let last = between(run, 5.0, 5.9);
        last.iter().map(|s| -s.force[2]).sum::<f64>() / last.len() as f64
    };

    let run = served(&searching);
    let end = run.samples.last().unwrap();
    assert!((height(end) + 0.023).abs() < 1e-3, "{}", height(end));
    assert!((end.position_error[0] - 0.002).hypot(end.position_error[1] + 0.002) < 6e-4, "{:?}", end.position_error);
    assert!((pressed(&run) - 10.0).abs() < 0.1, "{}", pressed(&run));
    let most = largest(&run.samples, |s| s.force[0].hypot(s.force[1]).hypot(s.force[2]));
    assert!(end.contacts.state[0] == ContactWord::Contact && most < 20.0, "{most}");

    let run = served(&straight);
    assert!(height(run.samples.last().unwrap()) > -4e-3 && (pressed(&run) - 10.0).abs() < 0.1, "{}", pressed(&run));
}

/// The edge is 8 mm in front of the peg, 3 mm below it, and 5 mm high.
#[test]
fn peg_presses_up_to_an_edge_and_below_it() {
    let run = served(&scenario("peg_edge"));
    let beyond = run.samples.iter().position(|s| s.position_error[1] > 0.008).unwrap();
    let start = run.samples.partition_point(|s| s.time_s < 1.0);
    let error = |s: &Sample| (s.force[2] + 10.0).abs();
    // The last 50 ms are the fall itself: the peg slides into the free place from a depth of 0.1 mm.
    let near = &run.samples[start..beyond - 25];
    assert!(largest(near, error) < 1.0, "{}", largest(near, error));
    let height = |s: &Sample| s.position_error[2];
    let end = run.samples.last().unwrap();
    assert!((height(end) + 0.0081).abs() < 1e-4 && end.position_error[1] > 0.018, "{:?}", end.position_error);
    let last = between(&run, 5.0, 5.9);
    assert!(largest(last, error) < 0.5, "{}", largest(last, error));
    let lost = run.samples.iter().filter(|s| s.contacts.event[0] == ContactEvent::Loss).count();
    assert_eq!(lost, 1);
}

#[test]
fn replay_streams_the_same_targets() {
    let server = RunningServer::start(router(AppState::new(Robots::built_in()))).unwrap();
    let client = Client::new(&server.url());
    let recorded = |name: &str| {
        let scenario = Scenario { duration_s: 1.0, ..scenario(name) };
        run(&scenario, &client, CallMode::Session, |_| ControlFlow::Continue(())).unwrap()
    };
    for name in ["door", "peg"] {
        let mut recording = recorded(name);
        let again = |recording: &Recording| {
            replay(recording, &client, CallMode::Session, 0.0, |_| ControlFlow::Continue(())).unwrap().differing
        };
        assert_eq!(again(&recording), 0, "{name}");
        recording.setup.as_mut().unwrap().target_programs.clear();
        assert!(again(&recording) > 100, "{name}");
    }
}

#[test]
fn pushed_arm_moves_like_a_spring_and_returns() {
    let run = served(&scenario("human_push"));
    let pushed = between(&run, 3.4, 3.5)[0].position_error[1];
    assert!((pushed - 0.06).abs() < 0.005, "{pushed}");
    let back = run.samples.last().unwrap();
    assert!(back.position_error.iter().all(|way| way.abs() < 2e-3), "{:?}", back.position_error);
    assert!(largest(&run.samples, |s| s.torque[2].abs()) > 1.9);
}

#[test]
fn six_joints_settle_at_a_wall_and_exact_methods_are_equal() {
    let run = served(&scenario("ur5e_wall"));
    assert!((final_force(&run) - 30.0).abs() < 0.3, "{}", final_force(&run));
    let other = served(&with_method("ur5e_wall", Method::TaskPriority));
    let difference = largest_difference(&run, &other);
    assert!(difference < 1e-9, "{difference}");
}

/// The scenarios of the arms of policies and teleoperation: the tool follows a sine to the side, behind lag and dead time.
#[test]
fn tools_of_other_arms_follow_a_sine_inside_all_limits() {
    for (arm, amplitude) in [("so101", 0.05), ("fr3", 0.15), ("xarm7", 0.15), ("iiwa14", 0.15), ("gen3", 0.15)] {
        let run = served(&scenario(&format!("examples/scenarios/{arm}_reach.toml")));
        let distance = |s: &Sample| {
            let [x, y, z] = s.position_error;
            (x.powi(2) + (y - amplitude * (1.5 * s.time_s).sin()).powi(2) + z.powi(2)).sqrt()
        };
        let late = largest(between(&run, 1.0, 6.0), distance);
        assert!(late < 3e-3, "{arm}: {late} m from its target");
        assert!(largest(&run.samples, |s| s.position_error[1]) > 0.8 * amplitude, "{arm} does not move");
        assert!(!run.samples.iter().any(exceeds_a_limit), "{arm}");
        let opening = |s: &Sample| s.channels.first().copied().flatten().unwrap_or_default();
        let jaws = largest(&run.samples, opening) + largest(&run.samples, |s| -opening(s));
        assert!(if arm == "so101" { jaws > 1.0 } else { jaws == 0.0 }, "{arm}: {jaws} rad");
    }
}

#[test]
fn biased_sensor_shifts_the_force_and_the_seed_determines_the_run() {
    let noisy = scenario("noisy_sensors");
    let run = served(&noisy);
    let steady = between(&run, 1.5, 3.0);
    let mean = steady.iter().map(|s| s.force[0]).sum::<f64>() / steady.len() as f64;
    assert!((mean - 29.5).abs() < 0.2, "{mean}");
    let sensed = run.samples[0].sensed.as_ref().unwrap();
    assert_eq!((sensed.force[0] / 0.05).round() * 0.05, sensed.force[0]);
    let short = |seed| served(&Scenario { duration_s: 0.2, seed, ..noisy.clone() }).samples;
    assert!(short(1) == run.samples[..200] && short(2) != run.samples[..200]);
}

#[test]
fn arm_comes_to_rest_during_an_outage_and_continues_afterwards() {
    for mode in [CallMode::Session, CallMode::Stateless] {
        let run = run_in(&scenario("lossy_line"), mode);
        let lost = run.samples.iter().filter(|s| !s.answered).count();
        // Answers are up to ten periods late, if a second late answer follows the first.
        let ages_are_valid = run.samples.iter().all(|s| if s.answered { s.answer_age <= 10 } else { s.answer_age > 0 });
        assert!(lost > 600 && ages_are_valid, "{lost}");
        let outage = between(&run, 2.0, 2.5);
        assert!(outage.iter().all(|s| !s.answered));
        // Valid for 100 ms from 1.999 s on, then slower in each period, at rest before the end.
        let (held, ramp) = outage.split_at(99);
        assert!(held.iter().all(|s| s.joint_velocity == held[0].joint_velocity) && speed(&held[0]) > 0.01);
        assert!(ramp.is_sorted_by(|a, b| speed(a) >= speed(b)) && speed(ramp.last().unwrap()) == 0.0);
        let last = run.samples.last().unwrap();
        let expected = 0.1 * (2.0 * last.time_s).sin();
        assert!((last.position_error[1] - expected).abs() < 0.05, "{} {expected}", last.position_error[1]);
    }
}

/// With a lag, the velocity changes within a period, which matters for a wall with inertia.
#[test]
fn error_is_proportional_to_the_length_of_the_substeps() {
    let mut heavy = Scenario { duration_s: 1.0, ..scenario("stiff_wall_lag_damped") };
    heavy.contacts[0].offset_m = 0.01;
    heavy.contacts[0].damping = 50.0;
    heavy.contacts[0].inertia = 0.5;
    let forces = |substeps| served(&Scenario { substeps, ..heavy.clone() }).samples.into_iter().map(|s| s.force[0]);
    let finest: Vec<f64> = forces(256).collect();
    assert!(finest.iter().copied().fold(0.0, f64::max) > 60.0);
    let errors = [1, 4, 16]
        .map(|substeps| forces(substeps).zip(&finest).map(|(coarse, fine)| (coarse - fine).abs()).fold(0.0, f64::max));
    assert!(errors[0] < 0.3 && errors.windows(2).all(|pair| (3.0..6.0).contains(&(pair[0] / pair[1]))), "{errors:?}");
}
