//! Runs the scenarios whose surfaces the controller is not told: a curved one, a door and a hole.
//!
//! `cargo run --example unknown_surfaces` prints the tables of `docs/scenarios.md` and draws `docs/unknown_surfaces.svg`.

use std::ops::ControlFlow;

use revprio::service::{AppState, Robots, RunningServer, router};
use revprio_api::{Client, wire};
use revprio_lab::report::figure::{Colour, Curve, Figure, Panel, Stroke, TIME};
use revprio_lab::simulator::recording::{ContactEvent, Sample};
use revprio_lab::simulator::{CallMode, Scenario, run};

type Error = Box<dyn std::error::Error>;
type Points = Vec<(f64, f64)>;

/// Time at which the slide of `wiping_curved` begins, s.
const SLIDE: f64 = 2.0;

/// Angle at which the door counts as open, rad.
const OPEN: f64 = std::f64::consts::FRAC_PI_3;

/// Depth at which the peg counts as inserted, m.
const INSERTED: f64 = 0.003;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NEG_INFINITY, f64::max)
}

/// Returns the unit vector from the axis of a cylinder or a hinge to the tool. `axis`: 0 = x.
fn outward(scenario: &Scenario, sample: &Sample) -> [f64; 3] {
    let contact = &scenario.contacts[0];
    let reach = contact.radius_m.unwrap_or(0.0) + contact.offset_m;
    let mut way = contact.normal.unwrap_or_default().map(|part| reach * part);
    for (i, part) in way.iter_mut().enumerate() {
        *part += sample.position_error[i];
    }
    if let Some(axis) = contact.axis {
        way[axis] = 0.0;
    }
    let length = dot(way, way).sqrt();
    way.map(|part| part / length)
}

/// Returns the normal force over time.
fn normal_force(scenario: &Scenario, samples: &[Sample]) -> Points {
    samples.iter().map(|sample| (sample.time_s, -dot(outward(scenario, sample), sample.force))).collect()
}

/// Returns the angle of the door over time, rad.
fn angle(scenario: &Scenario, samples: &[Sample]) -> Points {
    let of = |sample: &Sample| {
        let [x, y, _] = outward(scenario, sample);
        (sample.time_s, x.atan2(-y))
    };
    samples.iter().map(of).collect()
}

/// Returns the force across the motion of the handle over the angle of the door, degrees.
fn across(scenario: &Scenario, samples: &[Sample]) -> Points {
    let force = samples.iter().map(|sample| dot(outward(scenario, sample), sample.force));
    angle(scenario, samples).iter().zip(force).map(|((_, angle), force)| (angle.to_degrees(), force)).collect()
}

/// Returns a scenario whose law `contact` does not follow the surface.
fn without_surface(mut scenario: Scenario) -> Scenario {
    if let Some(wire::Law::Contact { surface, .. }) = &mut scenario.controller.tasks[0].law {
        *surface = None;
    }
    scenario
}

/// Returns the door with another radius, m; `follows`: whether the force turns with the motion.
fn door(radius: f64, follows: bool) -> Result<Scenario, Error> {
    let mut scenario = Scenario { duration_s: 20.0, ..Scenario::find("door")? };
    scenario.contacts[0].radius_m = Some(radius);
    if !follows {
        scenario.target_programs.clear();
    }
    Ok(scenario)
}

/// Returns the peg with another hole, its place and its clearance, m, and a speed of the search, m/s. The pitch of the spiral is twice the
/// clearance. The search ends after 250 mm.
fn peg([x, y]: [f64; 2], clearance: f64, search_speed: f64) -> Result<Scenario, Error> {
    let mut scenario = Scenario { duration_s: 0.25 / search_speed, ..Scenario::find("peg")? };
    if let Some(hole) = &mut scenario.contacts[0].hole {
        (hole.center, hole.clearance_m) = ([x, y, 0.0], clearance);
    }
    for stream in &mut scenario.target_programs {
        if let revprio_lab::simulator::TargetProgram::SpiralSearch { pitch_m, speed, .. } = stream {
            (*pitch_m, *speed) = (2.0 * clearance, search_speed);
        }
    }
    Ok(scenario)
}

fn print_wiping(label: &str, scenario: &Scenario, samples: &[Sample]) {
    let start = samples.partition_point(|sample| sample.time_s < SLIDE);
    let slid = |sample: &Sample| {
        let way = [0, 1, 2].map(|i| sample.position_error[i] - samples[start].position_error[i]);
        dot(way, way).sqrt()
    };
    let five = start + samples[start..].iter().position(|sample| slid(sample) > 5e-3).unwrap_or(0);
    let range = |samples: &[Sample]| {
        let force = normal_force(scenario, samples);
        format!("{:.1} to {:.1} N", -largest(force.iter().map(|p| -p.1)), largest(force.iter().map(|p| p.1)))
    };
    println!("| {label} | {} | {} |", range(&samples[start..five]), range(&samples[five..]));
}

fn print_door(radius: f64, follows: bool, scenario: &Scenario, samples: &[Sample]) {
    let angle = angle(scenario, samples);
    let open = angle.iter().position(|(_, angle)| *angle > OPEN);
    let until = open.map_or(samples, |open| &samples[..open]);
    let most = largest(across(scenario, until).iter().map(|(_, force)| force.abs()));
    let time = open.map_or("–".to_owned(), |open| format!("{:.1}", samples[open].time_s));
    let force = if follows { "along the motion" } else { "along x" };
    println!("| {radius} | {force} | {time} | {most:.1} |");
}

