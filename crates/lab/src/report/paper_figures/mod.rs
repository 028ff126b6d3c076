//! Figures 5 to 8 of the paper, from recordings.

use revprio_api::wire::Method;

use super::comparison::{CLASSICAL, REVERSE_PRIORITY, solver_preference};
use super::figure::{Colour, Curve, Figure, Stroke};
use super::time_series::{MM, panel, points, span};
use crate::metrics::{Metrics, evaluation_start, force_error};
use crate::number::significant;
use crate::simulator::recording::{Recording, Sample};

/// Time before and after the first contact that the impact panel shows (s).
const IMPACT_WINDOW: (f64, f64) = (0.05, 1.0);

/// Start posture of the runs of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Posture {
    /// Well inside the arm's limits: `force_tracking`, `stiff_wall`.
    Nominal,
    /// Next to a singularity: `force_tracking_singular`, `stiff_wall_singular`.
    Singular,
}

impl Posture {
    /// Returns `nominal` or `singular`, as in the names of the figures.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nominal => "nominal",
            Self::Singular => "singular",
        }
    }

    fn scenario(self, scenario: &str) -> String {
        match self {
            Self::Nominal => scenario.to_owned(),
            Self::Singular => format!("{scenario}_singular"),
        }
    }
}

/// Returns the figures for which the recordings suffice, in the order of the paper. If a method was run with several
/// solvers, the closed form is drawn.
#[must_use]
pub fn of_posture(posture: Posture, recordings: &[&Recording]) -> Vec<Figure> {
    let find = |scenario: &str, method| pick(recordings, &posture.scenario(scenario), method);
    let tracking = (find("force_tracking", CLASSICAL), find("force_tracking", REVERSE_PRIORITY));
    let wall = (find("stiff_wall", CLASSICAL), find("stiff_wall", REVERSE_PRIORITY));
    let mut figures = tracking_figures(posture, tracking.0, tracking.1);
    if let (Some(classical), Some(reverse)) = wall {
        figures.push(contact_force(posture, classical, reverse));
        figures.extend(position_errors(posture, classical, reverse));
    }
    figures
}

fn pick<'a>(recordings: &[&'a Recording], scenario: &str, method: Method) -> Option<&'a Recording> {
    let runs = recordings.iter().copied().filter(|r| r.scenario == scenario && r.method == method);
    runs.min_by_key(|run| solver_preference(run))
}

fn tracking_figures(posture: Posture, classical: Option<&Recording>, reverse: Option<&Recording>) -> Vec<Figure> {
    let figure = |number, control, run| tracking_force(posture, number, control, run);
    let mut fifth = reverse.map(|run| figure(5, "reverse priority control", run));
    let mut sixth = classical.map(|run| figure(6, "classical control", run));
    if let (Some(fifth), Some(sixth)) = (&mut fifth, &mut sixth) {
        let distance = fifth.panels[0].curves[0].largest_distance(&sixth.panels[0].curves[0]);
        let comparison = format!(" F_x here and in Figure 5 {}.", apart(distance, "N"));
        sixth.caption.push_str(&comparison);
        share_scales(fifth, sixth);
    }
    fifth.into_iter().chain(sixth).collect()
}

/// Figures 5 and 6.
fn tracking_force(posture: Posture, number: u8, control: &str, run: &Recording) -> Figure {
    let curve = |label: &str, colour, stroke, of: &dyn Fn(&Sample) -> Option<f64>| Curve {
        label: label.to_owned(),
        colour,
        stroke,
        points: points(run, of),
    };
    let forces = vec![
        curve("F_x (primary)", Colour::Orange, Stroke::Wide, &|s| Some(s.force[0])),
        curve("F_y", Colour::Blue, Stroke::Thin, &|s| Some(s.force[1])),
        curve("target F_d", Colour::Black, Stroke::Dashed, &|s| s.target_force[0]),
    ];
    let errors = vec![
        curve("F_x − F_d", Colour::Orange, Stroke::Wide, &|s| force_error(s, 0)),
        curve("F_y − F_d", Colour::Blue, Stroke::Thin, &|s| force_error(s, 1)),
    ];
    let (start, end) = span(run);
    let evaluated = evaluation_start(run).unwrap_or(start);
    let distance = forces[0].largest_distance(&forces[1]);
    Figure {
        name: format!("figure{number}_{}", posture.name()),
        title: title(number, &format!("Tracking force, {control}"), posture),
        caption: format!(
            "Figure {number}, {} posture. Tracking force under {control}; F_x and F_y {}. (b) shows the \
             part over which the RMSE is computed.",
            posture.name(),
            apart(distance, "N")
        ),
        panels: vec![
            panel("(a) Force on the environment", "force (N)", (start, end), forces),
            panel(
                &format!("(b) Force error from {} s on", significant(evaluated, 2)),
                "force error (N)",
                (evaluated, end),
                errors,
            ),
        ],
    }
}

