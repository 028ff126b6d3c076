//! The velocity of a surface that moves.
//!
//! The surface is at w = x_m − F/K_m, whatever the tool does. x_m is the *measured* position of the tool as the force sensor sees it, and
//! K_m the stiffness between it and the surface: a drive that yields moves neither. The velocity of w is that of two means,
//! v = (w − w̄)/τ with w̄ ← w̄ + (T/τ) (w − w̄): a long one, τ_s, with little noise, and a short one, τ_d, which shows a change.
//!
//! An error of K_m makes the share |1 − K/K_m| of the tool's own velocity relative to the surface look like one of the surface. So a
//! change counts from [`OWN_SHARE`] of that on, and only while no force says that K_m is wrong.

use super::estimate::StiffnessEstimate;
use super::settings::ContactSettings;
use super::swing::Swing;
use super::timing::ContactTiming;

/// Velocity that is no motion, m/s: swings of a contact on a drive that yields look like it.
const REST: f64 = 5e-4;

/// Uncertainties of a velocity below which it is no motion.
const SIGMAS: f64 = 3.0;

/// Share of the tool's velocity that an error of K_m may make look like one of the surface.
const OWN_SHARE: f64 = 0.25;

/// Multiple of the tool's velocity, in the other direction, that a contact makes look like one of the surface which has become 10 times as
/// stiff: K/K_m − 1, and a margin.
const STIFFER: f64 = 12.0;

/// Periods after which a change is believed.
const BELIEVED: f64 = 2.0;

/// τ_d after which a change is over: the short mean has reached 95 % of it.
const OVER: f64 = 3.0;

/// Share of F_d by which a force is off that refutes a stiffness.
const OFF: f64 = 0.2;

/// Factor of swings, and K̂ over K_m, up to which a change is believed. A held K̂ is twice K_m; above that a force has shown more.
const TRUSTED: (f64, f64) = (1.2, 2.05);

/// How a surface moves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfaceMotion {
    /// Measured position of the tool, m; the same as the force sensor sees it, x_m; and the short mean of that.
    pub tool: [f64; 3],
    /// What is known of the stiffness between x_m and the surface.
    pub stiffness: StiffnessEstimate,
    /// w̄, the long and the short mean, m.
    pub means: [f64; 2],
    /// K_m of these means, N/m; 0: the surface was not seen yet.
    pub slope: f64,
    /// The velocity of the long mean, m/s.
    pub slow: f64,
    /// How long the change from it has lasted, s.
    pub lasts: f64,
    /// The velocity that is fed forward, m/s.
    pub velocity: f64,
}

impl SurfaceMotion {
    /// No motion, no data.
    pub(super) const NONE: Self = Self {
        tool: [0.0; 3],
        stiffness: StiffnessEstimate::NONE,
        means: [0.0; 2],
        slope: 0.0,
        slow: 0.0,
        lasts: 0.0,
        velocity: 0.0,
    };

    /// Moves the tool by a way (m) in a time (s).
    pub(super) fn advance(&mut self, sensor_lag: f64, [way, time]: [f64; 2]) {
        let [before, sensed, _] = &mut self.tool;
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
        self.stiffness.restart_means(self.tool[1], force);
    }

    /// Lets the surface go on with its velocity for a period (s) in which it is not seen. One that comes, and is lost all the same, has stopped.
    pub(super) fn coast(&mut self, timing: &ContactTiming) {
        if self.velocity < 0.0 {
            self.velocity *= (-timing.period / timing.reaction).exp();
        }
        let way = timing.period * self.velocity;
        self.means = self.means.map(|mean| mean + way);
        self.tool[2] += way;
    }

    /// Returns whether the surface moves otherwise than over the long time.
    pub(super) fn is_changing(&self, timing: &ContactTiming) -> bool {
        self.lasts > BELIEVED * timing.period
    }

