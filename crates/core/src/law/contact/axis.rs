//! What the contact law remembers of one axis.

use super::estimate::StiffnessEstimate;
use super::following::Following;
use super::motion::{SurfaceMotion, lagging};
use super::settings::ContactSettings;
use super::swing::Swing;
use super::timing::ContactTiming;
use super::unchanged::Unchanged;
use crate::surface::{KnownContact, NormalEstimate, Touch};

/// Time near the target to which the clock of a held contact counts, s. The contact is held above the half of it.
pub(super) const HELD: f64 = 0.3;

/// Share by which the slopes over the modelled and the measured position differ on a drive that does not yield.
const SAME: f64 = 0.1;

/// Factor of K̂ from which a contact is much stiffer.
const MUCH_STIFFER: f64 = 2.0;

/// The state of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ContactPhase {
    /// The tool approaches a surface.
    #[default]
    Approach,
    /// The tool presses.
    Contact,
    /// The tool has lost the surface and goes back to it.
    Loss,
    /// The tool retreats and rests. Only a new memory ends it.
    Fault(FaultCause),
}

impl ContactPhase {
    /// Returns whether the tool touches a surface, or retreats from one.
    pub fn touches(self) -> bool {
        matches!(self, Self::Contact | Self::Fault(_))
    }
}

/// Why a contact is given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultCause {
    /// The surface pulls: the sign of the force is wrong, or its bias is too large.
    Pull,
    /// The force stays while the tool retreats by 0.1 m: its sign is wrong, its axes are swapped, or its bias exceeds the target.
    StaysInRetreat,
    /// The force exceeds its limit.
    ForceLimit,
    /// The reading does not change although the tool moves: the sensor sticks.
    Stuck,
}

/// The memory of one axis, along its pressing direction. For an axis of rotation read N·m for N and rad for m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactAxis {
    /// The state.
    pub phase: ContactPhase,
    /// x, modelled position of the tool since the first step, m; the measured one goes on where the arm is held back.
    pub position: f64,
    /// x_s, the position as the force sensor sees it, m.
    pub sensed_position: f64,
    /// F of the last period, N.
    pub force: f64,
    /// x₀, position of the surface, m.
    pub surface: f64,
    /// Time in contact since the last touch, of suspicion before it, or of a loss, s.
    pub contact_time: f64,
    /// How much force has been missing for how long since the contact was sure, ∫ (f_off − F) dt, N·s.
    pub lack: f64,
    /// Clock of a held contact, s: it counts while the force is near its target, and runs back while it is away.
    pub hold_time: f64,
    /// Mean of F_d over the window of the estimator, N.
    pub mean_target: f64,
    /// Largest speed of the way back to a lost surface, and up to which an approach speeds up at once, m/s.
    pub return_speed: f64,
    /// Energy of the tank that is spent, J.
    pub spent: f64,
    /// x_s when the tool last moved forward, m.
    pub before_retreat: f64,
    /// F when the tool last moved forward, N.
    pub force_before_retreat: f64,
    /// x at the fault, m.
    pub fault_position: f64,
    /// What is known of the stiffness.
    pub estimate: StiffnessEstimate,
    /// How the surface moves.
    pub motion: SurfaceMotion,
    /// How well the arm follows its model.
    pub following: Following,
    /// How the force swings.
    pub swing: Swing,
    /// Since when the reading is the same.
    pub unchanged: Unchanged,
    /// What is known of the normal of the surface.
    pub normal: NormalEstimate,
}

impl ContactAxis {
    /// An axis at the first step: it approaches.
    pub const START: Self = Self {
        phase: ContactPhase::Approach,
        position: 0.0,
        sensed_position: 0.0,
        force: 0.0,
        surface: 0.0,
        contact_time: 0.0,
        lack: 0.0,
        hold_time: 0.0,
        mean_target: 0.0,
        return_speed: 0.0,
        spent: 0.0,
        before_retreat: 0.0,
        force_before_retreat: 0.0,
        fault_position: 0.0,
        estimate: StiffnessEstimate::NONE,
        motion: SurfaceMotion::NONE,
        following: Following::START,
        swing: Swing::NONE,
        unchanged: Unchanged::START,
        normal: NormalEstimate::START,
    };

    /// Returns whether the tool presses, and the force has been near its target for some time.
    pub fn is_held(&self) -> bool {
        self.phase == ContactPhase::Contact && self.hold_time > 0.5 * HELD
    }