/// Figure 7.
fn contact_force(posture: Posture, classical: &Recording, reverse: &Recording) -> Figure {
    let mut curves = cases(classical, reverse, |s| Some(s.force[0]));
    let distance = curves[0].largest_distance(&curves[1]);
    curves.push(Curve {
        label: "target F_d".to_owned(),
        colour: Colour::Black,
        stroke: Stroke::Dashed,
        points: points(reverse, |s| s.target_force[0]),
    });
    let (start, end) = span(reverse);
    let measured = [classical, reverse].map(Metrics::of);
    let first_contact = measured.iter().filter_map(|m| m.first_contact_s).reduce(f64::min);
    let impact = first_contact.map(|t| {
        let window = ((t - IMPACT_WINDOW.0).max(start), (t + IMPACT_WINDOW.1).min(end));
        panel("(b) Impact", "force F_x (N)", window, curves.clone())
    });
    let whole = panel("(a) Whole run", "force F_x (N)", (start, end), curves);
    Figure {
        name: format!("figure7_{}", posture.name()),
        title: title(7, "Contact force at the stiff wall", posture),
        caption: format!(
            "Figure 7, {} posture. Contact force F_x at the stiff wall. Under classical control the tool {}; \
             under reverse priority it {}. The two {}.",
            posture.name(),
            wall_result(&measured[0]),
            wall_result(&measured[1]),
            apart(distance, "N")
        ),
        panels: std::iter::once(whole).chain(impact).collect(),
    }
}

/// Figure 8; `None` if the scenario has no wall.
fn position_errors(posture: Posture, classical: &Recording, reverse: &Recording) -> Option<Figure> {
    reverse.samples.first()?.wall_distance?;
    let x = cases(classical, reverse, |s| s.wall_distance.map(|d| MM * d));
    let y = cases(classical, reverse, |s| Some(MM * s.position_error[1]));
    let z = cases(classical, reverse, |s| Some(MM * s.position_error[2]));
    let [x_apart, y_apart, z_apart] = [&x, &y, &z].map(|curves| apart(curves[0].largest_distance(&curves[1]), "mm"));
    let window = span(reverse);
    Some(Figure {
        name: format!("figure8_{}", posture.name()),
        title: title(8, "Position errors at the stiff wall", posture),
        caption: format!(
            "Figure 8, {} posture. (a) Distance to the wall, positive without contact; (b, c) errors of \
             the lower task. In x the two methods {x_apart}, in y they {y_apart}, in z \
             they {z_apart}.",
            posture.name()
        ),
        panels: vec![
            panel("(a) x: distance to the wall", "distance (mm)", window, x),
            panel("(b) y: position error", "error (mm)", window, y),
            panel("(c) z: position error", "error (mm)", window, z),
        ],
    })
}

/// Classical control and reverse priority, cases 1 and 2 of the paper. Reverse priority is drawn stronger; both are visible
/// where they coincide.
fn cases(classical: &Recording, reverse: &Recording, value: impl Fn(&Sample) -> Option<f64>) -> Vec<Curve> {
    let curve = |label: &str, colour, stroke, run| Curve {
        label: label.to_owned(),
        colour,
        stroke,
        points: points(run, &value),
    };
    vec![
        curve("reverse priority", Colour::Blue, Stroke::Wide, reverse),
        curve("classical control", Colour::Orange, Stroke::Thin, classical),
    ]
}

/// Gives the panels of two figures the same vertical scales, so that they can be compared.
fn share_scales(a: &mut Figure, b: &mut Figure) {
    for (a, b) in a.panels.iter_mut().zip(&mut b.panels) {
        let ((low_a, high_a), (low_b, high_b)) = (a.y_extent(), b.y_extent());
        a.y_covers = vec![low_b, high_b];
        b.y_covers = vec![low_a, high_a];
    }
}

/// Returns the largest distance of two curves as a predicate.
fn apart(distance: f64, unit: &str) -> String {
    if distance > 0.0 {
        format!("are at most {} {unit} apart", significant(distance, 2))
    } else {
        "coincide exactly".to_owned()
    }
}

/// Returns the result at the wall as a predicate.
fn wall_result(metrics: &Metrics) -> String {
    metrics.first_contact_s.map_or_else(
        || "does not reach it".to_owned(),
        |time| {
            let (time, peak) = (significant(time, 3), significant(metrics.peak_force, 3));
            format!("touches it at {time} s and peaks at {peak} N")
        },
    )
}

fn title(number: u8, subject: &str, posture: Posture) -> String {
    format!("Figure {number} · {subject} ({} posture)", posture.name())
}

#[cfg(test)]
mod tests;
