//! Prints how a wipe follows tilted surfaces that it is not told, with friction.
//!
//! `cargo run --release -p revprio-core --example contact_surface` prints the table of docs/contact.md.

#[expect(dead_code, reason = "the tests use the rest")]
#[path = "../tests/surface/world.rs"]
mod world;

use revprio_core::surface::SurfaceSettings;
use world::{BEGIN, Stroke, Surface, Wipe, Wiped, World};

/// Tilts along the motion, degrees.
const TILTS: [f64; 7] = [-30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0];

/// Coefficients of friction.
const FRICTIONS: [f64; 3] = [0.0, 0.25, 0.5];

/// The worst of some runs.
struct Worst {
    least: f64,
    most: f64,
    rms: f64,
    angle: f64,
    peak: f64,
    lost: usize,
}

fn worst(stiffness: f64, stroke: Stroke, surface: Option<SurfaceSettings>) -> Worst {
    let start = Worst { least: 0.0, most: 0.0, rms: 0.0, angle: 0.0, peak: 0.0, lost: 0 };
    let runs = TILTS.iter().flat_map(|tilt| FRICTIONS.map(|friction| (tilt.to_radians(), friction)));
    runs.fold(start, |worst, (tilt, friction)| {
        let plane = Surface { stiffness, ..Surface::plane([0.0, tilt], friction) };
        let found = Wiped::of(&World::new(plane, Wipe { surface, stroke, ..Wipe::ALONG_X }).run(BEGIN + 4.5));
        Worst {
            least: worst.least.min(found.errors[0]),
            most: worst.most.max(found.errors[1]),
            rms: worst.rms.max(found.rms),
            angle: worst.angle.max(found.angle),
            peak: worst.peak.max(found.peak),
            lost: worst.lost + usize::from(found.losses > 0),
        }
    })
}

fn main() {
    println!(
        "| K, N/m | start | axes | force after 10 mm, % | rms, % | angle at the end, ° | peak of the run | runs with losses |\n\
         |---|---|---|---|---|---|---|---|"
    );
    for stroke in [Stroke::SlowStart, Stroke::Abrupt] {
        for stiffness in [1e3, 1e4, 3e4, 1e5] {
            for (name, surface) in [("follow", Some(SurfaceSettings::default())), ("fixed", None)] {
                let found = worst(stiffness, stroke, surface);
                let start = if stroke == Stroke::Abrupt { "at once" } else { "slow" };
                println!(
                    "| {stiffness:.0e} | {start} | {name} | {:+.0}, {:+.0} | {:.1} | {:.1} | {:.2} F_d | {} of 21 |",
                    100.0 * found.least,
                    100.0 * found.most,
                    100.0 * found.rms,
                    found.angle.to_degrees(),
                    found.peak,
                    found.lost
                );
            }
        }
    }
}
