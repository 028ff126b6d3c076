//! Each metric on runs with known results.

use super::*;
use crate::simulator::recording::Contacts;

/// A sample at `time_s`, 10 cm in front of the wall, with a target of 30 N in x.
fn sample(time_s: f64) -> Sample {
    Sample {
        time_s,
        joint_position: vec![0.0; 2],
        joint_velocity: vec![0.0; 2],
        target_force: [Some(30.0), None, None],
        wall_distance: Some(0.1),
        ..Sample::at_rest()
    }
}

fn in_contact_with(time_s: f64, force_x: f64) -> Sample {
    Sample { force: [force_x, 0.0, 0.0], wall_distance: Some(-1e-4), ..sample(time_s) }
}

fn recording(samples: Vec<Sample>) -> Recording {
    Recording { period_s: 0.1, joint_names: vec!["a".to_owned(), "b".to_owned()], samples, ..Recording::empty() }
}

/// A run in contact, one sample every 0.1 s, with these values of `F_x`.
fn run_with_forces(forces: &[f64]) -> Recording {
    let times = (0..).map(|i| 0.1 * f64::from(i));
    recording(times.zip(forces).map(|(t, f)| in_contact_with(t, *f)).collect())
}

fn near(value: Option<f64>, expected: f64) -> bool {
    value.is_some_and(|v| (v - expected).abs() < 1e-12)
}

#[test]
fn losses_and_faults_are_counted_on_all_axes_with_the_law_contact() {
    use ContactEvent::{Approach, Contact, ForceLimit, Loss, None as Nothing, Stuck};
    let events = [[Contact, Nothing], [Loss, Contact], [Approach, Loss], [Stuck, ForceLimit], [Loss, Nothing]];
    let period = |event: [ContactEvent; 2]| {
        let contacts = Contacts { event: event.to_vec(), ..Contacts::approaching(2, 0) };
        Sample { contacts, ..sample(0.0) }
    };
    let run = recording(events.map(period).to_vec());
    assert_eq!(Metrics::of(&run).contact_failures, Some(ContactFailures { losses: 3, faults: 2 }));
    let without_law = recording(vec![in_contact_with(0.0, 30.0)]);
    assert_eq!(Metrics::of(&without_law).contact_failures, None);
}

#[test]
fn short_run_is_evaluated_from_the_first_contact() {
    let run = recording(vec![sample(0.0), in_contact_with(0.1, 33.0), in_contact_with(0.2, 26.0)]);
    assert!(near(Metrics::of(&run).rmse_fx, 12.5_f64.sqrt()));
}

#[test]
fn short_run_is_also_evaluated_while_contact_is_lost() {
    let run = recording(vec![in_contact_with(0.0, 30.0), sample(0.1)]);
    assert!(near(Metrics::of(&run).rmse_fx, 450.0_f64.sqrt()));
}

#[test]
fn long_run_is_evaluated_from_five_seconds() {
    let error = |t: f64| if t < 5.0 { 100.0 } else { 2.0 };
    let samples = (0..=22).map(|i| 0.5 * f64::from(i)).map(|t| in_contact_with(t, 30.0 + error(t)));
    assert!(near(Metrics::of(&recording(samples.collect())).rmse_fx, 2.0));
}

#[test]
fn run_of_exactly_ten_seconds_is_short() {
    let run = recording(vec![in_contact_with(0.0, 34.0), in_contact_with(10.0, 30.0)]);
    assert!(near(Metrics::of(&run).rmse_fx, 8.0_f64.sqrt()));
}

#[test]
fn axis_without_a_target_has_no_rmse() {
    let mut run = run_with_forces(&[30.0]);
    assert_eq!(Metrics::of(&run).rmse_fy, None);
    run.samples[0].target_force[1] = Some(3.0);
    assert!(near(Metrics::of(&run).rmse_fy, 3.0));
}

