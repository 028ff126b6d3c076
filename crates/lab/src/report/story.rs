//! The beginning of the page of the demo: the claim of the paper, a picture, and what it means.

use super::comparison::MethodPair;
use super::figure::{Colour, Curve, Figure, Panel, Stroke};
use super::run::Run;
use super::time_series::{MM, panel, points, span};
use crate::metrics::Metrics;
use crate::number::{significant, trimmed};
use crate::simulator::Scenario;
use crate::simulator::recording::{Recording, Sample};

/// Name of the scenario with the law `contact` in the plant of `stiff_wall`.
pub const CONTACT_LAW: &str = "stiff_wall_contact";

/// Time after the first contact that the impact panel shows, s.
const IMPACT_WINDOW: (f64, f64) = (-0.02, 0.3);

/// Horizontal axis of the impact panel.
const AFTER_TOUCH: &str = "time after the first contact (s)";

/// Time before the first contact over which the speed of the approach is measured, s.
const APPROACH_S: f64 = 0.02;

/// The claim, the picture, and what it means.
#[derive(Debug, Clone, PartialEq)]
pub struct Story {
    /// The claim and its result in one sentence.
    pub claim: String,
    /// The picture.
    pub figure: Figure,
    /// What it means, one paragraph each.
    pub meaning: Vec<String>,
}

/// Returns the story; `None` unless both methods ran both experiments at the stiff wall, unchanged and to their end.
#[must_use]
pub fn of_runs(runs: &[Run]) -> Option<Story> {
    let whole = |name: &str| Scenario::built_in(name)?.ok().map(|scenario| scenario.duration_s);
    let pair = |name: &str| {
        let runs = runs.chunk_by(|a, b| a.recording.scenario == b.recording.scenario);
        let pair = MethodPair::from_runs(runs.into_iter().find(|runs| runs[0].recording.scenario == name)?)?;
        let is_whole = |run: &Run| Some(run.scenario.duration_s) >= whole(name);
        (pair.is_built_in() && is_whole(pair.reverse) && is_whole(pair.classical)).then_some(pair)
    };
    let (singular, nominal) = (pair("stiff_wall_singular")?, pair("stiff_wall")?);
    let contact = runs.iter().find(|run| run.recording.scenario == CONTACT_LAW);
    let contact = contact.map(|run| &run.recording);
    Some(Story {
        claim: claim(&singular)?,
        figure: figure(&singular, &nominal.reverse.recording, contact),
        meaning: [singularity(&singular), nominal_posture(&nominal), spike(&nominal.reverse.recording, contact)]
            .into_iter()
            .flatten()
            .collect(),
    })
}

fn claim(pair: &MethodPair) -> Option<String> {
    let [reverse, classical] = [pair.reverse, pair.classical].map(|run| Metrics::of(&run.recording));
    let force = significant(reverse.final_force?, 3);
    let others = match classical.final_force.filter(|_| classical.first_contact_s.is_some()) {
        Some(force) => format!("ends at {} N", significant(force, 3)),
        None => format!("does not reach it in {} s", trimmed(pair.classical.scenario.duration_s)),
    };
    Some(format!(
        "Next to a singularity, an arm under reverse priority presses on a stiff wall with {force} N. Under the classical \
         control the same arm {others}."
    ))
}

fn singularity(pair: &MethodPair) -> Option<String> {
    let nearest = |run: &Recording| run.samples.iter().filter_map(|s| s.wall_distance).reduce(f64::min);
    let distance = nearest(&pair.classical.recording).filter(|distance| *distance > 0.0)?;
    let aside = |axis: usize| {
        let errors = pair.reverse.recording.samples.iter().map(|sample| sample.position_error[axis].abs());
        errors.fold(0.0, f64::max)
    };
    Some(format!(
        "In picture (a) the tool moves to a wall. The classical control damps all directions alike, also the one towards the \
         wall: it stays {} mm away. Reverse priority protects the direction that presses, and damps only the lower task. \
         This costs accuracy there: the tool moves by up to {} mm to the side.",
        significant(MM * distance, 2),
        significant(MM * aside(1).max(aside(2)), 2),
    ))
}

fn nominal_posture(pair: &MethodPair) -> Option<String> {
    let text = "Away from singularities, nothing is damped. Both methods then command the same joint velocities, and reverse \
                priority has no advantage.";
    pair.coincide().then(|| text.to_owned())
}

/// Explains the peak of the law of the paper.
fn spike(hybrid: &Recording, contact: Option<&Recording>) -> Option<String> {
    let metrics = Metrics::of(hybrid);
    let mut text = format!(
        "Picture (b) is the wall from the ordinary posture. The peak of {} N comes from the law of the paper, not from the \
         priorities: the tool meets the wall at {} mm/s, and the law reads the force only after the impact. The tool bounces: \
         there are {} contacts before the force settles.",
        significant(metrics.peak_force, 3),
        significant(MM * approach_speed(hybrid, metrics.first_contact_s?)?, 2),
        metrics.contacts,
    );
    if let Some(contact) = contact {
        text += &contact_explained(contact, metrics.first_contact_s?)?;
    }
    Some(text)
}

/// Returns what the law `contact` does at the same wall; `first_contact_s`: when the law of the paper touches it, s.
fn contact_explained(contact: &Recording, first_contact_s: f64) -> Option<String> {
    let law = Metrics::of(contact);
    let count = if law.contacts == 1 { "one contact".to_owned() } else { format!("{} contacts", law.contacts) };
    Some(format!(
        " The law `contact`, with its defaults and at the same wall, approaches at {} mm/s and touches after {} s in place of {} s. \
         It has {count}, peaks at {} N and ends at {} N.",
        significant(MM * approach_speed(contact, law.first_contact_s?)?, 2),
        significant(law.first_contact_s?, 2),
        significant(first_contact_s, 2),
        significant(law.peak_force, 3),
        significant(law.final_force?, 3),
    ))
}

