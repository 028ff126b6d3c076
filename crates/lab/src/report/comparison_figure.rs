//! One figure with all runs of a scenario.

use super::comparison::{REVERSE_PRIORITY, group_coinciding};
use super::figure::{Colour, Curve, Figure, Stroke};
use super::time_series::{AXES, MM, is_zero, panel, points, span};
use crate::metrics::main_axis;
use crate::simulator::recording::{Recording, Sample};

const COLOURS: [Colour; 5] = [Colour::Blue, Colour::Orange, Colour::Green, Colour::Vermillion, Colour::SkyBlue];
/// Largest number of tasks whose residuals are drawn.
const MAX_TASKS: usize = 3;

/// Value of a sample, if the sample has it.
type Measure = Box<dyn Fn(&Sample) -> Option<f64>>;

/// Content of a panel.
struct Quantity {
    heading: String,
    y_label: String,
    value: Measure,
    with_target: Option<usize>,
}

/// Returns forces, distance, residuals and joint speed of all runs. Runs with the same commands share a curve. Returns
/// `None` for fewer than two runs, or without samples.
#[must_use]
pub fn of_scenario(runs: &[&Recording]) -> Option<Figure> {
    let first = runs.iter().find(|run| !run.samples.is_empty())?;
    if runs.len() < 2 {
        return None;
    }
    let mut groups = group_coinciding(runs);
    // Reverse priority is drawn first, with the widest line.
    groups.sort_by_key(|group| !group.iter().any(|run| run.method == REVERSE_PRIORITY));
    let end = runs.iter().map(|run| span(run).1).fold(0.0, f64::max);
    let drawn = quantities(first).into_iter().map(|quantity| {
        let curves = curves(&groups, &quantity);
        (quantity, curves)
    });
    let panels = drawn.filter(|(_, curves)| !is_zero(curves)).enumerate().map(|(i, (quantity, curves))| {
        let heading = format!("({}) {}", char::from(b'a' + u8::try_from(i).unwrap_or(0)), quantity.heading);
        panel(&heading, &quantity.y_label, (0.0, end), curves)
    });
    let name = first.scenario.replace('_', " ");
    Some(Figure {
        name: format!("comparison_{}", first.scenario),
        title: format!("{name}: {} runs side by side", runs.len()),
        caption: format!(
            "The runs of {name} side by side. Runs whose commands differ by at most 1e-9 rad/s share a curve. The \
             residual of a task is ‖J q̇ − ẋ‖, the part of its velocity that the command does not achieve. Quantities that \
             are zero in all runs are not drawn."
        ),
        panels: panels.collect(),
    })
}

fn quantities(run: &Recording) -> Vec<Quantity> {
    let quantity = |heading: String, y_label: &str, value: Measure| Quantity {
        heading,
        y_label: y_label.to_owned(),
        value,
        with_target: None,
    };
    let first = &run.samples[0];
    let has_force = |axis: &usize| {
        first.target_force[*axis].is_some() || run.samples.iter().any(|sample| sample.force[*axis] != 0.0)
    };
    let mut quantities: Vec<Quantity> = (0..AXES.len())
        .filter(has_force)
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
            format!("Displacement of the tool along {}", AXES[axis]),
            "displacement (mm)",
            Box::new(move |sample| Some(MM * sample.position_error[axis])),
        ),
    });
    quantities.extend((0..first.residual_norms.len().min(MAX_TASKS)).map(|k| {
        quantity(
            format!("Residual of task {}", k + 1),
            "residual (m/s, rad/s)",
            Box::new(move |sample| sample.residual_norms.get(k).copied()),
        )
    }));
    let fastest = |sample: &Sample| sample.joint_velocity.iter().map(|v| v.abs()).reduce(f64::max);
    quantities.push(quantity("Speed of the fastest joint".to_owned(), "speed (rad/s)", Box::new(fastest)));
    quantities
}

fn curves(groups: &[Vec<&Recording>], quantity: &Quantity) -> Vec<Curve> {
    let mut curves: Vec<Curve> = groups
        .iter()
        .enumerate()
        .map(|(i, group)| Curve {
            label: label(group),
            colour: COLOURS[i % COLOURS.len()],
            stroke: stroke(i),
            points: points(group[0], &quantity.value),
        })
        .collect();
    if let Some(axis) = quantity.with_target {
        let target = points(groups[0][0], |sample| sample.target_force[axis]);
        let curve = Curve { label: "target".to_owned(), colour: Colour::Black, stroke: Stroke::Dashed, points: target };
        curves.extend((!curve.points.is_empty()).then_some(curve));
    }
    curves
}

/// Returns a wide line, then a thin one, then dashes, so that all of them are visible where they coincide.
const fn stroke(group: usize) -> Stroke {
    match group {
        0 => Stroke::Wide,
        1 => Stroke::Thin,
        _ => Stroke::Dashed,
    }
}

/// Returns methods and solvers of runs that coincide: `reverse priority (closed form, qp) = pseudoinverse (qp)`.
fn label(group: &[&Recording]) -> String {
    let words = |word: String| word.replace('_', " ");
    let methods = group.chunk_by(|a, b| a.method == b.method);
    let method = |runs: &[&Recording]| {
        let solvers: Vec<String> = runs.iter().map(|run| words(run.solver.to_string())).collect();
        format!("{} ({})", words(runs[0].method.to_string()), solvers.join(", "))
    };
    methods.map(method).collect::<Vec<_>>().join(" = ")
}
