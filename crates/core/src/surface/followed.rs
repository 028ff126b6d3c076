//! A task frame that follows the normal of a surface.

use nalgebra::{Rotation3, Vector3};
use revprio_robot::kinematics::{Axis, Configuration, TaskFrame};

use super::normal::{NormalEstimate, NormalReport, SlidingInput, SurfaceSettings, Touch};

/// What is known of a contact before a period.
#[derive(Debug, Clone, Copy)]
pub(crate) struct KnownContact {
    pub touch: Touch,
    /// Estimated stiffness, 0 before it is known, and its upper bound, N/m.
    pub stiffness: [f64; 2],
    pub estimate: NormalEstimate,
}

impl Default for KnownContact {
    fn default() -> Self {
        Self { touch: Touch::Free, stiffness: [0.0; 2], estimate: NormalEstimate::START }
    }
}

/// The surface on which a task presses, and its normal.
#[derive(Debug, Clone)]
pub(crate) struct FollowedSurface {
    /// Index of the pressing axis among those of all contact laws.
    pub contact: usize,
    /// The tip whose wrench presses.
    pub tip: usize,
    /// The frame of the task, with the stated axes.
    pub frame: TaskFrame,
    /// The pressing direction along the stated axes of the frame.
    pub axis: Vector3<f64>,
    pub settings: SurfaceSettings,
    /// Stiffness of the softest contact, N/m.
    pub softest: f64,
    /// What was known before the period.
    known: KnownContact,
    /// What is known of the normal.
    pub estimate: NormalEstimate,
    /// What the period reports; `None` before the first one.
    pub report: Option<NormalReport>,
    /// The rotation from the stated axes to those of the surface, base axes.
    pub turn: Rotation3<f64>,
}

impl FollowedSurface {
    /// A surface that is pressed along an axis of a frame, in the direction 1 or −1, and not known yet.
    pub fn new(
        (contact, tip): (usize, usize),
        frame: &TaskFrame,
        (axis, direction): (Axis, f64),
        (settings, softest): (SurfaceSettings, f64),
    ) -> Self {
        let mut along = Vector3::zeros();
        along[axis.index()] = direction;
        let (estimate, turn) = (NormalEstimate::START, Rotation3::identity());
        Self {
            contact,
            tip,
            frame: *frame,
            axis: along,
            settings,
            softest,
            known: KnownContact::default(),
            estimate,
            report: None,
            turn,
        }
    }

    /// Returns whether a frame has the axes of this surface: body and axes are the same, the reference point may differ.
    pub fn turns(&self, frame: &TaskFrame) -> bool {
        self.frame.body == frame.body && self.frame.frame == frame.frame
    }

    /// Continues from what is known; `posture`: the measured one.
    pub fn recall(&mut self, known: KnownContact, posture: &Configuration) {
        let stated = self.stated(posture);
        (self.known, self.report) = (known, None);
        self.estimate = known.estimate.within(&stated, self.settings.max_tilt);
        self.turn = self.estimate.turn(&stated);
    }

    /// Updates the estimate by the force at the tool, N, after a time, s.
    pub fn update(&mut self, posture: &Configuration, (force, time): (Vector3<f64>, f64)) {
        let KnownContact { touch, stiffness: [known, bound], .. } = self.known;
        let stated = self.stated(posture);
        let position = self.frame.pose(&self.frame.body_pose(posture)).translation.vector;
        let is_known = known > 0.0;
        let stiffness = if is_known { known } else { bound }.max(self.softest);
        let softest = if is_known { stiffness } else { self.softest };
        let input = SlidingInput { stated, position, force, touch, stiffness, softest, time };
        self.report = Some(self.estimate.update(self.settings, &input));
        self.turn = self.estimate.turn(&stated);
    }

    /// Returns the stated pressing direction, base axes.
    fn stated(&self, posture: &Configuration) -> Vector3<f64> {
        self.frame.at(posture).to_base(&self.axis)
    }
}
