//! One period of one axis: the states and the velocity of the contact law.

use super::approach::{largest_approach_speed, unavoidable_peak};
use super::axis::{ContactAxis, ContactPhase, FaultCause, HELD};
use super::estimate::Held;
use super::report::ContactReport;
use super::settings::ContactSettings;
use super::timing::ContactTiming;

/// β, the share of F_d by which the prediction may exceed it before the emergency stop begins.
const OVERSHOOT: f64 = 0.1;

/// Share of a that the emergency stop plans with.
const STOP_SHARE: f64 = 0.8;

/// Periods without any force after which the next touch is slower.
const BRIEF: f64 = 0.5;

/// Periods of full acceleration with which an approach resumes after a suspicion.
const RESUMED: f64 = 2.0;

/// Periods of suspicion that are a contact, if the reaction time is shorter.
const SUSPICIONS: f64 = 2.0;

/// Rate at which that clock runs back while the force is away.
const AWAY: f64 = 0.5;

/// The same while it is off by [`STAYS`] at most.
const SLOWLY_AWAY: f64 = 0.1;

/// Share of F_d within which a force does not count as away: an axis that is not the normal of the surface keeps an error while the tool slides.
const STAYS: f64 = 0.3;

/// Share of F_d by which it differs from its mean over the window if it has changed.
const CHANGED: f64 = 0.05;

/// Factor of swings above which the stiffness is learnt anew.
const RELEARNT: f64 = 4.0;

/// Share of F_d by which F exceeded it before a bounce that shows a K̂ which is too small.
const HAMMERS: f64 = 0.2;

/// How near that is: a share of F_d, or of f₅.
const NEAR: (f64, f64) = (0.1, 1.0);

/// Time in contact after which a loss does not slow the next touch down, s.
const LONG_CONTACT: f64 = 0.5;

/// Slowest way back to a lost surface, m/s.
const SLOWEST_RETURN: f64 = 1e-3;

/// Share of its velocity by which the tool is faster than a surface that has left.
const CHASE: f64 = 0.25;

/// Longest time for which a surface is thought to move on after a loss, s. What the tool meets later is a new surface, of unknown stiffness.
const LONGEST_CHASE: f64 = 0.1;

/// How far behind its place a lost surface of known stiffness may be, m.
const LOST_DEPTH: f64 = 1e-4;

/// Way that a surface may push the tool back without a stop, m. A force that stays longer in a retreat is none of a surface: its sign or
/// its axes are wrong, or its bias exceeds the target.
const LONGEST_PUSH: f64 = 0.1;

/// Share of the softest stiffness by which a force falls at least while the tool retreats from a surface.
const FALLS: f64 = 0.5;

/// Noise of a force that is compared with another one, in units of σ.
const DIFFERENCE: f64 = 6.0;

/// How far below −f₅ a force is a pull, in units of σ: noise of the stated size reaches 8 σ in no run.
const PULL: f64 = 3.0;

/// Way back after a fault, m, and its speed, m/s, where no deep contact makes it faster.
const FAULT_RETREAT: (f64, f64) = (0.006, 0.05);

/// Longest way back from a force that is still there, m.
const LONGEST_RETREAT: f64 = 0.05;

/// F_max over F_d: what the energy tank provides for.
const TANK_SHARE: f64 = 1.2;

/// What an axis is told in a period, along its pressing direction. For an axis of rotation read N·m for N and rad for m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisInput {
    /// F, measured force of the tool on the environment, N.
    pub force: f64,
    /// The force that `max_force` limits, N: F, or |f| in all directions on a surface whose normal is only estimated; in an approach with
    /// what no axis presses.
    pub limited_force: f64,
    /// F_d, target force, N, positive.
    pub target: f64,
    /// How far the tool was measured to move since the last period, m, and in what time, s.
    pub moved: [f64; 2],
    /// p − x, how far the tool moves on if all later commands are zero, m.
    pub to_rest: f64,
    /// u⁻, the velocity that the last command has achieved, m/s.
    pub last_velocity: f64,
    /// a, the acceleration that the joints can give, m/s².
    pub acceleration: f64,
}

/// Returns how near its target a force counts as near, N; `target`: F_d, N.
fn near(settings: &ContactSettings, target: f64) -> f64 {
    (NEAR.0 * target).max(NEAR.1 * settings.threshold())
}

/// An axis with all that its period needs.
pub(super) struct Step<'a> {
    pub settings: &'a ContactSettings,
    pub timing: &'a ContactTiming,
    pub input: AxisInput,
    pub axis: &'a mut ContactAxis,
}