    /// Learns from a period in contact: F and F_d, N, how F swings, and whether the contact is held.
    ///
    /// Returns whether a held contact is less stiff than K̂.
    pub(super) fn learn(
        &mut self,
        terms: (&ContactSettings, &ContactTiming),
        forces: [f64; 2],
        (swing, is_held): (&Swing, bool),
    ) -> bool {
        let [way, change] = [self.tool[1] - self.stiffness.mean_position, forces[0] - self.stiffness.mean_force];
        self.stiffness.learn(terms, (self.tool[1], forces[0]), (is_held, self.slow));
        if !is_held {
            let velocity = self.coming(terms, [way, change]);
            *self = Self { tool: self.tool, stiffness: self.stiffness, velocity, ..Self::NONE };
            return false;
        }
        let is_refuted = refutes(terms.0, forces, [way, change]);
        if is_refuted {
            self.stiffness.refute();
        }
        self.follow(terms, forces, swing);
        is_refuted
    }

    /// Updates the means and the velocity.
    fn follow(&mut self, terms: (&ContactSettings, &ContactTiming), [force, target]: [f64; 2], swing: &Swing) {
        let ((settings, timing), slope) = (terms, self.stiffness.slope);
        if slope <= 0.0 {
            return;
        }
        let place = self.tool[1] - force / slope;
        if self.slope <= 0.0 {
            (self.means, self.tool[2]) = ([place; 2], self.tool[1]);
        } else {
            // Another stiffness moves the place, not the surface.
            let shift = force / self.slope - force / slope;
            self.means = self.means.map(|mean| mean + shift);
        }
        self.slope = slope;
        let times = [timing.surface, timing.reaction];
        let seen = [0, 1].map(|i| (place - self.means[i]) / times[i]);
        let own = (self.tool[1] - self.tool[2]) / timing.reaction;
        self.means = [0, 1].map(|i| self.means[i] + timing.period * seen[i]);
        self.tool[2] += timing.period * own;
        let [long, short] = times.map(|time| SIGMAS * noise(terms, slope, time));
        let rest = REST * settings.metre;
        self.slow = beyond(seen[0], long.max(rest));
        let band = short + OWN_SHARE * (own - self.velocity).abs() + rest;
        let is_trusted = swing.factor < TRUSTED.0 && self.stiffness.upper <= TRUSTED.1 * slope;
        let change = seen[1] - self.slow;
        let is_believable = is_trusted && !looks_like_a_stiffer_contact(change, own - self.slow);
        let change = if is_believable { beyond(change, band) } else { 0.0 };
        self.lasts = if change == 0.0 { 0.0 } else { self.lasts + timing.period };
        let is_believed = self.is_changing(timing) && (change < 0.0 || force > self.vanished(terms, target));
        let change = if is_believed { change } else { 0.0 };
        if self.lasts > OVER * timing.reaction {
            // The long mean goes on with that velocity.
            (self.means[0], self.lasts) = (place - timing.surface * (self.slow + change), 0.0);
        }
        self.velocity = (self.slow + change).clamp(-settings.followed_speed, settings.followed_speed);
    }

