//! One figure with the most important quantities of a run.

use super::answer_gap;
use super::figure::{Colour, Curve, Figure, Stroke};
use super::time_series::{MM, is_zero, panel, points, span};
use crate::simulator::recording::{Contacts, Recording, Sample};

const AXES: [(&str, Colour); 3] = [("x", Colour::Orange), ("y", Colour::Blue), ("z", Colour::Green)];

/// Returns forces with their targets, displacement of the tool, and residuals of the tasks over time. Quantities that are
/// zero during the whole run are not drawn.
pub fn of_run(run: &Recording) -> Figure {
    let window = span(run);
    let mut quantities = vec![
        ("Force along the normal", "force (N)", contact(run), "Measured force along the normal that the law follows."),
        ("Force on the environment", "force (N)", forces(run), "Measured force; its target, if any, is dashed."),
        ("Displacement of the tool", "displacement (mm)", displacements(run), "Tool position minus start position."),
        (
            "Residual of each task",
            "residual (m/s, rad/s)",
            residuals(run),
            "‖J q̇ − ẋ‖ of each task, highest priority first.",
        ),
    ];
    if let Some(curves) = answer_gap::curves(run) {
        let heading = "Joint speed without answers";
        quantities.push((heading, "joint speed (rad/s)", curves, "Largest commanded joint speed."));
    }
    quantities.retain(|(_, _, curves, _)| !is_zero(curves));
    let (mut panels, mut caption) = (Vec::new(), Vec::new());
    for (letter, (heading, y_label, curves, meaning)) in ('a'..).zip(quantities) {
        panels.push(panel(&format!("({letter}) {heading}"), y_label, window, curves));
        caption.push(format!("({letter}) {meaning}"));
    }
    Figure {
        name: run.label(),
        title: format!("{}, {}, {}", run.scenario, run.method, run.solver).replace('_', " "),
        caption: caption.join(" "),
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

/// Returns the force of a law that follows a surface; without one, zeros.
fn contact(run: &Recording) -> Vec<Curve> {
    let of = |sample: &Sample, of: fn(&Contacts) -> &Vec<f64>| {
        let follows = sample.contacts.surface.is_followed();
        follows.then(|| of(&sample.contacts).first().copied()).flatten()
    };
    let force = |sample: &Sample| of(sample, |contacts| &contacts.force);
    let target = |sample: &Sample| of(sample, |contacts| &contacts.target_force);
    vec![
        curve(run, "F_n".to_owned(), Colour::Orange, Stroke::Thin, force),
        curve(run, "target".to_owned(), Colour::Black, Stroke::Dashed, target),
    ]
}

fn displacements(run: &Recording) -> Vec<Curve> {
    let displacement = |(i, (axis, colour)): (usize, &(&str, Colour))| {
        curve(run, (*axis).to_owned(), *colour, Stroke::Thin, move |sample| Some(MM * sample.position_error[i]))
    };
    AXES.iter().enumerate().map(displacement).collect()
}

fn residuals(run: &Recording) -> Vec<Curve> {
    let tasks = run.samples.first().map_or(0, |sample| sample.residual_norms.len());
    let colours = [Colour::Orange, Colour::Blue, Colour::Green, Colour::Vermillion, Colour::SkyBlue];
    let task = |(k, colour): (usize, &Colour)| {
        curve(run, format!("task {}", k + 1), *colour, Stroke::Thin, move |s| s.residual_norms.get(k).copied())
    };
    (0..tasks).zip(colours.iter().cycle()).map(task).collect()
}

fn curve(
    run: &Recording,
    label: String,
    colour: Colour,
    stroke: Stroke,
    value: impl Fn(&Sample) -> Option<f64>,
) -> Curve {
    Curve { label, colour, stroke, points: points(run, value) }
}
