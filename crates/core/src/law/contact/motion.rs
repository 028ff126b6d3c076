//! The velocity of a surface that moves.
//!
//! The surface is at w = x_m − F/K_m, whatever the tool does. x_m is the *measured* position of the tool as the force sensor sees it, and
//! K_m the stiffness between it and the surface: a drive that yields moves neither. So its velocity is v_w = v_x − v_F/K_m, with the rates
//! of x_m and F from filters of the time constant τ_t. Its acceleration a is that of a mean of v_w over 2 τ_t, and v_w + a t is fed forward,
//! where t is by how much filter, sensor and drive are late.
//!
//! An error of K_m makes the share |1 − K/K_m| of the tool's own velocity relative to the surface look like one of the surface.

use super::estimate::{Held, StiffnessEstimate};
use super::settings::ContactSettings;
use super::swing::Swing;
use super::timing::ContactTiming;

/// Velocity that is no motion, m/s, and as a share of F_d/(K_m τ_c), with which a missing force is made up for: swings of a contact on a
/// drive that yields look like it.
const REST: f64 = 5e-4;
const RESTORING: f64 = 0.05;

/// Uncertainties of a velocity below which it is no motion.
const SIGMAS: f64 = 3.0;

/// Multiple of the tool's velocity, in the other direction, that a contact which has become 10 times as stiff makes look like one of the
/// surface: K/K_m − 1 behind filters, and a margin.
const STIFFER: f64 = 30.0;

/// Time of the short mean over τ_t.
const SHORT: f64 = 2.0;

/// τ_d after which the long mean takes over.
const OVER: f64 = 3.0;

/// Share of F_d by which F is off where nothing that enlarges its error is fed forward.
const ENLARGED: f64 = 0.3;

/// How a surface moves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfaceMotion {
    /// Measured position of the tool, m; the same as the force sensor sees it, x_m.
    pub tool: [f64; 2],
    /// What is known of the stiffness between x_m and the surface.
    pub stiffness: StiffnessEstimate,
    /// Means of v_w over τ_s and over 2 τ_t, m/s.
    pub means: [f64; 2],
    /// How long the surface has been seen to move, s.
    pub lasts: f64,
    /// The velocity that is fed forward, m/s.
    pub velocity: f64,
}

impl SurfaceMotion {
    /// No motion, no data.
    pub(super) const NONE: Self =
        Self { tool: [0.0; 2], stiffness: StiffnessEstimate::NONE, means: [0.0; 2], lasts: 0.0, velocity: 0.0 };

    /// Moves the tool by a way (m) in a time (s).
    pub(super) fn advance(&mut self, sensor_lag: f64, [way, time]: [f64; 2]) {
        let [before, sensed] = &mut self.tool;
        *sensed = lagging(sensor_lag, (*before, *sensed), [way, time]);
        *before += way;
    }

    /// Begins with a touch at the force F, N.
    pub(super) fn touch(&mut self, settings: &ContactSettings, force: f64) {
        let stiffness = StiffnessEstimate::start(settings, self.tool[1], force);
        *self = Self { tool: self.tool, stiffness, ..Self::NONE };
    }

    /// Goes on with a surface that was lost and is found again.
    pub(super) fn find_again(&mut self, force: f64) {
        self.stiffness.restart([self.tool[1], force], self.velocity);
    }

    /// Lets the surface go on with its velocity for a period in which it is not seen. One that comes, and is lost all the same, has stopped.
    pub(super) fn coast(&mut self, timing: &ContactTiming) {
        if self.velocity < 0.0 {
            self.velocity *= (-timing.period / timing.reaction).exp();
        }
    }

    /// Returns whether the surface has been seen to move for longer than τ_t.
    pub(super) fn is_seen(&self, timing: &ContactTiming) -> bool {
        self.lasts > timing.tracking
    }

