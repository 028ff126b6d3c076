//! Which recordings give which figures, and whether texts fit into the picture.

use revprio_api::wire::Solver;

use super::*;
use crate::report::drawing;
use crate::report::sheet::{MARGIN, TITLE_EM, WIDTH};
use crate::report::typeface;

/// A run of 2 s with a force of `peak` N in one sample in the middle.
fn run(scenario: &str, method: Method, solver: Solver, peak: f64) -> Recording {
    let samples = (0..2000).map(|i| sample(i, if i == 1000 { peak } else { 0.0 })).collect();
    Recording { scenario: scenario.to_owned(), method, solver, samples, ..Recording::empty() }
}

fn sample(index: i32, force: f64) -> Sample {
    Sample {
        time_s: 1e-3 * f64::from(index),
        position_error: [0.0, 0.002, 0.0],
        force: [force, 0.0, 0.0],
        target_force: [Some(30.0), Some(30.0), None],
        wall_distance: Some(if force > 0.0 { -1e-3 } else { 0.05 }),
        ..Sample::at_rest()
    }
}

fn all_runs(suffix: &str) -> Vec<Recording> {
    let scenarios = ["force_tracking", "stiff_wall"].map(|name| format!("{name}{suffix}"));
    let pairs = scenarios.iter().flat_map(|s| [(s, CLASSICAL, 200.0), (s, REVERSE_PRIORITY, 240.0)]);
    pairs.map(|(scenario, method, peak)| run(scenario, method, Solver::ClosedForm, peak)).collect()
}

fn figures(posture: Posture, recordings: &[Recording]) -> Vec<Figure> {
    of_posture(posture, &recordings.iter().collect::<Vec<_>>())
}

fn names(posture: Posture, recordings: &[Recording]) -> Vec<String> {
    figures(posture, recordings).into_iter().map(|figure| figure.name).collect()
}

#[test]
fn each_posture_has_the_four_figures_of_the_paper() {
    let recordings = all_runs("_singular");
    let expected = ["figure5_singular", "figure6_singular", "figure7_singular", "figure8_singular"];
    assert_eq!(names(Posture::Singular, &recordings), expected);
    assert!(names(Posture::Nominal, &recordings).is_empty());
}

#[test]
fn figures_without_recordings_are_left_out() {
    let mut recordings = all_runs("");
    recordings.retain(|r| r.method == REVERSE_PRIORITY);
    assert_eq!(names(Posture::Nominal, &recordings), ["figure5_nominal"]);
}

#[test]
fn closed_form_is_drawn_if_it_was_run() {
    let qp = run("force_tracking", REVERSE_PRIORITY, Solver::Qp, 1.0);
    let closed_form = run("force_tracking", REVERSE_PRIORITY, Solver::ClosedForm, 2.0);
    let figures = of_posture(Posture::Nominal, &[&qp, &closed_form]);
    assert_eq!(figures[0].panels[0].y_extent(), (0.0, 30.0));
    assert!(figures[0].panels[0].curves[0].points.contains(&(1.0, 2.0)));
}

#[test]
fn figures_five_and_six_share_their_scales() {
    let figures = figures(Posture::Nominal, &all_runs(""));
    for (five, six) in figures[0].panels.iter().zip(&figures[1].panels) {
        assert_eq!(five.y_extent(), six.y_extent());
    }
    assert_eq!(figures[0].panels[0].y_extent(), (0.0, 240.0));
}

#[test]
fn the_impact_panel_surrounds_the_first_contact() {
    let figures = figures(Posture::Nominal, &all_runs(""));
    let (from, to) = figures[2].panels[1].window;
    assert!((from - 0.95).abs() < 1e-12 && (to - 2.0).abs() < 1e-12);
}

#[test]
fn captions_state_distances_and_contacts() {
    let mut recordings = all_runs("");
    recordings.iter_mut().filter(|r| r.method == CLASSICAL).for_each(|r| {
        r.samples.iter_mut().for_each(|s| (s.force[0], s.wall_distance) = (0.0, Some(0.05)));
    });
    let figures = figures(Posture::Nominal, &recordings);
    assert!(figures[2].caption.contains("Under classical control the tool does not reach it"));
    assert!(figures[2].caption.contains("under reverse priority it touches it at 1.00 s and peaks at 240 N"));
    assert!(figures[2].caption.contains("at most 240 N apart"));
    assert!(figures[3].caption.contains("in y they coincide exactly"));
}

#[test]
fn every_title_and_heading_fits_into_the_picture() {
    typeface::register().unwrap();
    let available = i32::try_from(WIDTH).unwrap() - 2 * i32::try_from(MARGIN).unwrap();
    for figure in figures(Posture::Singular, &all_runs("_singular")) {
        assert!(typeface::width(&figure.title, TITLE_EM) < available, "{}", figure.title);
        assert!(figure.panels.iter().all(|p| typeface::width(&p.heading, 13.0) < available));
    }
}

#[test]
fn drawing_is_small_and_keeps_indices_and_spikes() {
    let figures = figures(Posture::Nominal, &all_runs(""));
    let svg = drawing::svg(&figures[2]).unwrap();
    assert!(svg.len() < 200_000);
    assert!(svg.contains(r#"F<tspan dy="0.3em" font-size="72%">x</tspan>"#));
    assert!(svg.contains(">\n250\n<"), "the axis reaches the spike of 240 N");
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
}

#[test]
fn run_without_samples_gives_empty_figures() {
    let mut recordings = all_runs("");
    for run in &mut recordings {
        run.samples.clear();
    }
    let figures = figures(Posture::Nominal, &recordings);
    assert_eq!(figures.len(), 3, "figure 8 needs a wall");
    assert!(figures.iter().all(|figure| drawing::svg(figure).is_ok()));
}
