//! One axis that presses against a wall: drive, wall and sensor, simulated between the periods of a controller.
//!
//! The arm follows its command after a dead time with a first-order lag. A *rigid* drive is exactly there. A *soft* drive moves a
//! mass m with a PI velocity loop of the bandwidth ω_v: stiffness m ω_v², damping 2 m ω_v. The wall is a spring with a damping
//! ratio of 0.02 that never pulls; the sensor is a first-order filter with white noise.

#[path = "noise.rs"]
mod noise;
#[path = "random_wall.rs"]
mod random_wall;

use std::collections::VecDeque;

pub use noise::Noise;
use random_wall::RandomWall;
pub use random_wall::STIFFNESS;

/// Speed with which F_d fills the tank of the law up, m/s.
const REFILL_SPEED: f64 = 0.05;

/// Way to the wall of a tool that starts at rest, m.
const AWAY: f64 = 0.02;

/// What happens to the wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// Nothing.
    None,
    /// From this force on, N, the wall is this many times as stiff.
    Layer(f64, f64),
    /// At a time, s, the slope of the force changes by a factor, from the present depth on.
    Slope(f64, f64),
    /// At a time, s, the wall pushes by a distance, m, within 10 ms.
    Push(f64, f64),
    /// At a time, s, the wall is a distance, m, farther.
    Leave(f64, f64),
    /// At a time, s, the wall moves away at a speed, m/s, for another time, s, and then returns at the same speed.
    LeaveAndReturn(f64, f64, f64),
    /// From a time, s, on for [`SWINGS`], the wall swings away and back by twice an amplitude, m, at a frequency, Hz.
    Swing(f64, f64, f64),
    /// At a time, s, the wall is a distance, m, farther, and has another stiffness, N/m.
    Hole(f64, f64, f64),
    /// From a time, s, on for another time, s, the arm does a share of what it is told: a brake, or a slider of the robot's speed.
    HeldBack(f64, f64, f64),
    /// From a time, s, on for another time, s, the wall leaves, pushes, moves and changes its stiffness at random.
    Random(f64, f64),
}

/// How long a wall swings, s: whole periods of 0.2 Hz and more.
pub const SWINGS: f64 = 10.0;

/// The conditions of one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// T, s.
    pub period: f64,
    /// L, s.
    pub lag: f64,
    /// D, periods.
    pub delay: usize,
    /// a, m/s².
    pub acceleration: f64,
    /// τ_f, s.
    pub sensor_lag: f64,
    /// K, N/m.
    pub stiffness: f64,
    /// m, kg, and ω_v, rad/s; `None`: rigid.
    pub soft: Option<(f64, f64)>,
    /// Largest force of a soft drive, N. There its reference gives way, so that it does not wind up.
    pub most_force: f64,
    /// Approach speed, m/s.
    pub speed: f64,
    /// Part of a period by which the first contact is later.
    pub phase: f64,
    /// σ, N.
    pub noise: f64,
    /// Error of the sensor, N.
    pub bias: f64,
    /// Sign of the sensor, 1 or −1.
    pub sign: f64,
    /// Coulomb friction of the drive with backlash, m: the tool follows only beyond this play.
    pub backlash: f64,
    /// Mass of a tool beyond the sensor, kg, whose inertia is not compensated.
    pub tool_mass: f64,
    /// Whether the tool starts at rest, 20 mm before the wall.
    pub at_rest: bool,
    /// F_d, N.
    pub target: f64,
    /// Time after the travel, s.
    pub hold: f64,
    pub event: Event,
    pub seed: u64,
}

impl Conditions {
    /// The conditions of the grid for a stiffness (N/m), a speed (m/s), L (s), D and T (s).
    pub fn new(stiffness: f64, speed: f64, (lag, delay, period): (f64, usize, f64)) -> Self {
        Self {
            period,
            lag,
            delay,
            acceleration: 5.0,
            sensor_lag: 0.002,
            stiffness,
            soft: None,
            most_force: f64::INFINITY,
            speed,
            phase: 0.3,
            noise: 0.2,
            bias: 0.0,
            sign: 1.0,
            backlash: 0.0,
            tool_mass: 0.0,
            at_rest: false,
            target: 30.0,
            hold: 1.6,
            event: Event::None,
            seed: 1,
        }
    }