#[test]
fn run_without_contact_has_no_contact_metrics() {
    let metrics = Metrics::of(&recording(vec![sample(0.0), sample(1.0)]));
    assert_eq!(metrics.rmse_fx, None);
    assert_eq!(metrics.overshoot, None);
    assert_eq!(metrics.settling_time_s, None);
    assert_eq!(metrics.first_contact_s, None);
    assert_eq!(metrics.contacts, 0);
}

#[test]
fn empty_run_has_metrics() {
    let metrics = Metrics::of(&recording(vec![]));
    assert_eq!(metrics.final_force, None);
    assert_eq!(metrics.calls_per_second, Some(0.0));
}

#[test]
fn overshoot_is_relative_to_the_target_at_the_same_time() {
    let mut run = run_with_forces(&[240.0, 31.0]);
    run.samples[0].target_force[0] = Some(40.0);
    let expected = Overshoot { newton: 200.0, percent: 500.0 };
    assert_eq!(Metrics::of(&run).overshoot, Some(expected));
}

#[test]
fn force_below_its_target_does_not_overshoot() {
    let expected = Overshoot { newton: 0.0, percent: 0.0 };
    assert_eq!(Metrics::of(&run_with_forces(&[10.0, 29.0])).overshoot, Some(expected));
}

#[test]
fn negative_target_overshoots_in_negative_direction() {
    let mut run = run_with_forces(&[-33.0, -20.0]);
    run.samples.iter_mut().for_each(|s| s.target_force[0] = Some(-30.0));
    let expected = Overshoot { newton: 3.0, percent: 10.0 };
    assert_eq!(Metrics::of(&run).overshoot, Some(expected));
}

#[test]
fn settling_starts_after_the_last_sample_outside_the_band() {
    let run = run_with_forces(&[30.0, 31.6, 31.4, 28.6, 30.0, 30.0]);
    assert!(near(Metrics::of(&run).settling_time_s, 0.2));
}

#[test]
fn force_that_ends_outside_the_band_does_not_settle() {
    assert_eq!(Metrics::of(&run_with_forces(&[30.0, 30.0, 31.6])).settling_time_s, None);
}

#[test]
fn force_that_only_crosses_the_band_at_the_end_does_not_settle() {
    assert_eq!(Metrics::of(&run_with_forces(&[90.0, 0.0, 30.0])).settling_time_s, None);
}

#[test]
fn each_bounce_counts_as_a_contact() {
    let bounces = vec![
        sample(0.0),
        in_contact_with(0.1, 90.0),
        in_contact_with(0.2, 5.0),
        sample(0.3),
        in_contact_with(0.4, 30.0),
    ];
    let metrics = Metrics::of(&recording(bounces));
    assert_eq!(metrics.contacts, 2);
    assert_eq!(metrics.first_contact_s, Some(0.1));
    assert!(near(Some(metrics.peak_force), 90.0));
    assert!(near(metrics.final_force, 30.0));
}

#[test]
fn without_a_wall_a_force_counts_as_contact() {
    let mut run = run_with_forces(&[0.0, 1.0, 2.0]);
    run.samples.iter_mut().for_each(|s| s.wall_distance = None);
    assert!(near(Metrics::of(&run).first_contact_s, 0.1));
}

#[test]
fn speed_call_rate_and_paths_cover_all_samples() {
    let mut run = run_with_forces(&[30.0; 4]);
    run.samples[2].joint_velocity = vec![0.5, -1.5];
    run.samples[3].path = Path::Qp;
    let metrics = Metrics::of(&run);
    assert!(near(Some(metrics.max_joint_speed), 1.5));
    assert!(near(metrics.calls_per_second, 8.0));
    assert_eq!(metrics.paths[&Path::ClosedForm], 3);
    assert_eq!(metrics.paths[&Path::Qp], 1);
}

#[test]
fn steady_error_is_the_mean_of_the_last_tenth() {
    let mut forces = vec![90.0; 18];
    forces.extend([31.0, 30.5]);
    assert!(near(Metrics::of(&run_with_forces(&forces)).steady_error, 0.75));
    assert_eq!(Metrics::of(&recording(vec![sample(0.0)])).steady_error, None);
}

