//! The quantities of a control period. All formats are made from this table.

use super::cell::{Cell, Cells};
use super::{Sample, Timing};

/// The index of the values of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Per {
    /// One value per period.
    Period,
    /// One value per joint.
    Joint,
    /// One value per axis x, y, z.
    Axis,
    /// One value per part w, x, y, z.
    QuaternionPart,
    /// One value per task, highest priority first.
    Task,
    /// One value per channel of the controller.
    Channel,
    /// One value per axis with the law `contact`, in the order of the tasks.
    Contact,
    /// One value per axis x, y, z of each axis with the law `contact`.
    ContactAxis,
}

/// Kind of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A number.
    Number,
    /// A number that may be missing.
    OptionalNumber,
    /// A non-negative integer.
    Count,
    /// True or false.
    Flag,
    /// A word.
    Word,
}

/// The recordings that contain a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// All recordings.
    Always,
    /// Recordings in which an axis with the law `contact` follows a surface.
    Surface,
    /// Recordings whose controller watches distances.
    Watched,
    /// Recordings whose controller received other values than the true state.
    Sensed,
    /// Recordings with real times.
    Timed,
}

/// One quantity.
pub struct Quantity {
    /// First part of the column names.
    pub name: &'static str,
    /// Unit, the last part of the column names.
    pub unit: &'static str,
    /// Index of its values.
    pub per: Per,
    /// Kind of its values.
    pub kind: Kind,
    /// The recordings that contain it.
    pub presence: Presence,
    /// Description.
    pub about: &'static str,
    pub(super) get: fn(&Sample, &Timing, usize) -> Option<super::cell::Value>,
    pub(super) set: fn(&mut Sample, &mut Timing, usize, super::cell::Value) -> bool,
}

impl Quantity {
    /// Returns whether the quantity comes from the answer of the service.
    pub fn is_answered(&self) -> bool {
        ANSWERED.contains(&self.name)
    }
}

/// Names of the quantities that come from the answer of the service.
const ANSWERED: [&str; 19] = [
    "velocity",
    "target_force",
    "path",
    "status",
    "kkt_residual",
    "smallest_singular_value",
    "manipulability",
    "residual_task",
    "channel",
    "contact_state",
    "contact_event",
    "contact_force",
    "contact_target",
    "contact_stiffness",
    "contact_normal",
    "contact_friction",
    "contact_normal_uncertainty",
    "limit",
    "least_distance",
];

/// One line per quantity: name, unit, index, kind, field and description. The field belongs to the sample, to the received
/// state (`sensed`) or to the timing.
macro_rules! quantities {
    ($($name:literal $unit:literal $per:ident $kind:ident $of:ident.$($field:ident).+ $about:literal;)+) => {
        [$(Quantity {
            name: $name,
            unit: $unit,
            per: Per::$per,
            kind: Kind::$kind,
            presence: quantities!(@presence $of),
            about: $about,
            get: |sample, timing, i| {
                let _ = (sample, timing);
                quantities!(@owner $of sample timing as_deref)?.$($field).+.cell(i).map(Cell::value)
            },
            set: |sample, timing, i, value| {
                let _ = (&sample, &timing);
                let owner = quantities!(@owner_mut $of sample timing);
                owner.and_then(|owner| owner.$($field).+.cell_mut(i)).is_some_and(|cell| cell.set(value))
            },
        }),+]
    };
    (@presence sample) => { Presence::Always };
    (@presence surface) => { Presence::Surface };
    (@presence watched) => { Presence::Watched };
    (@presence sensed) => { Presence::Sensed };
    (@presence timing) => { Presence::Timed };
    (@owner sample $sample:ident $timing:ident $by:ident) => { Some($sample) };
    (@owner surface $sample:ident $timing:ident $by:ident) => { Some(&$sample.contacts.surface) };
    (@owner watched $sample:ident $timing:ident $by:ident) => { Some($sample) };
    (@owner sensed $sample:ident $timing:ident $by:ident) => { $sample.sensed.$by() };
    (@owner timing $sample:ident $timing:ident $by:ident) => { Some($timing) };
    (@owner_mut sample $sample:ident $timing:ident) => { Some($sample) };
    (@owner_mut surface $sample:ident $timing:ident) => { Some(&mut $sample.contacts.surface) };
    (@owner_mut watched $sample:ident $timing:ident) => { Some($sample) };
    (@owner_mut sensed $sample:ident $timing:ident) => { $sample.sensed.as_deref_mut() };
    (@owner_mut timing $sample:ident $timing:ident) => { Some($timing) };
}

