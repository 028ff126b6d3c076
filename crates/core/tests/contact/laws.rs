//! The controllers that press: the contact law, and full reversal, which has the smallest peak of all.

use revprio_core::law::{
    AxisInput, ContactAxis, ContactLaw, ContactPhase, ContactReport, ContactSettings, ContactTiming, Profile,
};
use revprio_core::limits::{Drive, DriveState};
use revprio_core::linalg::Vector;

use crate::plant::{Conditions, Controller, Outcome, run};

/// Returns when the contact law first presses with 95 % of its target, s.
pub fn time_near_target(terms: &Conditions) -> f64 {
    let mut first = f64::INFINITY;
    run(terms, &mut Pressing::new(terms), |[time, force, ..]| {
        first = if force > 0.95 * terms.target { first.min(time) } else { first };
    });
    first
}

/// The contact law with its model of the drive.
pub struct Pressing {
    law: ContactLaw,
    timing: ContactTiming,
    drive: Drive,
    state: DriveState,
    axis: ContactAxis,
    acceleration: f64,
    target: f64,
    /// Another target, N, from a time on, s.
    pub later: Option<(f64, f64)>,
    time: f64,
    last: f64,
    /// Where the tool was measured last, m.
    place: Option<f64>,
    pub report: Option<ContactReport>,
}

impl Pressing {
    /// The law that is told the true drive and sensor.
    pub fn new(terms: &Conditions) -> Self {
        let drive = Drive { lag_s: terms.lag, delay_periods: terms.delay };
        let settings = ContactSettings {
            approach_speed: Some(terms.speed),
            noise: terms.noise.max(1e-3),
            sensor_lag: terms.sensor_lag,
            ..ContactSettings::default()
        };
        Self::told(terms, drive, settings)
    }

    /// The law that is told this drive and these settings.
    pub fn told(terms: &Conditions, drive: Drive, settings: ContactSettings) -> Self {
        let speed = if terms.at_rest { 0.0 } else { settings.approach_speed.unwrap_or(0.0) };
        let profile = Profile::constant(vec![terms.target]).unwrap();
        Self {
            law: ContactLaw::new(profile, vec![settings]).unwrap(),
            timing: ContactTiming::new(terms.period, drive, settings.sensor_lag, 0.0),
            drive,
            state: DriveState::moving(drive, &Vector::from_element(1, speed)),
            axis: ContactAxis::START,
            acceleration: terms.acceleration,
            target: terms.target,
            later: None,
            time: 0.0,
            last: speed,
            place: None,
            report: None,
        }
    }

    pub fn axis(&self) -> &ContactAxis {
        &self.axis
    }
}

impl Controller for Pressing {
    fn command(&mut self, reading: f64, [place, _]: [f64; 2]) -> f64 {
        let period = self.timing.period;
        self.time += period;
        if let Some((_, target)) = self.later.take_if(|later| self.time > later.0) {
            self.target = target;
        }
        let input = AxisInput {
            force: reading,
            limited_force: reading,
            target: self.target,
            moved: [place - self.place.replace(place).unwrap_or(place), period],
            to_rest: self.state.distance_to_rest(self.drive, 0, period),
            last_velocity: self.last,
            acceleration: self.acceleration,
        };
        let (velocity, report) = self.law.step(0, &self.timing, input, &mut self.axis);
        let command = Vector::from_element(1, velocity);
        let way = self.state.way(self.drive, 0, &command, period);
        self.axis.advance(&self.timing, way, period);
        self.state.advance(self.drive, &command, period);
        (self.last, self.report) = (velocity, Some(report));
        velocity
    }

    fn has_fault(&self) -> bool {
        matches!(self.axis.phase, ContactPhase::Fault(_))
    }
}

/// Full reversal from the first sample whose reading without noise exceeds 3 σ.
struct Reversal {
    step: f64,
    least: f64,
    command: f64,
    touched: bool,
}

impl Controller for Reversal {
    fn command(&mut self, reading: f64, _: [f64; 2]) -> f64 {
        self.touched |= reading > self.least;
        if self.touched {
            self.command -= self.step;
        }
        self.command
    }
}

/// Returns the smallest peak that a controller can reach, N.
pub fn bound(terms: &Conditions) -> f64 {
    let least = 3.0 * terms.noise;
    let quiet = Conditions { noise: 0.0, bias: 0.0, sign: 1.0, hold: 0.5, event: crate::plant::Event::None, ..*terms };
    let mut reversal =
        Reversal { step: terms.acceleration * terms.period, least, command: terms.speed, touched: false };
    run(&quiet, &mut reversal, |_| {}).peak
}

/// Runs the contact law.
pub fn press(terms: &Conditions) -> Outcome {
    run(terms, &mut Pressing::new(terms), |_| {})
}