    /// Returns the same with a seed, and one of three phases of the touch.
    pub fn seeded(self, seed: u64) -> Self {
        let phase = [0.05, 0.5, 0.95][(seed % 3) as usize];
        Self { phase, seed, ..self }
    }

    /// F_d/(K v), s.
    pub fn travel(&self) -> f64 {
        self.target / (self.stiffness * self.speed)
    }

    /// Time of the run, s.
    pub fn duration(&self) -> f64 {
        let (event, lasts) = match self.event {
            Event::None | Event::Layer(..) => (0.0, 0.0),
            Event::Slope(t, _) | Event::Push(t, _) => (t, 0.0),
            Event::Leave(t, way) | Event::Hole(t, way, _) => (t, way / self.speed + 2.0 * self.travel()),
            Event::LeaveAndReturn(t, _, time) => (t, 2.0 * time),
            Event::Swing(t, ..) => (t, SWINGS),
            Event::Random(t, time) | Event::HeldBack(t, time, _) => (t, time),
        };
        let way = if self.at_rest { AWAY / self.speed } else { 0.02 };
        way + self.hold + 1.5 * self.travel() + event + lasts
    }
}

/// What moves the axis: returns the command, m/s, for a reading, N, and the measured position and velocity, m and m/s.
pub trait Controller {
    fn command(&mut self, reading: f64, tool: [f64; 2]) -> f64;

    /// Returns whether the controller has given up.
    fn has_fault(&self) -> bool {
        false
    }
}

/// What a run shows.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Outcome {
    /// Largest force before the event, and after it, N.
    pub peak: f64,
    pub peak_after: f64,
    /// Smallest force from the event on, N.
    pub least_after: f64,
    /// Time from the first touch, and from the event, after which the force stays in max(5 %, 1 N) of the target, s.
    pub settling: f64,
    pub settling_after: f64,
    /// Mean and rms of the last 0.4 s about it, N.
    pub error: f64,
    pub rms: f64,
    /// How often the tool left the wall.
    pub losses: usize,
    /// Whether the end is quiet: no loss, mean and rms within max(5 %, 1 N).
    pub settled: bool,
    /// Largest energy that the wall got, J.
    pub energy: f64,
    /// Largest energy that the wall got beyond F_d × 5 cm/s since the start, and in any time, J.
    pub beyond_refill: [f64; 2],
    /// The largest stiffness, N/m, and the largest speed towards the tool, m/s, of a wall that changes at random.
    pub hardest: [f64; 2],
    pub fault: bool,
}

/// The state of drive, wall and sensor.
struct Plant<'a> {
    terms: &'a Conditions,
    queue: VecDeque<f64>,
    /// Reference of the drive, and its velocity.
    reference: [f64; 2],
    /// Tool, and its velocity.
    tool: [f64; 2],
    time: f64,
    depth_at_event: Option<f64>,
    random: Option<RandomWall>,
    reading: f64,
}