    /// Learns from a period in contact: F and F_d, N, how F swings, and what is known of a held contact. `is_read`: the reading changes;
    /// the velocity of a held contact stays otherwise.
    pub(super) fn learn(
        &mut self,
        terms: (&ContactSettings, &ContactTiming),
        forces: [f64; 2],
        (swing, held): (&Swing, Option<Held>),
        is_read: bool,
    ) {
        let [way, change] = [self.tool[1] - self.stiffness.mean_position, forces[0] - self.stiffness.mean_force];
        self.stiffness.learn(terms, (self.tool[1], forces[0]), held);
        if held.is_some() {
            if is_read {
                self.follow(terms, forces, swing);
            }
        } else {
            let velocity = self.coming(terms, [way, change]);
            *self = Self { tool: self.tool, stiffness: self.stiffness, velocity, ..Self::NONE };
        }
    }

    /// Updates the means and the velocity.
    fn follow(&mut self, terms: (&ContactSettings, &ContactTiming), forces: [f64; 2], swing: &Swing) {
        let ((settings, timing), slope) = (terms, self.stiffness.slope);
        if slope <= 0.0 {
            return;
        }
        let [own, rate] = self.stiffness.rates;
        let (seen, short) = (own - rate / slope, SHORT * timing.tracking);
        let acceleration = (seen - self.means[1]) / short;
        let [position_noise, force_noise] = self.stiffness.noise(settings);
        let place_noise = position_noise.hypot(force_noise / slope);
        let (noise, rest) = (rate_noise(timing, place_noise), rest_velocity(terms, slope, forces[1]));
        let is_stiffer = looks_like_a_stiffer_contact(seen, own);
        // Noise stays in the long mean, which would not be zero at rest otherwise.
        let meant = if is_stiffer && seen.abs() > SIGMAS * noise { 0.0 } else { seen };
        self.means[0] += timing.period / timing.surface * (meant - self.means[0]);
        self.means[1] += timing.period * acceleration;
        let slow = beyond(self.means[0], rest.max(SIGMAS * mean_noise(timing, place_noise)));
        let is_moving = self.is_seen(timing) || slow != 0.0;
        let (band, patience) = begins(timing, is_moving, [noise, rest], swing);
        let counts = seen.abs() > band && !is_stiffer;
        self.lasts = if counts { self.lasts + timing.period } else { 0.0 };
        let is_believed = self.lasts > patience && (seen < 0.0 || forces[0] > self.vanished(terms, forces[1]));
        let ahead = (timing.following + short) * beyond(acceleration, SIGMAS * noise / short);
        let velocity = if is_believed { seen + ahead } else { slow };
        if self.lasts > OVER * timing.reaction {
            // The long mean goes on with that velocity.
            self.means[0] = seen;
        }
        let velocity = velocity * useful_share(velocity, forces);
        self.velocity = velocity.clamp(-settings.followed_speed, settings.followed_speed);
    }

    /// Returns the force, N, that a sensor with a lag still reads of a surface that has vanished: it has jumped, and does not move.
    fn vanished(&self, (settings, timing): (&ContactSettings, &ContactTiming), target: f64) -> f64 {
        let time = (self.lasts - timing.tracking).max(0.0);
        let left = if timing.sensor_lag > 0.0 { (-time / timing.sensor_lag).exp() } else { 0.0 };
        (target * left).max(settings.threshold())
    }

    /// Returns the velocity of a surface that comes, m/s, from the way (m) of the tool and the change of the force (N) within the window.
    ///
    /// The tool retreats, and the force rises all the same: then the surface comes at the speed of the tool at least, whatever K_m is.
    fn coming(&self, (settings, timing): (&ContactSettings, &ContactTiming), [way, change]: [f64; 2]) -> f64 {
        let is_coming = way < -REST * settings.metre * timing.window && change > SIGMAS * settings.noise;
        let speed = if is_coming { way / timing.window } else { 0.0 };
        let before = self.velocity.min(0.0) * (-timing.period / timing.surface).exp();
        speed.min(before).max(-settings.followed_speed)
    }
}

