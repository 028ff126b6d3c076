//! One run at a glance.

use super::figure::{Colour, Curve, Figure, Panel, Stroke, TIME};
use super::silence;
use crate::simulator::recording::{Recording, Sample};

const AXES: [(&str, Colour); 3] = [("x", Colour::Orange), ("y", Colour::Blue), ("z", Colour::Green)];
const MM: f64 = 1e3;

/// Forces with their targets, the tool's way, and what each task lacks, over time.
pub fn of_run(run: &Recording) -> Figure {
    let mut panels = vec![
        panel(run, "(a) Force on the environment", "force (N)", forces(run)),
        panel(run, "(b) Way of the tool from its start", "displacement (mm)", displacements(run)),
        panel(run, "(c) What each task lacks", "residual (m/s, rad/s)", residuals(run)),
    ];
    let mut caption =
        "(a) Measured force and, dashed, its target where there is one. (b) Tool position minus start position. \
                       (c) ‖J q̇ − ẋ‖ of each task, highest priority first."
            .to_owned();
    if let Some(curves) = silence::curves(run) {
        panels.push(panel(run, "(d) What the arm does without answers", "joint speed (rad/s)", curves));
        caption += " (d) Largest commanded joint speed.";
    }
    Figure {
        name: run.label(),
        title: format!("{}, {}, {}", run.scenario, run.method, run.solver).replace('_', " "),
        caption,
        panels,
    }
}

fn forces(run: &Recording) -> Vec<Curve> {
    let measured = AXES.iter().enumerate().map(|(i, (axis, colour))| {
        let stroke = if i == 0 { Stroke::Wide } else { Stroke::Thin };
        curve(run, format!("F_{axis}"), *colour, stroke, |sample| Some(sample.force[i]))
    });
    let has_target = |i: &usize| run.samples.first().is_some_and(|sample| sample.target_force[*i].is_some());
    let targets = (0..AXES.len()).filter(has_target).map(|i| {
        curve(run, format!("target, {}", AXES[i].0), Colour::Black, Stroke::Dashed, |sample| sample.target_force[i])
    });
    measured.chain(targets).collect()
}

fn displacements(run: &Recording) -> Vec<Curve> {
    let way = |(i, (axis, colour)): (usize, &(&str, Colour))| {
        curve(run, (*axis).to_owned(), *colour, Stroke::Thin, move |sample| Some(MM * sample.position_error[i]))
    };
    AXES.iter().enumerate().map(way).collect()
}

fn residuals(run: &Recording) -> Vec<Curve> {
    let tasks = run.samples.first().map_or(0, |sample| sample.residual_norms.len());
    let colours = [Colour::Orange, Colour::Blue, Colour::Green, Colour::Vermillion, Colour::SkyBlue];
    let task = |(k, colour): (usize, &Colour)| {
        curve(run, format!("task {}", k + 1), *colour, Stroke::Thin, move |s| s.residual_norms.get(k).copied())
    };
    (0..tasks).zip(colours.iter().cycle()).map(task).collect()
}

fn curve(run: &Recording, label: String, colour: Colour, stroke: Stroke, of: impl Fn(&Sample) -> Option<f64>) -> Curve {
    let points = run.samples.iter().filter_map(|sample| Some((sample.time_s, of(sample)?))).collect();
    Curve { label, colour, stroke, points }
}

fn panel(run: &Recording, heading: &str, y_label: &str, curves: Vec<Curve>) -> Panel {
    let time = |sample: Option<&Sample>| sample.map_or(0.0, |sample| sample.time_s);
    let window = (time(run.samples.first()), time(run.samples.last()) + run.period_s);
    Panel {
        heading: heading.to_owned(),
        x_label: TIME.to_owned(),
        y_label: y_label.to_owned(),
        window,
        y_covers: Vec::new(),
        curves,
    }
}