impl Plant<'_> {
    /// Share of a command that the drive obeys.
    fn obeyed(&self) -> f64 {
        match self.terms.event {
            Event::HeldBack(t, time, share) if self.time > t && self.time < t + time => share,
            _ => 1.0,
        }
    }

    /// Displacement of the wall, m.
    fn wall(&self) -> f64 {
        let since = |t: f64| (self.time - t).max(0.0);
        match self.terms.event {
            Event::None | Event::Layer(..) | Event::Slope(..) | Event::Random(..) | Event::HeldBack(..) => 0.0,
            Event::Push(t, way) => -way * (since(t) / 0.01).min(1.0),
            Event::Leave(t, way) | Event::Hole(t, way, _) => {
                if self.time > t {
                    way
                } else {
                    0.0
                }
            }
            Event::LeaveAndReturn(t, speed, lasts) => {
                let passed = since(t);
                speed * if passed < lasts { passed } else { (2.0 * lasts - passed).max(0.0) }
            }
            Event::Swing(t, amplitude, frequency) => {
                let angle = std::f64::consts::TAU * frequency * since(t).min(SWINGS);
                amplitude * (1.0 - angle.cos())
            }
        }
    }

    /// Force of the tool on the wall, N.
    fn force(&mut self) -> f64 {
        let terms = self.terms;
        if let Some(wall) = &self.random {
            return wall.force(self.tool);
        }
        let depth = self.tool[0] - self.wall();
        if depth <= 0.0 {
            return 0.0;
        }
        let k = match terms.event {
            Event::Hole(t, _, stiffness) if self.time > t => stiffness,
            _ => terms.stiffness,
        };
        let spring = match terms.event {
            Event::Layer(force, factor) if k * depth > force => force + factor * (k * depth - force),
            Event::Slope(t, factor) if self.time > t => {
                let knee = *self.depth_at_event.get_or_insert(depth);
                k * (knee + factor * (depth - knee))
            }
            _ => k * depth,
        };
        let mass = terms.soft.map_or(5.0, |(mass, _)| mass);
        (spring + 0.04 * (k * mass).sqrt() * self.tool[1]).max(0.0)
    }

    /// Advances by `dt` under the active command; returns the force.
    fn advance(&mut self, active: f64, dt: f64) -> f64 {
        let terms = self.terms;
        if let Some(wall) = &mut self.random {
            wall.advance(self.time, self.tool[0], dt);
        }
        let ([x, v], share) = (self.reference, self.obeyed());
        let remaining = if terms.lag > 0.0 { (-dt / terms.lag).exp() } else { 0.0 };
        let velocity = active + (v - active) * remaining;
        let moved = if terms.lag > 0.0 { 0.5 * (v + velocity) * dt } else { active * dt };
        // A brake stops the drive at once.
        let velocity = if share > 0.0 { velocity } else { 0.0 };
        self.reference = [x + share * moved, velocity];
        let speed_before = self.tool[1];
        let force = match terms.soft {
            None => {
                let play = terms.backlash;
                let before = self.tool[0];
                self.tool[0] = before.clamp(self.reference[0] - play, self.reference[0]);
                if play <= 0.0 {
                    self.tool[0] = self.reference[0];
                }
                self.tool[1] = if play > 0.0 { (self.tool[0] - before) / dt } else { share * velocity };
                self.force()
            }
            Some((mass, bandwidth)) => {
                let force = self.force();
                let [tool, speed] = self.tool;
                let drive = mass
                    * (2.0 * bandwidth * (velocity - speed) + bandwidth * bandwidth * (self.reference[0] - tool))
                    + mass * (velocity - v) / dt;
                let most = drive.clamp(-terms.most_force, terms.most_force);
                self.reference[0] += (most - drive) / (mass * bandwidth * bandwidth);
                let drive = most;
                let speed = speed + dt * (drive - force) / mass;
                self.tool = [tool + dt * speed, speed];
                force
            }
        };
        let sensed = force + terms.tool_mass * (self.tool[1] - speed_before) / dt;
        self.reading = sensed
            + (self.reading - sensed) * if terms.sensor_lag > 0.0 { (-dt / terms.sensor_lag).exp() } else { 0.0 };
        self.time += dt;
        force
    }
}

/// The number of parts that cover a ratio.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small positive numbers")]
fn whole(ratio: f64) -> usize {
    ratio.ceil() as usize
}

/// Number of steps of the simulation in a period.
fn substeps(terms: &Conditions) -> usize {
    let stiffness = match terms.event {
        Event::Layer(_, factor) | Event::Slope(_, factor) => terms.stiffness * factor.max(1.0),
        Event::Hole(_, _, stiffness) => terms.stiffness.max(stiffness),
        Event::Random(..) => STIFFNESS[1],
        _ => terms.stiffness,
    };
    let mut dt: f64 = 5e-5;
    if let Some((mass, bandwidth)) = terms.soft {
        dt = dt.min(0.05 / (stiffness / mass).sqrt().max(bandwidth));
    }
    for time in [terms.sensor_lag / 5.0, terms.lag / 10.0] {
        if time > 0.0 {
            dt = dt.min(time);
        }
    }
    whole(terms.period / dt)
}