/// Returns the velocity (m/s) beyond which and the time (s) after which a surface moves, for the noise of its velocity and the velocity that is no
/// motion. One that moves already need not exceed more than the noise.
fn begins(timing: &ContactTiming, is_moving: bool, [noise, rest]: [f64; 2], swing: &Swing) -> (f64, f64) {
    if is_moving {
        (noise, timing.tracking)
    } else {
        (SIGMAS * noise + rest, timing.tracking * swing.factor * swing.factor)
    }
}

/// Returns which share of a velocity (m/s) is fed forward: the less, the more it would enlarge the error of F (N).
fn useful_share(velocity: f64, [force, target]: [f64; 2]) -> f64 {
    let error = force / target - 1.0;
    (1.0 - error * velocity.signum() / ENLARGED).clamp(0.0, 1.0)
}

/// Returns whether a velocity may come from the tool's own one (m/s) in a contact that has become stiffer: a surface that moves takes the tool
/// with it, and this one seems to move against the tool.
fn looks_like_a_stiffer_contact(velocity: f64, own: f64) -> bool {
    velocity * own < 0.0 && velocity.abs() < STIFFER * own.abs()
}

/// Returns the velocity that is no motion, m/s.
fn rest_velocity((settings, timing): (&ContactSettings, &ContactTiming), slope: f64, target: f64) -> f64 {
    (REST * settings.metre).min(RESTORING * target / (slope * timing.contact))
}

/// Returns the rms noise of v_w, m/s, for that of the place of the surface, m: that of the second-order filter.
fn rate_noise(timing: &ContactTiming, place: f64) -> f64 {
    let kept = (-timing.period / timing.tracking).exp();
    let [nearer, faster] = [1.0 - kept * kept, (1.0 - kept) * (1.0 - kept)];
    let variance = 2.0 * faster * faster / (nearer * (4.0 - 2.0 * nearer - faster));
    place / timing.period * variance.sqrt() * correlation(timing)
}

/// Returns the rms noise of the mean of v_w over τ_s, m/s, for that of the place of the surface, m.
fn mean_noise(timing: &ContactTiming, place: f64) -> f64 {
    let time = timing.surface;
    place / time * (0.5 * timing.period / time).sqrt() * correlation(timing)
}

fn correlation(timing: &ContactTiming) -> f64 {
    (1.0 + 2.0 * timing.sensor_lag / timing.period).sqrt()
}

/// Returns a value from twice a band on, less of it within, and nothing within the band.
fn beyond(value: f64, band: f64) -> f64 {
    if value.abs() <= band { 0.0 } else { value * ((value.abs() - band) / band).min(1.0) }
}

