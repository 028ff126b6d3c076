//! The paper's Figures 5 to 8, made from recordings.

use revprio_api::wire::{Method, Solver};

use super::figure::{Colour, Curve, Figure, Panel, Stroke, TIME};
use super::metrics::{Metrics, evaluation_start, force_error};
use super::number::significant;
use crate::simulator::recording::{Recording, Sample};

/// The paper's contribution.
pub const REVERSE_PRIORITY: Method = Method::ReversePriority;
/// The classical control it is compared with.
pub const CLASSICAL: Method = Method::DampedLeastSquares;

/// How long before and after the first contact the impact panel reaches (s).
const IMPACT: (f64, f64) = (0.05, 1.0);
const MM: f64 = 1e3;

/// Where the runs of a figure start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Posture {
    /// Well inside the arm's limits: `force_tracking`, `stiff_wall`.
    Nominal,
    /// Next to a singularity: `force_tracking_singular`, `stiff_wall_singular`.
    Singular,
}

impl Posture {
    /// `nominal` or `singular`, as in the names of the figures.
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

/// The figures that the recordings of a posture suffice for, in the paper's order. Of several
/// solvers of one method, the closed form is drawn.
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
    runs.min_by_key(|r| r.solver != Solver::ClosedForm)
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
        points: over_time(run, of),
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
    let judged = evaluation_start(run).unwrap_or(start);
    let distance = forces[0].largest_distance(&forces[1]);
    Figure {
        name: format!("figure{number}_{}", posture.name()),
        title: title(number, &format!("Tracking force, {control}"), posture),
        caption: format!(
            "Figure {number}, {} posture. Tracking force under {control}; F_x and F_y {}. (b) begins \
             where the RMSE does.",
            posture.name(),
            apart(distance, "N")
        ),
        panels: vec![
            panel("(a) Force on the environment", "force (N)", (start, end), forces),
            panel(
                &format!("(b) Force error from {} s on", significant(judged, 2)),
                "force error (N)",
                (judged, end),
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
        points: over_time(reverse, &|s| s.target_force[0]),
    });
    let (start, end) = span(reverse);
    let measured = [classical, reverse].map(Metrics::of);
    let first_contact = measured.iter().filter_map(|m| m.first_contact_s).reduce(f64::min);
    let impact = first_contact.map(|t| {
        let window = ((t - IMPACT.0).max(start), (t + IMPACT.1).min(end));
        panel("(b) The impact", "force F_x (N)", window, curves.clone())
    });
    let whole = panel("(a) The whole run", "force F_x (N)", (start, end), curves);
    Figure {
        name: format!("figure7_{}", posture.name()),
        title: title(7, "Contact force at the stiff wall", posture),
        caption: format!(
            "Figure 7, {} posture. Contact force F_x at the stiff wall. Case 1 {}; case 2 {}. The \
             two {}.",
            posture.name(),
            touch(&measured[0]),
            touch(&measured[1]),
            apart(distance, "N")
        ),
        panels: std::iter::once(whole).chain(impact).collect(),
    }
}

/// Figure 8; `None` without a wall.
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
            "Figure 8, {} posture. (a) Distance to the wall, positive when free; (b, c) errors of \
             the lower-priority hold. In x the two cases {x_apart}, in y they {y_apart}, in z \
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

/// Case 1 and case 2 of the paper, drawn so that both are seen where they coincide.
fn cases(classical: &Recording, reverse: &Recording, of: impl Fn(&Sample) -> Option<f64>) -> Vec<Curve> {
    let curve = |label: &str, colour, stroke, run| Curve {
        label: label.to_owned(),
        colour,
        stroke,
        points: over_time(run, &of),
    };
    vec![
        curve("case 1: classical control", Colour::Orange, Stroke::Wide, classical),
        curve("case 2: reverse priority", Colour::Blue, Stroke::Thin, reverse),
    ]
}

/// Gives the panels of two figures the same vertical scales, so that they compare at a glance.
fn share_scales(a: &mut Figure, b: &mut Figure) {
    for (a, b) in a.panels.iter_mut().zip(&mut b.panels) {
        let ((low_a, high_a), (low_b, high_b)) = (a.y_extent(), b.y_extent());
        a.y_covers = vec![low_b, high_b];
        b.y_covers = vec![low_a, high_a];
    }
}

/// How far two coinciding curves are from each other, as a predicate.
fn apart(distance: f64, unit: &str) -> String {
    if distance > 0.0 {
        format!("are at most {} {unit} apart", significant(distance, 2))
    } else {
        "coincide exactly".to_owned()
    }
}

/// What happened at the wall, as a predicate.
fn touch(metrics: &Metrics) -> String {
    metrics.first_contact_s.map_or_else(
        || "does not reach it".to_owned(),
        |time| {
            let (time, peak) = (significant(time, 3), significant(metrics.peak_force, 3));
            format!("touches it after {time} s and peaks at {peak} N")
        },
    )
}

fn title(number: u8, subject: &str, posture: Posture) -> String {
    format!("Figure {number} · {subject} ({} posture)", posture.name())
}

fn panel(heading: &str, y_label: &str, window: (f64, f64), curves: Vec<Curve>) -> Panel {
    let (heading, y_label) = (heading.to_owned(), y_label.to_owned());
    Panel { heading, x_label: TIME.to_owned(), y_label, window, y_covers: vec![], curves }
}

fn over_time(run: &Recording, of: &dyn Fn(&Sample) -> Option<f64>) -> Vec<(f64, f64)> {
    run.samples.iter().filter_map(|s| Some((s.time_s, of(s)?))).collect()
}

/// First instant of a run and the end of its last period (s).
fn span(run: &Recording) -> (f64, f64) {
    let time = |sample: Option<&Sample>| sample.map_or(0.0, |s| s.time_s);
    (time(run.samples.first()), time(run.samples.last()) + run.period_s)
}

#[cfg(test)]
mod tests;
