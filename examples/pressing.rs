//! Compares the scenarios that press with the law `contact` with the law of the paper and with fixed axes.
//!
//! `cargo run --example pressing` prints the table of `docs/scenarios.md` and draws `docs/pressing.svg`.

use std::ops::ControlFlow;

use revprio::service::{AppState, Robots, RunningServer, router};
use revprio_api::{Client, wire};
use revprio_lab::report::figure::{Colour, Curve, Figure, Panel, Stroke, TIME};
use revprio_lab::simulator::{CallMode, Scenario, run};

type Error = Box<dyn std::error::Error>;

/// The force of a tool on the wall or plane of a scenario.
struct Pressed {
    label: &'static str,
    /// Time, s, and force along the normal, N.
    force: Vec<(f64, f64)>,
    /// Place of the tool, m from its start.
    places: Vec<[f64; 3]>,
    /// Target force, N.
    target: f64,
}

/// Time at which the slide of `wiping` begins, s.
const SLIDE: f64 = 2.0;

impl Pressed {
    fn of(client: &Client, label: &'static str, target: f64, scenario: &Scenario) -> Result<Self, Error> {
        let inward = scenario.contacts[0].normal.map_or([1.0, 0.0, 0.0], |outward| outward.map(|part| -part));
        let samples = run(scenario, client, CallMode::Session, |_| ControlFlow::Continue(()))?.samples;
        let along = |force: [f64; 3]| (0..3).map(|i| force[i] * inward[i]).sum::<f64>() + 0.0;
        let force = samples.iter().map(|s| (s.time_s, along(s.force))).collect();
        Ok(Self { label, force, places: samples.iter().map(|s| s.position_error).collect(), target })
    }

    fn curve(&self, colour: Colour, stroke: Stroke) -> Curve {
        let label = self.label.trim_start_matches("– ").replace('`', "").replace('_', " ");
        Curve { label, colour, stroke, points: self.force.clone() }
    }

    fn print(&self) {
        let peak = self.force.iter().map(|(_, force)| *force).fold(0.0, f64::max);
        let touches = self.force.windows(2).filter(|pair| pair[0].1 <= 0.0 && pair[1].1 > 0.0);
        let touches: Vec<f64> = touches.map(|pair| pair[1].0).collect();
        let outside = self.force.iter().rfind(|(_, force)| (force - self.target).abs() > 0.05 * self.target);
        let (end, (last, _)) = (self.force[self.force.len() - 1].0, *outside.unwrap_or(&self.force[0]));
        let settled = if last < end - 0.2 { format!("{:.2} s", last - touches[0]) } else { "never".to_owned() };
        println!("| {} | {:.2} s | {} | {peak:.1} N | {settled} |", self.label, touches[0], touches.len());
    }

    fn print_slide(&self) {
        let start = self.force.partition_point(|(time, _)| *time < SLIDE);
        let way = |place: &[f64; 3]| (0..3).map(|i| (place[i] - self.places[start][i]).powi(2)).sum::<f64>().sqrt();
        let five = self.places[start..].iter().position(|place| way(place) > 5e-3).unwrap_or(0);
        let (first, later) = self.force[start..].split_at(five);
        println!("| {} | {} | {} |", self.label, range(first), range(later));
    }
}

/// Returns the least and the largest force.
fn range(force: &[(f64, f64)]) -> String {
    let least = force.iter().map(|(_, force)| *force).fold(f64::INFINITY, f64::min);
    let largest = force.iter().map(|(_, force)| *force).fold(0.0, f64::max);
    format!("{least:.1} to {largest:.1} N")
}

/// Returns the scenario `press` whose law `contact` has another approach speed (m/s; `None`: the default), and a duration, s.
fn press_at(approach: Option<f64>, duration_s: f64) -> Result<Scenario, Error> {
    let mut scenario = Scenario { duration_s, ..Scenario::find("press")? };
    if let Some(wire::Law::Contact { approach_speed, .. }) = &mut scenario.controller.tasks[0].law {
        *approach_speed = approach.map(wire::PerAxis::All);
    }
    Ok(scenario)
}

fn wiping_without_surface() -> Result<Scenario, Error> {
    let mut scenario = Scenario::find("wiping")?;
    if let Some(wire::Law::Contact { surface, .. }) = &mut scenario.controller.tasks[0].law {
        *surface = None;
    }
    Ok(scenario)
}

fn panel(heading: &str, window: (f64, f64), curves: Vec<Curve>) -> Panel {
    Panel {
        heading: heading.to_owned(),
        x_label: TIME.to_owned(),
        y_label: "normal force (N)".to_owned(),
        window,
        y_covers: vec![0.0],
        curves,
    }
}

fn picture(runs: &[Pressed]) -> Result<String, Error> {
    let [stiff, lag, _, press, _, _, wiping, fixed] = runs else { return Err("eight runs".into()) };
    let figure = Figure {
        name: "pressing".to_owned(),
        title: "Pressing without knowing the surface".to_owned(),
        caption: String::new(),
        panels: vec![
            panel(
                "(a) The wall of stiff wall",
                (0.0, 3.0),
                vec![
                    press.curve(Colour::Orange, Stroke::Wide),
                    lag.curve(Colour::SkyBlue, Stroke::Thin),
                    stiff.curve(Colour::Blue, Stroke::Thin),
                ],
            ),
            panel(
                "(b) A plane tilted by 25°",
                (0.0, 10.0),
                vec![wiping.curve(Colour::Orange, Stroke::Wide), fixed.curve(Colour::Blue, Stroke::Thin)],
            ),
            panel("(c) The same, wiping only", (0.0, 10.0), vec![wiping.curve(Colour::Orange, Stroke::Thin)]),
        ],
    };
    Ok(revprio_lab::report::svg(&figure)?)
}

fn main() -> Result<(), Error> {
    let server = RunningServer::start(router(AppState::new(Robots::built_in())))?;
    let client = Client::new(&server.url());
    let of = |label, target, scenario| Pressed::of(&client, label, target, &scenario);
    let runs = [
        of("`stiff_wall`", 30.0, Scenario::find("stiff_wall")?)?,
        of("`stiff_wall_lag`", 30.0, Scenario::find("stiff_wall_lag")?)?,
        of("`stiff_wall_lag_damped`", 30.0, Scenario::find("stiff_wall_lag_damped")?)?,
        of("`press`", 30.0, Scenario::find("press")?)?,
        of("– without `approach_speed`", 30.0, press_at(None, 10.0)?)?,
        of("– with `approach_speed` 0.2", 30.0, press_at(Some(0.2), 3.0)?)?,
        of("`wiping`", 20.0, Scenario::find("wiping")?)?,
        of("– without `surface`", 20.0, wiping_without_surface()?)?,
    ];
    println!("| run | first touch | contacts | peak | within 5 % after |\n|---|---|---|---|---|");
    runs.iter().for_each(Pressed::print);
    println!("\n| normal force | first 5 mm of the slide | later |\n|---|---|---|");
    runs[6..].iter().for_each(Pressed::print_slide);
    std::fs::write("docs/pressing.svg", picture(&runs)?)?;
    Ok(())
}
