//! The upper estimate of the stiffness.

use super::settings::ContactSettings;
use super::timing::ContactTiming;

/// γ, K̂ over the estimate.
const MARGIN: f64 = 1.25;

/// K̂ over the slope, below which K̂ does not fall while the contact is held.
const HELD_MARGIN: f64 = 2.0;

/// Factor by which K̂ grows with bounces and swings.
const DOUBT: f64 = 4.0;

/// n_z, dead zone of the estimator in units of σ.
const DEAD_ZONE: f64 = 10.0;

/// Factor on the window of the means until a slope is known, in periods that teach nothing: a tool that sinks slowly into a soft contact
/// leaves the dead zone then.
const PATIENCE: f64 = 3.0;

/// N_i, memory of the estimator in samples of information.
const SAMPLES: f64 = 1000.0;

/// Multiple of its uncertainty by which K̂ exceeds the estimate, and by which a slope is known.
const SIGMAS: f64 = 3.0;

/// Noise of a single sample that may look like stiffness, in units of σ.
const SAMPLE_SIGMAS: f64 = 4.0;

/// Rate at which the uncertainty grows with the number of samples.
const CORRELATION: f64 = 0.7;

/// Uncertainty over the slope, and share of the squared force that the motion explains, of a slope that is known.
const KNOWN: f64 = 0.1;
const EXPLAINED: f64 = 0.98;

/// Acceleration of a surface that the filter of a held contact need not foresee, m/s².
const UNFORESEEN: f64 = 0.3;

/// Share of the force that a surface changes within τ_t which sets off at [`FASTEST`]: what the force does not foresee changes its rate by
/// no more. A force that jumps is no motion.
const SETS_OFF: f64 = 0.4;

/// Speed of a surface that sets off, m/s.
const FASTEST: f64 = 0.05;

/// Noise of x and F over the scatter of what is not foreseen. That of a position has a margin, because nobody states it; that of a force has
/// the stated one below it.
const NOISE: [f64; 2] = [1.2, 0.8];

/// What the contact law knows of the stiffness.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StiffnessEstimate {
    /// K̂, upper estimate, N/m.
    pub upper: f64,
    /// K_l, the last slope that was known, N/m; 0: none yet.
    pub slope: f64,
    /// Uncertainty of that slope, rms, N/m; 0: none yet.
    pub uncertainty: f64,
    /// x̄, running mean of the position, m.
    pub mean_position: f64,
    /// F̄, running mean of the force, N.
    pub mean_force: f64,
    /// S_xx, m².
    pub squared_position: f64,
    /// S_xF, N·m.
    pub product: f64,
    /// S_FF, N².
    pub squared_force: f64,
    /// n, number of samples.
    pub samples: f64,
    /// x and F as they are followed while the contact is held, m and N; 0, 0: it is not held.
    pub followed: [f64; 2],
    /// Their rates, m/s and N/s.
    pub rates: [f64; 2],
    /// What was not foreseen of x and F in the last period, m and N.
    pub unforeseen: [f64; 2],
    /// Rms of its changes from period to period, over √2: the noise.
    pub scatter: [f64; 2],
}

/// What is known of a held contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Held {
    /// Velocity of the surface, m/s.
    pub surface_velocity: f64,
    /// Whether the target has changed within the window.
    pub target_has_changed: bool,
}

impl StiffnessEstimate {
    /// Nothing.
    pub(super) const NONE: Self = Self {
        upper: 0.0,
        slope: 0.0,
        uncertainty: 0.0,
        mean_position: 0.0,
        mean_force: 0.0,
        squared_position: 0.0,
        product: 0.0,
        squared_force: 0.0,
        samples: 0.0,
        followed: [0.0; 2],
        rates: [0.0; 2],
        unforeseen: [0.0; 2],
        scatter: [0.0; 2],
    };

    /// Returns whether all numbers are finite and in their ranges.
    pub(super) fn is_valid(&self) -> bool {
        let Self { upper, slope, uncertainty, mean_position, mean_force, .. } = *self;
        let Self { squared_position, product, squared_force, samples, .. } = *self;
        let positive = [upper, slope, uncertainty, squared_position, squared_force, samples];
        let signed = [mean_position, mean_force, product];
        signed.iter().chain(&self.followed).chain(&self.rates).chain(&self.unforeseen).all(|value| value.is_finite())
            && positive.iter().chain(&self.scatter).all(|value| value.is_finite() && *value >= 0.0)
    }

    /// Returns the estimate at a first contact: the stiffest one, without data; x_s (m), F (N).
    pub(super) fn start(settings: &ContactSettings, position: f64, force: f64) -> Self {
        Self { upper: settings.stiffest, mean_position: position, mean_force: force, ..Self::default() }
    }

    /// Returns the best known stiffness, N/m.
    pub(super) fn best(&self) -> f64 {
        if self.slope > 0.0 { self.slope } else { self.upper }
    }

