//! The laws of others, and the older ones of this project.
//!
//! All of them approach at the speed of the cell until a reading exceeds 5 σ. Then their law continues from the velocity of the approach.
//! None goes faster than the approach, or back faster than 0.25 m/s, and all keep the limit of acceleration. What they integrate is the
//! velocity that these limits leave.

use revprio_core::controller::ContactLoop;

use crate::plant::{Conditions, Controller};

/// Retreat speed, m/s.
const RETREAT: f64 = 0.25;

/// A law that integrates an acceleration.
#[derive(Debug, Clone, Copy)]
pub enum Law {
    /// M_d ẍ + B_d ẋ = F_d − F, with the measured velocity.
    Force { inertia: f64, damping: f64 },
    /// The same with the velocity of the law itself, as `admittance_controller` of `ros2_controllers` integrates it.
    Admittance { inertia: f64, damping: f64 },
    /// v ← 0.9 (v + T p (F_d − F)/m), as `cartesian_force_controller` of FZI integrates the motion of a virtual arm.
    ForwardDynamics { gain: f64, mass: f64 },
}

type Choose = fn(&Conditions) -> Option<Law>;

/// The laws and their names.
pub const LAWS: [(&str, Choose); 4] = [
    ("force, damping for the true K", |terms| Some(Law::Force { inertia: INERTIA, damping: recommended(terms)? })),
    ("force, gains of the paper", |_| Some(Law::Force { inertia: INERTIA, damping: 150.0 })),
    // Mass, stiffness and damping ratio of the parameters in the tests of `ros2_controllers`: D = 2 · 2.828427 √(5.5 · 214.1) N·s/m. Its
    // law has no target force; here it is added, and the stiffness towards a position left out.
    ("ros2_controllers, admittance", |_| Some(Law::Admittance { inertia: 5.5, damping: 194.1 })),
    // `pd_gains` 0.05, `error_scale` 0.5, and the mass of 1 kg that the solver gives the last link.
    ("FZI, cartesian force", |_| Some(Law::ForwardDynamics { gain: 0.05 * 0.5, mass: 1.0 })),
];

/// M_d of the paper, kg.
const INERTIA: f64 = 15.0;

/// Factor that `push_with_damping` keeps from both ends of the stable interval.
const SAFETY: f64 = 2.0;

/// Returns the damping that the preset `push_with_damping` of the Python client chooses for the true stiffness, N·s/m.
fn recommended(terms: &Conditions) -> Option<f64> {
    let stable = |stiffness: f64| {
        let contact = ContactLoop {
            inertia: INERTIA,
            damping: 0.0,
            stiffness: 0.0,
            environment_inertia: 0.0,
            environment_damping: 0.0,
            environment_stiffness: stiffness,
            period_s: terms.period,
            lag_s: terms.lag,
            delay_periods: terms.delay,
            velocity_measured: true,
        };
        contact.stable_dampings().ok().flatten()
    };
    let (contact, free) = (stable(terms.stiffness)?, stable(0.0)?);
    let high = contact.largest.unwrap_or(f64::INFINITY).min(free.largest.unwrap_or(f64::INFINITY));
    let middle = (contact.smallest * high).sqrt();
    let (least, most) = (terms.target / terms.speed, (high / SAFETY).max(middle));
    (contact.smallest < high && least <= most).then(|| (SAFETY * contact.smallest).min(middle).max(least))
}

/// A law at work.
pub struct Virtual {
    law: Law,
    terms: Conditions,
    velocity: f64,
    has_touched: bool,
}

impl Virtual {
    pub fn new(terms: &Conditions, law: Law) -> Self {
        Self { law, terms: *terms, velocity: terms.speed, has_touched: false }
    }

    fn wanted(&self, reading: f64, measured: f64) -> f64 {
        let (period, missing) = (self.terms.period, self.terms.target - reading);
        match self.law {
            Law::Force { inertia, damping } => self.velocity + period * (missing - damping * measured) / inertia,
            Law::Admittance { inertia, damping } => {
                self.velocity + period * (missing - damping * self.velocity) / inertia
            }
            Law::ForwardDynamics { gain, mass } => 0.9 * (self.velocity + period * gain * missing / mass),
        }
    }
}

impl Controller for Virtual {
    fn command(&mut self, reading: f64, [_, velocity]: [f64; 2]) -> f64 {
        self.has_touched |= reading > 5.0 * self.terms.noise;
        if self.has_touched {
            let step = self.terms.acceleration * self.terms.period;
            let wanted = self.wanted(reading, velocity).clamp(-RETREAT, self.terms.speed);
            self.velocity = wanted.clamp(self.velocity - step, self.velocity + step);
        }
        self.velocity
    }
}