    /// Returns whether the tool presses: also while it retreats from a force that is still there.
    pub fn presses(&self, settings: &ContactSettings) -> bool {
        match self.phase {
            ContactPhase::Contact | ContactPhase::Loss => true,
            // A reading that stays, or sticks, is none of a surface.
            ContactPhase::Fault(cause) => cause == FaultCause::ForceLimit && self.force > settings.threshold(),
            ContactPhase::Approach => false,
        }
    }

    /// Returns whether the tool certainly presses on a surface: the contact is held, or the force has risen with the way of the tool, as no bias
    /// does; also while the tool retreats from such a contact.
    pub fn presses_surely(&self, settings: &ContactSettings) -> bool {
        let knows = || self.knows_stiffness(settings.noise);
        match self.phase {
            ContactPhase::Contact => self.is_held() || knows(),
            ContactPhase::Fault(FaultCause::ForceLimit) => self.force > settings.threshold() && knows(),
            _ => false,
        }
    }

    /// Returns whether the stiffness is known well, for a noise σ (N): also from the measured position, so that the drive does not yield.
    pub(super) fn knows_stiffness(&self, sigma: f64) -> bool {
        let [modelled, measured] = [&self.estimate, &self.motion.stiffness];
        let is_same = (modelled.slope - measured.slope).abs() < SAME * measured.slope;
        is_same && modelled.is_known(sigma) && measured.is_known(sigma)
    }

    /// Returns whether the measured positions show a much stiffer contact than the modelled ones: those are wrong, or the drive yields.
    pub(super) fn is_measured_stiffer(&self) -> bool {
        self.motion.stiffness.best() > MUCH_STIFFER * self.estimate.upper
    }

    /// Returns what a surface that is followed continues from.
    pub(crate) fn known(&self) -> KnownContact {
        let touch = match self.phase {
            ContactPhase::Approach => Touch::Free,
            ContactPhase::Contact => Touch::Touches,
            ContactPhase::Loss | ContactPhase::Fault(_) => Touch::Left,
        };
        KnownContact { touch, stiffness: [self.estimate.slope, self.estimate.upper], estimate: self.normal }
    }

    /// Returns whether all numbers are finite and in their ranges.
    pub(crate) fn is_valid(&self) -> bool {
        let Self { position, sensed_position, force, surface, contact_time, return_speed, .. } = *self;
        let signed = [
            position,
            sensed_position,
            force,
            surface,
            self.fault_position,
            self.before_retreat,
            self.force_before_retreat,
            self.motion.tool[0],
            self.motion.tool[1],
            self.motion.means[0],
            self.motion.means[1],
            self.motion.velocity,
            self.following.position,
            self.following.ahead,
            self.following.force,
            self.following.velocities[0],
            self.following.velocities[1],
            self.unchanged.force,
            self.unchanged.position,
        ];
        let positive = [
            contact_time,
            self.lack,
            self.hold_time,
            return_speed,
            self.spent,
            self.mean_target,
            self.motion.lasts,
            self.swing.amplitude,
            self.swing.before,
            self.unchanged.time,
            self.unchanged.change,
            self.unchanged.step,
            self.following.time,
        ];
        let is_finite = |value: &f64| value.is_finite();
        signed.iter().all(is_finite)
            && positive.iter().all(|value| value.is_finite() && *value >= 0.0)
            && self.swing.factor >= 1.0
            && self.swing.factor.is_finite()
            && self.estimate.is_valid()
            && self.motion.stiffness.is_valid()
            && self.normal.is_valid()
    }

    /// Begins to learn the stiffness of a contact with the force F, N, here.
    pub(super) fn touch(&mut self, settings: &ContactSettings, force: f64) {
        self.estimate = StiffnessEstimate::start(settings, self.sensed_position, force);
        self.swing = Swing::NONE;
        self.motion.touch(settings, force);
        (self.surface, self.hold_time) = (self.sensed_position, 0.0);
    }

    /// Moves the model by `way` (m) in a time (s), at a constant speed.
    pub fn advance(&mut self, timing: &ContactTiming, way: f64, time: f64) {
        self.sensed_position = lagging(timing.sensor_lag, (self.position, self.sensed_position), [way, time]);
        self.position += way;
    }
}