    /// Returns whether the slope is known well, for a noise σ (N): its uncertainty is small, and the motion of the tool explains the force.
    pub(super) fn is_known(&self, sigma: f64) -> bool {
        let changes = (self.squared_force - self.samples * sigma * sigma).max(0.0);
        self.slope > 0.0
            && self.uncertainty < KNOWN * self.slope
            && self.product * self.product > EXPLAINED * self.squared_position * changes
    }

    /// Starts means and filters at x_s (m) and F (N), on a surface with a velocity (m/s).
    pub(super) fn restart(&mut self, [position, force]: [f64; 2], velocity: f64) {
        (self.mean_position, self.mean_force) = (position, force);
        (self.followed, self.rates) = ([position, force], [velocity, 0.0]);
    }

    /// Raises K̂, and forgets what it rests on: a contact that bounces or swings is stiffer than was thought. Returns the factor.
    pub(super) fn doubt(&mut self, settings: &ContactSettings) -> f64 {
        let upper = (DOUBT * self.upper).min(settings.stiffest);
        let factor = if self.upper > 0.0 { upper / self.upper } else { 1.0 };
        let Self { mean_position, mean_force, .. } = *self;
        *self = Self { upper, mean_position, mean_force, ..Self::default() };
        factor
    }

    /// Learns from x_s (m) and F (N) of a period in contact. It learns only from motion that the noise does not hide.
    ///
    /// While the contact is held, the slope stays and K̂ does not fall below twice the slope: motion with little change of the force
    /// then comes from a surface that moves, and a K̂ that is too large is only slow.
    pub(super) fn learn(
        &mut self,
        terms: (&ContactSettings, &ContactTiming),
        (position, force): (f64, f64),
        held: Option<Held>,
    ) {
        let (settings, timing) = terms;
        // Of a contact whose stiffness is not known, nothing is held.
        let held = held.filter(|_| self.slope > 0.0);
        self.mean_position += timing.period * held.map_or(0.0, |held| held.surface_velocity);
        let (x, f) = (position - self.mean_position, force - self.mean_force);
        if let Some(held) = held {
            // A force that falls as the tool goes deeper is no stiffness: the surface moves.
            let is_caused = held.target_has_changed && held.surface_velocity == 0.0 && x * f >= 0.0;
            if is_caused {
                self.teach(terms, (x, f), [settings.noise; 2], true);
            }
            self.follow(terms, (position, force), !is_caused);
        } else {
            (self.followed, self.rates) = ([0.0; 2], [0.0; 2]);
            (self.unforeseen, self.scatter) = ([0.0; 2], [0.0; 2]);
            self.teach(terms, (x, f), [settings.noise; 2], false);
        }
        let waits = self.slope == 0.0 && !self.exceeds_dead_zone(x, settings.noise);
        let share = timing.period / timing.window / if waits { PATIENCE } else { 1.0 };
        self.mean_position += share * x;
        self.mean_force += share * f;
    }

    /// Returns whether a motion (m) changes the force by more than a noise σ (N) hides, if the contact is as stiff as K̂.
    fn exceeds_dead_zone(&self, x: f64, sigma: f64) -> bool {
        x.abs() * self.upper > DEAD_ZONE * sigma
    }

    /// Learns from a sample whose motion exceeds what noise or a surface explains, `motion` over K̂; `noise`: σ of its force. Both are N.
    fn teach(
        &mut self,
        terms: (&ContactSettings, &ContactTiming),
        (x, f): (f64, f64),
        [motion, noise]: [f64; 2],
        is_held: bool,
    ) {
        if self.exceeds_dead_zone(x, motion) {
            self.add(terms, (x, f), noise);
            self.update(terms, noise, is_held);
        }
    }

    /// Follows position and force of a held contact by two filters of second order with both poles at τ_t. What they do not foresee teaches
    /// K̂, if it `teaches`: steady motion of tool and surface does not.
    fn follow(&mut self, terms: (&ContactSettings, &ContactTiming), (position, force): (f64, f64), teaches: bool) {
        let (settings, timing) = terms;
        if self.followed[1] == 0.0 {
            self.followed = [position, force];
        }
        let kept = (-timing.period / timing.tracking).exp();
        let [nearer, faster] = [1.0 - kept * kept, (1.0 - kept) * (1.0 - kept) / timing.period];
        let foreseen = [0, 1].map(|i| self.followed[i] + timing.period * self.rates[i]);
        let (x, f) = (position - foreseen[0], force - foreseen[1]);
        let share = timing.period / timing.window;
        for (i, value) in [x, f].into_iter().enumerate() {
            let change = value - self.unforeseen[i];
            self.scatter[i] =
                ((1.0 - share) * self.scatter[i] * self.scatter[i] + 0.5 * share * change * change).sqrt();
        }
        self.unforeseen = [x, f];
        let [_, noise] = self.noise(settings);
        if teaches {
            let sets_off = self.slope * UNFORESEEN * settings.metre * timing.tracking * timing.tracking;
            self.teach(terms, (x, f), [noise.hypot(sets_off), noise], true);
        }
        let most = (SETS_OFF * self.slope * FASTEST * settings.metre * timing.tracking).max(SAMPLE_SIGMAS * noise);
        self.followed = [foreseen[0] + nearer * x, foreseen[1] + nearer * f];
        self.rates = [self.rates[0] + faster * x, self.rates[1] + faster * f.clamp(-most, most)];
    }