/// All quantities, in the order of their columns. To add one, add a field to [`Sample`] and a line here.
pub static QUANTITIES: [Quantity; 40] = quantities! {
    "time" "s" Period Number sample.time_s "simulated time";
    "position" "rad" Joint Number sample.joint_position "joint position q; m for a prismatic joint";
    "velocity" "rad_s" Joint Number sample.joint_velocity "commanded joint velocity q̇; m/s for a prismatic joint";
    "tool" "m" Axis Number sample.position "tool point, base frame";
    "displacement" "m" Axis Number sample.position_error "displacement of the tool point from its start position";
    "force" "n" Axis Number sample.force "force F_e of the tool on the environment, base axes";
    "target_force" "n" Axis OptionalNumber sample.target_force "target force F_d; empty if the axis is not force-controlled, or its task follows a surface";
    "wall_distance" "m" Period OptionalNumber sample.wall_distance "distance to the nearest wall, negative in contact; empty without a wall";
    "least_distance" "m" Period OptionalNumber watched.least_distance "least distance of the pairs of shapes that the controller watches, at the sensed posture and of the last answer; empty without a pair";
    "path" "" Period Word sample.path "solution path of the command: `closed_form`, `active_set`, `qp`, …";
    "status" "" Period Word sample.status "status of the command: `optimal`, or the reason why it is not";
    "kkt_residual" "" Period OptionalNumber sample.kkt_residual "residual of the optimality conditions";
    "smallest_singular_value" "" Period Number sample.smallest_singular_value "smallest singular value σ_min of all task rows";
    "residual_task" "" Task Number sample.residual_norms "residual ‖J_k q̇ − ẋ_k‖ of each task, highest priority first";
    "answered" "" Period Flag sample.answered "whether an answer arrived in this period; if not, the values of the answer are those of the last one";
    "actual_velocity" "rad_s" Joint Number sample.actual_velocity "actual joint velocity q̇";
    "orientation" "" QuaternionPart Number sample.orientation "orientation of the tool, base frame, unit quaternion";
    "torque" "n_m" Axis Number sample.torque "torque of F_e at the tool point";
    "external_force" "n" Axis Number sample.external_force "external push on the tool, a part of −F_e";
    "manipulability" "" Period Number sample.manipulability "product of the singular values of all task rows";
    "channel" "" Channel OptionalNumber sample.channels "command of each channel of the controller in the order of their names, m, rad, N or N·m";
    "contact_state" "" Contact Word sample.contacts.state "state of each axis with the law `contact`: `approach`, `contact`, `loss` or `fault`";
    "contact_event" "" Contact Word sample.contacts.event "what began in the period: `contact`, `loss`, `approach`, a fault (`pull`, `stays_in_retreat`, `force_limit`, `stuck`), or `none`";
    "contact_force" "" Contact Number sample.contacts.force "measured force along the pressing direction, N or N·m";
    "contact_target" "" Contact Number sample.contacts.target_force "target force along the pressing direction, N or N·m";
    "contact_stiffness" "" Contact OptionalNumber sample.contacts.stiffness "estimated stiffness, N/m or N·m/rad; empty until it is known";
    "contact_normal" "" ContactAxis OptionalNumber surface.normal "estimated normal of the surface: the pressing direction, a unit vector along the axes of the base; empty for an axis without `surface`";
    "contact_friction" "" Contact OptionalNumber surface.friction "estimated coefficient of friction; empty until the tool has slid 1 mm";
    "contact_normal_uncertainty" "rad" Contact OptionalNumber surface.normal_uncertainty "rms angle between the normal and single measurements of it; empty until the tool has slid 1 mm";
    "limit" "" Joint Word sample.limits "`free`, at an active bound (`lower`, `upper`), or beyond a bound (`below`, `above`)";
    "work" "j" Period Number sample.energy.work_j "work done on the contacts so far";
    "stored" "j" Period Number sample.energy.stored_j "energy stored in the contacts";
    "dissipated" "j" Period Number sample.energy.dissipated_j "energy dissipated by damping, friction and impacts so far";
    "answer_age" "" Period Count sample.answer_age "age of the answer: periods since the measurement of its state";
    "sensed_position" "rad" Joint Number sensed.joint_position "joint position q that the controller received";
    "sensed_velocity" "rad_s" Joint Number sensed.joint_velocity "joint velocity q̇ that the controller received";
    "sensed_force" "n" Axis Number sensed.force "force that the controller received, in its convention of sign and axes";
    "sensed_torque" "n_m" Axis Number sensed.torque "torque that the controller received, in the same convention";
    "round_trip" "us" Period Number timing.round_trip_us "real time from sending the state to its answer";
    "elapsed" "us" Period Number timing.elapsed_us "real time to compute the answer, as reported by the service";
};