#[test]
fn residuals_are_computed_per_task() {
    let mut run = run_with_forces(&[30.0; 2]);
    run.samples[0].residual_norms = vec![0.0, 3.0];
    run.samples[1].residual_norms = vec![0.0, 4.0];
    let [first, second] = Metrics::of(&run).residuals[..] else { panic!("two tasks") };
    assert_eq!(first, Residual { rms: 0.0, largest: 0.0 });
    assert!(near(Some(second.rms), 12.5_f64.sqrt()) && second.largest == 4.0);
}

#[test]
fn metrics_can_be_computed_along_another_axis() {
    let mut run = run_with_forces(&[0.0; 3]);
    run.samples.iter_mut().for_each(|s| (s.force, s.target_force) = ([0.0, 0.0, -33.0], [None, None, Some(-30.0)]));
    assert_eq!(main_direction(&run), Direction::Base(2));
    let metrics = Metrics::along(&run, Direction::Base(2));
    assert!(near(metrics.final_force, -33.0) && near(Some(metrics.peak_force), 33.0) && near(metrics.rmse_fz, 3.0));
}

#[test]
fn statuses_and_missing_answers_are_counted_and_the_largest_kkt_residual_is_kept() {
    let mut run = run_with_forces(&[30.0; 3]);
    run.samples[1].status = Status::NotCertified;
    run.samples[1].kkt_residual = Some(1e-3);
    run.samples[2].answered = false;
    let metrics = Metrics::of(&run);
    assert_eq!(metrics.statuses, BTreeMap::from([(Status::Optimal, 1), (Status::NotCertified, 1)]));
    assert_eq!((metrics.largest_kkt_residual, metrics.unanswered), (Some(1e-3), 1));
}

#[test]
fn largest_difference_covers_samples_and_joints() {
    let a = run_with_forces(&[30.0; 3]);
    let mut b = a.clone();
    b.samples[1].joint_velocity = vec![0.25, -0.5];
    assert!(near(Some(largest_difference(&a, &b)), 0.5));
    assert!(near(Some(largest_difference(&a, &a)), 0.0));
}

#[test]
fn runs_that_cannot_be_compared_have_an_infinite_difference() {
    let a = run_with_forces(&[30.0; 3]);
    let mut other_joints = a.clone();
    other_joints.samples[0].joint_velocity.push(0.0);
    let mut not_a_number = a.clone();
    not_a_number.samples[0].joint_velocity[0] = f64::NAN;
    for b in [run_with_forces(&[30.0; 2]), other_joints, not_a_number] {
        assert!(largest_difference(&a, &b).is_infinite());
    }
}

/// The law presses with 20 N along a normal that it has learnt. F_z is smaller, and has no target.
#[test]
fn force_of_a_law_that_follows_a_surface_is_that_along_the_normal() {
    let pressed = |(i, force): (i32, &f64)| {
        let mut contacts = Contacts::approaching(1, 1);
        (contacts.force[0], contacts.target_force[0]) = (*force, 20.0);
        let no_target = Sample { target_force: [None; 3], contacts, ..in_contact_with(0.1 * f64::from(i), 0.0) };
        Sample { force: [0.0, 0.0, -0.9 * force], ..no_target }
    };
    let run = recording((0..).zip(&[21.0, 19.0, 22.0, 20.0, 20.0, 20.0]).map(pressed).collect());
    assert_eq!(main_direction(&run), Direction::Contact);
    let metrics = Metrics::along(&run, Direction::Contact);
    assert_eq!((metrics.peak_force, metrics.final_force), (22.0, Some(20.0)));
    assert!(near(metrics.rmse_contact, 1.0) && near(metrics.settling_time_s, 0.3), "{metrics:?}");
    assert_eq!((metrics.overshoot.unwrap().percent, metrics.rmse_fz), (10.0, None));
    assert_eq!(Metrics::of(&run).rmse_contact, None);
}