/// Returns where a lag (s) sees a position that has moved from `before` by a way (m) in a time (s), at a constant speed; `seen`: where it saw it then.
pub(super) fn lagging(lag: f64, (before, seen): (f64, f64), [way, time]: [f64; 2]) -> f64 {
    let after = before + way;
    if lag > 0.0 && time > 0.0 {
        let behind = way / time * lag;
        after - behind + (seen - before + behind) * (-time / lag).exp()
    } else {
        after
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Drive;

    /// K, N/m.
    const STIFFNESS: f64 = 3e4;
    /// F_d, N.
    const TARGET: f64 = 30.0;

    fn timing() -> ContactTiming {
        ContactTiming::new(0.002, Drive { lag_s: 0.005, delay_periods: 1 }, 0.0, 0.0)
    }

    /// A held contact whose stiffness is thought to be K_m, N/m, on a surface at 0.
    fn held(slope: f64) -> SurfaceMotion {
        let place = TARGET / STIFFNESS;
        let stiffness = StiffnessEstimate {
            upper: 2.0 * slope,
            slope,
            mean_position: place,
            mean_force: TARGET,
            followed: [place, TARGET],
            ..StiffnessEstimate::NONE
        };
        SurfaceMotion { tool: [place; 2], stiffness, ..SurfaceMotion::NONE }
    }

    /// Moves surface and tool for some periods, with velocities in m/s at a time in s; returns the largest velocity that was fed forward, too.
    fn moved(mut motion: SurfaceMotion, periods: usize, velocities: impl Fn(f64) -> [f64; 2]) -> (SurfaceMotion, f64) {
        let (settings, timing) = (ContactSettings { noise: 0.02, ..ContactSettings::default() }, timing());
        let (mut depth, mut largest) = (TARGET / STIFFNESS, 0.0_f64);
        for k in 0..periods {
            let [surface, tool] = velocities(k as f64 * timing.period);
            motion.advance(0.0, [tool * timing.period, timing.period]);
            depth += (tool - surface) * timing.period;
            let held = Held { surface_velocity: motion.velocity, target_has_changed: false };
            motion.learn((&settings, &timing), [STIFFNESS * depth, TARGET], (&Swing::NONE, Some(held)), true);
            largest = largest.max(motion.velocity.abs());
        }
        (motion, largest)
    }

    #[test]
    fn a_surface_that_moves_is_known_within_three_reaction_times() {
        // In 36 ms, whether the tool follows it or not.
        for (velocity, tool) in [(0.01, 1.0), (0.01, 0.8), (-0.01, 1.0), (-0.01, 0.5), (0.03, 0.9)] {
            let (motion, _) = moved(held(STIFFNESS), 18, |_| [velocity, tool * velocity]);
            assert!((motion.velocity / velocity - 1.0).abs() < 0.1, "{velocity} {tool}: {motion:?}");
        }
    }

    #[test]
    fn a_surface_that_swings_is_foreseen_by_the_reaction_time() {
        // 1 Hz and 3 mm: the velocity changes by 1.2 mm/s while the tool follows, and by up to 19 mm/s in all.
        let velocity = |time: f64| 0.019 * (std::f64::consts::TAU * time).sin();
        let (motion, _) = moved(held(STIFFNESS), 575, |time| [velocity(time); 2]);
        let now = 574.0 * timing().period;
        let ahead = velocity(now + timing().following);
        assert!((motion.velocity - ahead).abs() < 6e-4, "{ahead}: {motion:?}");
        assert!((motion.velocity - velocity(now)).abs() > 6e-4, "without what the acceleration adds: {motion:?}");
    }

    #[test]
    fn a_contact_that_has_become_stiffer_is_no_surface_that_moves() {
        for own in [0.01, -0.01] {
            let (motion, largest) = moved(held(0.1 * STIFFNESS), 6, |_| [0.0, own]);
            assert!(largest == 0.0, "{own}: {motion:?}");
        }
    }

    #[test]
    fn what_would_enlarge_the_error_of_the_force_is_not_fed_forward() {
        // The surface seems to leave, and the force is above its target.
        assert!(useful_share(0.01, [33.0, 30.0]) < 0.7);
        assert!(useful_share(0.01, [39.0, 30.0]).abs() < 1e-9);
        assert!(useful_share(-0.01, [39.0, 30.0]) == 1.0 && useful_share(0.01, [20.0, 30.0]) == 1.0);
    }

    #[test]
    fn a_surface_that_comes_is_known_without_its_stiffness() {
        let (settings, timing) = (ContactSettings::default(), timing());
        let mut motion = SurfaceMotion::NONE;
        motion.touch(&settings, 10.0);
        for k in 0..100 {
            motion.advance(0.0, [-0.02 * timing.period, timing.period]);
            motion.learn((&settings, &timing), [10.0 + f64::from(k), TARGET], (&Swing::NONE, None), true);
        }
        assert!(motion.velocity < -0.015 && motion.velocity >= -0.02, "{motion:?}");
    }
}
