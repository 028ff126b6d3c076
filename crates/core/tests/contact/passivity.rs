//! The energy that the law gives to walls that leave, move and change their stiffness at random.
//!
//! `cargo run --release -p revprio-core --example contact_passivity` measures 10⁴ runs; the test is a part of them.

use revprio_core::law::ContactSettings;

use crate::laws::{Pressing, bound};
use crate::plant::{Conditions, Event, Noise, STIFFNESS, run};

/// Time for which the wall changes, s.
const LASTS: f64 = 4.0;

/// The energy of one run.
#[derive(Debug, Clone, Copy)]
pub struct Energy {
    pub terms: Conditions,
    /// What the wall got beyond F_d × 5 cm/s since the start, and in any time, J.
    pub given: [f64; 2],
    /// The full tank, J.
    pub tank: f64,
    /// ½ F²/K of the smallest impact that a controller can reach on the stiffest wall of the run, J, if that wall rests.
    pub impact: f64,
    /// The same if the wall comes with its largest speed.
    pub moving_impact: f64,
    /// How often the tool lost the wall.
    pub losses: usize,
    pub fault: bool,
}

impl Energy {
    /// Returns the energy in any time over the larger one of tank and impact.
    pub fn share(&self) -> f64 {
        self.given[1] / self.tank.max(self.impact)
    }
}

/// Returns the conditions of a run: drive, sensor, target, speed and wall at random. Every second drive yields.
fn conditions(seed: u64) -> Conditions {
    let mut noise = Noise::new(seed);
    let lag = if noise.uniform() < 0.2 { 0.0 } else { 0.02 * noise.uniform() };
    let (delay, period) = (pick(&mut noise, [0, 1, 2]), pick(&mut noise, [1e-3, 2e-3, 8e-3]));
    let stiffness = noise.between(STIFFNESS[0], STIFFNESS[1]);
    let terms = Conditions::new(stiffness, noise.between(0.003, 0.1), (lag, delay, period));
    let soft = (seed % 2 == 1).then(|| (noise.between(2.0, 20.0), noise.between(100.0, 400.0)));
    let rests = noise.between(0.03, 1.0);
    Conditions {
        soft,
        acceleration: noise.between(1.0, 10.0),
        sensor_lag: if noise.uniform() < 0.2 { 0.0 } else { 5e-3 * noise.uniform() },
        target: noise.between(5.0, 100.0),
        phase: noise.uniform(),
        seed,
        hold: 0.0,
        event: Event::Random(rests, LASTS),
        ..terms
    }
}

fn pick<T: Copy>(noise: &mut Noise, of: [T; 3]) -> T {
    let third = 3.0 * noise.uniform();
    of[usize::from(third >= 1.0) + usize::from(third >= 2.0)]
}

/// Returns the energy of a run.
pub fn energy(seed: u64) -> Energy {
    let terms = conditions(seed);
    let found = run(&terms, &mut Pressing::new(&terms), |_| {});
    let [stiffness, comes] = found.hardest;
    let impact = |speed| {
        let stiff = Conditions { stiffness, speed, ..terms };
        0.5 * bound(&stiff).powi(2) / stiffness
    };
    let force = 1.2 * terms.target;
    Energy {
        terms,
        given: found.beyond_refill,
        tank: 0.5 * force * force / ContactSettings::LINEAR.softest,
        impact: impact(terms.speed),
        moving_impact: impact(terms.speed + comes),
        losses: found.losses,
        fault: found.fault,
    }
}

/// A rigid drive moves as the law models it. A wall that comes makes the impact harder.
#[test]
fn the_wall_gets_no_more_than_the_tank_or_an_impact() {
    let mut largest: f64 = 0.0;
    for seed in (0..240).step_by(2) {
        let run = energy(seed);
        let share = run.given[1] / run.tank.max(run.moving_impact);
        assert!(share < 1.0, "{seed}: {share} {run:?}");
        largest = largest.max(share);
    }
    // The runs come near what is allowed.
    assert!(largest > 0.2, "{largest}");
}