fn print_peg([x, y]: [f64; 2], [clearance, speed]: [f64; 2], scenario: &Scenario, samples: &[Sample]) {
    let surface = -scenario.contacts[0].offset_m;
    let inserted = samples.iter().find(|sample| sample.position_error[2] < surface - INSERTED);
    let inserted = inserted.map_or("–".to_owned(), |sample| format!("{:.1}", sample.time_s));
    let last = samples[samples.len() - 200..].iter().map(|sample| -sample.force[2]).sum::<f64>() / 200.0;
    let most = largest(samples.iter().map(|sample| -sample.force[2]));
    let side = largest(samples.iter().map(|sample| sample.force[0].hypot(sample.force[1])));
    let losses = samples.iter().filter(|sample| sample.contacts.event[0] == ContactEvent::Loss).count();
    let state = samples.last().map_or(String::new(), |sample| sample.contacts.state[0].to_string());
    println!(
        "| {:.1} | {:.0} | {:.0}, {:.0} | {inserted} | {last:.2} | {most:.1} | {side:.1} | {losses} | {state} |",
        1e3 * clearance,
        1e3 * speed,
        1e3 * x,
        1e3 * y
    );
}

fn panel(heading: &str, [x_label, y_label]: [&str; 2], window: (f64, f64), curves: Vec<Curve>) -> Panel {
    Panel {
        heading: heading.to_owned(),
        x_label: x_label.to_owned(),
        y_label: y_label.to_owned(),
        window,
        y_covers: vec![0.0],
        curves,
    }
}

fn curve(label: &str, colour: Colour, stroke: Stroke, points: Points) -> Curve {
    Curve { label: label.to_owned(), colour, stroke, points }
}

fn main() -> Result<(), Error> {
    let server = RunningServer::start(router(AppState::new(Robots::built_in())))?;
    let client = Client::new(&server.url());
    let samples = |scenario: &Scenario| -> Result<Vec<Sample>, Error> {
        Ok(run(scenario, &client, CallMode::Session, |_| ControlFlow::Continue(()))?.samples)
    };

    let curved = Scenario::find("wiping_curved")?;
    let fixed = without_surface(curved.clone());
    let [on_curve, on_axes] = [samples(&curved)?, samples(&fixed)?];
    println!("| normal force | first 5 mm of the slide | later |\n|---|---|---|");
    print_wiping("`wiping_curved`", &curved, &on_curve);
    print_wiping("– without `surface`", &fixed, &on_axes);
    let mut panels = vec![panel(
        "(a) Wiping a cylinder",
        [TIME, "normal force (N)"],
        (0.0, 10.0),
        vec![
            curve("wiping curved", Colour::Orange, Stroke::Wide, normal_force(&curved, &on_curve)),
            curve("without surface", Colour::Blue, Stroke::Thin, normal_force(&fixed, &on_axes)),
        ],
    )];

    println!("\n| radius, m | force | time to 60°, s | most across the motion, N |\n|---|---|---|---|");
    let mut curves = Vec::new();
    for radius in [0.2, 0.3, 0.4] {
        for follows in [false, true] {
            let scenario = door(radius, follows)?;
            let samples = samples(&scenario)?;
            print_door(radius, follows, &scenario, &samples);
            if radius == 0.3 {
                let (label, colour, stroke) = if follows {
                    ("door", Colour::Orange, Stroke::Wide)
                } else {
                    ("force along x", Colour::Blue, Stroke::Thin)
                };
                curves.push(curve(label, colour, stroke, across(&scenario, &samples)));
            }
        }
    }
    panels.push(panel(
        "(b) Opening a door",
        ["angle of the door (°)", "force across its motion (N)"],
        (0.0, 60.0),
        curves,
    ));

    println!(
        "\n| clearance, mm | search, mm/s | hole at x, y, mm | inserted after, s | force at the end, N | most, N | most across, N | losses | state |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for [clearance, speed] in [[2e-4, 0.01], [2e-4, 0.004], [5e-4, 0.01]] {
        for place in [[1e-3, 0.0], [2e-3, -2e-3], [-4e-3, 3e-3]] {
            let scenario = peg(place, clearance, speed)?;
            print_peg(place, [clearance, speed], &scenario, &samples(&scenario)?);
        }
    }
    let scenario = Scenario::find("peg")?;
    let found = samples(&scenario)?;
    let of = |of: fn(&Sample) -> (f64, f64)| found.iter().map(of).collect::<Points>();
    panels.push(panel(
        "(c) Searching a hole at (2, −2) mm",
        ["x (mm)", "y (mm)"],
        (-3.5, 3.5),
        vec![curve(
            "peg",
            Colour::Orange,
            Stroke::Thin,
            of(|s| (1e3 * s.position_error[0], 1e3 * s.position_error[1])),
        )],
    ));
    panels.push(panel(
        "(d) Its depth",
        [TIME, "height (mm)"],
        (0.0, scenario.duration_s),
        vec![curve("peg", Colour::Orange, Stroke::Thin, of(|s| (s.time_s, 1e3 * s.position_error[2])))],
    ));
    let figure = Figure {
        name: "unknown_surfaces".to_owned(),
        title: "Surfaces that the controller is not told".to_owned(),
        caption: String::new(),
        panels,
    };
    std::fs::write("docs/unknown_surfaces.svg", revprio_lab::report::svg(&figure)?)?;
    Ok(())
}
