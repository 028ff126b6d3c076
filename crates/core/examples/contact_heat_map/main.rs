//! Compares laws that press on walls of any stiffness at any approach speed: peak and settling time of each, as tables and a picture.
//!
//! `cargo run --release -p revprio-core --example contact_heat_map` prints the tables and writes docs/contact_heat_map.svg.
//! `… --example contact_heat_map -- python3 my_law.py` prints the tables of a program beside them, see the module `program`.

#[expect(dead_code, reason = "the other examples use the rest")]
#[path = "../../tests/contact/laws.rs"]
mod laws;
mod others;
mod picture;
#[expect(dead_code, reason = "the tests use the rest")]
#[path = "../../tests/contact/plant.rs"]
mod plant;
mod program;

use std::error::Error;

use laws::{Pressing, bound};
use others::Virtual;
use plant::{Conditions, Outcome, run};
use program::Program;

/// K, N/m.
const STIFFNESSES: [f64; 7] = [1e3, 3e3, 1e4, 3e4, 1e5, 3e5, 1e6];
/// v, m/s.
const SPEEDS: [f64; 5] = [0.005, 0.01, 0.02, 0.05, 0.1];
const SEEDS: u64 = 3;
/// L, s; D; T, s.
const DRIVE: (f64, usize, f64) = (0.01, 1, 0.002);
const FILE: &str = "docs/contact_heat_map.svg";

/// What one law does in one cell, the worst of all seeds.
#[derive(Debug, Clone, Copy)]
enum Cell {
    /// The law is not defined here.
    Refused,
    /// Largest force over the target; time beyond the travel until the force stays within 5 %, s: `None` if it never does.
    Pressed { peak: f64, late: Option<f64> },
}

/// The cells of a law, by speed and then by stiffness.
struct Map {
    name: String,
    cells: Vec<Vec<Cell>>,
}

impl Map {
    fn new(
        name: &str,
        mut press: impl FnMut(&Conditions) -> Result<Cell, Box<dyn Error>>,
    ) -> Result<Self, Box<dyn Error>> {
        let mut row = |speed: f64| {
            STIFFNESSES.map(|stiffness| Conditions::new(stiffness, speed, DRIVE)).iter().map(&mut press).collect()
        };
        let cells = SPEEDS.into_iter().map(&mut row).collect::<Result<_, _>>()?;
        Ok(Self { name: name.to_owned(), cells })
    }

    /// Prints the map as a table of peaks and times.
    fn print(&self) {
        println!(
            "\n{}\n\n| v, cm/s |{}\n|---|{}",
            self.name,
            STIFFNESSES.map(|k| format!(" {k:.0e} N/m |")).concat(),
            "---|".repeat(STIFFNESSES.len())
        );
        for (speed, cells) in SPEEDS.iter().zip(&self.cells) {
            let text = |cell: &Cell| match cell {
                Cell::Refused => " refused |".to_owned(),
                Cell::Pressed { peak, late: Some(late) } => format!(" {peak:.2}, {late:.2} s |"),
                Cell::Pressed { peak, late: None } => format!(" {peak:.2}, – |"),
            };
            println!("| {} |{}", 100.0 * speed, cells.iter().map(text).collect::<String>());
        }
    }
}

/// Runs a controller with all seeds; `run` returns nothing where its law is not defined.
fn press(terms: &Conditions, mut run: impl FnMut(&Conditions) -> Option<Outcome>) -> Cell {
    let (mut worst_peak, mut worst_late) = (0.0_f64, Some(0.0_f64));
    for seed in 1..=SEEDS {
        let terms = terms.seeded(seed);
        let Some(found) = run(&terms) else { return Cell::Refused };
        worst_peak = worst_peak.max(found.peak / terms.target);
        let late = (found.settling - terms.travel()).max(0.0);
        worst_late = worst_late.filter(|_| found.settled).map(|worst| worst.max(late));
    }
    Cell::Pressed { peak: worst_peak, late: worst_late }
}

/// The map of a program.
fn map_of(command: &[String]) -> Result<Map, Box<dyn Error>> {
    let mut program = Program::start(command)?;
    Map::new(&command.join(" "), |terms| {
        let cell = press(terms, |terms| Some(run(terms, program.begin(terms), |_| {})));
        program.failure().map_or(Ok(cell), |failure| Err(failure.into()))
    })
}

/// The map of full reversal, the strongest reaction to a touch, and those of all laws.
fn maps() -> Result<Vec<Map>, Box<dyn Error>> {
    let least = Map::new("full reversal at the touch", |terms| {
        let peak = (1..=SEEDS).map(|seed| bound(&terms.seeded(seed))).fold(terms.target, f64::max) / terms.target;
        Ok(Cell::Pressed { peak, late: Some(0.0) })
    })?;
    let contact = Map::new("revprio, law contact", |terms| {
        Ok(press(terms, |terms| Some(run(terms, &mut Pressing::new(terms), |_| {}))))
    })?;
    let others = others::LAWS.into_iter().map(|(name, law)| {
        Map::new(name, |terms| {
            Ok(press(terms, |terms| Some(run(terms, &mut Virtual::new(terms, law(terms)?), |_| {}))))
        })
    });
    [Ok(least), Ok(contact)].into_iter().chain(others).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let command: Vec<String> = std::env::args().skip(1).collect();
    if !command.is_empty() {
        map_of(&command)?.print();
        return Ok(());
    }
    let maps = maps()?;
    maps.iter().for_each(Map::print);
    Ok(std::fs::write(FILE, picture::draw(&maps))?)
}
