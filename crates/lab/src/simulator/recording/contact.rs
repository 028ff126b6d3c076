//! The contacts of the law `contact` in a recording.

use std::fmt;

use revprio_api::wire;
use serde::{Deserialize, Serialize};

/// The contacts of one period: one entry per axis with the law `contact`, in the order of the tasks. Forces are along the pressing
/// directions.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Contacts {
    /// States.
    pub state: Vec<ContactWord>,
    /// What began in this period.
    pub event: Vec<ContactEvent>,
    /// Measured forces, N or N·m.
    pub force: Vec<f64>,
    /// Target forces, N or N·m.
    pub target_force: Vec<f64>,
    /// Estimated stiffnesses, N/m or N·m/rad; `None`: not known yet.
    pub stiffness: Vec<Option<f64>>,
    /// What the law learns of the surfaces; empty if no axis follows one.
    #[serde(flatten)]
    pub surface: Surfaces,
}

/// The surfaces of one period: one entry per axis with the law `contact`; `None` for an axis that follows no surface.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Surfaces {
    /// Pressing directions, unit vectors along the axes of the base.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub normal: Vec<[Option<f64>; 3]>,
    /// Coefficients of friction; `None` until the tool has slid 1 mm.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub friction: Vec<Option<f64>>,
    /// Rms angles between the normals and single measurements, rad; `None` until the tool has slid 1 mm.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub normal_uncertainty: Vec<Option<f64>>,
}

/// The state of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ContactWord {
    /// The tool approaches a surface.
    Approach,
    /// The tool presses.
    Contact,
    /// The tool goes back to a lost surface.
    Loss,
    /// The contact is given up.
    Fault,
}

/// What began in a period, with the cause of a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ContactEvent {
    /// Nothing.
    None,
    /// The approach to another surface.
    Approach,
    /// A contact.
    Contact,
    /// A loss of the surface.
    Loss,
    /// A fault: the surface pulls.
    Pull,
    /// A fault: the force stays while the tool retreats.
    StaysInRetreat,
    /// A fault: the force is beyond its limit.
    ForceLimit,
    /// A fault: the sensor sticks.
    Stuck,
}

impl fmt::Display for ContactWord {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(formatter)
    }
}

impl fmt::Display for ContactEvent {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(formatter)
    }
}

impl Contacts {
    /// Returns contacts that approach, for a number of axes. `surfaces`: the same number if an axis follows a surface, otherwise 0.
    pub fn approaching(axes: usize, surfaces: usize) -> Self {
        Self {
            state: vec![ContactWord::Approach; axes],
            event: vec![ContactEvent::None; axes],
            force: vec![0.0; axes],
            target_force: vec![0.0; axes],
            stiffness: vec![None; axes],
            surface: Surfaces {
                normal: vec![[None; 3]; surfaces],
                friction: vec![None; surfaces],
                normal_uncertainty: vec![None; surfaces],
            },
        }
    }

    /// Returns the contacts of an answer; `is_new`: whether it arrived in this period. Events of older answers are past.
    pub fn of(answer: &wire::StepAnswer, is_new: bool) -> Self {
        let reports = || answer.tasks.iter().flat_map(|task| &task.contact);
        Self {
            state: reports().map(|report| word(report.state)).collect(),
            event: reports().map(|report| if is_new { event(report) } else { ContactEvent::None }).collect(),
            force: reports().map(|report| report.force).collect(),
            target_force: reports().map(|report| report.target_force).collect(),
            stiffness: reports().map(|report| report.stiffness).collect(),
            surface: Surfaces::of(&reports().map(|report| report.surface.as_ref()).collect::<Vec<_>>()),
        }
    }

    /// Returns the number of axes.
    pub fn axes(&self) -> usize {
        self.state.len()
    }

    /// Returns whether no axis has the law.
    pub fn is_empty(&self) -> bool {
        self.state.is_empty()
    }
}

impl Surfaces {
    /// Returns the surfaces of the axes with the law `contact`.
    fn of(reports: &[Option<&wire::SurfaceReport>]) -> Self {
        if reports.iter().all(Option::is_none) {
            return Self::default();
        }
        let reports = || reports.iter().copied();
        Self {
            normal: reports().map(|report| report.map_or([None; 3], |report| report.normal.map(Some))).collect(),
            friction: reports().map(|report| report?.friction).collect(),
            normal_uncertainty: reports().map(|report| report?.uncertainty_rad).collect(),
        }
    }

    /// Returns whether an axis follows a surface.
    pub fn is_followed(&self) -> bool {
        !self.normal.is_empty()
    }
}

fn word(state: wire::ContactState) -> ContactWord {
    match state {
        wire::ContactState::Approach => ContactWord::Approach,
        wire::ContactState::Contact => ContactWord::Contact,
        wire::ContactState::Loss => ContactWord::Loss,
        wire::ContactState::Fault => ContactWord::Fault,
    }
}

fn event(report: &wire::ContactReport) -> ContactEvent {
    match (report.event, report.fault) {
        (None, _) => ContactEvent::None,
        (Some(wire::ContactState::Approach), _) => ContactEvent::Approach,
        (Some(wire::ContactState::Contact), _) => ContactEvent::Contact,
        (Some(wire::ContactState::Loss), _) => ContactEvent::Loss,
        (Some(wire::ContactState::Fault), Some(wire::ContactFault::ForceLimit)) => ContactEvent::ForceLimit,
        (Some(wire::ContactState::Fault), Some(wire::ContactFault::StaysInRetreat)) => ContactEvent::StaysInRetreat,
        (Some(wire::ContactState::Fault), Some(wire::ContactFault::Stuck)) => ContactEvent::Stuck,
        (Some(wire::ContactState::Fault), _) => ContactEvent::Pull,
    }
}