impl Step<'_> {
    /// Updates the axis; returns the velocity u that the law wants, m/s, and the report.
    pub fn run(mut self) -> (f64, ContactReport) {
        let (speed, before) = (self.approach_speed(), self.axis.phase);
        self.spend();
        self.follow_arm();
        self.axis.force = self.input.force;
        self.find_faults();
        self.axis.motion.advance(self.timing.sensor_lag, self.input.moved);
        self.change_phase(speed);
        if self.presses() {
            self.learn();
        } else if matches!(self.axis.phase, ContactPhase::Contact | ContactPhase::Loss) {
            self.chase();
        }
        self.give_up_lost_surface();
        let wanted = self.wanted(speed);
        let most = self.input.acceleration * self.timing.period;
        let faster = self.most_faster();
        let velocity = wanted.clamp(self.input.last_velocity - most, self.input.last_velocity + faster);
        (self.within_tank(velocity), self.report(speed, before))
    }

    /// Returns by how much the velocity may grow in this period, m/s.
    ///
    /// An approach begins gently: the inertia of a tool looks like a contact. Up to a speed that it had, or that of a way back, it returns
    /// at once, so that noise which looks like a contact costs no time.
    fn most_faster(&mut self) -> f64 {
        let AxisInput { force, acceleration, last_velocity, .. } = self.input;
        let most = acceleration * self.timing.period;
        if self.axis.phase != ContactPhase::Approach {
            return most;
        }
        let had = self.axis.return_speed;
        let is_suspected = force > self.settings.suspicion();
        let known = if is_suspected { had.min(last_velocity + RESUMED * most) } else { had.max(last_velocity) };
        self.axis.return_speed = known.max(0.0);
        let gently = self.settings.approach_acceleration() * self.timing.period;
        (self.axis.return_speed - last_velocity).clamp(gently.min(most), most)
    }

    /// Returns v_app, m/s.
    fn approach_speed(&self) -> f64 {
        let largest = || largest_approach_speed(self.settings, self.timing, self.input.target, self.input.acceleration);
        self.settings.approach_speed.unwrap_or_else(largest)
    }

    /// Returns s K̂, N/m.
    fn stiffness(&self) -> f64 {
        self.axis.estimate.upper * self.axis.swing.factor
    }

    /// Returns p − x_s, m.
    fn ahead_of_sensor(&self) -> f64 {
        self.axis.position + self.input.to_rest - self.axis.sensed_position
    }

    /// Returns p − x_s, m, less what the surface moves until the sensor sees p.
    fn ahead_of_surface(&self) -> f64 {
        self.ahead_of_sensor() - self.axis.motion.velocity * self.timing.following
    }

    /// Moves the model as the arm was measured to move while it is held back. What the model showed before is forgotten: it looked soft.
    fn follow_arm(&mut self) {
        let AxisInput { force, moved: [measured, time], .. } = self.input;
        let (settings, axis) = (self.settings, &mut *self.axis);
        let was_held_back = axis.following.is_held_back(self.timing);
        let modelled = axis.position - axis.following.position;
        let ways = [modelled, measured];
        axis.following.add((settings, self.timing), (ways, force - axis.force), time);
        if axis.following.is_held_back(self.timing) {
            let lost = if was_held_back { modelled - measured } else { axis.following.ahead };
            axis.position -= lost;
            axis.sensed_position -= lost;
            if !was_held_back && axis.phase == ContactPhase::Contact {
                axis.touch(settings, force);
            }
        }
        axis.following.position = axis.position;
    }

    /// Gives up a contact whose force is too large, of the wrong sign, or stuck.
    fn find_faults(&mut self) {
        let (settings, axis, force) = (self.settings, &mut *self.axis, self.input.force);
        if self.input.last_velocity >= 0.0 {
            (axis.before_retreat, axis.force_before_retreat) = (axis.sensed_position, force);
        }
        if matches!(axis.phase, ContactPhase::Fault(_)) {
            return;
        }
        let retreat = axis.before_retreat - axis.sensed_position;
        let stays = axis.phase == ContactPhase::Contact
            && force > settings.threshold()
            && retreat > LONGEST_PUSH * settings.metre
            && axis.force_before_retreat - force < FALLS * settings.softest * retreat;
        axis.unchanged.add(settings, (force, axis.position), self.timing.period);
        let near = near(settings, self.input.target);
        let is_near = (force - self.input.target).abs() < near;
        let sticks = axis.phase == ContactPhase::Contact
            && axis.unchanged.is_stuck(settings, axis.position, (is_near, near), axis.estimate.best());
        let (cause, place) = if self.input.limited_force > settings.max_force {
            (FaultCause::ForceLimit, axis.position)
        } else if force < -(settings.threshold() + PULL * settings.noise) {
            (FaultCause::Pull, axis.position)
        } else if sticks {
            (FaultCause::Stuck, axis.unchanged.position)
        } else if stays {
            (FaultCause::StaysInRetreat, axis.position)
        } else {
            return;
        };
        (axis.phase, axis.fault_position) = (ContactPhase::Fault(cause), place);
    }

    /// Finds a contact or its loss.
    fn change_phase(&mut self, speed: f64) {
        let (settings, axis, force) = (self.settings, &mut *self.axis, self.input.force);
        let (threshold, position) = (settings.threshold(), axis.sensed_position);
        let patience = self.timing.reaction.max(SUSPICIONS * self.timing.period);
        let mut touches = force > threshold;
        if axis.phase == ContactPhase::Approach {
            // A force that stays between suspicion and contact would hold the tool for ever: noise does not stay there.
            let suspected = axis.contact_time + self.timing.period;
            axis.contact_time = if force > settings.suspicion() { suspected } else { 0.0 };
            touches |= axis.contact_time > patience;
        }
        let (before, brief) = (axis.lack, BRIEF * self.timing.period * settings.release());
        let lack = before + self.timing.period * (settings.release() - force);
        axis.lack = if axis.phase == ContactPhase::Contact { lack.max(0.0) } else { 0.0 };
        if before <= brief && axis.lack > brief {
            // A bounce: the next touch is slower.
            let floor = (SLOWEST_RETURN * settings.metre).min(speed);
            let is_long = axis.contact_time >= LONG_CONTACT;
            // The second one in a row, from a force above the target: K̂ is too small.
            let hammers = !is_long && axis.return_speed < speed && axis.swing.before > HAMMERS * self.input.target;
            if hammers && axis.is_measured_stiffer() {
                axis.estimate.doubt(settings);
            }
            axis.return_speed = if is_long { speed } else { (0.5 * axis.return_speed).max(floor) };
            axis.contact_time = 0.0;
        }
        match axis.phase {
            ContactPhase::Approach if touches => {
                axis.phase = ContactPhase::Contact;
                axis.touch(settings, force);
                axis.mean_target = self.input.target;
                (axis.return_speed, axis.contact_time) = (speed, 0.0);
            }
            ContactPhase::Loss if force > threshold => {
                axis.phase = ContactPhase::Contact;
                axis.estimate.restart([position, force], axis.motion.velocity);
                axis.motion.find_again(force);
                axis.contact_time = 0.0;
            }
            ContactPhase::Contact if axis.lack > patience * settings.release() => {
                axis.phase = ContactPhase::Loss;
                // Without a stiffness, the force does not tell how deep the tool is.
                if axis.estimate.slope <= 0.0 {
                    axis.surface = axis.surface.max(position);
                }
            }
            _ => {}
        }
    }

    /// Takes the energy of what the tool has moved since the last period out of the tank, and fills it up with the power of a surface
    /// that the law follows.
    ///
    /// With the mean of both forces, the energy of a spring is exact however it was moved: an impact on one gives back what it took.
    fn spend(&mut self) {
        let AxisInput { force, target, moved: [way, time], .. } = self.input;
        let mean = 0.5 * (self.axis.force + force);
        self.axis.spent = (self.axis.spent + mean * way - self.settings.followed_speed * target * time).max(0.0);
    }

    /// Returns whether the tool is in contact, and the force does not say otherwise.
    fn presses(&self) -> bool {
        self.axis.phase == ContactPhase::Contact && self.input.force >= self.settings.release()
    }

    /// Learns stiffness, place of the surface and swings.
    fn learn(&mut self) {
        let (terms, forces) = ((self.settings, self.timing), [self.input.force, self.input.target]);
        self.axis.contact_time += self.timing.period;
        let target_has_changed = self.target_has_changed();
        self.axis.hold_time = self.hold_time(target_has_changed);
        let axis = &mut *self.axis;
        let held = Held { surface_velocity: axis.motion.velocity, target_has_changed };
        let held = (axis.hold_time > 0.5 * HELD).then_some(held);
        axis.estimate.learn(terms, (axis.sensed_position, forces[0]), held);
        if axis.estimate.slope <= 0.0 || axis.position > axis.surface {
            axis.surface = axis.sensed_position - forces[0] / axis.estimate.best();
        }
        // A reading that does not change says nothing about the surface.
        let is_read = axis.unchanged.time <= self.timing.tracking;
        axis.motion.learn(terms, forces, (&axis.swing, held), is_read);
        axis.swing.update(terms, forces[0] - forces[1], forces[1]);
        if axis.swing.factor > RELEARNT && axis.is_measured_stiffer() {
            axis.swing.factor /= axis.estimate.doubt(self.settings);
            axis.hold_time = 0.0;
        }
    }

    /// Returns the clock of a held contact after this period, s; `target_has_changed`: the target has changed.
    fn hold_time(&self, target_has_changed: bool) -> f64 {
        let (axis, target, period) = (&*self.axis, self.input.target, self.timing.period);
        let error = (self.input.force - target).abs();
        if axis.swing.factor > RELEARNT {
            0.0
        } else if error < near(self.settings, target) {
            // A stiffness that is known after a gentle touch is not learnt anew: the surface may set off.
            let is_gentle = axis.hold_time == 0.0 && axis.contact_time > 0.5 * HELD;
            let is_known = is_gentle && axis.knows_stiffness(self.settings.noise);
            if is_known { HELD } else { (axis.hold_time + period).min(HELD) }
        } else if axis.hold_time > 0.5 * HELD {
            // While the motion of the surface explains the force, the stiffness is not learnt anew.
            let stays = error < STAYS * target;
            let is_moving = axis.motion.is_seen(self.timing) || stays && axis.motion.velocity != 0.0;
            let unexplained = if stays { SLOWLY_AWAY } else { AWAY };
            let away = if is_moving && !target_has_changed { 0.0 } else { unexplained };
            (axis.hold_time - away * period).max(0.0)
        } else {
            0.0
        }
    }

    /// Returns whether the target has changed within the window of the estimator.
    fn target_has_changed(&mut self) -> bool {
        let (target, mean) = (self.input.target, &mut self.axis.mean_target);
        *mean += self.timing.period / self.timing.window * (target - *mean);
        (target - *mean).abs() > CHANGED * target
    }

    /// Approaches again if a lost surface is not where it was.
    fn give_up_lost_surface(&mut self) {
        let (settings, axis) = (self.settings, &mut *self.axis);
        let force = settings.threshold() + DIFFERENCE * settings.noise;
        // What has not shown its stiffness may be the stiffest contact, so the tool goes back very slowly. That would take long where it was
        // noise, or is soft.
        let least = if axis.estimate.slope > 0.0 { LOST_DEPTH * settings.metre } else { 0.0 };
        let depth = least.max(2.0 * force / axis.estimate.best());
        if axis.phase == ContactPhase::Loss {
            axis.contact_time += self.timing.period;
            let is_far = axis.sensed_position > axis.surface + depth;
            let is_late = axis.motion.velocity > 0.0 && axis.contact_time > LONGEST_CHASE;
            if is_far || is_late {
                axis.phase = ContactPhase::Approach;
            }
        }
    }

    /// Moves the place of a surface that has left, a little faster than it was seen to move, so that the tool meets it again.
    fn chase(&mut self) {
        let (axis, period) = (&mut *self.axis, self.timing.period);
        axis.motion.coast(self.timing);
        axis.surface += period * (axis.motion.velocity + CHASE * axis.motion.velocity.max(0.0));
    }

    /// Returns the velocity before the limit of acceleration, m/s.
    fn wanted(&self, speed: f64) -> f64 {
        let (settings, axis, AxisInput { force, .. }) = (self.settings, &*self.axis, self.input);
        match axis.phase {
            ContactPhase::Approach if force > settings.suspicion() => 0.0,
            ContactPhase::Approach => speed,
            ContactPhase::Contact if self.presses() => self.pressing(force, speed),
            ContactPhase::Contact => self.returning(force),
            // Nobody knows whether the surface still moves: the tool meets it at the speed of an approach.
            ContactPhase::Loss => self.returning(force).min(speed),
            ContactPhase::Fault(cause) => self.retreating(cause),
        }
    }

    /// Returns the velocity of the retreat from a fault, m/s.
    ///
    /// A tool whose force is too large yields at least as fast as in a contact: its surface may come after it. Near the end of the force it is
    /// slow, because something may be behind it.
    fn retreating(&self, cause: FaultCause) -> f64 {
        let (settings, axis, AxisInput { force, to_rest, acceleration, .. }) = (self.settings, &*self.axis, self.input);
        let is_pressed = match cause {
            // A force of the other sign comes from something behind the tool.
            FaultCause::ForceLimit => force > settings.threshold(),
            FaultCause::StaysInRetreat => force.abs() > settings.threshold(),
            FaultCause::Pull | FaultCause::Stuck => false,
        };
        let way = if is_pressed { LONGEST_RETREAT } else { FAULT_RETREAT.0 };
        let end = axis.fault_position - way * settings.metre;
        // A pull on a tool that has not moved forward may be a surface behind it, on which a retreat would press.
        let end = if cause == FaultCause::Pull { end.max(axis.fault_position.min(0.0)) } else { end };
        let yields = is_pressed && cause == FaultCause::ForceLimit;
        let best = self.axis.estimate.best();
        let depth = if yields && best > 0.0 { force / best } else { 0.0 };
        let fastest = (depth / self.timing.contact).max(FAULT_RETREAT.1 * settings.metre).min(settings.retreat_speed);
        let left = axis.position + to_rest - end;
        let is_held = cause == FaultCause::ForceLimit && force < -settings.threshold();
        if left <= 0.0 || is_held {
            return 0.0;
        }
        -fastest.min((2.0 * STOP_SHARE * acceleration * left).sqrt())
    }

    /// Returns the velocity of the way back to the place of the surface, m/s, for a force (N) that may be missing.
    fn returning(&self, force: f64) -> f64 {
        let modelled = self.axis.estimate.best() * (self.axis.sensed_position - self.axis.surface);
        self.pressing(force.min(modelled), self.axis.return_speed)
    }

    /// Returns the velocity that moves the position of rest to x*, m/s, for a force (N) and a largest speed (m/s).
    fn pressing(&self, force: f64, speed: f64) -> f64 {
        let (timing, AxisInput { target, acceleration, .. }) = (self.timing, self.input);
        let stiffness = self.stiffness();
        let error = (target - force) / stiffness - self.ahead_of_surface();
        let approach = (error.abs() / timing.contact).min((acceleration * error.abs()).sqrt()).copysign(error);
        let excess = -error - OVERSHOOT * target / stiffness;
        let stop = if excess > 0.0 {
            -(excess / timing.stop).min((2.0 * STOP_SHARE * acceleration * excess).sqrt())
        } else {
            f64::INFINITY
        };
        // The surface takes the tool with it: what counts is the velocity relative to it.
        let surface = self.axis.motion.velocity;
        let fastest = speed + surface.max(0.0);
        (approach.min(stop) + surface).clamp(-self.settings.retreat_speed, fastest)
    }

    /// Returns the energy of a full tank, J.
    fn tank(&self) -> f64 {
        let force = TANK_SHARE * self.input.target;
        0.5 * force * force / self.settings.softest
    }

    /// Returns the velocity, or one that brakes if the tank does not cover what is on its way.
    fn within_tank(&self, velocity: f64) -> f64 {
        let (axis, AxisInput { force, acceleration, last_velocity, .. }) = (&*self.axis, self.input);
        let available = self.tank() - axis.spent;
        let period = self.timing.period;
        let way = self.ahead_of_sensor() + period * velocity + 0.5 * velocity * velocity / acceleration;
        let is_covered = available > 0.0 && (force <= 0.0 || force * way <= available);
        if velocity > 0.0 && !is_covered { (last_velocity - acceleration * period).max(0.0) } else { velocity }
    }

    /// `before`: the state in the last period.
    fn report(&self, speed: f64, before: ContactPhase) -> ContactReport {
        let (settings, axis) = (self.settings, &*self.axis);
        let is_touching = axis.phase == ContactPhase::Contact;
        let terms = (settings.stiffest, self.input.acceleration);
        ContactReport {
            phase: axis.phase,
            is_new: axis.phase != before,
            force: self.input.force,
            target: self.input.target,
            stiffness_bound: if axis.estimate.upper > 0.0 { self.stiffness() } else { settings.stiffest },
            stiffness: (axis.estimate.slope > 0.0).then_some([axis.estimate.slope, axis.estimate.uncertainty]),
            predicted_force: if is_touching {
                self.input.force + self.stiffness() * self.ahead_of_surface()
            } else {
                0.0
            },
            surface_velocity: if axis.phase == ContactPhase::Approach { 0.0 } else { axis.motion.velocity },
            energy: (self.tank() - axis.spent).max(0.0),
            approach_speed: speed,
            unavoidable_peak: unavoidable_peak(settings, self.timing, terms, speed),
            normal: None,
        }
    }
}