    /// Returns the noise of x_s and F, rms, m and N: what changes from period to period of what is not foreseen, which a surface that sets off
    /// does not. That of F is the stated one at least.
    pub(super) fn noise(&self, settings: &ContactSettings) -> [f64; 2] {
        let [position, force] = self.scatter;
        [NOISE[0] * position, (NOISE[1] * force).max(settings.noise)]
    }

    /// Replaces all samples by a single one.
    fn replace(&mut self, settings: &ContactSettings, (x, f): (f64, f64), least: f64) {
        (self.squared_position, self.product, self.squared_force, self.samples) = (x * x, x * f, f * f, 1.0);
        self.upper = (MARGIN * least).min(settings.stiffest);
    }

    /// Adds a sample with the noise σ (N). A single one that shows more stiffness than K̂ replaces all others.
    fn add(&mut self, (settings, timing): (&ContactSettings, &ContactTiming), (x, f): (f64, f64), sigma: f64) {
        let least = (f.abs() - SAMPLE_SIGMAS * sigma) / x.abs();
        if x * f > 0.0 && least > self.upper {
            self.replace(settings, (x, f), least);
        } else {
            self.squared_position += x * x;
            self.product += x * f;
            self.squared_force += f * f;
            self.samples += 1.0;
        }
        // Forgets as fast as information arrives.
        let noise = inflation(timing) * sigma / self.upper;
        let most = SAMPLES * noise * noise;
        if self.squared_position > most {
            let share = most / self.squared_position;
            self.squared_position *= share;
            self.product *= share;
            self.squared_force *= share;
            self.samples *= share;
        }
    }

    /// Updates K̂ and the slope from the sums. A negative slope is no stiffness: the data are not from one contact.
    fn update(&mut self, (settings, timing): (&ContactSettings, &ContactTiming), sigma: f64, is_held: bool) {
        // With σ = 0 the memory may be empty.
        if self.squared_position <= 0.0 {
            return;
        }
        let variance = sigma * sigma;
        let slope = self.product / self.squared_position;
        let gain = ((self.squared_force - self.samples * variance).max(0.0) / self.squared_position).sqrt();
        let uncertainty =
            sigma * (inflation(timing) + CORRELATION * self.samples.sqrt()) / self.squared_position.sqrt();
        if slope > -uncertainty {
            let estimate = (MARGIN * gain + SIGMAS * uncertainty).clamp(settings.softest, settings.stiffest);
            let decayed = self.upper * (-timing.period / timing.fall).exp();
            let kept = if is_held { self.upper.min(HELD_MARGIN * self.slope) } else { 0.0 };
            let least = decayed.max(kept);
            self.upper = estimate.max(least);
        }
        if slope > SIGMAS * uncertainty && !is_held {
            (self.slope, self.uncertainty) = (slope.min(settings.stiffest), uncertainty.min(settings.stiffest));
        }
    }
}

/// Returns i = √(1 + 2 τ_f/T): how many samples behind a filter count as one.
fn inflation(timing: &ContactTiming) -> f64 {
    (1.0 + 2.0 * timing.sensor_lag / timing.period).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Drive;

    fn timing() -> ContactTiming {
        ContactTiming::new(0.001, Drive::IDEAL, 0.002, 0.0)
    }

    /// Moves into a spring of the stiffness K, and returns the estimate.
    fn after_motion(stiffness: f64, travel: f64) -> StiffnessEstimate {
        let settings = ContactSettings::default();
        let mut estimate = StiffnessEstimate::start(&settings, 0.0, 0.0);
        for i in 1..=500 {
            let x = travel * f64::from(i) / 500.0;
            estimate.learn((&settings, &timing()), (x, stiffness * x), None);
        }
        estimate
    }

    #[test]
    fn the_estimate_falls_from_the_stiffest_contact_to_a_bound_of_the_true_one() {
        for stiffness in [1e3, 1e4, 1e5] {
            let estimate = after_motion(stiffness, 30.0 / stiffness);
            assert!((estimate.slope / stiffness - 1.0).abs() < 1e-9, "{stiffness}: {estimate:?}");
            assert!(estimate.upper > 1.25 * stiffness && estimate.upper < 1.6 * stiffness, "{stiffness}: {estimate:?}");
        }
    }

    #[test]
    fn motion_that_the_noise_hides_teaches_nothing() {
        let estimate = after_motion(1e3, 1e-6);
        assert_eq!((estimate.upper, estimate.samples), (1e6, 0.0));
    }

    #[test]
    fn a_stiffer_sample_raises_the_estimate_at_once() {
        let settings = ContactSettings::default();
        let mut estimate = after_motion(1e3, 0.03);
        let (x, f) = (estimate.mean_position + 0.005, estimate.mean_force + 250.0);
        let held = Held { surface_velocity: 0.0, target_has_changed: true };
        estimate.learn((&settings, &timing()), (x, f), Some(held));
        assert!(estimate.upper > 1.24 * 49_000.0, "{estimate:?}");
    }
}
