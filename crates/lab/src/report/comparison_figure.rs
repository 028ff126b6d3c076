//! The runs of one scenario in one picture.

use super::experiment::coinciding;
use super::figure::{Colour, Curve, Figure, Panel, Stroke, TIME};
use super::metrics::main_axis;
use crate::simulator::recording::{Recording, Sample};

const AXES: [&str; 3] = ["x", "y", "z"];
const MM: f64 = 1e3;
const COLOURS: [Colour; 5] = [Colour::Orange, Colour::Blue, Colour::Green, Colour::Vermillion, Colour::SkyBlue];
/// Tasks whose residuals are drawn.
const TASKS: usize = 3;

/// What a sample says, if it says it.
type Measure = Box<dyn Fn(&Sample) -> Option<f64>>;

/// What a panel shows: heading, vertical axis, and its value in a sample.
struct Quantity {
    heading: String,
    y_label: String,
    of: Measure,
    with_target: Option<usize>,
}

/// Forces, way, residuals and joint speed of all runs; runs that command the same share a curve. `None` without two
/// runs that have samples.
#[must_use]
pub fn of_scenario(runs: &[&Recording]) -> Option<Figure> {
    let first = runs.iter().find(|run| !run.samples.is_empty())?;
    if runs.len() < 2 {
        return None;
    }
    let groups = coinciding(runs);
    let panels = quantities(first).into_iter().enumerate().map(|(i, quantity)| {
        let heading = format!("({}) {}", char::from(b'a' + u8::try_from(i).unwrap_or(0)), quantity.heading);
        Panel {
            heading,
            x_label: TIME.to_owned(),
            y_label: quantity.y_label.clone(),
            window: (0.0, longest(runs)),
            y_covers: Vec::new(),
            curves: curves(&groups, &quantity),
        }
    });
    let name = first.scenario.replace('_', " ");
    Some(Figure {
        name: format!("comparison_{}", first.scenario),
        title: format!("{name}: {} runs side by side", runs.len()),
        caption: format!(
            "The runs of {name} side by side. Runs whose commands differ by at most 1e-9 rad/s share a curve. Residuals \
             are ‖J q̇ − ẋ‖, what the command lacks of a task's velocity."
        ),
        panels: panels.collect(),
    })
}

fn quantities(run: &Recording) -> Vec<Quantity> {
    let quantity = |heading: String, y_label: &str, of: Measure| Quantity {
        heading,
        y_label: y_label.to_owned(),
        of,
        with_target: None,
    };
    let first = &run.samples[0];
    let pressed = |axis: &usize| {
        first.target_force[*axis].is_some() || run.samples.iter().any(|sample| sample.force[*axis] != 0.0)
    };
    let mut quantities: Vec<Quantity> = (0..AXES.len())
        .filter(pressed)
        .map(|axis| Quantity {
            with_target: Some(axis),
            ..quantity(
                format!("Force F_{} on the environment", AXES[axis]),
                "force (N)",
                Box::new(move |sample| Some(sample.force[axis])),
            )
        })
        .collect();
    let axis = main_axis(run);
    quantities.push(match first.wall_distance {
        Some(_) => {
            let distance = |sample: &Sample| sample.wall_distance.map(|distance| MM * distance);
            quantity("Distance to the wall, negative in contact".to_owned(), "distance (mm)", Box::new(distance))
        }
        None => quantity(
            format!("Way of the tool along {}", AXES[axis]),
            "displacement (mm)",
            Box::new(move |sample| Some(MM * sample.position_error[axis])),
        ),
    });
    quantities.extend((0..first.residual_norms.len().min(TASKS)).map(|k| {
        quantity(
            format!("What task {} lacks", k + 1),
            "residual (m/s, rad/s)",
            Box::new(move |sample| sample.residual_norms.get(k).copied()),
        )
    }));
    let fastest = |sample: &Sample| sample.joint_velocity.iter().map(|v| v.abs()).reduce(f64::max);
    quantities.push(quantity("Speed of the fastest joint".to_owned(), "speed (rad/s)", Box::new(fastest)));
    quantities
}

fn curves(groups: &[Vec<&Recording>], quantity: &Quantity) -> Vec<Curve> {
    let points = |run: &Recording, of: &dyn Fn(&Sample) -> Option<f64>| {
        run.samples.iter().filter_map(|sample| Some((sample.time_s, of(sample)?))).collect()
    };
    let mut curves: Vec<Curve> = groups
        .iter()
        .enumerate()
        .map(|(i, group)| Curve {
            label: label(group),
            colour: COLOURS[i % COLOURS.len()],
            stroke: stroke(i),
            points: points(group[0], &quantity.of),
        })
        .collect();
    if let Some(axis) = quantity.with_target {
        let target = points(groups[0][0], &|sample| sample.target_force[axis]);
        let curve = Curve { label: "target".to_owned(), colour: Colour::Black, stroke: Stroke::Dashed, points: target };
        curves.extend((!curve.points.is_empty()).then_some(curve));
    }
    curves
}

/// A broad line, a fine one over it, then dashes: all of them show where they coincide.
const fn stroke(group: usize) -> Stroke {
    match group {
        0 => Stroke::Wide,
        1 => Stroke::Thin,
        _ => Stroke::Dashed,
    }
}

/// Methods and solvers of runs that coincide: `reverse priority (closed form, qp) = pseudoinverse (qp)`.
fn label(group: &[&Recording]) -> String {
    let words = |word: String| word.replace('_', " ");
    let methods = group.chunk_by(|a, b| a.method == b.method);
    let method = |runs: &[&Recording]| {
        let solvers: Vec<String> = runs.iter().map(|run| words(run.solver.to_string())).collect();
        format!("{} ({})", words(runs[0].method.to_string()), solvers.join(", "))
    };
    methods.map(method).collect::<Vec<_>>().join(" = ")
}

/// End of the longest run, s.
fn longest(runs: &[&Recording]) -> f64 {
    let ends = runs.iter().filter_map(|run| Some(run.samples.last()?.time_s + run.period_s));
    ends.fold(0.0, f64::max)
}
