//! What is known of every control period: one line per quantity, from which all formats are made.

use super::cell::{Cell, Cells};
use super::{Sample, Timing};

/// What a quantity has one value for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Per {
    /// The period.
    Period,
    /// Each joint.
    Joint,
    /// Each of x, y, z.
    Axis,
    /// Each of w, x, y, z.
    QuaternionPart,
    /// Each task, highest priority first.
    Task,
}

/// What a value is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A number.
    Number,
    /// A number that may be missing.
    OptionalNumber,
    /// A whole number.
    Count,
    /// True or false.
    Flag,
    /// One of a few words.
    Word,
}

/// Which recordings have it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// All.
    Always,
    /// Those whose controller was told something else than the true state.
    Sensed,
    /// Those that are asked for the clock on the wall.
    Timed,
}

/// One quantity: the name of its columns, what it means, and where it stands.
pub struct Quantity {
    /// First part of the column names.
    pub name: &'static str,
    /// Unit, the last part of the column names.
    pub unit: &'static str,
    /// Its columns.
    pub per: Per,
    /// Its values.
    pub kind: Kind,
    /// Which recordings have it.
    pub presence: Presence,
    /// What it is.
    pub about: &'static str,
    pub(super) of: fn(&Sample, &Timing, usize) -> Option<super::cell::Value>,
    pub(super) put: fn(&mut Sample, &mut Timing, usize, super::cell::Value) -> bool,
}

impl Quantity {
    /// Whether it says what the service answered.
    pub fn is_answered(&self) -> bool {
        ANSWERED.contains(&self.name)
    }
}

/// Names of the quantities that the service answers.
const ANSWERED: [&str; 9] = [
    "velocity",
    "target_force",
    "path",
    "status",
    "kkt_residual",
    "smallest_singular_value",
    "manipulability",
    "residual_task",
    "limit",
];

/// `name, unit, per, kind, field: about`; the field of the sample, of what was sensed, or of the timing.
macro_rules! quantities {
    ($($name:literal $unit:literal $per:ident $kind:ident $of:ident.$($field:ident).+ $about:literal;)+) => {
        [$(Quantity {
            name: $name,
            unit: $unit,
            per: Per::$per,
            kind: Kind::$kind,
            presence: quantities!(@presence $of),
            about: $about,
            of: |sample, timing, i| {
                let _ = (sample, timing);
                quantities!(@owner $of sample timing as_deref)?.$($field).+.cell(i).map(Cell::value)
            },
            put: |sample, timing, i, value| {
                let _ = (&sample, &timing);
                let owner = quantities!(@owner_mut $of sample timing);
                owner.and_then(|owner| owner.$($field).+.cell_mut(i)).is_some_and(|cell| cell.put(value))
            },
        }),+]
    };
    (@presence sample) => { Presence::Always };
    (@presence sensed) => { Presence::Sensed };
    (@presence timing) => { Presence::Timed };
    (@owner sample $sample:ident $timing:ident $by:ident) => { Some($sample) };
    (@owner sensed $sample:ident $timing:ident $by:ident) => { $sample.sensed.$by() };
    (@owner timing $sample:ident $timing:ident $by:ident) => { Some($timing) };
    (@owner_mut sample $sample:ident $timing:ident) => { Some($sample) };
    (@owner_mut sensed $sample:ident $timing:ident) => { $sample.sensed.as_deref_mut() };
    (@owner_mut timing $sample:ident $timing:ident) => { Some($timing) };
}

/// All quantities, in the order of their columns. A new one is a field of [`Sample`] and a line here.
pub static QUANTITIES: [Quantity; 30] = quantities! {
    "time" "s" Period Number sample.time_s "simulated time";
    "position" "rad" Joint Number sample.joint_position "q, joint position; m for a prismatic joint";
    "velocity" "rad_s" Joint Number sample.joint_velocity "q̇ as commanded for this period; m/s for a prismatic joint";
    "tool" "m" Axis Number sample.position "tool point, base frame";
    "displacement" "m" Axis Number sample.position_error "tool point minus where it started";
    "force" "n" Axis Number sample.force "F_e, force of the tool on what it touches, base axes";
    "target_force" "n" Axis OptionalNumber sample.target_force "F_d; empty where the axis is not force-controlled";
    "wall_distance" "m" Period OptionalNumber sample.wall_distance "way to the nearest wall, negative in contact; empty without a wall";
    "path" "" Period Word sample.path "which way led to the command: `closed_form`, `active_set`, `qp`, …";
    "status" "" Period Word sample.status "how sure the command is: `optimal` or why not";
    "kkt_residual" "" Period OptionalNumber sample.kkt_residual "residual of the optimality conditions";
    "smallest_singular_value" "" Period Number sample.smallest_singular_value "σ_min of all task rows together";
    "residual_task" "" Task Number sample.residual_norms "‖J_k q̇ − ẋ_k‖, highest priority first";
    "answered" "" Period Flag sample.answered "whether an answer came in this period; if not, the rest is that of the last one";
    "actual_velocity" "rad_s" Joint Number sample.actual_velocity "q̇ at which the arm moves";
    "orientation" "" QuaternionPart Number sample.orientation "orientation of the tool, base frame, unit quaternion";
    "torque" "n_m" Axis Number sample.torque "torque of F_e at the tool point";
    "external_force" "n" Axis Number sample.external_force "part of −F_e with which somebody pushes the tool";
    "manipulability" "" Period Number sample.manipulability "product of the singular values of all task rows";
    "limit" "" Joint Word sample.limits "`free`, held back by a bound (`lower`, `upper`), or beyond it (`below`, `above`)";
    "work" "j" Period Number sample.energy.work_j "work done on the contacts so far";
    "stored" "j" Period Number sample.energy.stored_j "what they give back";
    "dissipated" "j" Period Number sample.energy.dissipated_j "what they turned into heat";
    "answer_age" "" Period Count sample.answer_age "periods since the state was measured that the answer belongs to";
    "sensed_position" "rad" Joint Number sensed.joint_position "q as the controller was told it";
    "sensed_velocity" "rad_s" Joint Number sensed.joint_velocity "q̇ as the controller was told it";
    "sensed_force" "n" Axis Number sensed.force "force as the controller was told it, with the sign and along the axes that it expects";
    "sensed_torque" "n_m" Axis Number sensed.torque "torque, likewise";
    "round_trip" "us" Period Number timing.round_trip_us "real time from the state to its answer";
    "elapsed" "us" Period Number timing.elapsed_us "real time to compute the answer, as the service says";
};