    /// Returns the force, N, that a sensor with a lag still reads of a surface that has vanished: it has jumped, and does not move.
    fn vanished(&self, (settings, timing): (&ContactSettings, &ContactTiming), target: f64) -> f64 {
        let time = (self.lasts - BELIEVED * timing.period).max(0.0);
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

/// Returns whether no stiffness explains the way (m) of the tool and the change of the force (N) within the window: the tool retreats, and a
/// force above F_d rises all the same; or it advances, and one below F_d falls.
fn refutes(settings: &ContactSettings, [force, target]: [f64; 2], [way, change]: [f64; 2]) -> bool {
    let error = force - target;
    let is_off = error.abs() > OFF * target && error * change > 0.0;
    is_off && change.abs() > SIGMAS * settings.noise && way * change < 0.0
}

/// Returns whether a velocity may come from the tool's own one (m/s) in a contact that has become stiffer: a surface that moves takes the tool
/// with it, and this one seems to move against the tool.
fn looks_like_a_stiffer_contact(velocity: f64, own: f64) -> bool {
    velocity * own < 0.0 && velocity.abs() < STIFFER * own.abs()
}

/// Returns the rms noise of a velocity over a time constant, m/s, at the stiffness K_m.
fn noise((settings, timing): (&ContactSettings, &ContactTiming), slope: f64, time: f64) -> f64 {
    let correlation = (1.0 + 2.0 * timing.sensor_lag / timing.period).sqrt();
    settings.noise / slope / time * (0.5 * timing.period / time).sqrt() * correlation
}

/// Returns a value from twice a band on, less of it within, and nothing within the band.
fn beyond(value: f64, band: f64) -> f64 {
    value * ((value.abs() - band) / band).clamp(0.0, 1.0)
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

    /// A held contact whose stiffness is known, on a surface at 0.
    fn held() -> SurfaceMotion {
        let (place, known) = (TARGET / STIFFNESS, StiffnessEstimate::NONE);
        let means = StiffnessEstimate { mean_position: place, mean_force: TARGET, ..known };
        let stiffness = StiffnessEstimate { upper: 2.0 * STIFFNESS, slope: STIFFNESS, ..means };
        let tool = [place; 3];
        SurfaceMotion { tool, stiffness, slope: STIFFNESS, ..SurfaceMotion::NONE }
    }

    /// Moves surface and tool for some periods, with velocities in m/s.
    fn moved(mut motion: SurfaceMotion, [surface, tool]: [f64; 2], periods: usize) -> SurfaceMotion {
        let (settings, timing, start) = (ContactSettings::default(), timing(), motion.tool[0] - TARGET / STIFFNESS);
        for k in 1..=periods {
            motion.advance(0.0, [tool * timing.period, timing.period]);
            let force = STIFFNESS * (motion.tool[0] - start - surface * timing.period * k as f64);
            motion.learn((&settings, &timing), [force, TARGET], (&Swing::NONE, true));
        }
        motion
    }

    #[test]
    fn a_surface_that_moves_is_known_within_three_reaction_times() {
        // In 36 ms, whether the tool follows it or not.
        for (velocity, tool) in [(0.01, 1.0), (0.01, 0.8), (-0.01, 1.0), (-0.01, 0.5), (0.03, 0.9)] {
            let motion = moved(held(), [velocity, tool * velocity], 18);
            assert!((motion.velocity / velocity - 1.0).abs() < 0.05, "{velocity} {tool}: {motion:?}");
        }
    }

    #[test]
    fn a_tool_that_presses_deeper_is_no_surface_that_moves() {
        // K_m is 20 % wrong.
        let stiffness = StiffnessEstimate { upper: 2.4 * STIFFNESS, slope: 1.2 * STIFFNESS, ..held().stiffness };
        let motion = moved(SurfaceMotion { stiffness, slope: 1.2 * STIFFNESS, ..held() }, [0.0, 0.01], 18);
        assert!(motion.velocity.abs() < 1e-3, "{motion:?}");
    }

    #[test]
    fn a_contact_that_has_become_stiffer_is_no_surface_that_moves() {
        let slope = 0.1 * STIFFNESS;
        for own in [0.01, -0.01] {
            let stiffness = StiffnessEstimate { upper: 2.0 * slope, slope, ..held().stiffness };
            let means = [held().tool[1] - TARGET / slope; 2];
            let motion = moved(SurfaceMotion { stiffness, means, slope, ..held() }, [0.0, own], 4);
            assert!((motion.velocity - motion.slow).abs() < 1e-9, "{own}: {motion:?}");
        }
    }

    #[test]
    fn a_force_that_moves_against_the_tool_refutes_a_stiffness() {
        // The tool retreats and the force rises, or the tool advances and the force falls; with a spring both go together.
        for (surface, tool, is_stiff) in [(-0.02, -0.01, false), (0.02, 0.01, false), (0.0, 0.01, true)] {
            let stiffness = StiffnessEstimate { upper: 20.0 * STIFFNESS, ..held().stiffness };
            let motion = moved(SurfaceMotion { stiffness, ..held() }, [surface, tool], 30);
            assert_eq!(motion.stiffness.upper > 2.1 * STIFFNESS, is_stiff, "{surface} {tool}: {motion:?}");
        }
    }

    #[test]
    fn a_surface_that_comes_is_known_without_its_stiffness() {
        let (settings, timing) = (ContactSettings::default(), timing());
        let mut motion = SurfaceMotion::NONE;
        motion.touch(&settings, 10.0);
        for k in 0..100 {
            motion.advance(0.0, [-0.02 * timing.period, timing.period]);
            motion.learn((&settings, &timing), [10.0 + f64::from(k), TARGET], (&Swing::NONE, false));
        }
        assert!(motion.velocity < -0.015 && motion.velocity >= -0.02, "{motion:?}");
    }
}