/// Runs a controller. `see` gets time, force, reading and command of each period.
pub fn run(terms: &Conditions, controller: &mut dyn Controller, mut see: impl FnMut([f64; 4])) -> Outcome {
    let n = substeps(terms);
    let dt = terms.period / n as f64;
    let speed = if terms.at_rest { 0.0 } else { terms.speed };
    let start = if terms.at_rest { -AWAY } else { -terms.speed * (0.02 + terms.phase * terms.period) };
    let mut plant = Plant {
        terms,
        queue: std::iter::repeat_n(speed, terms.delay).collect(),
        reference: [start, speed],
        tool: [start, speed],
        time: 0.0,
        depth_at_event: None,
        random: match terms.event {
            Event::Random(rests, _) => Some(RandomWall::new(terms.stiffness, rests, terms.seed)),
            _ => None,
        },
        reading: 0.0,
    };
    let event = match terms.event {
        Event::None | Event::Layer(..) => f64::INFINITY,
        Event::Slope(t, _)
        | Event::Push(t, _)
        | Event::Leave(t, _)
        | Event::Hole(t, ..)
        | Event::LeaveAndReturn(t, ..)
        | Event::Swing(t, ..)
        | Event::HeldBack(t, ..)
        | Event::Random(t, _) => t,
    };
    let mut noise = Noise::new(terms.seed);
    let mut outcome = Outcome { least_after: f64::INFINITY, ..Outcome::default() };
    let (band, end) = ((0.05 * terms.target).max(1.0), terms.duration());
    let (mut touch, mut is_in, mut losses_at_end) = (None, false, 0);
    let (mut force, mut energy, mut beyond) = (0.0, 0.0, [0.0; 2]);
    let (mut outside, mut outside_after) = (None, None);
    let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
    let periods = whole(end / terms.period);
    for _ in 0..periods {
        let reading = terms.sign * plant.reading + terms.bias + terms.noise * noise.normal();
        let command = controller.command(reading, plant.tool);
        plant.queue.push_back(command);
        let active = plant.queue.pop_front().unwrap_or(command);
        for _ in 0..n {
            let before = (plant.tool[0], force);
            force = plant.advance(active, dt);
            let given = 0.5 * (before.1 + force) * (plant.tool[0] - before.0);
            energy += given;
            outcome.energy = outcome.energy.max(energy);
            let surplus = given - REFILL_SPEED * terms.target * dt;
            beyond = [beyond[0] + surplus, f64::max(0.0, beyond[1] + surplus)];
            outcome.beyond_refill = [0, 1].map(|i| outcome.beyond_refill[i].max(beyond[i]));
            let now = force > 0.0;
            if now {
                touch.get_or_insert(plant.time);
            }
            if is_in && !now {
                outcome.losses += 1;
                losses_at_end += usize::from(plant.time > end - 0.4);
            }
            is_in = now;
            if plant.time < event {
                outcome.peak = outcome.peak.max(force);
            } else {
                outcome.peak_after = outcome.peak_after.max(force);
                outcome.least_after = outcome.least_after.min(force);
            }
        }
        if touch.is_some() && (force - terms.target).abs() > band {
            if plant.time < event { outside = Some(plant.time) } else { outside_after = Some(plant.time) }
        }
        if plant.time > end - 0.4 {
            count += 1.0;
            sum += force - terms.target;
            squares += (force - terms.target).powi(2);
        }
        see([plant.time, force, reading, command]);
        if !(outcome.peak < 1e7) {
            break;
        }
    }
    outcome.settling = outside.zip(touch).map_or(0.0, |(outside, touch)| outside - touch);
    outcome.settling_after = outside_after.map_or(0.0, |outside| outside - event);
    if count > 0.0 {
        outcome.error = sum / count;
        outcome.rms = (squares / count - outcome.error * outcome.error).max(0.0).sqrt();
    }
    outcome.settled = count > 0.0 && losses_at_end == 0 && outcome.rms < band && outcome.error.abs() < band;
    outcome.hardest = plant.random.map_or([terms.stiffness, 0.0], |wall| wall.hardest);
    outcome.fault = controller.has_fault();
    outcome
}