/// Returns the mean speed towards the wall before the first contact at this time (s), m/s.
fn approach_speed(run: &Recording, first_contact_s: f64) -> Option<f64> {
    let before = |sample: &&Sample| sample.time_s < first_contact_s && sample.time_s >= first_contact_s - APPROACH_S;
    let distances: Vec<(f64, f64)> =
        run.samples.iter().filter(before).filter_map(|sample| Some((sample.time_s, sample.wall_distance?))).collect();
    let (first, last) = (distances.first()?, distances.last()?);
    (last.0 > first.0).then(|| (first.1 - last.1) / (last.0 - first.0))
}

fn figure(singular: &MethodPair, hybrid: &Recording, contact: Option<&Recording>) -> Figure {
    let force = |label: &str, colour, stroke, run: &Recording| Curve {
        label: label.to_owned(),
        colour,
        stroke,
        points: points(run, |sample| Some(sample.force[0])),
    };
    let target = |run: &Recording| Curve {
        label: "target".to_owned(),
        colour: Colour::Black,
        stroke: Stroke::Dashed,
        points: points(run, |sample| sample.target_force[0]),
    };
    let (reverse, classical) = (&singular.reverse.recording, &singular.classical.recording);
    let methods = vec![
        force("reverse priority", Colour::Blue, Stroke::Wide, reverse),
        force("classical control", Colour::Orange, Stroke::Thin, classical),
        target(reverse),
    ];
    let mut laws = vec![force("law of the paper", Colour::Blue, Stroke::Thin, hybrid)];
    laws.extend(contact.map(|run| force("law contact", Colour::Green, Stroke::Wide, run)));
    laws.push(target(hybrid));
    let touches =
        [Some(hybrid), contact, Some(hybrid)].into_iter().flatten().map(|run| Metrics::of(run).first_contact_s);
    for (curve, touch) in laws.iter_mut().zip(touches) {
        curve.points.iter_mut().for_each(|(time, _)| *time -= touch.unwrap_or_default());
    }
    let impact = panel("(b) Ordinary posture, impact: two laws", "force F_x (N)", IMPACT_WINDOW, laws);
    Figure {
        name: "story".to_owned(),
        title: "Force on a stiff wall".to_owned(),
        caption: "Force of the tool on the wall. (a) Next to a singularity, by method. (b) From the ordinary posture, by law, from the first contact on."
            .to_owned(),
        panels: vec![
            panel("(a) Next to a singularity: two methods", "force F_x (N)", span(reverse), methods),
            Panel { x_label: AFTER_TOUCH.to_owned(), ..impact },
        ],
    }
}

#[cfg(test)]
mod tests {
    use revprio_api::wire::{Method, Solver};

    use super::*;

    /// A tool that moves to a wall at 0.1 m/s, and presses with 30 N or stops 5 mm before it.
    fn run(scenario: &str, method: Method, touches: bool) -> Run {
        let sample = |i: i32| {
            let distance = 0.01 - 1e-4 * f64::from(i);
            let is_contact = touches && distance <= 0.0;
            Sample {
                time_s: 1e-3 * f64::from(i),
                force: [if is_contact { 30.0 } else { 0.0 }, 0.0, 0.0],
                target_force: [Some(30.0), None, None],
                wall_distance: Some(distance.max(if touches { -3e-4 } else { 5e-3 })),
                ..Sample::at_rest()
            }
        };
        let samples = (0..400).map(sample).collect();
        let scenario = scenario.to_owned();
        Run::of(Recording { scenario, method, solver: Solver::Auto, samples, ..Recording::empty() })
    }

    fn runs() -> Vec<Run> {
        let (reverse, classical) = (Method::ReversePriority, Method::DampedLeastSquares);
        vec![
            run("stiff_wall", reverse, true),
            run("stiff_wall", classical, true),
            run("stiff_wall_singular", reverse, true),
            run("stiff_wall_singular", classical, false),
            run(CONTACT_LAW, reverse, true),
        ]
    }

    #[test]
    fn the_story_says_who_reaches_the_wall_and_how_fast() {
        let Story { claim, figure, meaning } = of_runs(&runs()).unwrap();
        assert!(claim.contains("with 30.0 N.") && claim.ends_with("does not reach it in 5 s."), "{claim}");
        assert!(meaning[0].contains("5.0 mm away"), "{}", meaning[0]);
        assert!(
            meaning[2].contains("meets the wall at 100 mm/s") && meaning[2].contains("one contact"),
            "{}",
            meaning[2]
        );
        let impact = &figure.panels[1];
        assert_eq!(impact.curves.len(), 3);
        assert!(impact.curves.iter().all(|curve| curve.points[0].0 == -0.1), "time counts from the contact");
    }

    #[test]
    fn there_is_no_story_without_both_experiments_to_their_end() {
        assert_eq!(of_runs(&runs()[2..]), None);
        let mut short = runs();
        short[3].scenario.duration_s = 1.0;
        assert_eq!(of_runs(&short), None);
        let mut changed = runs();
        changed[3].scenario.contacts[0].stiffness = 1e4;
        assert_eq!(of_runs(&changed), None);
        assert!(of_runs(&runs()[..4]).is_some_and(|story| !story.meaning[2].contains("law `contact`")));
    }
}
