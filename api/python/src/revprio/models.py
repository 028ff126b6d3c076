"""The bodies of requests and answers. Generated from the OpenAPI document by `generate.py`; do not edit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from numpy.typing import ArrayLike as AnyArrayLike
from pydantic import BeforeValidator, Field

from revprio.answers import Answer
from revprio.bodies import (
    ArrayLike,
    Body,
    FloatArray,
    JointVector,
    LowerBounds,
    Matrix,
    OneOrMore,
    Tagged,
    UpperBounds,
    Vector,
)
from revprio.conversions import Quaternion, UrdfText, constant
from revprio.problem import REMEDIES, Problem


__all__ = [
    "ActiveInequality",
    "ActiveLimit",
    "ActiveLimitName",
    "ActiveRow",
    "AntiWindup",
    "ArmView",
    "Axis",
    "BatchAnswer",
    "BatchItem",
    "BatchRequest",
    "Capsule",
    "Certificate",
    "CertificatePart",
    "CertifiedLevel",
    "CertifiedProblem",
    "ChainView",
    "Channel",
    "ChannelInput",
    "ChannelKind",
    "ChannelMemory",
    "ChannelTarget",
    "ChunkAction",
    "ChunkAlign",
    "ChunkMemory",
    "ChunkStatus",
    "CollisionPairs",
    "CollisionReport",
    "CollisionRows",
    "Collisions",
    "ConstantProfile",
    "Contact",
    "ContactFault",
    "ContactKind",
    "ContactLaw",
    "ContactMemory",
    "ContactReport",
    "ContactState",
    "Contradiction",
    "ContradictionMember",
    "ControllerConfig",
    "ControllerTask",
    "CreatedController",
    "Cuboid",
    "Damping",
    "DenavitHartenberg",
    "DriveState",
    "Edge",
    "Environment",
    "EnvironmentAxis",
    "ExplicitLimits",
    "Fade",
    "Faults",
    "ForceAlongMotionTargetProgram",
    "ForceLaw",
    "Frame",
    "FramePose",
    "Friction",
    "HalfSpace",
    "Hinge",
    "Hole",
    "HybridLaw",
    "ImpedanceLaw",
    "Inequality",
    "InitialPostureNullSpaceMotion",
    "Interactive",
    "JerkState",
    "JointDrive",
    "JointKind",
    "JointLimitsNullSpaceMotion",
    "JointTurns",
    "JointView",
    "JointsInequality",
    "KinematicsAnswer",
    "KinematicsRequest",
    "LaterTarget",
    "Law",
    "LeftOutJoint",
    "LeftOutPair",
    "LeftOutReason",
    "LevelMultipliers",
    "LimitKind",
    "Limits",
    "Line",
    "LinkFrame",
    "LinkShape",
    "LiveContact",
    "LiveFrame",
    "LiveRoom",
    "LiveSample",
    "LookAtLaw",
    "MeasuredContact",
    "Memory",
    "Method",
    "MotionPath",
    "NamedScenario",
    "NormalMemory",
    "NullSpaceMotion",
    "NullSpaceVelocity",
    "Obstacle",
    "ObstacleMotion",
    "ObstacleState",
    "Orientation",
    "Outage",
    "PairDistance",
    "Path",
    "PathCounts",
    "Payload",
    "PayloadAnswer",
    "PayloadReading",
    "PayloadRequest",
    "PerAxisBool",
    "PlaneInequality",
    "Pose",
    "PoseLaw",
    "PostureLaw",
    "PostureNullSpaceMotion",
    "PostureTarget",
    "Problem",
    "Profile",
    "ProfilePoint",
    "Progress",
    "REMEDIES",
    "RampProfile",
    "RegisteredTip",
    "ResolveAnswer",
    "ResolveRequest",
    "ResolveTask",
    "RestNullSpaceMotion",
    "RestReading",
    "RestState",
    "Robot",
    "RobotChain",
    "RobotJoint",
    "RobotList",
    "RobotRegistration",
    "RobotShapes",
    "RobotSource",
    "RobotTip",
    "RoomObstacle",
    "RowName",
    "Scenario",
    "ScenarioEntry",
    "ScenarioList",
    "Sensor",
    "Sensors",
    "SessionEntry",
    "SessionList",
    "SessionStatus",
    "ShapeSource",
    "Side",
    "Simulation",
    "SimulationControl",
    "SimulationMetrics",
    "SimulationRequest",
    "SimulationState",
    "SineProfile",
    "Singularity",
    "Solver",
    "SolverLevel",
    "SolverReport",
    "Sphere",
    "SpiralSearchTargetProgram",
    "StabilityAnswer",
    "StabilityRequest",
    "Stall",
    "State",
    "StateChecks",
    "StatedLimits",
    "Status",
    "StepAnswer",
    "StepRequest",
    "StepsProfile",
    "StreamedPose",
    "StreamedQuantity",
    "StreamedTarget",
    "Streaming",
    "StuckTask",
    "SurfaceFollowing",
    "SurfaceReport",
    "TareAnswer",
    "TareRequest",
    "TargetAhead",
    "TargetPose",
    "TargetProgram",
    "TargetReference",
    "TargetSample",
    "TargetState",
    "TargetStream",
    "TaskGain",
    "TaskOutcome",
    "TimeHistogram",
    "TipPose",
    "TipReason",
    "VelocityEnvelope",
    "VelocityLaw",
    "VelocityLoop",
    "ViolatedInequality",
    "ViolatedLimit",
    "VirtualArm",
    "WatchedStep",
    "WaypointsProfile",
    "Wrench",
    "WrenchConvention",
    "WrenchFrame",
    "WrenchSensor",
    "WrenchSensorMemory",
]


class ActiveInequality(Answer):
    """An active inequality: it restricts the answer. It holds with equality, or as nearly as the others permit if it is
    among the violated ones.

    Fields:

    - bound: Upper bound b.
    - multiplier: Lagrange multiplier: decrease of ½ residual² of the highest restricted task per unit of a larger
      b.
    - name: Name of the inequality.
    """

    bound: float
    """Upper bound b."""
    multiplier: float
    """Lagrange multiplier: decrease of ½ residual² of the highest restricted task per unit of a larger b."""
    name: str
    """Name of the inequality."""


Side = Literal["lower", "upper"]
"""The side of a bound."""


class ActiveLimit(Answer):
    """An active limit: a bound that the answer reaches and that restricts it.

    Fields:

    - joint: Name of the joint.
    - multiplier: Lagrange multiplier: decrease of ½ residual² of the highest restricted task per unit of a wider
      bound.
    - side: Lower or upper bound.
    - value: Bound, rad/s or m/s.
    """

    joint: str
    """Name of the joint."""
    multiplier: float
    """Lagrange multiplier: decrease of ½ residual² of the highest restricted task per unit of a wider bound."""
    side: Side
    """Lower or upper bound."""
    value: float
    """Bound, rad/s or m/s."""


class ActiveLimitName(Body):
    """An active limit: a joint, an inequality, or a row of a task, and a side.

    Fields:

    - side: Lower or upper bound; `upper` for an inequality.
    - inequality: Name of the inequality, for an inequality.
    - joint: Name of the joint, for a limit of a joint.
    - row: Index of the row in its task, from 0.
    - task: Name of the task, for a row of a task.
    """

    side: Side
    """Lower or upper bound; `upper` for an inequality."""
    inequality: str | None = None
    """Name of the inequality, for an inequality."""
    joint: str | None = None
    """Name of the joint, for a limit of a joint."""
    row: int | None = None
    """Index of the row in its task, from 0."""
    task: str | None = None
    """Name of the task, for a row of a task."""


class ActiveRow(Answer):
    """An active row: a row of a task that reaches a bound and restricts the answer.

    Fields:

    - multiplier: Lagrange multiplier: decrease of ½ residual² of the highest restricted task per unit of a wider
      bound.
    - row: Index of the row in its task, from 0.
    - side: Lower or upper bound.
    """

    multiplier: float
    """Lagrange multiplier: decrease of ½ residual² of the highest restricted task per unit of a wider bound."""
    row: int
    """Index of the row in its task, from 0."""
    side: Side
    """Lower or upper bound."""


AntiWindup = Literal["always", "except_damping"]
"""When the integrators of `force`, `impedance` and `hybrid` follow the achieved velocity instead of the requested
one."""


class JointView(Answer):
    """The axis of a joint, and the velocities that its limits allow.

    Fields:

    - axis: Direction of the axis, unit vector, base frame.
    - origin: Point on the axis, base frame, m.
    - lower: Minimum velocity in this period, rad/s or m/s; `null` without a bound.
    - upper: Maximum velocity in this period, rad/s or m/s; `null` without a bound.
    """

    axis: FloatArray
    """Direction of the axis, unit vector, base frame."""
    origin: FloatArray
    """Point on the axis, base frame, m."""
    lower: float | None = None
    """Minimum velocity in this period, rad/s or m/s; `null` without a bound."""
    upper: float | None = None
    """Maximum velocity in this period, rad/s or m/s; `null` without a bound."""


class Orientation(Quaternion):
    """An orientation as a unit quaternion. Four numbers in a list or an array are x, y, z, w, as in ROS and SciPy.

    Fields:

    - w: Scalar part.
    - x: x of the vector part.
    - y: y of the vector part.
    - z: z of the vector part.
    """

    w: float
    """Scalar part."""
    x: float
    """x of the vector part."""
    y: float
    """y of the vector part."""
    z: float
    """z of the vector part."""


class Pose(Body):
    """A pose in the frame that the description of its field names.

    Fields:

    - orientation: Orientation, unit quaternion.
    - position: Position x, y, z, m. Shape: 3.
    """

    orientation: Orientation
    """Orientation, unit quaternion."""
    position: Vector
    """Position x, y, z, m. Shape: 3."""


class ChainView(Answer):
    """The chain of joints from the base to a tip.

    Fields:

    - joints: Its joints, base first: places in `joints`, from 0.
    - tip: Position of the tip in the base frame, m.
    """

    joints: list[int]
    """Its joints, base first: places in `joints`, from 0."""
    tip: FloatArray
    """Position of the tip in the base frame, m."""


class ArmView(Answer):
    """An arm at a posture, for drawing.

    Fields:

    - joints: The joints, base first.
    - tool: Tool pose in the base frame, m.
    - chains: The chain to each tip, first the tool; absent if all joints are one chain.
    """

    joints: list[JointView]
    """The joints, base first."""
    tool: Pose
    """Tool pose in the base frame, m."""
    chains: list[ChainView] = Field(default_factory=list)
    """The chain to each tip, first the tool; absent if all joints are one chain."""


Axis = Literal["x", "y", "z", "rx", "ry", "rz"]
"""One axis of a twist or a wrench, in the frame of the task."""


class Singularity(Answer):
    """Distance of the tasks from singularities.

    Fields:

    - algorithmic: Whether the rows of any task depend on the rows of lower tasks.
    - manipulability: Manipulability, the product of the singular values of all task rows together.
    - smallest_singular_value: Smallest singular value of all task rows together.
    """

    algorithmic: bool
    """Whether the rows of any task depend on the rows of lower tasks."""
    manipulability: float
    """Manipulability, the product of the singular values of all task rows together."""
    smallest_singular_value: float
    """Smallest singular value of all task rows together."""


Path = Literal["closed_form", "active_set", "qp"]
"""The solver path that found an answer."""

Status = Literal["optimal", "not_certified", "failed"]
"""The status of an answer: whether it is certified optimal."""


class SolverLevel(Answer):
    """What Clarabel did at one level.

    Fields:

    - iterations: Number of iterations; 0 with a `clarabel_residual` of 0 where the levels above leave nothing to
      decide.
    - clarabel_residual: Largest relative residual of the optimality conditions of the level at Clarabel's answer;
      `null` without an answer. Where the level was solved again from its first answer, this is the residual of the
      first one.
    - residual: The same after the polish, one linear solve on Clarabel's active limits, if that is more accurate;
      otherwise before it. Where the level was solved again from its first answer, this is the residual of the last
      one. It is at least the relative change that lower levels made to the rows that the level keeps, so it can be
      larger than `clarabel_residual`.
    """

    iterations: int
    """Number of iterations; 0 with a `clarabel_residual` of 0 where the levels above leave nothing to decide."""
    clarabel_residual: float | None = None
    """Largest relative residual of the optimality conditions of the level at Clarabel's answer; `null` without an
    answer. Where the level was solved again from its first answer, this is the residual of the first one."""
    residual: float | None = None
    """The same after the polish, one linear solve on Clarabel's active limits, if that is more accurate; otherwise
    before it. Where the level was solved again from its first answer, this is the residual of the last one. It is at
    least the relative change that lower levels made to the rows that the level keeps, so it can be larger than
    `clarabel_residual`."""


class SolverReport(Answer):
    """Solver path, status and optimality check of an answer.

    Fields:

    - iterations: Number of iterations of Clarabel over all levels; 0 unless the solver is `qp`.
    - path: Solver path that found the answer.
    - status: Whether the answer is certified optimal.
    - failures: Number of levels for which Clarabel found no answer, with the solver `qp`. An answer at its cap of
      iterations counts as one; its residual judges it. Where a level has no answer, the result keeps what the
      levels above achieved, and `status` is not `optimal`.
    - kkt_residual: Largest relative residual of the optimality conditions; `null` without an answer or if not
      finite, never if `status` is `optimal`.
    - last_resorts: Number of problems for which the solver `auto` needed its last resort, one change of the active
      limits at a time; absent if 0.
    - levels: What Clarabel did at each level, in the order of solution; only with the solver `qp`.
    - rank_uncertain: Whether a rank decision lies so near its threshold that rounding may have decided it; default
      `false`.
    - working_sets: Number of working sets (sets of active limits) that the solver `auto` tried; 0 with the others.
    """

    iterations: int
    """Number of iterations of Clarabel over all levels; 0 unless the solver is `qp`."""
    path: Path
    """Solver path that found the answer."""
    status: Status
    """Whether the answer is certified optimal."""
    failures: int | None = None
    """Number of levels for which Clarabel found no answer, with the solver `qp`. An answer at its cap of iterations
    counts as one; its residual judges it. Where a level has no answer, the result keeps what the levels above achieved,
    and `status` is not `optimal`."""
    kkt_residual: float | None = None
    """Largest relative residual of the optimality conditions; `null` without an answer or if not finite, never if
    `status` is `optimal`."""
    last_resorts: int | None = None
    """Number of problems for which the solver `auto` needed its last resort, one change of the active limits at a time;
    absent if 0."""
    levels: list[SolverLevel] = Field(default_factory=list)
    """What Clarabel did at each level, in the order of solution; only with the solver `qp`."""
    rank_uncertain: bool | None = None
    """Whether a rank decision lies so near its threshold that rounding may have decided it; default `false`."""
    working_sets: int | None = None
    """Number of working sets (sets of active limits) that the solver `auto` tried; 0 with the others."""


class ChunkStatus(Answer):
    """The chunk that a task follows.

    Fields:

    - actions_left: Number of actions to come.
    - ends_in_s: Time until the last action, s; negative after it.
    - dropped: Number of actions of a chunk of this state that were past; absent if none came or it was ignored.
    - shift_s: Time by which the actions of a chunk of this state were moved, s; absent if none came or it was
      ignored.
    """

    actions_left: int
    """Number of actions to come."""
    ends_in_s: float
    """Time until the last action, s; negative after it."""
    dropped: int | None = None
    """Number of actions of a chunk of this state that were past; absent if none came or it was ignored."""
    shift_s: float | None = None
    """Time by which the actions of a chunk of this state were moved, s; absent if none came or it was ignored."""


ContactState = Literal["approach", "contact", "loss", "fault"]
"""The state of a contact."""

ContactFault = Literal["pull", "stays_in_retreat", "force_limit", "stuck"]
"""Why a contact is given up."""


class SurfaceReport(Answer):
    """The normal of a surface that a task follows.

    Fields:

    - is_limited: Whether the surface is tilted by more than `max_tilt_rad`. The force then has an error.
    - normal: Direction in which the task presses, a unit vector along the axes of the base.
    - friction: Estimated coefficient of friction; absent until the tool has slid 1 mm.
    - max_speed: Largest speed of the other tasks along the surface, m/s, until its normal is known; absent from
      then on, and without contact.
    - uncertainty_rad: Rms angle between the normal and single measurements of it over the last 5 mm, rad. It begins
      with the largest tilt; absent until the tool has slid 1 mm.
    """

    is_limited: bool
    """Whether the surface is tilted by more than `max_tilt_rad`. The force then has an error."""
    normal: FloatArray
    """Direction in which the task presses, a unit vector along the axes of the base."""
    friction: float | None = None
    """Estimated coefficient of friction; absent until the tool has slid 1 mm."""
    max_speed: float | None = None
    """Largest speed of the other tasks along the surface, m/s, until its normal is known; absent from then on, and
    without contact."""
    uncertainty_rad: float | None = None
    """Rms angle between the normal and single measurements of it over the last 5 mm, rad. It begins with the largest
    tilt; absent until the tool has slid 1 mm."""


class ContactReport(Answer):
    """The contact of one row, along its pressing direction. Forces are N or N·m, positions m or rad.

    Fields:

    - approach_speed: Approach speed of this period, m/s or rad/s.
    - energy_j: Energy that the law may still give to the surface, J.
    - predicted_force: Predicted force if all later commands are zero, N or N·m; 0 without contact.
    - state: State of the contact.
    - stiffness_bound: Upper bound of the stiffness with which the law computes, N/m or N·m/rad. It starts at the
      stiffest contact.
    - surface_velocity: Estimated velocity of a surface that moves, along the pressing direction, m/s or rad/s.
    - unavoidable_peak: Peak force that no controller can avoid that brakes with the acceleration of this law, at
      this approach speed in the stiffest contact, N or N·m.
    - event: The state that began in this period; absent in all others. Count these to count contacts and losses.
    - fault: Why the contact is given up; only in the state `fault`.
    - force: Measured force along the pressing direction, N or N·m.
    - stiffness: Estimated stiffness, N/m or N·m/rad; absent until it is known.
    - stiffness_uncertainty: Uncertainty of the estimated stiffness, rms, N/m or N·m/rad; absent until it is known.
    - surface: Normal of the surface; absent for a law without `surface`.
    - target_force: Target force along the pressing direction, N or N·m.
    """

    approach_speed: float
    """Approach speed of this period, m/s or rad/s."""
    energy_j: float
    """Energy that the law may still give to the surface, J."""
    predicted_force: float
    """Predicted force if all later commands are zero, N or N·m; 0 without contact."""
    state: ContactState
    """State of the contact."""
    stiffness_bound: float
    """Upper bound of the stiffness with which the law computes, N/m or N·m/rad. It starts at the stiffest contact."""
    surface_velocity: float
    """Estimated velocity of a surface that moves, along the pressing direction, m/s or rad/s."""
    unavoidable_peak: float
    """Peak force that no controller can avoid that brakes with the acceleration of this law, at this approach speed in
    the stiffest contact, N or N·m."""
    event: ContactState | None = None
    """The state that began in this period; absent in all others. Count these to count contacts and losses."""
    fault: ContactFault | None = None
    """Why the contact is given up; only in the state `fault`."""
    force: float | None = None
    """Measured force along the pressing direction, N or N·m."""
    stiffness: float | None = None
    """Estimated stiffness, N/m or N·m/rad; absent until it is known."""
    stiffness_uncertainty: float | None = None
    """Uncertainty of the estimated stiffness, rms, N/m or N·m/rad; absent until it is known."""
    surface: SurfaceReport | None = None
    """Normal of the surface; absent for a law without `surface`."""
    target_force: float | None = None
    """Target force along the pressing direction, N or N·m."""


TargetState = Literal["following", "extrapolating", "holding", "braking"]
"""Where the streamed target of a period comes from."""


class TaskOutcome(Answer):
    """The outcome of one task.

    Fields:

    - achieved: Achieved task velocity J_k q̇, m/s and rad/s.
    - algorithmic: Whether the rows of the task depend on the rows of lower tasks (algorithmic singularity, Eq.
      (12)).
    - name: Name of the task.
    - rank: Rank of the task Jacobian J_k.
    - requested: Requested task velocity ẋ_k, m/s and rad/s; for a task with bounds the allowed velocity nearest to
      the achieved one.
    - residual_norm: Norm of the residual, ‖J_k q̇ − ẋ_k‖; for a task with bounds the norm of their violation.
    - active_rows: Active rows of a task with bounds: rows that reach a bound and restrict the answer.
    - chunk: The chunk of actions that the task follows; absent if none came.
    - contact: Contact of each row with the law `contact`; absent for other laws.
    - scale: Factor s of a task with `"scale": true`, J_k q̇ = s ẋ_k; absent if no factor keeps its direction.
    - target_age_s: Time of the state minus time of the newest streamed target, s; negative if the target lies
      ahead.
    - target_force: Target force F_d of this period per row, N and N·m; `null` on rows without one; only in answers
      to a state.
    - target_state: Where the streamed target of this period comes from; absent if no target was streamed to this
      task.
    """

    achieved: FloatArray
    """Achieved task velocity J_k q̇, m/s and rad/s."""
    algorithmic: bool
    """Whether the rows of the task depend on the rows of lower tasks (algorithmic singularity, Eq. (12))."""
    name: str
    """Name of the task."""
    rank: int
    """Rank of the task Jacobian J_k."""
    requested: FloatArray
    """Requested task velocity ẋ_k, m/s and rad/s; for a task with bounds the allowed velocity nearest to the achieved
    one."""
    residual_norm: float
    """Norm of the residual, ‖J_k q̇ − ẋ_k‖; for a task with bounds the norm of their violation."""
    active_rows: list[ActiveRow] = Field(default_factory=list)
    """Active rows of a task with bounds: rows that reach a bound and restrict the answer."""
    chunk: ChunkStatus | None = None
    """The chunk of actions that the task follows; absent if none came."""
    contact: list[ContactReport] = Field(default_factory=list)
    """Contact of each row with the law `contact`; absent for other laws."""
    scale: float | None = None
    """Factor s of a task with `"scale": true`, J_k q̇ = s ẋ_k; absent if no factor keeps its direction."""
    target_age_s: float | None = None
    """Time of the state minus time of the newest streamed target, s; negative if the target lies ahead."""
    target_force: FloatArray | None = None
    """Target force F_d of this period per row, N and N·m; `null` on rows without one; only in answers to a state."""
    target_state: TargetState | None = None
    """Where the streamed target of this period comes from; absent if no target was streamed to this task."""


class ViolatedLimit(Answer):
    """A limit that the answer violates.

    Fields:

    - joint: Name of the joint.
    - limit: Bound, rad/s or m/s.
    - side: Lower or upper bound.
    - value: Velocity of the joint, rad/s or m/s.
    """

    joint: str
    """Name of the joint."""
    limit: float
    """Bound, rad/s or m/s."""
    side: Side
    """Lower or upper bound."""
    value: float
    """Velocity of the joint, rad/s or m/s."""


class CertificatePart(Answer):
    """A part of an answer.

    Fields:

    - problem: Index of the problem, from 0.
    - weight: Weight of its solution; all weights add up to one.
    """

    problem: int
    """Index of the problem, from 0."""
    weight: float
    """Weight of its solution; all weights add up to one."""


class RowName(Answer):
    """What a row stands for: a row of a task, an inequality, or, without fields, damping or a part of a scaled task.

    Fields:

    - inequality: Name of the inequality. Its row has length one.
    - row: Index of the row in its task, from 0.
    - task: Name of the task.
    """

    inequality: str | None = None
    """Name of the inequality. Its row has length one."""
    row: int | None = None
    """Index of the row in its task, from 0."""
    task: str | None = None
    """Name of the task."""


class CertifiedLevel(Answer):
    """The rows of a level: each asks lower ≤ a·x ≤ upper.

    Fields:

    - lower: Lower bounds of the rows; `null`: no bound. A row with equal bounds is an equation.
    - names: What each row stands for.
    - rows: Coefficients a of each row, one per unknown.
    - upper: Upper bounds of the rows.
    """

    lower: FloatArray
    """Lower bounds of the rows; `null`: no bound. A row with equal bounds is an equation."""
    names: list[RowName]
    """What each row stands for."""
    rows: list[FloatArray]
    """Coefficients a of each row, one per unknown."""
    upper: FloatArray
    """Upper bounds of the rows."""


class LevelMultipliers(Answer):
    """The multipliers of one level.

    Fields:

    - rows: Weights w of the rows of this level and all higher ones, highest level first; the residuals on the
      level's own rows.
    - unknowns: Multipliers h of the bounds of the unknowns, Σ w a over the rows; for the last objective plus ζ − x.
    """

    rows: FloatArray
    """Weights w of the rows of this level and all higher ones, highest level first; the residuals on the level's own
    rows."""
    unknowns: FloatArray
    """Multipliers h of the bounds of the unknowns, Σ w a over the rows; for the last objective plus ζ − x."""


class CertifiedProblem(Answer):
    """A problem with priority levels inside a box, and its solution x.

    Fields:

    - levels: Levels, highest first.
    - lower: Lower bounds of the unknowns: the joint velocities, then the speed of each scaled task; `null`: no
      bound.
    - multipliers: Multipliers of each level, and of the last objective at the end; `null` where a level leaves no
      residual.
    - reference: Reference ζ: after the last level, ‖x − ζ‖² is as small as possible.
    - solution: Solution x.
    - upper: Upper bounds of the unknowns.
    """

    levels: list[CertifiedLevel]
    """Levels, highest first."""
    lower: FloatArray
    """Lower bounds of the unknowns: the joint velocities, then the speed of each scaled task; `null`: no bound."""
    multipliers: list[LevelMultipliers | None]
    """Multipliers of each level, and of the last objective at the end; `null` where a level leaves no residual."""
    reference: FloatArray
    """Reference ζ: after the last level, ‖x − ζ‖² is as small as possible."""
    solution: FloatArray
    """Solution x."""
    upper: FloatArray
    """Upper bounds of the unknowns."""


class Certificate(Answer):
    """The problems that were solved on the way to an answer, with their solutions and multipliers.

    Fields:

    - answer: The parts of the joint velocity: Σ weight · solution, moved to the nearest point of the box.
    - problems: The problems in the order of their solution.
    """

    answer: list[CertificatePart]
    """The parts of the joint velocity: Σ weight · solution, moved to the nearest point of the box."""
    problems: list[CertifiedProblem]
    """The problems in the order of their solution."""


class ContradictionMember(Answer):
    """A demand in a contradiction: a row of a task, a joint limit, or an inequality, and a side.

    Fields:

    - side: Lower or upper bound.
    - inequality: Name of the inequality, for an inequality.
    - joint: Name of the joint, for a limit of a joint.
    - row: Index of the row in its task, from 0.
    - task: Name of the task, for a row of a task.
    """

    side: Side
    """Lower or upper bound."""
    inequality: str | None = None
    """Name of the inequality, for an inequality."""
    joint: str | None = None
    """Name of the joint, for a limit of a joint."""
    row: int | None = None
    """Index of the row in its task, from 0."""
    task: str | None = None
    """Name of the task, for a row of a task."""


class Contradiction(Answer):
    """A contradiction: demands that cannot all be kept, of which any one can be dropped so that the others can.

    Fields:

    - members: Demands that contradict each other.
    - task: Name of the task whose bounds cannot all be kept; `null` for the inequalities, which come before all
      tasks.
    """

    members: list[ContradictionMember]
    """Demands that contradict each other."""
    task: str | None = None
    """Name of the task whose bounds cannot all be kept; `null` for the inequalities, which come before all tasks."""


class ViolatedInequality(Answer):
    """An inequality that the answer violates: the solver is `closed_form`, or the inequalities contradict the joint
    limits.

    Fields:

    - bound: Upper bound b.
    - name: Name of the inequality.
    - value: Value a·q̇ of the answer.
    """

    bound: float
    """Upper bound b."""
    name: str
    """Name of the inequality."""
    value: float
    """Value a·q̇ of the answer."""


class ResolveAnswer(Answer):
    """Joint velocities and their explanation.

    Fields:

    - active_limits: Active limits: bounds that the answer reaches and that restrict it.
    - elapsed_us: Time to compute the answer, µs.
    - joint_velocity: Joint velocity q̇, the command, in joint order, rad/s or m/s.
    - limit_conflict: Names of joints whose acceleration limit contradicts position or velocity limits and is not
      kept.
    - singularity: Distance of the tasks from singularities.
    - solver: Solver path, status and optimality check.
    - tasks: Outcome of each task, highest priority first.
    - violated_limits: Violated limits. The solver `closed_form` may violate all; others exceed only speed limits
      that `limits` do not contain.
    - active_inequalities: Active inequalities.
    - certificate: Certificate of the answer; only if the request has `"certificate": true`.
    - contradictions: Contradictions: minimal sets of demands that cannot all be kept.
    - joint_limit_index: Joint-limit index H: 0 with all joints in the middle of their ranges, ½ with all at a
      limit; only with a robot.
    - violated_inequalities: Violated inequalities.
    - warnings: Warnings: numbers that are probably in another unit, and a method that does not keep the order of
      the tasks.
    - why: Sentences that say what restricts the joint velocities, then what each task gives up; only if the request
      has `"why": true`.
    """

    active_limits: list[ActiveLimit]
    """Active limits: bounds that the answer reaches and that restrict it."""
    elapsed_us: float
    """Time to compute the answer, µs."""
    joint_velocity: FloatArray
    """Joint velocity q̇, the command, in joint order, rad/s or m/s."""
    limit_conflict: list[str]
    """Names of joints whose acceleration limit contradicts position or velocity limits and is not kept."""
    singularity: Singularity
    """Distance of the tasks from singularities."""
    solver: SolverReport
    """Solver path, status and optimality check."""
    tasks: list[TaskOutcome]
    """Outcome of each task, highest priority first."""
    violated_limits: list[ViolatedLimit]
    """Violated limits. The solver `closed_form` may violate all; others exceed only speed limits that `limits` do not
    contain."""
    active_inequalities: list[ActiveInequality] = Field(default_factory=list)
    """Active inequalities."""
    certificate: Certificate | None = None
    """Certificate of the answer; only if the request has `"certificate": true`."""
    contradictions: list[Contradiction] = Field(default_factory=list)
    """Contradictions: minimal sets of demands that cannot all be kept."""
    joint_limit_index: float | None = None
    """Joint-limit index H: 0 with all joints in the middle of their ranges, ½ with all at a limit; only with a
    robot."""
    violated_inequalities: list[ViolatedInequality] = Field(default_factory=list)
    """Violated inequalities."""
    warnings: list[str] = Field(default_factory=list)
    """Warnings: numbers that are probably in another unit, and a method that does not keep the order of the tasks."""
    why: list[str] = Field(default_factory=list)
    """Sentences that say what restricts the joint velocities, then what each task gives up; only if the request has
    `"why": true`."""


BatchItem = ResolveAnswer | Problem
"""The result of one problem of a batch."""


class BatchAnswer(Answer):
    """The results of a batch.

    Fields:

    - items: One answer or error per problem, in the order of the request.
    """

    items: list[BatchItem]
    """One answer or error per problem, in the order of the request."""


Frame = Literal["base", "tool"] | Pose
"""Axes of a task: of the base, of the tool, or of a frame with this pose in the base (m, unit quaternion). In the
last case, target poses are given in that frame."""


class ResolveTask(Body):
    """One task: axes of the tool or its own Jacobian, and their velocity or bounds of it.

    Fields:

    - axes: Axes of the tool that the task moves, one per row; list only those that matter, so that lower tasks keep
      the others. Instead of `jacobian`.
    - frame: Axes along which the rows are measured. Set `tool` for motions relative to the tool, or a pose for a
      surface; default `base`.
    - jacobian: Task Jacobian J_k, m × n, row by row. Set it for rows that you compute, such as those of a mobile
      base; instead of `axes`.
    - link: Tip or link that the axes belong to, by its name, in place of the tool. Set it for a second arm, an
      elbow or a camera; only with `axes`; default: the first tip, which is the tool.
    - lower: Lower bounds of the task velocity J_k q̇, one entry per row, m/s and rad/s. Set bounds instead of
      `velocity` if the task only limits a motion; `null`: no bound; default: none.
    - name: Name, by which the answer names the task; default `task 1`, `task 2`, …
    - reference_point: Reference point of the rows: x, y, z in the tool frame, m. Set it if this task moves another
      point than the others; default: the tool point. Shape: 3.
    - relative_to: Tip or link from which the motion is seen, by its name, in place of the base: poses, velocities
      and the frame `base` are then those of its frame. Set it for two hands that hold one part; only with `axes`;
      default: the base.
    - scale: Whether limits slow the task down in its direction, J_k q̇ = s ẋ_k with the largest s ≤ 1. Set it for
      paths that must keep their shape; only with `velocity`; default `false`.
    - upper: Upper bounds of the task velocity J_k q̇, as `lower`.
    - velocity: Task velocity ẋ_k, one entry per row, m/s and rad/s; instead of `lower` and `upper`.
    """

    axes: OneOrMore[Axis] | None = None
    """Axes of the tool that the task moves, one per row; list only those that matter, so that lower tasks keep the
    others. Instead of `jacobian`."""
    frame: Frame | None = None
    """Axes along which the rows are measured. Set `tool` for motions relative to the tool, or a pose for a surface;
    default `base`."""
    jacobian: Matrix | None = None
    """Task Jacobian J_k, m × n, row by row. Set it for rows that you compute, such as those of a mobile base; instead
    of `axes`."""
    link: str | None = None
    """Tip or link that the axes belong to, by its name, in place of the tool. Set it for a second arm, an elbow or a
    camera; only with `axes`; default: the first tip, which is the tool."""
    lower: LowerBounds | None = None
    """Lower bounds of the task velocity J_k q̇, one entry per row, m/s and rad/s. Set bounds instead of `velocity` if
    the task only limits a motion; `null`: no bound; default: none."""
    name: str | None = None
    """Name, by which the answer names the task; default `task 1`, `task 2`, …"""
    reference_point: Vector | None = None
    """Reference point of the rows: x, y, z in the tool frame, m. Set it if this task moves another point than the
    others; default: the tool point. Shape: 3."""
    relative_to: str | None = None
    """Tip or link from which the motion is seen, by its name, in place of the base: poses, velocities and the frame
    `base` are then those of its frame. Set it for two hands that hold one part; only with `axes`; default: the base."""
    scale: bool | None = None
    """Whether limits slow the task down in its direction, J_k q̇ = s ẋ_k with the largest s ≤ 1. Set it for paths that
    must keep their shape; only with `velocity`; default `false`."""
    upper: UpperBounds | None = None
    """Upper bounds of the task velocity J_k q̇, as `lower`."""
    velocity: Vector | None = None
    """Task velocity ẋ_k, one entry per row, m/s and rad/s; instead of `lower` and `upper`."""


class Damping(Body):
    """Damping near singularities: λ² = (1 − (σ_min/δ)²) λ_max² for σ_min < δ, otherwise 0.

    Fields:

    - max_factor: Maximum damping factor λ_max ≥ 0, reached at a singular value of zero. A larger one moves the
      joints more slowly there.
    - threshold: Threshold δ > 0: damping acts if the smallest singular value is below it. A larger one begins
      farther from the singularity.
    """

    max_factor: float
    """Maximum damping factor λ_max ≥ 0, reached at a singular value of zero. A larger one moves the joints more slowly
    there."""
    threshold: float
    """Threshold δ > 0: damping acts if the smallest singular value is below it. A larger one begins farther from the
    singularity."""


class JointsInequality(Tagged):
    """The inequality a·q̇ ≤ b.

    Fields:

    - coefficients: Coefficients a, one per joint, in joint order, any unit; zero for joints that the inequality is
      not about.
    - kind: Selects the variant.
    - upper: Upper bound b, rad/s (or m/s) times the unit of a. For a lower bound, change the sign of `coefficients`
      and `upper`.
    - name: Name, unique in the list; default `inequality 1`, `inequality 2`, …
    """

    coefficients: Vector
    """Coefficients a, one per joint, in joint order, any unit; zero for joints that the inequality is not about."""
    kind: Literal["joints"] = "joints"
    """Selects the variant."""
    upper: float
    """Upper bound b, rad/s (or m/s) times the unit of a. For a lower bound, change the sign of `coefficients` and
    `upper`."""
    name: str | None = None
    """Name, unique in the list; default `inequality 1`, `inequality 2`, …"""


class PlaneInequality(Tagged):
    """A virtual wall: a point p of the arm stays on one side of a plane, n·ṗ ≤ rate (offset − n·p).

    Fields:

    - kind: Selects the variant.
    - normal: Normal n of the plane in the base frame, towards the forbidden side, of any length; n is the vector of
      length one. Shape: 3.
    - offset_m: Distance of the plane from the base origin along n, m.
    - name: Name, unique in the list; default `inequality 1`, `inequality 2`, …
    - point: Point p that is held back: `tool`, the name of a joint for the origin of its frame, or that of a tip or
      a link for the origin of that frame; default `tool`.
    - rate_per_s: Maximum rate at which the distance to the plane decreases, 1/s; at most 1/T. A smaller one slows
      the arm earlier; default 10.
    """

    kind: Literal["plane"] = "plane"
    """Selects the variant."""
    normal: Vector
    """Normal n of the plane in the base frame, towards the forbidden side, of any length; n is the vector of length
    one. Shape: 3."""
    offset_m: float
    """Distance of the plane from the base origin along n, m."""
    name: str | None = None
    """Name, unique in the list; default `inequality 1`, `inequality 2`, …"""
    point: str | None = None
    """Point p that is held back: `tool`, the name of a joint for the origin of its frame, or that of a tip or a link
    for the origin of that frame; default `tool`."""
    rate_per_s: float | None = None
    """Maximum rate at which the distance to the plane decreases, 1/s; at most 1/T. A smaller one slows the arm earlier;
    default 10."""


Inequality = Annotated[JointsInequality | PlaneInequality, Field(discriminator="kind")]
"""A linear inequality on the joint velocities, besides the joint limits."""

LimitKind = Literal["none", "velocity", "position_velocity", "position_velocity_acceleration"]
"""The limits of the robot that apply."""


class ExplicitLimits(Body):
    """Bounds lower ≤ q̇ ≤ upper.

    Fields:

    - lower: Lower bounds, one per joint, rad/s or m/s; usually negative.
    - upper: Upper bounds, one per joint, rad/s or m/s.
    """

    lower: Vector
    """Lower bounds, one per joint, rad/s or m/s; usually negative."""
    upper: Vector
    """Upper bounds, one per joint, rad/s or m/s."""


Limits = LimitKind | ExplicitLimits
"""The limits of the joint velocities: limits of the robot by name, or bounds of the velocities."""

Method = Literal[
    "pseudoinverse",
    "damped_least_squares",
    "task_priority",
    "singularity_robust",
    "reverse_priority",
    "strict_reverse_priority",
]
"""The resolution method, the meaning of priorities."""


class JointLimitsNullSpaceMotion(Tagged):
    """The velocity −k ∇H, away from the position limits, with the joint-limit index H.

    Fields:

    - gain: Gain k, rad²/s or m²/s. A larger one leaves the limits faster.
    - kind: Selects the variant.
    """

    gain: float
    """Gain k, rad²/s or m²/s. A larger one leaves the limits faster."""
    kind: Literal["joint_limits"] = "joint_limits"
    """Selects the variant."""


class PostureNullSpaceMotion(Tagged):
    """The velocity K (q_d − q), towards a posture.

    Fields:

    - gain: Gain K, 1/s: within 1/K seconds the distance to the posture decreases to 37 %.
    - joint_position: Target posture q_d, rad or m: a posture that works well, such as one with a raised elbow.
    - kind: Selects the variant.
    """

    gain: float
    """Gain K, 1/s: within 1/K seconds the distance to the posture decreases to 37 %."""
    joint_position: JointVector
    """Target posture q_d, rad or m: a posture that works well, such as one with a raised elbow."""
    kind: Literal["posture"] = "posture"
    """Selects the variant."""


class InitialPostureNullSpaceMotion(Tagged):
    """The part of K (q_0 − q) in the null space of all tasks, towards the posture of the first state, with a norm of at
    most 0.5 rad/s; only in controllers.

    Fields:

    - gain: Gain K, 1/s: within 1/K seconds the distance to the posture decreases to 37 %.
    - kind: Selects the variant.
    """

    gain: float
    """Gain K, 1/s: within 1/K seconds the distance to the posture decreases to 37 %."""
    kind: Literal["initial_posture"] = "initial_posture"
    """Selects the variant."""


class RestNullSpaceMotion(Tagged):
    """Rest, ζ̇ = 0.

    Fields:

    - kind: Selects the variant.
    """

    kind: Literal["rest"] = "rest"
    """Selects the variant."""


NullSpaceMotion = Annotated[
    JointLimitsNullSpaceMotion | PostureNullSpaceMotion | InitialPostureNullSpaceMotion | RestNullSpaceMotion,
    Field(discriminator="kind"),
]
"""A null-space velocity computed from the posture."""

NullSpaceVelocity = NullSpaceMotion | JointVector
"""The null-space velocity ζ̇: a constant, or a motion computed from the posture."""

Solver = Literal["closed_form", "qp", "auto"]
"""The solver of the problem."""


class ResolveRequest(Body):
    """Prioritised tasks at one posture, to resolve into joint velocities.

    Fields:

    - tasks: The tasks, highest priority first: put first what must not give way.
    - certificate: Whether the answer has a `certificate`, with which anyone can check that it is optimal. Set it to
      audit an answer; default `false`.
    - damping: Damping near singularities, which trades accuracy for lower joint speeds. Set it if the posture may
      be singular; default: no damping.
    - inequalities: Inequalities on the joint velocities besides the limits: set them to keep the arm behind planes,
      or to couple joints; default: none.
    - joint_position: Joint position q, rad or m; needed unless every task has its own `jacobian`.
    - joint_velocity: Joint velocity of the last command, rad/s or m/s; needed for acceleration limits.
    - limits: Limits of the joint velocities. Set them if the answer moves an arm; default: `position_velocity` with
      robot, posture and period; `velocity` with a robot alone; otherwise `none`.
    - method: Resolution method, the meaning of priorities. Set another one only to compare; default
      `strict_reverse_priority`.
    - null_space_velocity: Null-space velocity ζ̇, which the answer follows as far as the tasks permit. Set it to
      choose the posture of a redundant arm; default: rest.
    - period_s: Control period T, s: how long the answer will be commanded. Needed for position and acceleration
      limits.
    - robot: Name of the robot, from `GET /v1/robots`; not needed if every task has its own `jacobian`.
    - solver: Solver. Keep the default on an arm: `qp` is a second, slower solver to compare with, and `closed_form`
      ignores limits. Default `auto`.
    - tool_offset: Pose of the tool point and axes in the robot's own tool frame, m. Set it to the point that works,
      such as the tip of a gripper; default: that frame itself.
    - why: Whether the answer has `why`, sentences that say what restricts it. Set it while you try a problem out;
      default `false`.
    """

    tasks: list[ResolveTask]
    """The tasks, highest priority first: put first what must not give way."""
    certificate: bool | None = None
    """Whether the answer has a `certificate`, with which anyone can check that it is optimal. Set it to audit an
    answer; default `false`."""
    damping: Damping | None = None
    """Damping near singularities, which trades accuracy for lower joint speeds. Set it if the posture may be singular;
    default: no damping."""
    inequalities: list[Inequality] | None = None
    """Inequalities on the joint velocities besides the limits: set them to keep the arm behind planes, or to couple
    joints; default: none."""
    joint_position: JointVector | None = None
    """Joint position q, rad or m; needed unless every task has its own `jacobian`."""
    joint_velocity: JointVector | None = None
    """Joint velocity of the last command, rad/s or m/s; needed for acceleration limits."""
    limits: Limits | None = None
    """Limits of the joint velocities. Set them if the answer moves an arm; default: `position_velocity` with robot,
    posture and period; `velocity` with a robot alone; otherwise `none`."""
    method: Method | None = None
    """Resolution method, the meaning of priorities. Set another one only to compare; default
    `strict_reverse_priority`."""
    null_space_velocity: NullSpaceVelocity | None = None
    """Null-space velocity ζ̇, which the answer follows as far as the tasks permit. Set it to choose the posture of a
    redundant arm; default: rest."""
    period_s: float | None = None
    """Control period T, s: how long the answer will be commanded. Needed for position and acceleration limits."""
    robot: str | None = None
    """Name of the robot, from `GET /v1/robots`; not needed if every task has its own `jacobian`."""
    solver: Solver | None = None
    """Solver. Keep the default on an arm: `qp` is a second, slower solver to compare with, and `closed_form` ignores
    limits. Default `auto`."""
    tool_offset: Pose | None = None
    """Pose of the tool point and axes in the robot's own tool frame, m. Set it to the point that works, such as the tip
    of a gripper; default: that frame itself."""
    why: bool | None = None
    """Whether the answer has `why`, sentences that say what restricts it. Set it while you try a problem out; default
    `false`."""


class BatchRequest(Body):
    """Independent problems to resolve.

    Fields:

    - items: Problems, at most 10 000. Each is solved on its own, so their order does not matter.
    """

    items: list[ResolveRequest]
    """Problems, at most 10 000. Each is solved on its own, so their order does not matter."""


class Capsule(Body):
    """All points within a radius of a segment.

    Fields:

    - end: The other end, m. Shape: 3.
    - radius: Radius, m.
    - start: One end of the segment, m; of an obstacle in the base frame, of a link in its frame. Shape: 3.
    """

    end: Vector
    """The other end, m. Shape: 3."""
    radius: float
    """Radius, m."""
    start: Vector
    """One end of the segment, m; of an obstacle in the base frame, of a link in its frame. Shape: 3."""


ChannelKind = Literal["position", "force"]
"""What the number of a channel is."""


class ConstantProfile(Tagged):
    """A constant value.

    Fields:

    - kind: Selects the variant.
    - value: Constant value.
    """

    kind: Literal["constant"] = "constant"
    """Selects the variant."""
    value: ArrayLike
    """Constant value."""


class SineProfile(Tagged):
    """A sine: offset + amplitude sin(ω t + φ).

    Fields:

    - amplitude: Amplitude.
    - angular_frequency_rad_s: Angular frequency ω, rad/s.
    - kind: Selects the variant.
    - offset: Mean value.
    - phase_rad: Phase φ, rad; default 0.
    - start_time_s: Start time, s: before it, the value is that at the start. Absent: the sine has no start.
    """

    amplitude: ArrayLike
    """Amplitude."""
    angular_frequency_rad_s: float
    """Angular frequency ω, rad/s."""
    kind: Literal["sine"] = "sine"
    """Selects the variant."""
    offset: ArrayLike
    """Mean value."""
    phase_rad: float | None = None
    """Phase φ, rad; default 0."""
    start_time_s: float | None = None
    """Start time, s: before it, the value is that at the start. Absent: the sine has no start."""


class RampProfile(Tagged):
    """A linear change from one value to another, constant before and after.

    Fields:

    - duration_s: Duration, s; at least 1e-6.
    - end: Value after the ramp.
    - kind: Selects the variant.
    - start: Value before the ramp.
    - start_time_s: Start time, s; default 0.
    """

    duration_s: float
    """Duration, s; at least 1e-6."""
    end: ArrayLike
    """Value after the ramp."""
    kind: Literal["ramp"] = "ramp"
    """Selects the variant."""
    start: ArrayLike
    """Value before the ramp."""
    start_time_s: float | None = None
    """Start time, s; default 0."""


class ProfilePoint(Body):
    """A value at a time.

    Fields:

    - time_s: Time t, s.
    - value: Value at that time.
    """

    time_s: float
    """Time t, s."""
    value: ArrayLike
    """Value at that time."""


class StepsProfile(Tagged):
    """The value of the last point passed; before the first point, its value.

    Fields:

    - kind: Selects the variant.
    - points: Points in the order of their times.
    """

    kind: Literal["steps"] = "steps"
    """Selects the variant."""
    points: list[ProfilePoint]
    """Points in the order of their times."""


class WaypointsProfile(Tagged):
    """A smooth curve through all points, at rest at the first and the last point.

    Fields:

    - kind: Selects the variant.
    - points: Points in the order of their times.
    """

    kind: Literal["waypoints"] = "waypoints"
    """Selects the variant."""
    points: list[ProfilePoint]
    """Points in the order of their times."""


if TYPE_CHECKING:
    Profile = ConstantProfile | SineProfile | RampProfile | StepsProfile | WaypointsProfile | AnyArrayLike
else:
    Profile = Annotated[
        Annotated[
            ConstantProfile | SineProfile | RampProfile | StepsProfile | WaypointsProfile, Field(discriminator="kind")
        ],
        BeforeValidator(constant),
    ]
"""A set-point over time, on the clock of the states. On the clock of Unix (times above 1e9 s) it counts from the
first state. A number or an array is a constant."""


class Channel(Body):
    """A channel besides the joints, such as a gripper: one number that passes through the controller with its timing,
    within a range and a rate. It never moves the arm.

    Fields:

    - kind: What the number is.
    - lower: Smallest command: m or rad for a position, N or N·m for a force.
    - max_rate: Largest change of the command, per second. A `PUT` with a range that does not hold the command moves
      it into the range at once.
    - name: Name, unique in the controller. States, actions and answers use it.
    - upper: Largest command.
    - target: Target over time until a state brings another one, one row; default: the channel has no command before
      its first target. A `PUT` that changes it replaces the targets of states.
    """

    kind: ChannelKind
    """What the number is."""
    lower: float
    """Smallest command: m or rad for a position, N or N·m for a force."""
    max_rate: float
    """Largest change of the command, per second. A `PUT` with a range that does not hold the command moves it into the
    range at once."""
    name: str
    """Name, unique in the controller. States, actions and answers use it."""
    upper: float
    """Largest command."""
    target: Profile | None = None
    """Target over time until a state brings another one, one row; default: the channel has no command before its first
    target. A `PUT` that changes it replaces the targets of states."""


class ChannelInput(Body):
    """What a state brings for a channel.

    Fields:

    - measured: Measured number, from which the first command starts; default: the first command is the first
      target.
    - target: Target from now on, in place of all that came before; default: as before.
    """

    measured: float | None = None
    """Measured number, from which the first command starts; default: the first command is the first target."""
    target: float | None = None
    """Target from now on, in place of all that came before; default: as before."""


class ChannelTarget(Body):
    """A target of a channel in the memory.

    Fields:

    - time_s: Time at which it is due, s.
    - value: The number.
    """

    time_s: float
    """Time at which it is due, s."""
    value: float
    """The number."""


class ChannelMemory(Body):
    """A channel in the memory.

    Fields:

    - channel: Name of the channel.
    - command: Last command; default: none was given.
    - targets: Targets that still count; default: none.
    """

    channel: str
    """Name of the channel."""
    command: float | None = None
    """Last command; default: none was given."""
    targets: list[ChannelTarget] | None = None
    """Targets that still count; default: none."""


class StreamedPose(Body):
    """A target pose of the reference point, in the task's frame if that is a pose, otherwise in the base frame.

    Fields:

    - orientation: Orientation, unit quaternion; required if the task has an angular axis.
    - position: Position x, y, z, m; required if the task has a linear axis. Shape: 3.
    """

    orientation: Orientation | None = None
    """Orientation, unit quaternion; required if the task has an angular axis."""
    position: Vector | None = None
    """Position x, y, z, m; required if the task has a linear axis. Shape: 3."""


class ChunkAction(Body):
    """An action of a chunk: a target with the time at which it is due. Position and orientation are those of a
    `pose`.

    Fields:

    - time_s: Time on the clock of the states, s; later than that of the action before it by at least 1 µs, and at
      most 10 s after the state.
    - channels: Targets of channels of the controller by name, due with the action; default: none.
    - force: Target force F_d per row, N and N·m.
    - gripper: Target of the channel `gripper` of the controller, due with the action.
    - joint_position: Target positions of the joints of the task, in their order or by name, rad or m.
    - orientation: Target orientation, unit quaternion; required if the task has an angular axis.
    - pose: Target pose, in place of `position` and `orientation`.
    - position: Target position x, y, z, m; required if the task has a linear axis. Shape: 3.
    - velocity: Target velocity of a task with the law `velocity`, per row, m/s and rad/s.
    """

    time_s: float
    """Time on the clock of the states, s; later than that of the action before it by at least 1 µs, and at most 10 s
    after the state."""
    channels: dict[str, float] | None = None
    """Targets of channels of the controller by name, due with the action; default: none."""
    force: Vector | None = None
    """Target force F_d per row, N and N·m."""
    gripper: float | None = None
    """Target of the channel `gripper` of the controller, due with the action."""
    joint_position: JointVector | None = None
    """Target positions of the joints of the task, in their order or by name, rad or m."""
    orientation: Orientation | None = None
    """Target orientation, unit quaternion; required if the task has an angular axis."""
    pose: StreamedPose | None = None
    """Target pose, in place of `position` and `orientation`."""
    position: Vector | None = None
    """Target position x, y, z, m; required if the task has a linear axis. Shape: 3."""
    velocity: Vector | None = None
    """Target velocity of a task with the law `velocity`, per row, m/s and rad/s."""


ChunkAlign = Literal["time", "progress"]
"""Which actions of a chunk that comes late are past."""


class LaterTarget(Body):
    """A target of a later time in the memory.

    Fields:

    - time_s: Time of the target, s.
    - pose: Pose in the base frame, m.
    - values: Values per row, if the target is not a pose.
    """

    time_s: float
    """Time of the target, s."""
    pose: Pose | None = None
    """Pose in the base frame, m."""
    values: Vector | None = None
    """Values per row, if the target is not a pose."""


class Fade(Body):
    """An offset that fades, in the memory: of a pose linear and angular in base axes, otherwise per row.

    Fields:

    - acceleration: Second derivative of the offset at the start, per second².
    - duration_s: Time that it takes, s.
    - offset: Offset at the start.
    - rate: Rate of the offset at the start, per second.
    - start_s: Time at which it began, s.
    """

    acceleration: Vector
    """Second derivative of the offset at the start, per second²."""
    duration_s: float
    """Time that it takes, s."""
    offset: Vector
    """Offset at the start."""
    rate: Vector
    """Rate of the offset at the start, per second."""
    start_s: float
    """Time at which it began, s."""


class ChunkMemory(Body):
    """The chunks that a task follows, in the memory.

    Fields:

    - first_s: Time of the first action of the newest chunk, as it was sent, s.
    - merged_s: Time of the state with which it came, s.
    - actions: The actions that still count, at the times at which they are due; default: none.
    - fade: What is left of the motion before the newest chunk; default: nothing.
    """

    first_s: float
    """Time of the first action of the newest chunk, as it was sent, s."""
    merged_s: float
    """Time of the state with which it came, s."""
    actions: list[LaterTarget] | None = None
    """The actions that still count, at the times at which they are due; default: none."""
    fade: Fade | None = None
    """What is left of the motion before the newest chunk; default: nothing."""


class CollisionPairs(Body):
    """Pairs of links of which nothing is watched.

    Fields:

    - leave_out: Pairs of links that may touch, besides neighbours and those that touch in every posture.
    """

    leave_out: list[OneOrMore[str]] | None = None
    """Pairs of links that may touch, besides neighbours and those that touch in every posture."""


class PairDistance(Answer):
    """Distance of one pair.

    Fields:

    - a: Name of the link.
    - b: Name of the other link, or of the obstacle.
    - distance_m: Distance, m; negative: how far the shapes intersect.
    - points: The nearest points on both surfaces in the base frame, m.
    """

    a: str
    """Name of the link."""
    b: str
    """Name of the other link, or of the obstacle."""
    distance_m: float
    """Distance, m; negative: how far the shapes intersect."""
    points: list[FloatArray]
    """The nearest points on both surfaces in the base frame, m."""


class CollisionRows(Answer):
    """Numbers of rows.

    Fields:

    - left: Rows that the solver got.
    - made: Rows that could matter.
    """

    left: int
    """Rows that the solver got."""
    made: int
    """Rows that could matter."""


class CollisionReport(Answer):
    """Distances of the shapes and how they restrict the joint velocities.

    Fields:

    - pairs: The nearest pairs, at most eight, the nearest first.
    - rows: How many rows could matter to the solver, and how many it got.
    - share: Share of the allowed joint velocities, around full braking, among which the answer was found: 1
      usually; less if the stop after the first answer would have come too near; 0: the joint velocities are those
      of full braking.
    - stop_in_s: Time that the arm needs to stop behind its drive, s; 0: it stands.
    - violated: Whether the stop, or that of a watchdog after `valid_for_ms`, comes nearer than `min_distance_m` all
      the same: the arm was nearer before, an obstacle comes, the bound between two samples is too rough, or the
      jerk limits permit nothing else.
    - least_distance_m: Distance of the nearest pair, m; absent: no pair is watched.
    """

    pairs: list[PairDistance]
    """The nearest pairs, at most eight, the nearest first."""
    rows: CollisionRows
    """How many rows could matter to the solver, and how many it got."""
    share: float
    """Share of the allowed joint velocities, around full braking, among which the answer was found: 1 usually; less if
    the stop after the first answer would have come too near; 0: the joint velocities are those of full braking."""
    stop_in_s: float
    """Time that the arm needs to stop behind its drive, s; 0: it stands."""
    violated: bool
    """Whether the stop, or that of a watchdog after `valid_for_ms`, comes nearer than `min_distance_m` all the same:
    the arm was nearer before, an obstacle comes, the bound between two samples is too rough, or the jerk limits permit
    nothing else."""
    least_distance_m: float | None = None
    """Distance of the nearest pair, m; absent: no pair is watched."""


class Cuboid(Body):
    """A box.

    Fields:

    - pose: Pose of its middle in the base frame, m.
    - size: Lengths of its edges along its own axes, m. Shape: 3.
    """

    pose: Pose
    """Pose of its middle in the base frame, m."""
    size: Vector
    """Lengths of its edges along its own axes, m. Shape: 3."""


class HalfSpace(Body):
    """All points x with n·x ≤ offset.

    Fields:

    - normal: Normal n in the base frame, towards the free side, of any length but zero. Shape: 3.
    - offset_m: Distance of the surface from the base origin along n, m.
    """

    normal: Vector
    """Normal n in the base frame, towards the free side, of any length but zero. Shape: 3."""
    offset_m: float
    """Distance of the surface from the base origin along n, m."""


class Sphere(Body):
    """All points within a radius of a centre.

    Fields:

    - radius: Radius, m.
    - center: Centre, m; of an obstacle in the base frame, of a link in its frame; default: the origin. Shape: 3.
    """

    radius: float
    """Radius, m."""
    center: Vector | None = None
    """Centre, m; of an obstacle in the base frame, of a link in its frame; default: the origin. Shape: 3."""


class RoomObstacle(Body):
    """A shape of the room: one of `sphere`, `capsule`, `box`, `half_space`.

    Fields:

    - name: Name, unique among the obstacles.
    - box: A box.
    - capsule: A capsule.
    - half_space: All that is behind a plane, such as the floor.
    - moves: Whether each state says where it is; default `false`: it stands where it is.
    - sphere: A sphere.
    """

    name: str
    """Name, unique among the obstacles."""
    box: Cuboid | None = None
    """A box."""
    capsule: Capsule | None = None
    """A capsule."""
    half_space: HalfSpace | None = None
    """All that is behind a plane, such as the floor."""
    moves: bool | None = None
    """Whether each state says where it is; default `false`: it stands where it is."""
    sphere: Sphere | None = None
    """A sphere."""


class Collisions(Body):
    """What an arm keeps clear of. It is no safety function: it trusts the shapes, the drive and the measured
    positions.

    Fields:

    - min_distance_m: Distance that shapes keep, m. Set it to what measurement and shapes may be wrong by; default
      0.01.
    - obstacles: Shapes of the room; default: none.
    - own_links: Whether the links keep clear of each other; default `true`.
    - rate_per_s: Maximum rate at which a distance shrinks to `min_distance_m`, 1/s. A smaller one slows the arm
      earlier; default 10.
    """

    min_distance_m: float | None = None
    """Distance that shapes keep, m. Set it to what measurement and shapes may be wrong by; default 0.01."""
    obstacles: list[RoomObstacle] | None = None
    """Shapes of the room; default: none."""
    own_links: bool | None = None
    """Whether the links keep clear of each other; default `true`."""
    rate_per_s: float | None = None
    """Maximum rate at which a distance shrinks to `min_distance_m`, 1/s. A smaller one slows the arm earlier; default
    10."""


ContactKind = Literal["spring", "wall", "plane", "cylinder", "sphere", "door"]
"""Kind of a contact."""


class Edge(Body):
    """A straight edge at which a plane ends, with a lower level beyond it. A peg presses on the plane until its whole
    lower end is beyond the edge of a block: for a peg with a radius, `distance_m` is that to the edge, and its
    radius.

    Fields:

    - depth_m: Depth of the lower level below the plane, m.
    - direction: Direction from the plane over the edge, square to the normal, base axes; of any length except zero.
      Shape: 3.
    - distance_m: Distance of the edge from the start position of the tool, along the direction, m.
    """

    depth_m: float
    """Depth of the lower level below the plane, m."""
    direction: Vector
    """Direction from the plane over the edge, square to the normal, base axes; of any length except zero. Shape: 3."""
    distance_m: float
    """Distance of the edge from the start position of the tool, along the direction, m."""


class Friction(Body):
    """Friction of a tool with velocity v along a surface that it presses with F_n: (μ F_n/√(v² + v_s²) + B_t) v.

    Fields:

    - coulomb: Coefficient μ of dry friction.
    - sticking_speed_m_s: Speed v_s, m/s. Below it, dry friction decreases to zero, so that a tool at rest has none.
    - viscous: Viscous friction B_t, N·s/m, during contact.
    """

    coulomb: float | None = None
    """Coefficient μ of dry friction."""
    sticking_speed_m_s: float | None = None
    """Speed v_s, m/s. Below it, dry friction decreases to zero, so that a tool at rest has none."""
    viscous: float | None = None
    """Viscous friction B_t, N·s/m, during contact."""


class Hinge(Body):
    """The hinge of a door with the angle θ: torque I θ̈ + b θ̇ and friction.

    Fields:

    - damping: Damping b, N·m·s/rad.
    - friction: Torque of dry friction, N·m. The door does not move while the tool turns it with less.
    - inertia: Moment of inertia I of the door about the hinge, kg·m².
    """

    damping: float | None = None
    """Damping b, N·m·s/rad."""
    friction: float | None = None
    """Torque of dry friction, N·m. The door does not move while the tool turns it with less."""
    inertia: float | None = None
    """Moment of inertia I of the door about the hinge, kg·m²."""


class Hole(Body):
    """A round hole for a round peg that stays upright. The tool point is the middle of its lower end.  A peg above the
    rim presses on the plane with its whole force. Where it is less deep in the side of the hole than in the plane, the
    force is that of the side, towards the hole.

    Fields:

    - center: A point on the axis of the hole, relative to the start position of the tool, base axes, m. Shape: 3.
    - clearance_m: Radius of the hole less that of the peg, m.
    - depth_m: Depth of the hole, m.
    """

    center: Vector
    """A point on the axis of the hole, relative to the start position of the tool, base axes, m. Shape: 3."""
    clearance_m: float
    """Radius of the hole less that of the peg, m."""
    depth_m: float
    """Depth of the hole, m."""


class Contact(Body):
    """A contact: F_e = M_e Ẍ + B_e Ẋ + K_e (X − X_0) along its normal, with friction along the surface.  Paper: Eq.
    (36). Departs: the paper does not print X_0, the position of the surface. It may move; velocity and acceleration are
    relative to it.

    Fields:

    - kind: Kind of contact.
    - stiffness: Stiffness K_e, N/m.
    - axis: Base axis of a spring or a wall, along a cylinder, or of the hinge of a door.
    - damping: Damping B_e, N·s/m.
    - edge: An edge at which a plane ends; none by default.
    - friction: Friction along a surface; none by default. A spring has no surface.
    - hinge: What resists a door; nothing by default.
    - hole: A hole in a plane for a peg at the tool; none by default.
    - inertia: Inertia M_e, kg.
    - motion: Motion that is added to `offset_m`, m, one value.
    - normal: Normal of a plane, a cylinder or a sphere at the place that is nearest to the start position of the
      tool, out of the material, base axes; of any length except zero. For a door: from the hinge to the handle.
      Shape: 3.
    - offset_m: X_0 relative to the start position of the tool, m, along the axis. A wall with a negative offset is
      in the negative direction. With a `normal`: the distance of the tool to the surface, against the normal.
    - radius_m: Radius of a cylinder or a sphere, or distance from the hinge of a door to its handle, m.
    """

    kind: ContactKind
    """Kind of contact."""
    stiffness: float
    """Stiffness K_e, N/m."""
    axis: Literal["x", "y", "z"] | None = None
    """Base axis of a spring or a wall, along a cylinder, or of the hinge of a door."""
    damping: float | None = None
    """Damping B_e, N·s/m."""
    edge: Edge | None = None
    """An edge at which a plane ends; none by default."""
    friction: Friction | None = None
    """Friction along a surface; none by default. A spring has no surface."""
    hinge: Hinge | None = None
    """What resists a door; nothing by default."""
    hole: Hole | None = None
    """A hole in a plane for a peg at the tool; none by default."""
    inertia: float | None = None
    """Inertia M_e, kg."""
    motion: Profile | None = None
    """Motion that is added to `offset_m`, m, one value."""
    normal: Vector | None = None
    """Normal of a plane, a cylinder or a sphere at the place that is nearest to the start position of the tool, out of
    the material, base axes; of any length except zero. For a door: from the hinge to the handle. Shape: 3."""
    offset_m: float | None = None
    """X_0 relative to the start position of the tool, m, along the axis. A wall with a negative offset is in the
    negative direction. With a `normal`: the distance of the tool to the surface, against the normal."""
    radius_m: float | None = None
    """Radius of a cylinder or a sphere, or distance from the hinge of a door to its handle, m."""


class MeasuredContact(Body):
    """What an axis with the law `contact` remembers of the measured positions of the tool. Positions are m or rad,
    forces N or N·m.

    Fields:

    - means: Running means of sensed position and force. Shape: 2.
    - position: Measured position of the tool, the same as the force sensor sees it, and as it is followed. Shape:
      3.
    - stiffness: Upper bound, slope and uncertainty of the stiffness, N/m or N·m/rad. Shape: 3.
    - sums: Sums of the squared position, position times force, the squared force, and the number of samples. Shape:
      4.
    - surface_motion: Means of the velocity of the surface over a short and a long time, and how long it has been
      seen to move, s. Shape: 3.
    - followed: Position and force as they are followed while the contact is held, their rates, what was not
      foreseen of them in the last period, and their noise; absent without a held contact, and in older memories:
      then a motion of the surface is learnt anew. Shape: 8.
    """

    means: Vector
    """Running means of sensed position and force. Shape: 2."""
    position: Vector
    """Measured position of the tool, the same as the force sensor sees it, and as it is followed. Shape: 3."""
    stiffness: Vector
    """Upper bound, slope and uncertainty of the stiffness, N/m or N·m/rad. Shape: 3."""
    sums: Vector
    """Sums of the squared position, position times force, the squared force, and the number of samples. Shape: 4."""
    surface_motion: Vector
    """Means of the velocity of the surface over a short and a long time, and how long it has been seen to move, s.
    Shape: 3."""
    followed: Vector | None = None
    """Position and force as they are followed while the contact is held, their rates, what was not foreseen of them in
    the last period, and their noise; absent without a held contact, and in older memories: then a motion of the surface
    is learnt anew. Shape: 8."""


class NormalMemory(Body):
    """What the law `contact` remembers of the normal of a surface. Vectors are along the axes of the base.

    Fields:

    - chords: Number of measured normals since the touch, up to 5.
    - force: Filtered force of the tool on the surface, N, and that where the present chord begins.
    - friction: Coefficient of friction.
    - is_sliding: Whether position and force are filtered.
    - mean: Mean of the measured normals; zeros before the first one. Shape: 3.
    - normal: Direction in which the task presses, a unit vector. Shape: 3.
    - position: Filtered position of the tool, m, and where the present chord begins.
    - variance: Mean of the squared angle between the mean and the measured normals, rad².
    """

    chords: float
    """Number of measured normals since the touch, up to 5."""
    force: list[Vector]
    """Filtered force of the tool on the surface, N, and that where the present chord begins."""
    friction: float
    """Coefficient of friction."""
    is_sliding: bool
    """Whether position and force are filtered."""
    mean: Vector
    """Mean of the measured normals; zeros before the first one. Shape: 3."""
    normal: Vector
    """Direction in which the task presses, a unit vector. Shape: 3."""
    position: list[Vector]
    """Filtered position of the tool, m, and where the present chord begins."""
    variance: float
    """Mean of the squared angle between the mean and the measured normals, rad²."""


class ContactMemory(Body):
    """What the law `contact` remembers of one axis, along its pressing direction. Forces are N or N·m, positions m or
    rad.

    Fields:

    - before_retreat: Sensed position when the tool last moved forward.
    - contact_time_s: Time in contact since the last touch, of suspicion before it, or of a loss, s.
    - fault_position: Position at the fault.
    - force: Force of the last state.
    - hold_time_s: Time for which the force is near its target, s, up to the time after which the contact is held.
    - is_above: Whether the force is above its target.
    - means: Running means of sensed position and force. Shape: 2.
    - position: Modelled position of the tool since the first step.
    - return_speed: Largest speed of the way back to a lost surface, m/s or rad/s.
    - sensed_position: The same as the force sensor sees it.
    - spent_j: Energy that the surface got, less what its motion may cost, J.
    - state: State of the contact.
    - stiffness: Upper bound, slope and uncertainty of the stiffness, N/m or N·m/rad. Shape: 3.
    - sums: Sums of the squared position, position times force, the squared force, and the number of samples. Shape:
      4.
    - surface: Position of the surface.
    - surface_motion: Place of the surface as it is followed, the stiffness of that place, and the velocity of the
      surface that is fed forward. Only the velocity is read back. Shape: 3.
    - swing: Factor of the upper bound, and the largest difference from the target force since the force last
      crossed it and before. Shape: 3.
    - fault: Why the contact is given up; only in the state `fault`.
    - followed: Position and force as they are followed while the contact is held, their rates, what was not
      foreseen of them in the last period, and their noise; absent without a held contact, and in older memories.
      Shape: 8.
    - following: Modelled position at the last step, how far the model has moved beyond the measured way lately, how
      much the force has risen in that time, and the mean velocities of model and tool, and for how long the model
      has been too far ahead, s; absent in older memories. After a while the modelled position goes on with the
      measured one.
    - force_before_retreat: Force when the tool last moved forward, N or N·m; default 0.
    - lack: Force that has been missing for a contact, added up over time, N·s or N·m·s; default 0. Above a bound
      the contact is lost.
    - mean_target_force: Mean of the target force; default 0.
    - measured: What the measured positions of the tool show; absent before the first period, and in older memories:
      then a motion of the surface is noticed from the next touch on.
    - normal: What is known of the normal of the surface; absent for a law without `surface`, and before the first
      period.
    - reading_change: Rms change of the readings before that, N or N·m; default 0: the reading has shown no noise.
    - reading_step: Smallest change of the reading so far, N or N·m; default 0: there was none.
    - unchanged: The reading that does not change, the position where it was read first, and the time since then, s;
      default zeros.
    """

    before_retreat: float
    """Sensed position when the tool last moved forward."""
    contact_time_s: float
    """Time in contact since the last touch, of suspicion before it, or of a loss, s."""
    fault_position: float
    """Position at the fault."""
    force: float
    """Force of the last state."""
    hold_time_s: float
    """Time for which the force is near its target, s, up to the time after which the contact is held."""
    is_above: bool
    """Whether the force is above its target."""
    means: Vector
    """Running means of sensed position and force. Shape: 2."""
    position: float
    """Modelled position of the tool since the first step."""
    return_speed: float
    """Largest speed of the way back to a lost surface, m/s or rad/s."""
    sensed_position: float
    """The same as the force sensor sees it."""
    spent_j: float
    """Energy that the surface got, less what its motion may cost, J."""
    state: ContactState
    """State of the contact."""
    stiffness: Vector
    """Upper bound, slope and uncertainty of the stiffness, N/m or N·m/rad. Shape: 3."""
    sums: Vector
    """Sums of the squared position, position times force, the squared force, and the number of samples. Shape: 4."""
    surface: float
    """Position of the surface."""
    surface_motion: Vector
    """Place of the surface as it is followed, the stiffness of that place, and the velocity of the surface that is fed
    forward. Only the velocity is read back. Shape: 3."""
    swing: Vector
    """Factor of the upper bound, and the largest difference from the target force since the force last crossed it and
    before. Shape: 3."""
    fault: ContactFault | None = None
    """Why the contact is given up; only in the state `fault`."""
    followed: Vector | None = None
    """Position and force as they are followed while the contact is held, their rates, what was not foreseen of them in
    the last period, and their noise; absent without a held contact, and in older memories. Shape: 8."""
    following: Vector | None = None
    """Modelled position at the last step, how far the model has moved beyond the measured way lately, how much the
    force has risen in that time, and the mean velocities of model and tool, and for how long the model has been too far
    ahead, s; absent in older memories. After a while the modelled position goes on with the measured one."""
    force_before_retreat: float | None = None
    """Force when the tool last moved forward, N or N·m; default 0."""
    lack: float | None = None
    """Force that has been missing for a contact, added up over time, N·s or N·m·s; default 0. Above a bound the contact
    is lost."""
    mean_target_force: float | None = None
    """Mean of the target force; default 0."""
    measured: MeasuredContact | None = None
    """What the measured positions of the tool show; absent before the first period, and in older memories: then a
    motion of the surface is noticed from the next touch on."""
    normal: NormalMemory | None = None
    """What is known of the normal of the surface; absent for a law without `surface`, and before the first period."""
    reading_change: float | None = None
    """Rms change of the readings before that, N or N·m; default 0: the reading has shown no noise."""
    reading_step: float | None = None
    """Smallest change of the reading so far, N or N·m; default 0: there was none."""
    unchanged: Vector | None = None
    """The reading that does not change, the position where it was read first, and the time since then, s; default
    zeros."""


class VelocityLaw(Tagged):
    """A given velocity ẋ.

    Fields:

    - kind: Selects the variant.
    - target_velocity: Task velocity ẋ, m/s and rad/s.
    """

    kind: Literal["velocity"] = "velocity"
    """Selects the variant."""
    target_velocity: Profile
    """Task velocity ẋ, m/s and rad/s."""


MotionPath = Literal["joint", "straight"]
"""The path on which the arm moves to a target that jumps, for a law that looks ahead. All tasks of a controller,
except bounds, have the same path. Each joint then moves as fast as its limits of velocity and acceleration permit,
whatever `gain` is."""

TargetPose = Literal["initial"] | Pose
"""Target pose, from which displacements are measured: `initial` (the pose at the first step), or a pose of the
reference point (m, unit quaternion), in the task's `frame` if that is a pose, otherwise in the base frame."""


class PoseLaw(Tagged):
    """Motion to a pose: ẋ = ẋ_d + f K (x_d − x). f is 1 near the target, and smaller where the joints could not
    brake.

    Fields:

    - gain: Gain K, 1/s: within 1/K seconds the distance to the target decreases to 37 %. 1 to 5 suits most arms.
    - kind: Selects the variant.
    - braking: Whether the law brakes before its target; `false`: the bare gain, which may pass the target; default
      `true`.
    - max_acceleration: Maximum acceleration with which the law brakes, m/s² and rad/s², in addition to the limits
      of the joints. Set it for a gentler stop; default: those limits alone.
    - path: Path on which the law looks ahead, for targets that move fast or jump far; default: the law does not
      look ahead.
    - target_displacement: Displacement added to X_d over time, m and rad (rotation vector), along the axes of the
      task's frame. Set it for a path that is known in advance; default: none.
    - target_pose: Target pose X_d. Set it to move the tool there; default `initial`, which holds the pose of the
      first step.
    """

    gain: ArrayLike
    """Gain K, 1/s: within 1/K seconds the distance to the target decreases to 37 %. 1 to 5 suits most arms."""
    kind: Literal["pose"] = "pose"
    """Selects the variant."""
    braking: bool | None = None
    """Whether the law brakes before its target; `false`: the bare gain, which may pass the target; default `true`."""
    max_acceleration: ArrayLike | None = None
    """Maximum acceleration with which the law brakes, m/s² and rad/s², in addition to the limits of the joints. Set it
    for a gentler stop; default: those limits alone."""
    path: MotionPath | None = None
    """Path on which the law looks ahead, for targets that move fast or jump far; default: the law does not look
    ahead."""
    target_displacement: Profile | None = None
    """Displacement added to X_d over time, m and rad (rotation vector), along the axes of the task's frame. Set it for
    a path that is known in advance; default: none."""
    target_pose: TargetPose | None = None
    """Target pose X_d. Set it to move the tool there; default `initial`, which holds the pose of the first step."""


if TYPE_CHECKING:
    PostureTarget = Literal["mid_range"] | Profile | AnyArrayLike
else:
    PostureTarget = Annotated[Literal["mid_range"] | Profile, BeforeValidator(constant)]
"""Target of the joints of a posture: `mid_range` (the middle of their ranges), or positions over time, one per
joint, rad or m. An array is a constant."""


class PostureLaw(Tagged):
    """Motion of joints to positions, q̇ = q̇_d + f K (q_d − q), or to the middle of their ranges, q̇ = −f K ∇H. f is 1
    near the target, and smaller where the joint could not brake.

    Fields:

    - gain: Gain K, one for all joints or one per joint, 1/s: within 1/K seconds the distance decreases to 37 %. For
      `mid_range` rad²/s or m²/s.
    - kind: Selects the variant.
    - target_position: Target positions q_d, rad or m, or `mid_range`.
    - braking: Whether the law brakes before its target; `false`: the bare gain, which may pass the target; default
      `true`.
    - joints: Names of the joints that the task moves; default: all joints, for `mid_range` all joints with a range.
    - max_acceleration: Maximum acceleration with which the law brakes, rad/s² or m/s², in addition to the limits of
      the joints. Set it for a gentler stop; default: those limits alone.
    - path: Path on which the law looks ahead, for targets that move fast or jump far; default: the law does not
      look ahead.
    """

    gain: ArrayLike
    """Gain K, one for all joints or one per joint, 1/s: within 1/K seconds the distance decreases to 37 %. For
    `mid_range` rad²/s or m²/s."""
    kind: Literal["posture"] = "posture"
    """Selects the variant."""
    target_position: PostureTarget
    """Target positions q_d, rad or m, or `mid_range`."""
    braking: bool | None = None
    """Whether the law brakes before its target; `false`: the bare gain, which may pass the target; default `true`."""
    joints: OneOrMore[str] | None = None
    """Names of the joints that the task moves; default: all joints, for `mid_range` all joints with a range."""
    max_acceleration: ArrayLike | None = None
    """Maximum acceleration with which the law brakes, rad/s² or m/s², in addition to the limits of the joints. Set it
    for a gentler stop; default: those limits alone."""
    path: MotionPath | None = None
    """Path on which the law looks ahead, for targets that move fast or jump far; default: the law does not look
    ahead."""


class LookAtLaw(Tagged):
    """Turning a direction of the tool, or of a link, towards a point, as a camera looks at a part: two rows, which
    reduce the angle at the rate f K. The task has no `axes`; its `link` looks from its `reference_point`.

    Fields:

    - gain: Gain K, 1/s: within 1/K seconds the angle decreases to 37 %. 1 to 5 suits most arms.
    - kind: Selects the variant.
    - target_point: The point p over time, m, in the base frame or in that of `relative_to`.
    - braking: Whether the law brakes before its target; `false`: the bare gain, which may pass the target; default
      `true`.
    - direction: The direction that looks, in the frame of the tool or of the link, of any length but zero; default:
      z.
    - max_acceleration: Maximum acceleration with which the law brakes, rad/s², in addition to the limits of the
      joints; default: those limits alone.
    """

    gain: float
    """Gain K, 1/s: within 1/K seconds the angle decreases to 37 %. 1 to 5 suits most arms."""
    kind: Literal["look_at"] = "look_at"
    """Selects the variant."""
    target_point: Profile
    """The point p over time, m, in the base frame or in that of `relative_to`."""
    braking: bool | None = None
    """Whether the law brakes before its target; `false`: the bare gain, which may pass the target; default `true`."""
    direction: Vector | None = None
    """The direction that looks, in the frame of the tool or of the link, of any length but zero; default: z."""
    max_acceleration: float | None = None
    """Maximum acceleration with which the law brakes, rad/s², in addition to the limits of the joints; default: those
    limits alone."""


class SurfaceFollowing(Body):
    """How the tasks in a frame follow the normal of a surface. It is learnt while the tool slides, from its motion and
    its force together.

    Fields:

    - max_tilt_rad: Largest angle between the normal and the stated axis, rad, up to 1.4; default π/4. Beyond it the
      axes stay there, and the answer says so.
    """

    max_tilt_rad: float | None = None
    """Largest angle between the normal and the stated axis, rad, up to 1.4; default π/4. Beyond it the axes stay there,
    and the answer says so."""


class ContactLaw(Tagged):
    """Pressing on a surface of unknown stiffness. The tool approaches the surface, presses with the target force and
    follows the surface. It needs no gains: the recommended law for contacts. Each axis of the task presses by
    itself.

    Fields:

    - kind: Selects the variant.
    - target_force: Target force F_d, N and N·m, along the axes of the task. Its sign is the direction in which the
      tool presses. A target below five times the noise is raised to it.
    - approach_speed: Speed at which the tool approaches the surface, and largest speed at which it presses, m/s and
      rad/s. A faster approach costs the peak force that the answer names; default: the largest that keeps the peak
      below 1.2 times the target force in the stiffest contact.
    - bias: Largest error of the measured force that stays, such as a bias after taring, N and N·m. Forces up to
      this error are no contact; at most 100 N and 10 N·m; default 0.
    - max_acceleration: Largest acceleration along the axis, m/s² and rad/s². The joints may permit less; default 5
      m/s² and 50 rad/s².
    - max_force: Force above which the tool retreats and stays away, N and N·m. The retreat comes before all other
      tasks, and after the limits of the joints. In an approach, the force that no axis of a contact presses counts
      too. Default: none.
    - noise: Noise of the measured force, rms, N and N·m; at most 10 N and 1 N·m; default 0.2 N and 0.02 N·m.
    - retreat_speed: Largest speed at which the tool retreats, m/s and rad/s; default 0.25 m/s and 2.5 rad/s.
    - sensor_lag_s: Time constant of the filter of the force sensor, s; at most 1; default 0.002.
    - stiffest: Stiffness of the stiffest contact that may come, N/m and N·m/rad, of tool, sensor, arm and surface
      in a row. Set it to approach faster; a contact that is stiffer may bounce; default 1e6 N/m and 1e4 N·m/rad.
    - surface: Follows the normal of a surface whose direction is not known: all tasks in the `frame` of this one
      move along and across the surface instead of along the stated axes. The task has one axis, x, y or z; default:
      the axes stay as they are stated.
    """

    kind: Literal["contact"] = "contact"
    """Selects the variant."""
    target_force: Profile
    """Target force F_d, N and N·m, along the axes of the task. Its sign is the direction in which the tool presses. A
    target below five times the noise is raised to it."""
    approach_speed: ArrayLike | None = None
    """Speed at which the tool approaches the surface, and largest speed at which it presses, m/s and rad/s. A faster
    approach costs the peak force that the answer names; default: the largest that keeps the peak below 1.2 times the
    target force in the stiffest contact."""
    bias: ArrayLike | None = None
    """Largest error of the measured force that stays, such as a bias after taring, N and N·m. Forces up to this error
    are no contact; at most 100 N and 10 N·m; default 0."""
    max_acceleration: ArrayLike | None = None
    """Largest acceleration along the axis, m/s² and rad/s². The joints may permit less; default 5 m/s² and 50
    rad/s²."""
    max_force: ArrayLike | None = None
    """Force above which the tool retreats and stays away, N and N·m. The retreat comes before all other tasks, and
    after the limits of the joints. In an approach, the force that no axis of a contact presses counts too. Default:
    none."""
    noise: ArrayLike | None = None
    """Noise of the measured force, rms, N and N·m; at most 10 N and 1 N·m; default 0.2 N and 0.02 N·m."""
    retreat_speed: ArrayLike | None = None
    """Largest speed at which the tool retreats, m/s and rad/s; default 0.25 m/s and 2.5 rad/s."""
    sensor_lag_s: float | None = None
    """Time constant of the filter of the force sensor, s; at most 1; default 0.002."""
    stiffest: ArrayLike | None = None
    """Stiffness of the stiffest contact that may come, N/m and N·m/rad, of tool, sensor, arm and surface in a row. Set
    it to approach faster; a contact that is stiffer may bounce; default 1e6 N/m and 1e4 N·m/rad."""
    surface: SurfaceFollowing | None = None
    """Follows the normal of a surface whose direction is not known: all tasks in the `frame` of this one move along and
    across the surface instead of along the stated axes. The task has one axis, x, y or z; default: the axes stay as
    they are stated."""


class ForceLaw(Tagged):
    """Force control: M_d Ẍ + B_d Ẋ = F_d − F_e.

    Fields:

    - damping: Damping B_d, N·s/m and N·m·s/rad. A larger one is slower and more stable; a free axis moves at
      F_d/B_d. `POST /v1/stability` computes the minimum.
    - inertia: Inertia M_d, kg and kg·m². The velocity follows a change of force within some M_d/B_d seconds; a
      larger one is more stable.
    - kind: Selects the variant.
    - target_force: Target force F_d, N and N·m, along the axes of the task; positive presses against a surface in
      the positive direction.
    """

    damping: ArrayLike
    """Damping B_d, N·s/m and N·m·s/rad. A larger one is slower and more stable; a free axis moves at F_d/B_d. `POST
    /v1/stability` computes the minimum."""
    inertia: ArrayLike
    """Inertia M_d, kg and kg·m². The velocity follows a change of force within some M_d/B_d seconds; a larger one is
    more stable."""
    kind: Literal["force"] = "force"
    """Selects the variant."""
    target_force: Profile
    """Target force F_d, N and N·m, along the axes of the task; positive presses against a surface in the positive
    direction."""


class ImpedanceLaw(Tagged):
    """Mass, damper and spring about a pose: M_d ΔẌ + B_d ΔẊ + K_d ΔX = −F_e.

    Fields:

    - damping: Damping B_d, N·s/m and N·m·s/rad. A larger one is slower and more stable; a free axis moves at
      F_d/B_d. `POST /v1/stability` computes the minimum.
    - inertia: Inertia M_d, kg and kg·m². The velocity follows a change of force within some M_d/B_d seconds; a
      larger one is more stable.
    - kind: Selects the variant.
    - stiffness: Stiffness K_d, N/m and N·m/rad: a force F moves the tool by F/K_d. Set a small one where contact is
      expected.
    - target_displacement: Displacement added to X_d over time, m and rad (rotation vector), along the axes of the
      task's frame. Set it for a path that is known in advance; default: none.
    - target_pose: Target pose X_d. Set it to move the tool there; default `initial`, which holds the pose of the
      first step.
    """

    damping: ArrayLike
    """Damping B_d, N·s/m and N·m·s/rad. A larger one is slower and more stable; a free axis moves at F_d/B_d. `POST
    /v1/stability` computes the minimum."""
    inertia: ArrayLike
    """Inertia M_d, kg and kg·m². The velocity follows a change of force within some M_d/B_d seconds; a larger one is
    more stable."""
    kind: Literal["impedance"] = "impedance"
    """Selects the variant."""
    stiffness: ArrayLike
    """Stiffness K_d, N/m and N·m/rad: a force F moves the tool by F/K_d. Set a small one where contact is expected."""
    target_displacement: Profile | None = None
    """Displacement added to X_d over time, m and rad (rotation vector), along the axes of the task's frame. Set it for
    a path that is known in advance; default: none."""
    target_pose: TargetPose | None = None
    """Target pose X_d. Set it to move the tool there; default `initial`, which holds the pose of the first step."""


PerAxisBool = bool | list[bool]
"""One value for all axes of the task, or a list with one value per axis."""


class HybridLaw(Tagged):
    """Force control on some axes, impedance on the others.

    Fields:

    - damping: Damping B_d, N·s/m and N·m·s/rad. A larger one is slower and more stable; a free axis moves at
      F_d/B_d. `POST /v1/stability` computes the minimum.
    - inertia: Inertia M_d, kg and kg·m². The velocity follows a change of force within some M_d/B_d seconds; a
      larger one is more stable.
    - kind: Selects the variant.
    - position_controlled: Selection S per axis: `true` position-controlled, `false` force-controlled.
    - stiffness: Stiffness K_d of the position-controlled axes, N/m and N·m/rad; ignored on the others.
    - target_force: Target force F_d of the force-controlled axes, N and N·m; ignored on the others.
    - target_displacement: Displacement added to X_d over time, m and rad (rotation vector), along the axes of the
      task's frame. Set it for a path that is known in advance; default: none.
    - target_pose: Target pose X_d. Set it to move the tool there; default `initial`, which holds the pose of the
      first step.
    """

    damping: ArrayLike
    """Damping B_d, N·s/m and N·m·s/rad. A larger one is slower and more stable; a free axis moves at F_d/B_d. `POST
    /v1/stability` computes the minimum."""
    inertia: ArrayLike
    """Inertia M_d, kg and kg·m². The velocity follows a change of force within some M_d/B_d seconds; a larger one is
    more stable."""
    kind: Literal["hybrid"] = "hybrid"
    """Selects the variant."""
    position_controlled: PerAxisBool
    """Selection S per axis: `true` position-controlled, `false` force-controlled."""
    stiffness: ArrayLike
    """Stiffness K_d of the position-controlled axes, N/m and N·m/rad; ignored on the others."""
    target_force: Profile
    """Target force F_d of the force-controlled axes, N and N·m; ignored on the others."""
    target_displacement: Profile | None = None
    """Displacement added to X_d over time, m and rad (rotation vector), along the axes of the task's frame. Set it for
    a path that is known in advance; default: none."""
    target_pose: TargetPose | None = None
    """Target pose X_d. Set it to move the tool there; default `initial`, which holds the pose of the first step."""


Law = Annotated[
    VelocityLaw | PoseLaw | PostureLaw | LookAtLaw | ContactLaw | ForceLaw | ImpedanceLaw | HybridLaw,
    Field(discriminator="kind"),
]
"""The law that computes the velocity of a task."""


class Streaming(Body):
    """How a task follows streamed targets. The defaults suit 30 to 90 targets per second.  The age of a target is the
    time of the state minus `time_s` of the target minus `delay_s`.

    Fields:

    - brake_after_s: Age of the newest target from which the task brakes to rest, s; at least `hold_after_s`;
      default 0.2.
    - delay_s: Delay with which targets are followed, s; default 0. A delay of one interval between targets makes
      the task interpolate instead of extrapolate.
    - fade_s: Time in which the offset between a new chunk of actions and the motion before it fades, s; default
      0.3; longer if it would need more than half of `max_acceleration`. 0: the task follows the new chunk as fast
      as `max_velocity` and `max_acceleration` allow.
    - hold_after_s: Age of the newest target up to which it is extrapolated, s; after it the target is held; default
      0.05.
    - max_acceleration: Maximum acceleration of the target per row, m/s² and rad/s²; default: 5 m/s² and 10 rad/s²,
      for joints their acceleration limits. The task brakes with it.
    - max_velocity: Maximum velocity of the target per row, m/s and rad/s; default: 1 m/s and 3 rad/s, for joints
      their velocity limits.
    - smoothing_s: Time constant with which the task follows noise and jumps of the targets, s; default 0.03; 0: no
      smoothing. A uniform motion is followed without lag.
    """

    brake_after_s: float | None = None
    """Age of the newest target from which the task brakes to rest, s; at least `hold_after_s`; default 0.2."""
    delay_s: float | None = None
    """Delay with which targets are followed, s; default 0. A delay of one interval between targets makes the task
    interpolate instead of extrapolate."""
    fade_s: float | None = None
    """Time in which the offset between a new chunk of actions and the motion before it fades, s; default 0.3; longer if
    it would need more than half of `max_acceleration`. 0: the task follows the new chunk as fast as `max_velocity` and
    `max_acceleration` allow."""
    hold_after_s: float | None = None
    """Age of the newest target up to which it is extrapolated, s; after it the target is held; default 0.05."""
    max_acceleration: ArrayLike | None = None
    """Maximum acceleration of the target per row, m/s² and rad/s²; default: 5 m/s² and 10 rad/s², for joints their
    acceleration limits. The task brakes with it."""
    max_velocity: ArrayLike | None = None
    """Maximum velocity of the target per row, m/s and rad/s; default: 1 m/s and 3 rad/s, for joints their velocity
    limits."""
    smoothing_s: float | None = None
    """Time constant with which the task follows noise and jumps of the targets, s; default 0.03; 0: no smoothing. A
    uniform motion is followed without lag."""


class ControllerTask(Body):
    """One task of a controller: its rows, and their law or bounds of their velocity.

    Fields:

    - name: Name, unique in the controller. Answers and targets name the task by it.
    - axes: Axes of the tool that the task moves, one per row; list only those that matter, so that lower tasks keep
      the others. Required by every law except `posture` if there is no `jacobian`.
    - frame: Axes along which rows, displacements and wrench are measured. Set `tool` for motions relative to the
      tool, or a pose for a surface; default `base`.
    - jacobian: Constant task Jacobian J_k, m × n, row by row, in joint order. Set it for rows that no axis gives,
      such as a sum of joints; instead of `axes`, with the law `velocity` or bounds.
    - law: Law that computes the velocity of the task: motion to a target, or contact with a force. Instead of
      `lower` and `upper`.
    - link: Tip or link that the axes belong to, by its name, in place of the tool. Set it for a second arm, an
      elbow or a camera; only with `axes`; default: the first tip, which is the tool.
    - lower: Lower bounds of the task velocity J_k q̇, one entry per row, m/s and rad/s. Set bounds instead of `law`
      if the task only limits a motion; `null`: no bound; default: none.
    - reference_point: Reference point of rows, pose and wrench: x, y, z in the tool frame, m. Set it if this task
      moves another point than the others; default: the tool point. Shape: 3.
    - relative_to: Tip or link from which the motion is seen, by its name, in place of the base: poses, velocities
      and the frame `base` are then those of its frame. Set it for two hands that hold one part; only with `axes`;
      default: the base.
    - scale: Whether limits slow the task down in its direction, J_k q̇ = s ẋ_k with the largest s ≤ 1. Set it for
      paths that must keep their shape; only with `law`; default `false`.
    - streaming: How the task follows the `targets` of the states. Set it for a source of targets that is slower
      than 30 Hz, noisy or late; default: the defaults of its fields.
    - upper: Upper bounds of the task velocity J_k q̇, as `lower`.
    """

    name: str
    """Name, unique in the controller. Answers and targets name the task by it."""
    axes: OneOrMore[Axis] | None = None
    """Axes of the tool that the task moves, one per row; list only those that matter, so that lower tasks keep the
    others. Required by every law except `posture` if there is no `jacobian`."""
    frame: Frame | None = None
    """Axes along which rows, displacements and wrench are measured. Set `tool` for motions relative to the tool, or a
    pose for a surface; default `base`."""
    jacobian: Matrix | None = None
    """Constant task Jacobian J_k, m × n, row by row, in joint order. Set it for rows that no axis gives, such as a sum
    of joints; instead of `axes`, with the law `velocity` or bounds."""
    law: Law | None = None
    """Law that computes the velocity of the task: motion to a target, or contact with a force. Instead of `lower` and
    `upper`."""
    link: str | None = None
    """Tip or link that the axes belong to, by its name, in place of the tool. Set it for a second arm, an elbow or a
    camera; only with `axes`; default: the first tip, which is the tool."""
    lower: LowerBounds | None = None
    """Lower bounds of the task velocity J_k q̇, one entry per row, m/s and rad/s. Set bounds instead of `law` if the
    task only limits a motion; `null`: no bound; default: none."""
    reference_point: Vector | None = None
    """Reference point of rows, pose and wrench: x, y, z in the tool frame, m. Set it if this task moves another point
    than the others; default: the tool point. Shape: 3."""
    relative_to: str | None = None
    """Tip or link from which the motion is seen, by its name, in place of the base: poses, velocities and the frame
    `base` are then those of its frame. Set it for two hands that hold one part; only with `axes`; default: the base."""
    scale: bool | None = None
    """Whether limits slow the task down in its direction, J_k q̇ = s ẋ_k with the largest s ≤ 1. Set it for paths that
    must keep their shape; only with `law`; default `false`."""
    streaming: Streaming | None = None
    """How the task follows the `targets` of the states. Set it for a source of targets that is slower than 30 Hz, noisy
    or late; default: the defaults of its fields."""
    upper: UpperBounds | None = None
    """Upper bounds of the task velocity J_k q̇, as `lower`."""


class JointDrive(Body):
    """How the joints follow a command: after a dead time, with a first-order lag. Limits hold behind it. Give values
    that are too large rather than too small: the arm then brakes a little early.

    Fields:

    - delay_periods: Dead time D from the measurement of a state to the motion that its answer causes, whole
      periods. Count sensor, network and drive; default 2.
    - lag_s: Time constant L of the lag, s: after a step of the command, the joint has 63 % of the velocity at that
      time. Default 0.03.
    """

    delay_periods: int | None = None
    """Dead time D from the measurement of a state to the motion that its answer causes, whole periods. Count sensor,
    network and drive; default 2."""
    lag_s: float | None = None
    """Time constant L of the lag, s: after a step of the command, the joint has 63 % of the velocity at that time.
    Default 0.03."""


class EnvironmentAxis(Body):
    """The environment on one axis, F_e = M_e Ẍ + B_e Ẋ + K_e X.

    Fields:

    - stiffness: Stiffness K_e, N/m or N·m/rad.
    - damping: Damping B_e, N·s/m or N·m·s/rad; default 0.
    - inertia: Inertia M_e, kg or kg·m²; default 0.
    """

    stiffness: float
    """Stiffness K_e, N/m or N·m/rad."""
    damping: float | None = None
    """Damping B_e, N·s/m or N·m·s/rad; default 0."""
    inertia: float | None = None
    """Inertia M_e, kg or kg·m²; default 0."""


class Environment(Body):
    """The environment of the tool and the response of the arm, as far as known. It causes warnings of unstable loops
    and changes no command.

    Fields:

    - delay_periods: Delay of a command, control periods: from the measurement to the motion that its answer causes.
      Default 0. A larger `delay_periods` of the controller's `drive` counts, unless that is the default one.
    - lag_s: Lag τ of the arm's velocity loop, s. Take a measured one; 0 is an ideal arm. Default 0. A larger
      `lag_s` of the controller's `drive` counts, unless that is the default one.
    - rx: Environment about x of the base; default: none.
    - ry: Environment about y of the base; default: none.
    - rz: Environment about z of the base; default: none.
    - velocity_measured: Whether states contain the measured joint velocity; otherwise the last command replaces it.
      Default `true`.
    - x: Environment along x of the base; default: none.
    - y: Environment along y of the base; default: none.
    - z: Environment along z of the base; default: none.
    """

    delay_periods: int | None = None
    """Delay of a command, control periods: from the measurement to the motion that its answer causes. Default 0. A
    larger `delay_periods` of the controller's `drive` counts, unless that is the default one."""
    lag_s: float | None = None
    """Lag τ of the arm's velocity loop, s. Take a measured one; 0 is an ideal arm. Default 0. A larger `lag_s` of the
    controller's `drive` counts, unless that is the default one."""
    rx: EnvironmentAxis | None = None
    """Environment about x of the base; default: none."""
    ry: EnvironmentAxis | None = None
    """Environment about y of the base; default: none."""
    rz: EnvironmentAxis | None = None
    """Environment about z of the base; default: none."""
    velocity_measured: bool | None = None
    """Whether states contain the measured joint velocity; otherwise the last command replaces it. Default `true`."""
    x: EnvironmentAxis | None = None
    """Environment along x of the base; default: none."""
    y: EnvironmentAxis | None = None
    """Environment along y of the base; default: none."""
    z: EnvironmentAxis | None = None
    """Environment along z of the base; default: none."""


class StateChecks(Body):
    """Bounds of a plausible state. A state beyond a bound is refused with 422; a larger bound allows it.

    Fields:

    - max_force_n: Maximum magnitude of each entry of the measured force, N; default: no bound, and a warning above
      10 000.
    - max_torque_nm: Maximum magnitude of each entry of the measured torque, N·m; default: no bound, and a warning
      above 10 000.
    - position_tolerance: Maximum distance of a measured joint position outside the joint's range, rad or m; default
      0.1. It applies if `limits` include positions and `solver` is not `closed_form`.
    """

    max_force_n: float | None = None
    """Maximum magnitude of each entry of the measured force, N; default: no bound, and a warning above 10 000."""
    max_torque_nm: float | None = None
    """Maximum magnitude of each entry of the measured torque, N·m; default: no bound, and a warning above 10 000."""
    position_tolerance: float | None = None
    """Maximum distance of a measured joint position outside the joint's range, rad or m; default 0.1. It applies if
    `limits` include positions and `solver` is not `closed_form`."""


WrenchConvention = Literal["on_environment", "on_tool"]
"""The sign convention of a wrench: who exerts it on whom."""

WrenchFrame = Literal["base", "tool"]
"""The axes of the wrench in a state."""


class Wrench(Body):
    """Force and torque at the tool point, or at another tip, along the axes of the controller's `wrench_frame`.

    Fields:

    - force: Force x, y, z, N. Shape: 3.
    - torque: Torque x, y, z, N·m. Shape: 3.
    """

    force: Vector
    """Force x, y, z, N. Shape: 3."""
    torque: Vector
    """Torque x, y, z, N·m. Shape: 3."""


class Payload(Body):
    """Mass and centre of mass of what a sensor carries.

    Fields:

    - mass_kg: Mass, kg.
    - center_of_mass: Centre of mass x, y, z from the origin of the sensor, along its axes, m; default: the origin.
      Shape: 3.
    """

    mass_kg: float
    """Mass, kg."""
    center_of_mass: Vector | None = None
    """Centre of mass x, y, z from the origin of the sensor, along its axes, m; default: the origin. Shape: 3."""


class WrenchSensor(Body):
    """A force and torque sensor, and what the controller corrects in its readings. The wrench of a state then is the
    raw reading, about the origin of the sensor, along the axes of the sensor (`"wrench_frame": "tool"`) or of the base.
    In this order: the bias is subtracted; the sign becomes that of `wrench_convention`; weight and inertia of the
    payload are subtracted; low-pass; deadband; the wrench is moved to the tip. Answers have the result in `wrench`.

    Fields:

    - bias: Reading without contact and without payload, along the axes of the sensor, as `POST
      /v1/controllers/{id}/tare` or `POST /v1/payload` finds it; default 0.
    - compensate_inertia: Whether the inertia of the payload is subtracted, with the acceleration of the commands
      behind `drive`. Set it for heavy tools, whose acceleration would look like a contact; default `false`.
    - deadband_n: Forces that are shorter count as zero, N; default 0.
    - deadband_nm: Torques that are shorter count as zero, N·m; default 0.
    - filter_time_s: Time constant of a first-order low-pass, s. The law `contact` counts its lag. Set it only for a
      noisy sensor: it costs speed. At most 1; default 0, none.
    - gravity: Acceleration of gravity along the axes of the base, m/s². Set it for an arm on a wall or a ceiling;
      default [0, 0, -9.81]. Shape: 3.
    - payload: What the sensor carries: all that moves with the tool; default: nothing.
    - pose: Pose of the sensor in the robot's own tool frame, as `tool_offset`, or in the frame of the tip, m.
      Default: the tool point.
    """

    bias: Wrench | None = None
    """Reading without contact and without payload, along the axes of the sensor, as `POST /v1/controllers/{id}/tare` or
    `POST /v1/payload` finds it; default 0."""
    compensate_inertia: bool | None = None
    """Whether the inertia of the payload is subtracted, with the acceleration of the commands behind `drive`. Set it
    for heavy tools, whose acceleration would look like a contact; default `false`."""
    deadband_n: float | None = None
    """Forces that are shorter count as zero, N; default 0."""
    deadband_nm: float | None = None
    """Torques that are shorter count as zero, N·m; default 0."""
    filter_time_s: float | None = None
    """Time constant of a first-order low-pass, s. The law `contact` counts its lag. Set it only for a noisy sensor: it
    costs speed. At most 1; default 0, none."""
    gravity: Vector | None = None
    """Acceleration of gravity along the axes of the base, m/s². Set it for an arm on a wall or a ceiling; default [0,
    0, -9.81]. Shape: 3."""
    payload: Payload | None = None
    """What the sensor carries: all that moves with the tool; default: nothing."""
    pose: Pose | None = None
    """Pose of the sensor in the robot's own tool frame, as `tool_offset`, or in the frame of the tip, m. Default: the
    tool point."""


class ControllerConfig(Body):
    """A controller: robot, tasks with their laws, method, solver, limits and control period.

    Fields:

    - period_s: Control period T, s: the time from one state to the next, as your loop keeps it.
    - robot: Name of the robot, from `GET /v1/robots`.
    - tasks: The tasks, highest priority first: put first what must not give way, such as contact or safety.
    - anti_windup: When integrators of laws follow the achieved velocity. Set another value only to reproduce the
      paper; default `always`.
    - channels: Channels besides the joints, such as a gripper, at most 16; default: none.
    - characteristic_length_m: Characteristic length L, m: 1 m/s of the tool counts as 1/L rad/s in singular values,
      in damping, and where the rows of a task are weighed against each other. Set it to the reach of an arm that is
      much smaller or larger than 1 m; default 1.
    - collisions: Shapes that the links keep clear of. It needs a robot with shapes; default: none.
    - damping: Damping near singularities, which trades accuracy for lower joint speeds; `null`: no damping, for
      simulations. Default: threshold 0.15, max_factor 0.15.
    - drive: How the joints follow a command. Set it if you have measured your arm, so that it brakes in time;
      default: a lag of 0.03 s and a delay of 2 periods.
    - environment: Environment that the tool touches, as far as known. Set it before a first contact: `POST
      /v1/controllers` then warns of unstable axes. Default: unknown.
    - inequalities: Inequalities on the joint velocities besides the limits: set them to keep the arm behind planes,
      or to couple joints; default: none.
    - leave_local_minima: Whether the arm leaves a posture in which the end of a joint's range holds a `pose` task
      back: the joints move towards the middle of their ranges for 4 s, up to three times. Tasks above it are not
      disturbed. Only if the arm has more joints than its tasks have rows, no task moves single joints, and no task
      has the law `force`, `impedance` or `hybrid`; default `true`.
    - limits: Limits of the joint velocities. Keep the default on an arm; give `lower` and `upper` to move it more
      slowly. Default `position_velocity_acceleration`.
    - method: Resolution method, the meaning of priorities. Set another one only to compare; default
      `strict_reverse_priority`.
    - null_space_velocity: Null-space velocity ζ̇, which the answer follows as far as the tasks permit. Set it to
      choose the posture of a redundant arm; default: `initial_posture` with the gain 2 (less for slow drives) if
      the arm has more joints than its tasks have rows, all tasks have the law `pose` or bounds, and none moves
      single joints; otherwise `rest`.
    - solver: Solver of each period's problem. Keep the default on an arm: `qp` is a second, slower solver to
      compare with, and `closed_form` ignores limits. Default `auto`.
    - state_checks: Bounds of a plausible state, beyond which it is refused. Set the largest force and torque that
      your task needs; default: those of `StateChecks`.
    - tool_offset: Pose of the tool point and axes in the robot's own tool frame, m. Set it to the point that works,
      such as the tip of a gripper; default: that frame itself.
    - valid_for_ms: Maximum validity of an answer, ms. Set it to a few periods of your loop: your watchdog brakes
      after it, and before the next answer comes if it is shorter than a period. Default 100.
    - why: Whether every answer has `why`, sentences that say what restricts it. Set it while you tune or look for a
      fault; it makes answers longer. Default `false`.
    - wrench_convention: Sign of the wrench in the states: who exerts it on whom. Set `on_tool` for a wrist sensor
      that measures the force on the tool; a wrong sign makes contacts unstable. Default `on_environment`.
    - wrench_frame: Axes of the wrench in the states. Set `tool` for a sensor that turns with the tool; default
      `base`.
    - wrench_sensor: Sensor of the wrench, and what is corrected in its readings: bias, payload, place, noise. Set
      it for a wrist sensor; default: the wrench of a state is that at the tool point, without the weight of the
      tool.
    - wrench_sensors: Sensors of tips other than the tool, by the name of the tip; default: none.
    """

    period_s: float
    """Control period T, s: the time from one state to the next, as your loop keeps it."""
    robot: str
    """Name of the robot, from `GET /v1/robots`."""
    tasks: list[ControllerTask]
    """The tasks, highest priority first: put first what must not give way, such as contact or safety."""
    anti_windup: AntiWindup | None = None
    """When integrators of laws follow the achieved velocity. Set another value only to reproduce the paper; default
    `always`."""
    channels: list[Channel] | None = None
    """Channels besides the joints, such as a gripper, at most 16; default: none."""
    characteristic_length_m: float | None = None
    """Characteristic length L, m: 1 m/s of the tool counts as 1/L rad/s in singular values, in damping, and where the
    rows of a task are weighed against each other. Set it to the reach of an arm that is much smaller or larger than 1
    m; default 1."""
    collisions: Collisions | None = None
    """Shapes that the links keep clear of. It needs a robot with shapes; default: none."""
    damping: Damping | None = None
    """Damping near singularities, which trades accuracy for lower joint speeds; `null`: no damping, for simulations.
    Default: threshold 0.15, max_factor 0.15."""
    drive: JointDrive | None = None
    """How the joints follow a command. Set it if you have measured your arm, so that it brakes in time; default: a lag
    of 0.03 s and a delay of 2 periods."""
    environment: Environment | None = None
    """Environment that the tool touches, as far as known. Set it before a first contact: `POST /v1/controllers` then
    warns of unstable axes. Default: unknown."""
    inequalities: list[Inequality] | None = None
    """Inequalities on the joint velocities besides the limits: set them to keep the arm behind planes, or to couple
    joints; default: none."""
    leave_local_minima: bool | None = None
    """Whether the arm leaves a posture in which the end of a joint's range holds a `pose` task back: the joints move
    towards the middle of their ranges for 4 s, up to three times. Tasks above it are not disturbed. Only if the arm has
    more joints than its tasks have rows, no task moves single joints, and no task has the law `force`, `impedance` or
    `hybrid`; default `true`."""
    limits: Limits | None = None
    """Limits of the joint velocities. Keep the default on an arm; give `lower` and `upper` to move it more slowly.
    Default `position_velocity_acceleration`."""
    method: Method | None = None
    """Resolution method, the meaning of priorities. Set another one only to compare; default
    `strict_reverse_priority`."""
    null_space_velocity: NullSpaceVelocity | None = None
    """Null-space velocity ζ̇, which the answer follows as far as the tasks permit. Set it to choose the posture of a
    redundant arm; default: `initial_posture` with the gain 2 (less for slow drives) if the arm has more joints than its
    tasks have rows, all tasks have the law `pose` or bounds, and none moves single joints; otherwise `rest`."""
    solver: Solver | None = None
    """Solver of each period's problem. Keep the default on an arm: `qp` is a second, slower solver to compare with, and
    `closed_form` ignores limits. Default `auto`."""
    state_checks: StateChecks | None = None
    """Bounds of a plausible state, beyond which it is refused. Set the largest force and torque that your task needs;
    default: those of `StateChecks`."""
    tool_offset: Pose | None = None
    """Pose of the tool point and axes in the robot's own tool frame, m. Set it to the point that works, such as the tip
    of a gripper; default: that frame itself."""
    valid_for_ms: int | None = None
    """Maximum validity of an answer, ms. Set it to a few periods of your loop: your watchdog brakes after it, and
    before the next answer comes if it is shorter than a period. Default 100."""
    why: bool | None = None
    """Whether every answer has `why`, sentences that say what restricts it. Set it while you tune or look for a fault;
    it makes answers longer. Default `false`."""
    wrench_convention: WrenchConvention | None = None
    """Sign of the wrench in the states: who exerts it on whom. Set `on_tool` for a wrist sensor that measures the force
    on the tool; a wrong sign makes contacts unstable. Default `on_environment`."""
    wrench_frame: WrenchFrame | None = None
    """Axes of the wrench in the states. Set `tool` for a sensor that turns with the tool; default `base`."""
    wrench_sensor: WrenchSensor | None = None
    """Sensor of the wrench, and what is corrected in its readings: bias, payload, place, noise. Set it for a wrist
    sensor; default: the wrench of a state is that at the tool point, without the weight of the tool."""
    wrench_sensors: dict[str, WrenchSensor] | None = None
    """Sensors of tips other than the tool, by the name of the tip; default: none."""


class CreatedController(Answer):
    """Answer to `POST /v1/controllers`.

    Fields:

    - id: Identifier of the session, part of its address.
    - idle_timeout_s: Time without a new state after which the session ends, s; `GET` requests do not extend it.
    - joints: Names of the joints, in the order of all vectors of joints.
    - warnings: Warnings: axes whose loop with the given environment is unstable, and tasks whose law is unstable
      without contact, behind the drive of the controller, with what would make them stable; tasks whose gain is
      above the ratio of the acceleration and speed limits of a joint.
    """

    id: str
    """Identifier of the session, part of its address."""
    idle_timeout_s: int
    """Time without a new state after which the session ends, s; `GET` requests do not extend it."""
    joints: list[str]
    """Names of the joints, in the order of all vectors of joints."""
    warnings: list[str] = Field(default_factory=list)
    """Warnings: axes whose loop with the given environment is unstable, and tasks whose law is unstable without
    contact, behind the drive of the controller, with what would make them stable; tasks whose gain is above the ratio
    of the acceleration and speed limits of a joint."""


class DenavitHartenberg(Answer):
    """A Denavit-Hartenberg row, Rot_z(θ) Trans_z(d) Trans_x(a) Rot_x(α); the joint position adds to θ (revolute) or d
    (prismatic).

    Fields:

    - a_m: Length a along x, m.
    - alpha_rad: Twist α about x, rad.
    - d_m: Offset d along z, m.
    - theta_rad: Angle θ at joint position zero, rad.
    """

    a_m: float
    """Length a along x, m."""
    alpha_rad: float
    """Twist α about x, rad."""
    d_m: float
    """Offset d along z, m."""
    theta_rad: float
    """Angle θ at joint position zero, rad."""


class DriveState(Body):
    """The commands that the drive still has to follow, in the memory of a controller.

    Fields:

    - pending: Commands of the last `delay_periods` periods, the oldest first, rad/s or m/s.
    - velocity: Velocity of the joints behind the lag, rad/s or m/s.
    """

    pending: list[Vector]
    """Commands of the last `delay_periods` periods, the oldest first, rad/s or m/s."""
    velocity: Vector
    """Velocity of the joints behind the lag, rad/s or m/s."""


class Outage(Body):
    """A time in which the service does not run.

    Fields:

    - duration_s: Duration, s.
    - start_s: Start, s; above zero.
    """

    duration_s: float
    """Duration, s."""
    start_s: float
    """Start, s; above zero."""


class Faults(Body):
    """Faults of the connection between arm and service; none by default. The first answer always arrives.

    Fields:

    - dropped: Share of the answers that are lost, 0 to 1.
    - late: Share of the answers that are late. A late answer delays all later answers; they arrive together after
      `late_periods`.
    - late_periods: Delay of a late answer, periods.
    - outages: Times at which the service does not run.
    - reordered: Share of the answers that arrive one period late, after the next answer.
    - repeated: Share of the answers that arrive a second time one period later.
    """

    dropped: float | None = None
    """Share of the answers that are lost, 0 to 1."""
    late: float | None = None
    """Share of the answers that are late. A late answer delays all later answers; they arrive together after
    `late_periods`."""
    late_periods: int | None = None
    """Delay of a late answer, periods."""
    outages: list[Outage] | None = None
    """Times at which the service does not run."""
    reordered: float | None = None
    """Share of the answers that arrive one period late, after the next answer."""
    repeated: float | None = None
    """Share of the answers that arrive a second time one period later."""


class FramePose(Body):
    """A pose with a rotation matrix, which keeps every bit when it is written and read, unlike a quaternion.

    Fields:

    - position: Position x, y, z in the base frame, m. Shape: 3.
    - rotation: Rotation matrix, 3 × 3, row by row. Shape: 3 × 3.
    """

    position: Vector
    """Position x, y, z in the base frame, m. Shape: 3."""
    rotation: Vector
    """Rotation matrix, 3 × 3, row by row. Shape: 3 × 3."""


class Interactive(Body):
    """The pace of an interactive run.

    Fields:

    - paused: Whether the run starts paused, to step it with `step`; default `false`.
    - speed: Simulated seconds per second of real time, if the machine is fast enough. Set less than 1 to watch a
      contact; default 1.
    """

    paused: bool | None = None
    """Whether the run starts paused, to step it with `step`; default `false`."""
    speed: float | None = None
    """Simulated seconds per second of real time, if the machine is fast enough. Set less than 1 to watch a contact;
    default 1."""


class JerkState(Body):
    """What joints with a jerk limit remember.

    Fields:

    - acceleration: Acceleration of the last command, rad/s² or m/s²; 0 for joints without jerk limit.
    - requested: Joint velocity that the tasks wanted in the last period, rad/s or m/s.
    """

    acceleration: Vector
    """Acceleration of the last command, rad/s² or m/s²; 0 for joints without jerk limit."""
    requested: Vector
    """Joint velocity that the tasks wanted in the last period, rad/s or m/s."""


JointKind = Literal["revolute", "prismatic"]
"""The kind of motion of a joint."""


class JointTurns(Body):
    """How a joint turns.

    Fields:

    - velocity: Command at the last turning point and extreme since then, rad/s or m/s.
    - falls: Whether the command falls since the last turning point; default: no.
    - position: Positions of the last two turns and extreme since then, rad or m; default: the joint has not moved.
    - repeats: How often in a row the joint turned where it had turned before; default 0.
    """

    velocity: Vector
    """Command at the last turning point and extreme since then, rad/s or m/s."""
    falls: bool | None = None
    """Whether the command falls since the last turning point; default: no."""
    position: Vector | None = None
    """Positions of the last two turns and extreme since then, rad or m; default: the joint has not moved."""
    repeats: int | None = None
    """How often in a row the joint turned where it had turned before; default 0."""


class LinkFrame(Answer):
    """The frame of one link.

    Fields:

    - joint: Name of the joint that moves the link.
    - pose: Pose in the base frame, m: origin on the axis of the joint, z along it.
    - parent: Name of the joint that it hangs on; absent: the base.
    """

    joint: str
    """Name of the joint that moves the link."""
    pose: Pose
    """Pose in the base frame, m: origin on the axis of the joint, z along it."""
    parent: str | None = None
    """Name of the joint that it hangs on; absent: the base."""


class TipPose(Answer):
    """The pose of a tip.

    Fields:

    - name: Name of the tip.
    - pose: Pose in the base frame, m.
    - joint: Name of the joint that carries it; absent: it is fixed to the base.
    """

    name: str
    """Name of the tip."""
    pose: Pose
    """Pose in the base frame, m."""
    joint: str | None = None
    """Name of the joint that carries it; absent: it is fixed to the base."""


class KinematicsAnswer(Answer):
    """The kinematics of a robot at a posture.

    Fields:

    - jacobian: Its Jacobian J, 6 × n, row by row: linear x y z (m/s), then angular x y z (rad/s), at its origin,
      along the axes of the base or of `relative_to`. Shape: 6.
    - links: Frames of the links, base first: the frame of each joint after its motion.
    - manipulability: Manipulability, the product of the singular values.
    - pose: Pose of the tool in the base frame, m; of `link` and seen from `relative_to`, if they are given.
    - singular_values: Singular values of J, largest first; min(6, n) of them.
    - tips: Poses of the tips in the base frame, first the tool.
    """

    jacobian: FloatArray
    """Its Jacobian J, 6 × n, row by row: linear x y z (m/s), then angular x y z (rad/s), at its origin, along the axes
    of the base or of `relative_to`. Shape: 6."""
    links: list[LinkFrame]
    """Frames of the links, base first: the frame of each joint after its motion."""
    manipulability: float
    """Manipulability, the product of the singular values."""
    pose: Pose
    """Pose of the tool in the base frame, m; of `link` and seen from `relative_to`, if they are given."""
    singular_values: FloatArray
    """Singular values of J, largest first; min(6, n) of them."""
    tips: list[TipPose] = Field(default_factory=list)
    """Poses of the tips in the base frame, first the tool."""


class KinematicsRequest(Body):
    """A posture of a robot.

    Fields:

    - joint_position: Joint position q, rad or m.
    - robot: Name of the robot, from `GET /v1/robots`.
    - link: Tip or link whose pose and Jacobian are asked for, by its name; default: the first tip, which is the
      tool.
    - relative_to: Tip or link from which they are seen, by its name; default: the base.
    """

    joint_position: JointVector
    """Joint position q, rad or m."""
    robot: str
    """Name of the robot, from `GET /v1/robots`."""
    link: str | None = None
    """Tip or link whose pose and Jacobian are asked for, by its name; default: the first tip, which is the tool."""
    relative_to: str | None = None
    """Tip or link from which they are seen, by its name; default: the base."""


LeftOutReason = Literal[
    "gripper", "head", "leg_or_wheel", "sensor", "unsupported", "beyond_tip", "other_branch", "not_below_base"
]
"""Why a joint is no part of the chain."""


class LeftOutJoint(Answer):
    """A moving joint that is no part of the chain.

    Fields:

    - joint: Name of the joint in the text.
    - reason: Why it is left out.
    """

    joint: str
    """Name of the joint in the text."""
    reason: LeftOutReason
    """Why it is left out."""


class LeftOutPair(Answer):
    """A pair of links that is not watched.

    Fields:

    - links: The links.
    - reason: `neighbours`, `always_touch`, `stated`, or the reason in the SRDF text.
    """

    links: list[str]
    """The links."""
    reason: str
    """`neighbours`, `always_touch`, `stated`, or the reason in the SRDF text."""


class Line(Body):
    """A line of the virtual arm from the place of the tool to targets that have jumped.

    Fields:

    - offset: Displacement of all rows from their targets at the start, m and rad.
    - postures: Joint positions at equal distances along the line, as far as they are known, rad or m.
    - progress: Progress along the line, 0 to 1.
    - speed: Its rate, 1/s.
    - speeds: The largest rates of progress there, 1/s.
    - is_given_up: Whether the line is out of reach or too slow; default: no.
    """

    offset: Vector
    """Displacement of all rows from their targets at the start, m and rad."""
    postures: Vector
    """Joint positions at equal distances along the line, as far as they are known, rad or m."""
    progress: float
    """Progress along the line, 0 to 1."""
    speed: float
    """Its rate, 1/s."""
    speeds: Vector
    """The largest rates of progress there, 1/s."""
    is_given_up: bool | None = None
    """Whether the line is out of reach or too slow; default: no."""


class LinkShape(Body):
    """A capsule or a sphere that covers a link, or a part of it.

    Fields:

    - link: Link that carries it.
    - body: Link of the robot's text that it covers, if that is no link of the robot and fixed joints connect it
      with `link`: a hand beyond the tip. The SRDF text names it.
    - capsule: A capsule; either this or `sphere`.
    - sphere: A sphere; either this or `capsule`.
    """

    link: str
    """Link that carries it."""
    body: str | None = None
    """Link of the robot's text that it covers, if that is no link of the robot and fixed joints connect it with `link`:
    a hand beyond the tip. The SRDF text names it."""
    capsule: Capsule | None = None
    """A capsule; either this or `sphere`."""
    sphere: Sphere | None = None
    """A sphere; either this or `capsule`."""


class LiveContact(Answer):
    """The contact of one axis with the law `contact` in one control period, along its pressing direction.

    Fields:

    - force: Measured force, N or N·m.
    - row: Row of the task, from 0.
    - state: State of the contact.
    - target_force: Target force, N or N·m.
    - task: Place of the task, from 0, highest priority first.
    - fault: Why the contact is given up; only in the state `fault`.
    - stiffness: Estimated stiffness, N/m or N·m/rad; absent until it is known.
    """

    force: float
    """Measured force, N or N·m."""
    row: int
    """Row of the task, from 0."""
    state: ContactState
    """State of the contact."""
    target_force: float
    """Target force, N or N·m."""
    task: int
    """Place of the task, from 0, highest priority first."""
    fault: ContactFault | None = None
    """Why the contact is given up; only in the state `fault`."""
    stiffness: float | None = None
    """Estimated stiffness, N/m or N·m/rad; absent until it is known."""


class PathCounts(Answer):
    """Number of periods per solver path.

    Fields:

    - active_set: Solved by active sets, starting from the last one.
    - closed_form: Solved by pseudo-inverses.
    - qp: Solved by Clarabel.
    """

    active_set: int
    """Solved by active sets, starting from the last one."""
    closed_form: int
    """Solved by pseudo-inverses."""
    qp: int
    """Solved by Clarabel."""


class TimeHistogram(Answer):
    """A histogram of times.

    Fields:

    - counts: Counts, ten bins per decade: bin 0 below 1 µs, bin k from 10^((k−1)/10) µs, the last bin from 0.1 s.
    - worst_us: Maximum time, µs.
    """

    counts: list[int]
    """Counts, ten bins per decade: bin 0 below 1 µs, bin k from 10^((k−1)/10) µs, the last bin from 0.1 s."""
    worst_us: float
    """Maximum time, µs."""


SimulationState = Literal["queued", "running", "finished", "failed", "cancelled"]
"""The state of a run."""


class SimulationMetrics(Answer):
    """The metrics of a run; `null` if one is not defined. "In contact" is touching a wall or, without a wall, measuring
    a force.

    Fields:

    - contacts: Number of separate intervals in contact.
    - calls_per_second: Control periods per second of real time.
    - final_force_n: F_x at the end, N.
    - first_contact_s: Time of the first contact, s.
    - largest_joint_speed_rad_s: Maximum joint speed, rad/s.
    - least_distance_m: Least distance of the pairs of shapes that the controller watches, m; `null` without such a
      pair.
    - overshoot_n: Maximum excess of F_x over its target, N.
    - overshoot_percent: Maximum excess of F_x over its target, % of the target.
    - peak_force_n: Maximum F_x, N.
    - rmse_force_x_n: Root mean square of F_x − F_d,x, N; from 5 s in runs longer than 10 s, otherwise from the
      first contact.
    - rmse_force_y_n: Root mean square of F_y − F_d,y, N, over the same time.
    - settling_time_s: Time from which F_x stays within 5 % of its target, s.
    """

    contacts: int
    """Number of separate intervals in contact."""
    calls_per_second: float | None = None
    """Control periods per second of real time."""
    final_force_n: float | None = None
    """F_x at the end, N."""
    first_contact_s: float | None = None
    """Time of the first contact, s."""
    largest_joint_speed_rad_s: float | None = None
    """Maximum joint speed, rad/s."""
    least_distance_m: float | None = None
    """Least distance of the pairs of shapes that the controller watches, m; `null` without such a pair."""
    overshoot_n: float | None = None
    """Maximum excess of F_x over its target, N."""
    overshoot_percent: float | None = None
    """Maximum excess of F_x over its target, % of the target."""
    peak_force_n: float | None = None
    """Maximum F_x, N."""
    rmse_force_x_n: float | None = None
    """Root mean square of F_x − F_d,x, N; from 5 s in runs longer than 10 s, otherwise from the first contact."""
    rmse_force_y_n: float | None = None
    """Root mean square of F_y − F_d,y, N, over the same time."""
    settling_time_s: float | None = None
    """Time from which F_x stays within 5 % of its target, s."""


class Simulation(Answer):
    """A run of a scenario.

    Fields:

    - id: Identifier of the run, part of its address.
    - method: Resolution method.
    - periods: Number of control periods of the whole run.
    - progress: Finished fraction of the run, 0 to 1.
    - scenario: Name of the scenario.
    - solver: Solver.
    - state: State of the run.
    - error: Reason of the failure; only if the run failed.
    - interactive: Pace of the run; only if it is interactive.
    - metrics: Metrics of the run; only when it is finished.
    """

    id: str
    """Identifier of the run, part of its address."""
    method: Method
    """Resolution method."""
    periods: int
    """Number of control periods of the whole run."""
    progress: float
    """Finished fraction of the run, 0 to 1."""
    scenario: str
    """Name of the scenario."""
    solver: Solver
    """Solver."""
    state: SimulationState
    """State of the run."""
    error: str | None = None
    """Reason of the failure; only if the run failed."""
    interactive: Interactive | None = None
    """Pace of the run; only if it is interactive."""
    metrics: SimulationMetrics | None = None
    """Metrics of the run; only when it is finished."""


class ObstacleState(Body):
    """Where a moving obstacle is.

    Fields:

    - name: Name of the obstacle.
    - position: Position of its middle in the base frame, m. Shape: 3.
    - velocity: Its velocity, m/s; default: it stands. Shape: 3.
    """

    name: str
    """Name of the obstacle."""
    position: Vector
    """Position of its middle in the base frame, m. Shape: 3."""
    velocity: Vector | None = None
    """Its velocity, m/s; default: it stands. Shape: 3."""


class LiveRoom(Answer):
    """The room around an arm in one control period.

    Fields:

    - obstacles: Where the moving obstacles are.
    - report: Distances of the answer.
    """

    obstacles: list[ObstacleState]
    """Where the moving obstacles are."""
    report: CollisionReport
    """Distances of the answer."""


class LiveSample(Answer):
    """One control period, in single precision. Vectors of joints follow the robot's joint order.

    Fields:

    - active_inequalities: Names of the inequalities that restricted the command at any time since the previous
      sample.
    - answered: Whether the service answered in this period.
    - at_lower: Joints (index from 0) at their lower bound at any time since the previous sample.
    - at_upper: Joints (index from 0) at their upper bound at any time since the previous sample.
    - force: Force F_e of the tool on the environment, base axes, N.
    - joint_position: Joint position q, rad or m.
    - joint_velocity: Commanded joint velocity q̇, rad/s or m/s.
    - orientation: Orientation of the tool in the base frame, a unit quaternion w, x, y, z.
    - path: Solver path of the command.
    - position: Tool position in the base frame, m.
    - residual_norms: Residual ‖J_k q̇ − ẋ_k‖ per task, highest priority first.
    - round_trip_us: Time from state to answer, µs.
    - smallest_singular_value: Smallest singular value of all task rows together.
    - solve_us: Time to compute the answer, µs.
    - status: Whether the command is certified optimal.
    - target_force: Target force F_d, N; `null` on axes that are not force-controlled.
    - task_residuals: Achieved minus requested velocity J_k q̇ − ẋ_k per task and row, m/s and rad/s, highest
      priority first.
    - time_s: Simulated time, s.
    - channels: Commands of the channels by name.
    - contacts: Contacts of the tasks with the law `contact`; absent without such a task.
    - kkt_residual: Relative residual of the optimality conditions; `null` if there is none.
    - room: The room around the arm; absent without collision avoidance, and before the first answer.
    - wall_distance_m: Distance to the wall, m, positive when free; `null` without a wall.
    - why: What restricts the command and what its tasks give up, in sentences; only if the controller has `"why":
      true`.
    """

    active_inequalities: list[str]
    """Names of the inequalities that restricted the command at any time since the previous sample."""
    answered: bool
    """Whether the service answered in this period."""
    at_lower: list[int]
    """Joints (index from 0) at their lower bound at any time since the previous sample."""
    at_upper: list[int]
    """Joints (index from 0) at their upper bound at any time since the previous sample."""
    force: FloatArray
    """Force F_e of the tool on the environment, base axes, N."""
    joint_position: FloatArray
    """Joint position q, rad or m."""
    joint_velocity: FloatArray
    """Commanded joint velocity q̇, rad/s or m/s."""
    orientation: FloatArray
    """Orientation of the tool in the base frame, a unit quaternion w, x, y, z."""
    path: Path
    """Solver path of the command."""
    position: FloatArray
    """Tool position in the base frame, m."""
    residual_norms: FloatArray
    """Residual ‖J_k q̇ − ẋ_k‖ per task, highest priority first."""
    round_trip_us: float
    """Time from state to answer, µs."""
    smallest_singular_value: float
    """Smallest singular value of all task rows together."""
    solve_us: float
    """Time to compute the answer, µs."""
    status: Status
    """Whether the command is certified optimal."""
    target_force: FloatArray
    """Target force F_d, N; `null` on axes that are not force-controlled."""
    task_residuals: list[FloatArray]
    """Achieved minus requested velocity J_k q̇ − ẋ_k per task and row, m/s and rad/s, highest priority first."""
    time_s: float
    """Simulated time, s."""
    channels: dict[str, float] | None = None
    """Commands of the channels by name."""
    contacts: list[LiveContact] = Field(default_factory=list)
    """Contacts of the tasks with the law `contact`; absent without such a task."""
    kkt_residual: float | None = None
    """Relative residual of the optimality conditions; `null` if there is none."""
    room: LiveRoom | None = None
    """The room around the arm; absent without collision avoidance, and before the first answer."""
    wall_distance_m: float | None = None
    """Distance to the wall, m, positive when free; `null` without a wall."""
    why: list[str] = Field(default_factory=list)
    """What restricts the command and what its tasks give up, in sentences; only if the controller has `"why": true`."""


class LiveFrame(Answer):
    """The state of a run at one moment, and samples since the previous frame.

    Fields:

    - arm: Present posture of the arm.
    - done: Number of finished control periods.
    - external_force: External force on the tool, N, base axes.
    - paths: Number of periods per solver path.
    - reached_speed: Recently reached speed, simulated seconds per second of real time.
    - round_trip: Histogram of the times from state to answer.
    - run: The run with its present pace, method and solver.
    - samples: Some of the periods since the previous frame, evenly spaced, oldest first.
    - solve_time: Histogram of the times to compute an answer.
    - time_s: Simulated time, s.
    """

    arm: ArmView
    """Present posture of the arm."""
    done: int
    """Number of finished control periods."""
    external_force: FloatArray
    """External force on the tool, N, base axes."""
    paths: PathCounts
    """Number of periods per solver path."""
    reached_speed: float
    """Recently reached speed, simulated seconds per second of real time."""
    round_trip: TimeHistogram
    """Histogram of the times from state to answer."""
    run: Simulation
    """The run with its present pace, method and solver."""
    samples: list[LiveSample]
    """Some of the periods since the previous frame, evenly spaced, oldest first."""
    solve_time: TimeHistogram
    """Histogram of the times to compute an answer."""
    time_s: float
    """Simulated time, s."""


class TaskGain(Body):
    """What a task has gained.

    Fields:

    - least: The least distance from the target since it changed, m and rad together.
    - task: Name of the task.
    - pose: The target of a task on the tool.
    - values: The target of a task on joints, one number per row.
    """

    least: float
    """The least distance from the target since it changed, m and rad together."""
    task: str
    """Name of the task."""
    pose: Pose | None = None
    """The target of a task on the tool."""
    values: Vector | None = None
    """The target of a task on joints, one number per row."""


class RestState(Body):
    """How the joints turn and what the tasks gained by it.

    Fields:

    - joints: How each joint turns, in joint order.
    - spent: W, what the joints have spent by turning without a gain, 0 to 2.7.
    - tasks: What the tasks that follow positions have gained.
    - exhausted: How often they have spent all; default 0.
    - fading_since_s: Time since which the requests fade, s; default: they do not.
    """

    joints: list[JointTurns]
    """How each joint turns, in joint order."""
    spent: float
    """W, what the joints have spent by turning without a gain, 0 to 2.7."""
    tasks: list[TaskGain]
    """What the tasks that follow positions have gained."""
    exhausted: int | None = None
    """How often they have spent all; default 0."""
    fading_since_s: float | None = None
    """Time since which the requests fade, s; default: they do not."""


class Stall(Body):
    """How far a joint was commanded and has moved since it last followed its commands, or lately.

    Fields:

    - commanded: Commanded distance, behind the drive of the controller, rad or m.
    - joint: Name of the joint.
    - moved: Measured distance, rad or m.
    - time_s: Time of both distances, s.
    """

    commanded: float
    """Commanded distance, behind the drive of the controller, rad or m."""
    joint: str
    """Name of the joint."""
    moved: float
    """Measured distance, rad or m."""
    time_s: float
    """Time of both distances, s."""


StreamedQuantity = Literal["pose", "joint_position", "velocity", "force"]
"""What the targets of a stream are."""


class TargetReference(Body):
    """The target that a law followed, in the memory.

    Fields:

    - velocity: Velocity: of a pose linear and angular in base axes, otherwise per row.
    - pose: Pose in the base frame, m.
    - values: Values per row, if the target is not a pose.
    """

    velocity: Vector
    """Velocity: of a pose linear and angular in base axes, otherwise per row."""
    pose: Pose | None = None
    """Pose in the base frame, m."""
    values: Vector | None = None
    """Values per row, if the target is not a pose."""


class TargetSample(Body):
    """A target in the memory.

    Fields:

    - time_s: Time of the target, s.
    - pose: Pose in the base frame, m.
    - values: Values per row, if the target is not a pose.
    - velocity: Given or estimated velocity: of a pose linear and angular in base axes, otherwise per row.
    """

    time_s: float
    """Time of the target, s."""
    pose: Pose | None = None
    """Pose in the base frame, m."""
    values: Vector | None = None
    """Values per row, if the target is not a pose."""
    velocity: Vector | None = None
    """Given or estimated velocity: of a pose linear and angular in base axes, otherwise per row."""


class TargetStream(Body):
    """The last targets of a task, as a part of the memory.

    Fields:

    - quantity: What the targets are.
    - reference: The target that the law followed in the last period, with its velocity.
    - state: State of the last period.
    - task: Name of the task.
    - ahead: Targets of later times that came with the newest one; default: none.
    - chunk: The chunks that the task follows; default: none came.
    - newest: The newest target.
    - previous: The target before it.
    """

    quantity: StreamedQuantity
    """What the targets are."""
    reference: TargetReference
    """The target that the law followed in the last period, with its velocity."""
    state: TargetState
    """State of the last period."""
    task: str
    """Name of the task."""
    ahead: list[LaterTarget] | None = None
    """Targets of later times that came with the newest one; default: none."""
    chunk: ChunkMemory | None = None
    """The chunks that the task follows; default: none came."""
    newest: TargetSample | None = None
    """The newest target."""
    previous: TargetSample | None = None
    """The target before it."""


class Progress(Body):
    """How a task follows its requests over time.

    Fields:

    - share: Filtered share of the requested velocity that the task achieves, 0 to 1.
    - attempts: How often the arm has left since a target changed; default 0.
    - leaving_since_s: Time at which the arm began to leave the posture, s; default: it does not leave.
    - left_at: Distance of the task from its target when the arm left last, m and rad together; default: it has not
      left.
    - slow_since_s: Time since which the share is below one half, s; default: it is not.
    """

    share: float
    """Filtered share of the requested velocity that the task achieves, 0 to 1."""
    attempts: int | None = None
    """How often the arm has left since a target changed; default 0."""
    leaving_since_s: float | None = None
    """Time at which the arm began to leave the posture, s; default: it does not leave."""
    left_at: float | None = None
    """Distance of the task from its target when the arm left last, m and rad together; default: it has not left."""
    slow_since_s: float | None = None
    """Time since which the share is below one half, s; default: it is not."""


class VirtualArm(Body):
    """The virtual arm of laws with `path`: postures at which the tasks have reached their targets.

    Fields:

    - next: Index of the posture that the next period computes.
    - postures: Joint positions at each of the times ahead, rad or m. Shape: 9.
    - line: The line on which the arm moves to targets that have jumped; default: it is at its targets.
    - target_accelerations: Smoothed accelerations of the streamed targets, one list per stream, m/s² and rad/s²;
      default: none.
    """

    next: int
    """Index of the posture that the next period computes."""
    postures: Vector
    """Joint positions at each of the times ahead, rad or m. Shape: 9."""
    line: Line | None = None
    """The line on which the arm moves to targets that have jumped; default: it is at its targets."""
    target_accelerations: Vector | None = None
    """Smoothed accelerations of the streamed targets, one list per stream, m/s² and rad/s²; default: none."""


class WrenchSensorMemory(Body):
    """What a wrench sensor remembers.

    Fields:

    - filtered: Wrench behind the low-pass, axes and origin of the sensor; default: the next reading sets it.
    - velocity: Velocity of the centre of mass of the payload, base axes, m/s; default: unknown. Shape: 3.
    """

    filtered: Wrench | None = None
    """Wrench behind the low-pass, axes and origin of the sensor; default: the next reading sets it."""
    velocity: Vector | None = None
    """Velocity of the centre of mass of the payload, base axes, m/s; default: unknown. Shape: 3."""


class Memory(Body):
    """The memory of a controller. Clients send it back unchanged with the next state.

    Fields:

    - active_set: Active limits of the last command, per level of the solver.
    - initial_pose: Tool pose at the first step, base frame, m.
    - last_command: Joint velocity of the last command, rad/s or m/s.
    - sequence: Sequence number of the last state.
    - task_velocities: Integrator velocity of each task, m/s and rad/s.
    - channels: The channels of the controller; default: none had a target.
    - contacts: What the law `contact` remembers of each of its axes, in the order of the tasks; default: the next
      state starts anew.
    - drive: The commands that the drive still has to follow; default: the last command for long.
    - in_transition: Whether the controller replaces another one and still limits accelerations for that; default:
      no.
    - initial_joint_position: Joint position of the first state, rad or m; default: that of the next state.
    - jerk: What joints with a jerk limit remember; default: they have moved at the last command for long.
    - joint_position: Joint position of the last state, rad or m; default: unknown.
    - rest: How the joints turn and what the tasks gained by it, so that the arm comes to rest; default: the next
      state starts anew.
    - stalls: Joints that did not follow their commands lately; default: none.
    - start_time_s: Time of the first state, from which profiles count, s; default: 0, unless that time is above 1e9
      s.
    - stop_time_s: `stop_time_s` of the last answer, s; default: each joint brakes at its own deceleration.
    - target_streams: Streamed targets of the tasks; default: none.
    - task_progress: How each task follows its requests; default: all follow.
    - time_s: Time of the last state, s; default: unknown, then the next state is not compared with it.
    - valid_for_ms: Validity of the last answer, ms: how long the arm may have held its command. Default: unknown,
      then the next state counts as one period later, whatever its time.
    - virtual_arm: The virtual arm of laws that look ahead; default: none, or the next state starts anew.
    - way: How far the joints move behind the modelled drive in the period after the last state, rad or m: positions
      tell by it whether a state is late or the clock jumped. Default: the velocity of the drive for a period.
    - wrench_sensors: What the wrench sensors remember, the tool first, then the other tips in the order of the
      robot; default: they start.
    """

    active_set: list[list[ActiveLimitName]]
    """Active limits of the last command, per level of the solver."""
    initial_pose: FramePose
    """Tool pose at the first step, base frame, m."""
    last_command: Vector
    """Joint velocity of the last command, rad/s or m/s."""
    sequence: int
    """Sequence number of the last state."""
    task_velocities: list[Vector]
    """Integrator velocity of each task, m/s and rad/s."""
    channels: list[ChannelMemory] | None = None
    """The channels of the controller; default: none had a target."""
    contacts: list[ContactMemory] | None = None
    """What the law `contact` remembers of each of its axes, in the order of the tasks; default: the next state starts
    anew."""
    drive: DriveState | None = None
    """The commands that the drive still has to follow; default: the last command for long."""
    in_transition: bool | None = None
    """Whether the controller replaces another one and still limits accelerations for that; default: no."""
    initial_joint_position: Vector | None = None
    """Joint position of the first state, rad or m; default: that of the next state."""
    jerk: JerkState | None = None
    """What joints with a jerk limit remember; default: they have moved at the last command for long."""
    joint_position: Vector | None = None
    """Joint position of the last state, rad or m; default: unknown."""
    rest: RestState | None = None
    """How the joints turn and what the tasks gained by it, so that the arm comes to rest; default: the next state
    starts anew."""
    stalls: list[Stall] | None = None
    """Joints that did not follow their commands lately; default: none."""
    start_time_s: float | None = None
    """Time of the first state, from which profiles count, s; default: 0, unless that time is above 1e9 s."""
    stop_time_s: float | None = None
    """`stop_time_s` of the last answer, s; default: each joint brakes at its own deceleration."""
    target_streams: list[TargetStream] | None = None
    """Streamed targets of the tasks; default: none."""
    task_progress: list[Progress] | None = None
    """How each task follows its requests; default: all follow."""
    time_s: float | None = None
    """Time of the last state, s; default: unknown, then the next state is not compared with it."""
    valid_for_ms: int | None = None
    """Validity of the last answer, ms: how long the arm may have held its command. Default: unknown, then the next
    state counts as one period later, whatever its time."""
    virtual_arm: VirtualArm | None = None
    """The virtual arm of laws that look ahead; default: none, or the next state starts anew."""
    way: Vector | None = None
    """How far the joints move behind the modelled drive in the period after the last state, rad or m: positions tell by
    it whether a state is late or the clock jumped. Default: the velocity of the drive for a period."""
    wrench_sensors: list[WrenchSensorMemory] | None = None
    """What the wrench sensors remember, the tool first, then the other tips in the order of the robot; default: they
    start."""


class ObstacleMotion(Body):
    """How an obstacle of the controller moves.

    Fields:

    - displacement: How far it is from where the controller has it, over time: three values, base axes, m.
    - name: Name of the obstacle, which has `moves: true`.
    """

    displacement: Profile
    """How far it is from where the controller has it, over time: three values, base axes, m."""
    name: str
    """Name of the obstacle, which has `moves: true`."""


class Sensor(Body):
    """Errors of a sensor: it measures quantum · round((value + bias + noise)/quantum). Each field is one number for all
    values, or one per value.

    Fields:

    - bias: Constant offset.
    - noise: Standard deviation of the normally distributed noise in each period.
    - quantum: Resolution; unlimited if 0.
    """

    bias: ArrayLike | None = None
    """Constant offset."""
    noise: ArrayLike | None = None
    """Standard deviation of the normally distributed noise in each period."""
    quantum: ArrayLike | None = None
    """Resolution; unlimited if 0."""


class Sensors(Body):
    """Sensors of the arm. The default is ideal sensors.

    Fields:

    - force: Force along x, y and z of the sensor, N.
    - joint_position: Joint positions q, rad or m; per joint.
    - joint_velocity: Joint velocities q̇, rad/s or m/s; per joint.
    - torque: Torque about x, y and z of the sensor, N·m.
    - wrench_filter_s: Time constant τ of a first-order low-pass filter for force and torque, s; no filter if 0.
    """

    force: Sensor | None = None
    """Force along x, y and z of the sensor, N."""
    joint_position: Sensor | None = None
    """Joint positions q, rad or m; per joint."""
    joint_velocity: Sensor | None = None
    """Joint velocities q̇, rad/s or m/s; per joint."""
    torque: Sensor | None = None
    """Torque about x, y and z of the sensor, N·m."""
    wrench_filter_s: float | None = None
    """Time constant τ of a first-order low-pass filter for force and torque, s; no filter if 0."""


class ForceAlongMotionTargetProgram(Tagged):
    """A force along the motion of the tool, as for a door or a drawer whose direction is not known.

    Fields:

    - force: Force F_d, N.
    - kind: Selects the variant.
    - memory_m: Way of the tool after which a direction of its motion is forgotten to 1/e, m.
    - start_direction: Direction of the force at the start, base axes; of any length except zero. Shape: 3.
    - task: Name of a task with the law `force` and the axes x, y and z of the base.
    """

    force: float
    """Force F_d, N."""
    kind: Literal["force_along_motion"] = "force_along_motion"
    """Selects the variant."""
    memory_m: float
    """Way of the tool after which a direction of its motion is forgotten to 1/e, m."""
    start_direction: Vector
    """Direction of the force at the start, base axes; of any length except zero. Shape: 3."""
    task: str
    """Name of a task with the law `force` and the axes x, y and z of the base."""


class SpiralSearchTargetProgram(Tagged):
    """A spiral of Archimedes, as for a peg whose hole is not where it should be. The tool moves along it while the
    first axis with the law `contact` is in contact.

    Fields:

    - inserted_m: Depth below the place of the first contact at which the search ends, m. The task then holds the
      place.
    - kind: Selects the variant.
    - pitch_m: Distance of two turns, m.
    - speed: Speed along the spiral, m/s.
    - task: Name of a task with the law `pose` and the axes x and y of the base.
    """

    inserted_m: float
    """Depth below the place of the first contact at which the search ends, m. The task then holds the place."""
    kind: Literal["spiral_search"] = "spiral_search"
    """Selects the variant."""
    pitch_m: float
    """Distance of two turns, m."""
    speed: float
    """Speed along the spiral, m/s."""
    task: str
    """Name of a task with the law `pose` and the axes x and y of the base."""


TargetProgram = Annotated[ForceAlongMotionTargetProgram | SpiralSearchTargetProgram, Field(discriminator="kind")]
"""A program that streams the target of a task in each period. It knows the place of the tool and the last
answer."""


class VelocityLoop(Body):
    """How the arm follows a commanded velocity. The default is an ideal arm.

    Fields:

    - clamp: Whether the drives clamp the command of each joint at the limits of the controller.
    - delay_periods: Delay of a command, whole periods.
    - lag_s: Time constant τ of a first-order lag, s.
    """

    clamp: bool | None = None
    """Whether the drives clamp the command of each joint at the limits of the controller."""
    delay_periods: int | None = None
    """Delay of a command, whole periods."""
    lag_s: float | None = None
    """Time constant τ of a first-order lag, s."""


class Scenario(Body):
    """An experiment: controller, start posture, contacts and duration.

    Fields:

    - controller: The controller, as in a request.
    - description: Description in one line.
    - duration_s: Simulated duration, s.
    - name: Name, as in `force_tracking`.
    - start_joint_position: Joint positions q at the start, n, rad or m.
    - contacts: Contacts of the tool.
    - expectation: Expected result, in words.
    - external_wrench: External force and torque on the tool at the tool point, base axes, N and N·m: six values
      over time.
    - faults: Faults of the connection between arm and service.
    - obstacle_motions: How obstacles of the controller move that have `moves: true`; those without a motion stand.
    - seed: Seed of noise and faults; the same seed gives the same run.
    - sensors: Errors of the sensors.
    - substeps: Integration steps of arm and contacts per period.
    - target_programs: Programs that stream targets of tasks, as an application would.
    - velocity_loop: How the arm follows its commands.
    """

    controller: ControllerConfig
    """The controller, as in a request."""
    description: str
    """Description in one line."""
    duration_s: float
    """Simulated duration, s."""
    name: str
    """Name, as in `force_tracking`."""
    start_joint_position: Vector
    """Joint positions q at the start, n, rad or m."""
    contacts: list[Contact] | None = None
    """Contacts of the tool."""
    expectation: str | None = None
    """Expected result, in words."""
    external_wrench: Profile | None = None
    """External force and torque on the tool at the tool point, base axes, N and N·m: six values over time."""
    faults: Faults | None = None
    """Faults of the connection between arm and service."""
    obstacle_motions: list[ObstacleMotion] | None = None
    """How obstacles of the controller move that have `moves: true`; those without a motion stand."""
    seed: int | None = None
    """Seed of noise and faults; the same seed gives the same run."""
    sensors: Sensors | None = None
    """Errors of the sensors."""
    substeps: int | None = None
    """Integration steps of arm and contacts per period."""
    target_programs: list[TargetProgram] | None = None
    """Programs that stream targets of tasks, as an application would."""
    velocity_loop: VelocityLoop | None = None
    """How the arm follows its commands."""


NamedScenario = str | Scenario
"""A scenario, by name or in full."""

Obstacle = Literal["limits", "singularity", "higher_tasks"]
"""What holds a task back."""


class PayloadAnswer(Answer):
    """Bias and payload. `bias` and `payload` fit into `wrench_sensor` of a controller as they are.

    Fields:

    - axes_verified: Whether the readings rule out every wrong sign and every exchange of axes; if not, the payload
      is too light for the noise or the postures are too similar.
    - bias: Reading without contact and without payload, along the axes of the sensor.
    - condition: How similar the postures are: 1 at best; above 8 they are refused.
    - force_residual_n: Residual of the forces, rms per axis, N. It is near the noise.
    - mass_uncertainty_kg: Uncertainty of the mass, rms, kg.
    - payload: Mass and centre of mass.
    - readings: Number of readings.
    - torque_residual_nm: Residual of the torques, rms per axis, N·m.
    - center_of_mass_uncertainty_m: Uncertainty of the centre of mass, rms per axis, m; absent without payload.
    """

    axes_verified: bool
    """Whether the readings rule out every wrong sign and every exchange of axes; if not, the payload is too light for
    the noise or the postures are too similar."""
    bias: Wrench
    """Reading without contact and without payload, along the axes of the sensor."""
    condition: float
    """How similar the postures are: 1 at best; above 8 they are refused."""
    force_residual_n: float
    """Residual of the forces, rms per axis, N. It is near the noise."""
    mass_uncertainty_kg: float
    """Uncertainty of the mass, rms, kg."""
    payload: Payload
    """Mass and centre of mass."""
    readings: int
    """Number of readings."""
    torque_residual_nm: float
    """Residual of the torques, rms per axis, N·m."""
    center_of_mass_uncertainty_m: float | None = None
    """Uncertainty of the centre of mass, rms per axis, m; absent without payload."""


class PayloadReading(Body):
    """A reading of a sensor at rest. Give either the posture or the direction of gravity.

    Fields:

    - wrench: Measured wrench.
    - gravity: Acceleration of gravity along the axes of the sensor, m/s², in place of `joint_position`. Shape: 3.
    - joint_position: Measured joint position, rad or m, in joint order or by name.
    """

    wrench: Wrench
    """Measured wrench."""
    gravity: Vector | None = None
    """Acceleration of gravity along the axes of the sensor, m/s², in place of `joint_position`. Shape: 3."""
    joint_position: JointVector | None = None
    """Measured joint position, rad or m, in joint order or by name."""


class PayloadRequest(Body):
    """`POST /v1/payload`: readings at rest in six postures or more, without contact.

    Fields:

    - readings: At least six readings, in postures that turn the sensor far: gravity along each of its axes in both
      directions is best.
    - force_noise_n: Noise of a reading, rms, N; of a mean, if the readings are means. Default 0.2.
    - gravity: Acceleration of gravity along the axes of the base, m/s², for the readings with `joint_position`;
      default [0, 0, -9.81]. Shape: 3.
    - pose: Pose of the sensor in the robot's own tool frame, as in `wrench_sensor`; default: that frame. Readings
      with their own `gravity` do not need it.
    - robot: Name of the robot, from `GET /v1/robots`; only for readings with `joint_position`.
    - tip: Tip before which the sensor is, by its name; default: the tool.
    - torque_noise_nm: Noise of a reading, rms, N·m; default 0.02.
    - wrench_convention: Sign of the readings, as in the controller; default `on_environment`.
    - wrench_frame: Axes of the readings: `tool` are those of the sensor. Default `tool`.
    """

    readings: list[PayloadReading]
    """At least six readings, in postures that turn the sensor far: gravity along each of its axes in both directions is
    best."""
    force_noise_n: float | None = None
    """Noise of a reading, rms, N; of a mean, if the readings are means. Default 0.2."""
    gravity: Vector | None = None
    """Acceleration of gravity along the axes of the base, m/s², for the readings with `joint_position`; default [0, 0,
    -9.81]. Shape: 3."""
    pose: Pose | None = None
    """Pose of the sensor in the robot's own tool frame, as in `wrench_sensor`; default: that frame. Readings with their
    own `gravity` do not need it."""
    robot: str | None = None
    """Name of the robot, from `GET /v1/robots`; only for readings with `joint_position`."""
    tip: str | None = None
    """Tip before which the sensor is, by its name; default: the tool."""
    torque_noise_nm: float | None = None
    """Noise of a reading, rms, N·m; default 0.02."""
    wrench_convention: WrenchConvention | None = None
    """Sign of the readings, as in the controller; default `on_environment`."""
    wrench_frame: WrenchFrame | None = None
    """Axes of the readings: `tool` are those of the sensor. Default `tool`."""


class RegisteredTip(Body):
    """A frame on a link that tasks can name, such as a tool.

    Fields:

    - link: Link of the text that carries it.
    - name: Name for the `link` and `relative_to` of tasks, unique among the tips.
    - offset: Pose in the frame of the link, m; default: the frame of the link.
    """

    link: str
    """Link of the text that carries it."""
    name: str
    """Name for the `link` and `relative_to` of tasks, unique among the tips."""
    offset: Pose | None = None
    """Pose in the frame of the link, m; default: the frame of the link."""


class RestReading(Body):
    """A reading of an arm at rest.

    Fields:

    - joint_position: Measured joint position, rad or m, in joint order or by name.
    - wrench: Measured wrench, as in the states.
    """

    joint_position: JointVector
    """Measured joint position, rad or m, in joint order or by name."""
    wrench: Wrench
    """Measured wrench, as in the states."""


class VelocityEnvelope(Body):
    """Maximum speed towards an end of the position range, which shrinks with the distance d from that end: max(0, √(2 D
    d) − o).  Controllers whose limits include positions keep it. The joint comes no nearer to an end than o²/2D. In a
    URDF text it is the element `<position_based_velocity_limits>` of a joint, with attributes of these names.

    Fields:

    - deceleration_limit: D, rad/s² or m/s².
    - velocity_offset: o, rad/s or m/s.
    """

    deceleration_limit: float
    """D, rad/s² or m/s²."""
    velocity_offset: float
    """o, rad/s or m/s."""


class RobotJoint(Answer):
    """A joint and its limits; a limit is `null` if there is none.

    Fields:

    - kind: Kind of motion.
    - name: Name of the joint.
    - unit: Unit of the position, `rad` or `m`; velocity, acceleration and jerk are per s, s² and s³.
    - acceleration_limit: Maximum acceleration, rad/s² or m/s².
    - denavit_hartenberg: Standard Denavit-Hartenberg row, if the robot was described by one.
    - jerk_limit: Maximum jerk, rad/s³ or m/s³; omitted if there is none.
    - position_limit: Minimum and maximum position, rad or m. Shape: 2.
    - published_range: Position range in a publication, if it differs; for information only. Shape: 2.
    - velocity_envelope: Maximum speed near the ends of the range; omitted if it does not shrink there.
    - velocity_limit: Maximum speed, rad/s or m/s.
    """

    kind: JointKind
    """Kind of motion."""
    name: str
    """Name of the joint."""
    unit: str
    """Unit of the position, `rad` or `m`; velocity, acceleration and jerk are per s, s² and s³."""
    acceleration_limit: float | None = None
    """Maximum acceleration, rad/s² or m/s²."""
    denavit_hartenberg: DenavitHartenberg | None = None
    """Standard Denavit-Hartenberg row, if the robot was described by one."""
    jerk_limit: float | None = None
    """Maximum jerk, rad/s³ or m/s³; omitted if there is none."""
    position_limit: FloatArray | None = None
    """Minimum and maximum position, rad or m. Shape: 2."""
    published_range: FloatArray | None = None
    """Position range in a publication, if it differs; for information only. Shape: 2."""
    velocity_envelope: VelocityEnvelope | None = None
    """Maximum speed near the ends of the range; omitted if it does not shrink there."""
    velocity_limit: float | None = None
    """Maximum speed, rad/s or m/s."""


RobotSource = Literal["denavit_hartenberg", "urdf"]
"""The format that described a robot."""

TipReason = Literal["request", "only_end", "tool_name", "before_gripper", "last_link"]
"""Why a chain ends at its tip."""


class RobotChain(Answer):
    """The chain of a URDF text that is the arm.

    Fields:

    - base: Link of the base frame.
    - joints: Joints from base to tip, under the names that requests use.
    - left_out: Moving joints of the text that are no part of the chain, at most the first 100.
    - reason: Why the chain ends there.
    - tip: Link of the tool frame.
    """

    base: str
    """Link of the base frame."""
    joints: list[str]
    """Joints from base to tip, under the names that requests use."""
    left_out: list[LeftOutJoint]
    """Moving joints of the text that are no part of the chain, at most the first 100."""
    reason: TipReason
    """Why the chain ends there."""
    tip: str
    """Link of the tool frame."""


class RobotShapes(Answer):
    """The shapes of a robot and the pairs that are watched.

    Fields:

    - left_out: Pairs of links that are not watched, with the reasons.
    - shape_list: Shapes.
    - watched_pairs: Number of pairs of shapes that keep clear of each other.
    - uncovered_links: Links of the text that have a form which no shape covers: fingers beyond the tip of an arm,
      or links without `<collision>`. Nothing keeps them clear. Known for `shapes` only.
    """

    left_out: list[LeftOutPair]
    """Pairs of links that are not watched, with the reasons."""
    shape_list: list[LinkShape]
    """Shapes."""
    watched_pairs: int
    """Number of pairs of shapes that keep clear of each other."""
    uncovered_links: list[str] = Field(default_factory=list)
    """Links of the text that have a form which no shape covers: fingers beyond the tip of an arm, or links without
    `<collision>`. Nothing keeps them clear. Known for `shapes` only."""


class RobotTip(Answer):
    """A frame on a link.

    Fields:

    - link: Link that carries it.
    - name: Name.
    """

    link: str
    """Link that carries it."""
    name: str
    """Name."""


class Robot(Answer):
    """A robot arm.

    Fields:

    - description: Description, one line of text.
    - joints: Joints, base first; the order of all vectors of joints.
    - name: Name for requests.
    - source: Format that described the robot.
    - chain: The chain of the URDF text that was taken for the arm; absent for Denavit-Hartenberg rows.
    - links: Names of the links, base first. Tasks can name them too.
    - shapes: Shapes and watched pairs; absent: the robot has no shapes.
    - tips: Tips, first the tool. Tasks name them as `link` and `relative_to`.
    """

    description: str
    """Description, one line of text."""
    joints: list[RobotJoint]
    """Joints, base first; the order of all vectors of joints."""
    name: str
    """Name for requests."""
    source: RobotSource
    """Format that described the robot."""
    chain: RobotChain | None = None
    """The chain of the URDF text that was taken for the arm; absent for Denavit-Hartenberg rows."""
    links: list[str] = Field(default_factory=list)
    """Names of the links, base first. Tasks can name them too."""
    shapes: RobotShapes | None = None
    """Shapes and watched pairs; absent: the robot has no shapes."""
    tips: list[RobotTip] = Field(default_factory=list)
    """Tips, first the tool. Tasks name them as `link` and `relative_to`."""


class RobotList(Answer):
    """Answer to `GET /v1/robots`.

    Fields:

    - robots: Robots that requests can name.
    """

    robots: list[Robot]
    """Robots that requests can name."""


class StatedLimits(Body):
    """Limits of one joint; a limit that is not given is read from the text.

    Fields:

    - acceleration: Maximum acceleration, rad/s² or m/s².
    - jerk: Maximum jerk, rad/s³ or m/s³.
    - position: Minimum and maximum position, rad or m. Shape: 2.
    - velocity: Maximum speed, rad/s or m/s.
    - velocity_envelope: Maximum speed near the ends of the range.
    """

    acceleration: float | None = None
    """Maximum acceleration, rad/s² or m/s²."""
    jerk: float | None = None
    """Maximum jerk, rad/s³ or m/s³."""
    position: Vector | None = None
    """Minimum and maximum position, rad or m. Shape: 2."""
    velocity: float | None = None
    """Maximum speed, rad/s or m/s."""
    velocity_envelope: VelocityEnvelope | None = None
    """Maximum speed near the ends of the range."""


ShapeSource = Literal["fit"]
"""From where a robot has its shapes."""


class RobotRegistration(Body):
    """`POST /v1/robots`: registers the chain of a URDF text from one link to another.

    Fields:

    - name: Name for requests: at most 64 letters, digits, `_`, `-` and `.`.
    - urdf: URDF text, `<robot …>`.
    - base: Base link; default: the root of the tree.
    - collision_pairs: Pairs of links of which nothing is watched.
    - joint_names: New names, by the name of the joint in the text.
    - limits: Limits that replace or complete those of the text, by the name of the joint in the text.
    - shape_list: Shapes that cover the links, so that controllers can keep clear; default: none.
    - shapes: `fit`: capsules that contain the `<collision>` elements of the text cover the links. Links of
      `shape_list` have those instead. Default: only `shape_list` counts.
    - srdf: SRDF text, the semantic description that belongs to the URDF text. Its `<disable_collisions>` pairs are
      not watched. If neither `tip` nor `tips` is given, the links of its `<end_effector>` elements are the tips:
      several make a robot with several arms.
    - tip: Link of the tool frame; default: the end of the only chain or of the only arm, without gripper.
    - tips: Tips of a robot with several arms, first the tool; then the robot is all that is below the base. Set it
      for two arms, a torso or a mobile base; instead of `tip`.
    - tool_offset: Pose of the tool frame in the frame of the tip, m; default: the frame of the tip.
    """

    name: str
    """Name for requests: at most 64 letters, digits, `_`, `-` and `.`."""
    urdf: UrdfText
    """URDF text, `<robot …>`."""
    base: str | None = None
    """Base link; default: the root of the tree."""
    collision_pairs: CollisionPairs | None = None
    """Pairs of links of which nothing is watched."""
    joint_names: dict[str, str] | None = None
    """New names, by the name of the joint in the text."""
    limits: dict[str, StatedLimits] | None = None
    """Limits that replace or complete those of the text, by the name of the joint in the text."""
    shape_list: list[LinkShape] | None = None
    """Shapes that cover the links, so that controllers can keep clear; default: none."""
    shapes: ShapeSource | None = None
    """`fit`: capsules that contain the `<collision>` elements of the text cover the links. Links of `shape_list` have
    those instead. Default: only `shape_list` counts."""
    srdf: str | None = None
    """SRDF text, the semantic description that belongs to the URDF text. Its `<disable_collisions>` pairs are not
    watched. If neither `tip` nor `tips` is given, the links of its `<end_effector>` elements are the tips: several make
    a robot with several arms."""
    tip: str | None = None
    """Link of the tool frame; default: the end of the only chain or of the only arm, without gripper."""
    tips: list[RegisteredTip] | None = None
    """Tips of a robot with several arms, first the tool; then the robot is all that is below the base. Set it for two
    arms, a torso or a mobile base; instead of `tip`."""
    tool_offset: Pose | None = None
    """Pose of the tool frame in the frame of the tip, m; default: the frame of the tip."""


class ScenarioEntry(Answer):
    """One scenario of the list.

    Fields:

    - description: Description in one line.
    - name: Name.
    - robot: Name of its robot.
    - scenario: The whole scenario.
    """

    description: str
    """Description in one line."""
    name: str
    """Name."""
    robot: str
    """Name of its robot."""
    scenario: Scenario
    """The whole scenario."""


class ScenarioList(Answer):
    """Answer to `GET /v1/scenarios`.

    Fields:

    - scenarios: The scenarios that ship with the service.
    """

    scenarios: list[ScenarioEntry]
    """The scenarios that ship with the service."""


class SessionEntry(Answer):
    """One session in a list of sessions.

    Fields:

    - id: Identifier of the session.
    - idle_s: Time since the last state, or since the session was opened, s.
    - method: Resolution method.
    - period_s: Control period T, s: the time from one state to the next, as your loop keeps it.
    - robot: Name of the robot, from `GET /v1/robots`.
    - solver: Solver.
    - steps: Number of states answered by a step.
    """

    id: str
    """Identifier of the session."""
    idle_s: float
    """Time since the last state, or since the session was opened, s."""
    method: Method
    """Resolution method."""
    period_s: float
    """Control period T, s: the time from one state to the next, as your loop keeps it."""
    robot: str
    """Name of the robot, from `GET /v1/robots`."""
    solver: Solver
    """Solver."""
    steps: int
    """Number of states answered by a step."""


class SessionList(Answer):
    """Answer to `GET /v1/controllers`.

    Fields:

    - controllers: Open sessions, the one with the most recent step first.
    """

    controllers: list[SessionEntry]
    """Open sessions, the one with the most recent step first."""


class SessionStatus(Answer):
    """Answer to `GET /v1/controllers/{id}`.

    Fields:

    - controller: Configuration of the controller. Fields that equal their default may be left out.
    - id: Identifier of the session.
    - retries: Number of repeated states, which got the same answer again.
    - steps: Number of states answered by a step.
    - last_sequence: Sequence number of the last state; `null` before the first.
    - missed_periods: Number of steps that came more than 1.5 periods after the previous step.
    """

    controller: ControllerConfig
    """Configuration of the controller. Fields that equal their default may be left out."""
    id: str
    """Identifier of the session."""
    retries: int
    """Number of repeated states, which got the same answer again."""
    steps: int
    """Number of states answered by a step."""
    last_sequence: int | None = None
    """Sequence number of the last state; `null` before the first."""
    missed_periods: int | None = None
    """Number of steps that came more than 1.5 periods after the previous step."""


class TargetAhead(Body):
    """A target of a later time. It has the same fields as the target with which it comes.

    Fields:

    - after_s: Time after `time_s` of the target, s; at least 1 µs after the one before it, at most 2.
    - joint_position: Target positions of the joints of the task at that time, in their order or by name, rad or m.
    - pose: Target pose at that time.
    """

    after_s: float
    """Time after `time_s` of the target, s; at least 1 µs after the one before it, at most 2."""
    joint_position: JointVector | None = None
    """Target positions of the joints of the task at that time, in their order or by name, rad or m."""
    pose: StreamedPose | None = None
    """Target pose at that time."""


class StreamedTarget(Body):
    """One target of a task. The law of the task decides which fields it has.  The laws `pose` and `impedance` accept
    `pose`, `posture` accepts `joint_position`, `velocity` accepts `velocity`, `force` and `contact` accept `force`, and
    `hybrid` accepts `pose`, `force` or both. A `pose` or a `joint_position` can have its `velocity`.

    Fields:

    - ahead: Where a `pose` or a `joint_position` will be in the next seconds, in the order of time; default:
      unknown. Laws with `path` use it.
    - align: Which actions of a `chunk` that comes late are past; default `time`.
    - chunk: Actions of the next seconds, as a policy computes them at once, in place of the other fields: 1 to 256
      of one kind, in the order of their times. The task follows a smooth curve through them. A chunk replaces the
      actions of earlier ones from its first time on; the offset to the motion before it fades in `fade_s`.
    - force: Target force F_d per row, N and N·m.
    - joint_position: Target positions of the joints of the task, in their order or by name, rad or m.
    - pose: Target pose. It replaces `target_pose` and `target_displacement` of the law.
    - time_s: Time of the target on the clock of the states, s; default: the time of the state; at most 1 s after
      it.
    - velocity: Target velocity per row, m/s and rad/s; of a `pose`: along the axes of the task's frame, for the
      frame `tool` those of the target. Default for a `pose` or a `joint_position`: estimated from the last targets.
    """

    ahead: list[TargetAhead] | None = None
    """Where a `pose` or a `joint_position` will be in the next seconds, in the order of time; default: unknown. Laws
    with `path` use it."""
    align: ChunkAlign | None = None
    """Which actions of a `chunk` that comes late are past; default `time`."""
    chunk: list[ChunkAction] | None = None
    """Actions of the next seconds, as a policy computes them at once, in place of the other fields: 1 to 256 of one
    kind, in the order of their times. The task follows a smooth curve through them. A chunk replaces the actions of
    earlier ones from its first time on; the offset to the motion before it fades in `fade_s`."""
    force: Vector | None = None
    """Target force F_d per row, N and N·m."""
    joint_position: JointVector | None = None
    """Target positions of the joints of the task, in their order or by name, rad or m."""
    pose: StreamedPose | None = None
    """Target pose. It replaces `target_pose` and `target_displacement` of the law."""
    time_s: float | None = None
    """Time of the target on the clock of the states, s; default: the time of the state; at most 1 s after it."""
    velocity: Vector | None = None
    """Target velocity per row, m/s and rad/s; of a `pose`: along the axes of the task's frame, for the frame `tool`
    those of the target. Default for a `pose` or a `joint_position`: estimated from the last targets."""


class SimulationControl(Body):
    """`POST /v1/simulations/{id}/control`: changes to a run. A field that is left out changes nothing.

    Fields:

    - controller: New controller. It may differ from the present one in method, solver, `why` and the laws
      `contact`, `force`, `impedance`, `hybrid`.
    - end: Whether to finish the run now and keep its trace so far; a paused run does one more period. Default
      `false`.
    - external_force: External force on the tool, N, base axes. Send it again at least once a second: it ends 1 s
      (real time) after the last request that sets it. Shape: 3.
    - method: New resolution method. The change is blended over 0.1 s of simulated time.
    - paused: Whether the run pauses, or goes on.
    - solver: New solver; the joint velocities change only if one of both is `closed_form`.
    - speed: Simulated seconds per second of real time; less than 1 to watch a contact.
    - step: Number of control periods to run before the run pauses.
    - targets: New targets by task name, without `time_s`: part of the next state. Between targets the task
      interpolates or extrapolates, as its `streaming` says.
    """

    controller: ControllerConfig | None = None
    """New controller. It may differ from the present one in method, solver, `why` and the laws `contact`, `force`,
    `impedance`, `hybrid`."""
    end: bool | None = None
    """Whether to finish the run now and keep its trace so far; a paused run does one more period. Default `false`."""
    external_force: Vector | None = None
    """External force on the tool, N, base axes. Send it again at least once a second: it ends 1 s (real time) after the
    last request that sets it. Shape: 3."""
    method: Method | None = None
    """New resolution method. The change is blended over 0.1 s of simulated time."""
    paused: bool | None = None
    """Whether the run pauses, or goes on."""
    solver: Solver | None = None
    """New solver; the joint velocities change only if one of both is `closed_form`."""
    speed: float | None = None
    """Simulated seconds per second of real time; less than 1 to watch a contact."""
    step: int | None = None
    """Number of control periods to run before the run pauses."""
    targets: dict[str, StreamedTarget] | None = None
    """New targets by task name, without `time_s`: part of the next state. Between targets the task interpolates or
    extrapolates, as its `streaming` says."""


class SimulationRequest(Body):
    """A simulation to run.

    Fields:

    - scenario: Name of a scenario from `GET /v1/scenarios`, or a whole scenario.
    - interactive: Interactive run: paced by the clock, shown live, and controlled by `POST
      /v1/simulations/{id}/control`. If left out, the simulation runs as fast as possible.
    - method: Method, instead of the method of the scenario. Set it to compare.
    - solver: Solver, instead of the solver of the scenario. Set it to compare.
    """

    scenario: NamedScenario
    """Name of a scenario from `GET /v1/scenarios`, or a whole scenario."""
    interactive: Interactive | None = None
    """Interactive run: paced by the clock, shown live, and controlled by `POST /v1/simulations/{id}/control`. If left
    out, the simulation runs as fast as possible."""
    method: Method | None = None
    """Method, instead of the method of the scenario. Set it to compare."""
    solver: Solver | None = None
    """Solver, instead of the solver of the scenario. Set it to compare."""


class StabilityAnswer(Answer):
    """The stability margins of a loop.

    Fields:

    - spectral_radius: Spectral radius of the loop from period to period; stable below 1.
    - stable: Whether the loop is stable.
    - stable_at_any_lag: Whether the loop is stable at any lag.
    - largest_damping: Damping B_d above `smallest_damping` at which the loop becomes unstable again; `null` if
      there is none.
    - largest_delay_periods: Delay up to which the loop stays stable from the stated one on, or else from zero on,
      control periods, at most 64; `null` if it is stable at neither.
    - largest_lag_s: Maximum lag at which the loop is stable, s; `null` if there is none, or if `stable_at_any_lag`.
      A loop that is unstable at a shorter lag needs a longer one.
    - smallest_damping: Minimum damping B_d at which the loop is stable; `null` if there is none.
    """

    spectral_radius: float
    """Spectral radius of the loop from period to period; stable below 1."""
    stable: bool
    """Whether the loop is stable."""
    stable_at_any_lag: bool
    """Whether the loop is stable at any lag."""
    largest_damping: float | None = None
    """Damping B_d above `smallest_damping` at which the loop becomes unstable again; `null` if there is none."""
    largest_delay_periods: int | None = None
    """Delay up to which the loop stays stable from the stated one on, or else from zero on, control periods, at most
    64; `null` if it is stable at neither."""
    largest_lag_s: float | None = None
    """Maximum lag at which the loop is stable, s; `null` if there is none, or if `stable_at_any_lag`. A loop that is
    unstable at a shorter lag needs a longer one."""
    smallest_damping: float | None = None
    """Minimum damping B_d at which the loop is stable; `null` if there is none."""


class StabilityRequest(Body):
    """One axis of a law in contact. Linear: kg, N·s/m, N/m; angular: kg·m², N·m·s/rad, N·m/rad.

    Fields:

    - damping: Damping B_d of the law, as in the task; the answer names the minimum.
    - environment: Environment that the tool touches. Take the stiffest one that it can meet.
    - inertia: Inertia M_d > 0 of the law, as in the task.
    - period_s: Control period T, s, as in the controller.
    - delay_periods: Delay of a command, control periods: from the measurement to the motion that its answer causes.
      Default 0.
    - lag_s: Lag τ of the arm's velocity loop, s. Take a measured one; 0 is an ideal arm. Default 0.
    - stiffness: Stiffness K_d of the law; default 0, as on a force-controlled axis.
    - velocity_measured: Whether states contain the measured joint velocity; otherwise the last command replaces it.
      Default `true`.
    """

    damping: float
    """Damping B_d of the law, as in the task; the answer names the minimum."""
    environment: EnvironmentAxis
    """Environment that the tool touches. Take the stiffest one that it can meet."""
    inertia: float
    """Inertia M_d > 0 of the law, as in the task."""
    period_s: float
    """Control period T, s, as in the controller."""
    delay_periods: int | None = None
    """Delay of a command, control periods: from the measurement to the motion that its answer causes. Default 0."""
    lag_s: float | None = None
    """Lag τ of the arm's velocity loop, s. Take a measured one; 0 is an ideal arm. Default 0."""
    stiffness: float | None = None
    """Stiffness K_d of the law; default 0, as on a force-controlled axis."""
    velocity_measured: bool | None = None
    """Whether states contain the measured joint velocity; otherwise the last command replaces it. Default `true`."""


class State(Body):
    """The measured state of one control period.

    Fields:

    - joint_position: Measured joint position q, rad or m, in joint order or by name.
    - sequence: Sequence number of the period; must increase. Repeat it only with an unchanged state, to get the
      same answer again.
    - time_s: Time t of the measurement, s, on any clock that runs evenly. Profiles count on the same clock; on the
      clock of Unix (times above 1e9 s) they count from the first state.
    - channels: What arrived for the channels of the controller, by name; default: nothing.
    - joint_velocity: Measured joint velocity q̇, rad/s or m/s. Omit it if the arm measures only positions or its
      velocities are noisy; default: the last command.
    - obstacles: Where the moving obstacles of the controller are; each must be named. Default: none.
    - targets: New targets by task name, if any arrived since the last state; default: none. Between targets the
      task interpolates or extrapolates, as its `streaming` says.
    - wrench: Measured wrench: without the weight of the tool, or the raw reading of the controller's
      `wrench_sensor`; required by the laws `contact`, `force`, `impedance` and `hybrid`, and by a `wrench_sensor`,
      also one that a tare has added.
    - wrenches: Measured wrenches of tips other than the tool, by the name of the tip, without the weight of what
      the tip carries unless the controller has its sensor in `wrench_sensors`; required by the same laws of tasks
      whose `link` is such a tip. Axes are those of `wrench_frame`: of the base, or of the tip itself. Default:
      none.
    """

    joint_position: JointVector
    """Measured joint position q, rad or m, in joint order or by name."""
    sequence: int
    """Sequence number of the period; must increase. Repeat it only with an unchanged state, to get the same answer
    again."""
    time_s: float
    """Time t of the measurement, s, on any clock that runs evenly. Profiles count on the same clock; on the clock of
    Unix (times above 1e9 s) they count from the first state."""
    channels: dict[str, ChannelInput] | None = None
    """What arrived for the channels of the controller, by name; default: nothing."""
    joint_velocity: JointVector | None = None
    """Measured joint velocity q̇, rad/s or m/s. Omit it if the arm measures only positions or its velocities are noisy;
    default: the last command."""
    obstacles: list[ObstacleState] | None = None
    """Where the moving obstacles of the controller are; each must be named. Default: none."""
    targets: dict[str, StreamedTarget] | None = None
    """New targets by task name, if any arrived since the last state; default: none. Between targets the task
    interpolates or extrapolates, as its `streaming` says."""
    wrench: Wrench | None = None
    """Measured wrench: without the weight of the tool, or the raw reading of the controller's `wrench_sensor`; required
    by the laws `contact`, `force`, `impedance` and `hybrid`, and by a `wrench_sensor`, also one that a tare has
    added."""
    wrenches: dict[str, Wrench] | None = None
    """Measured wrenches of tips other than the tool, by the name of the tip, without the weight of what the tip carries
    unless the controller has its sensor in `wrench_sensors`; required by the same laws of tasks whose `link` is such a
    tip. Axes are those of `wrench_frame`: of the base, or of the tip itself. Default: none."""


class StuckTask(Answer):
    """A task that makes no progress: over half a second, it achieves less than 5 % of the velocity that it requests, or
    less than 5 % of its request is passed on, see `request_share`.

    Fields:

    - held_by: What holds it back; empty while the arm leaves the posture, and where nothing but its own request
      does, which fades.
    - leaving: Whether the arm leaves the posture, by a motion towards the middle of the ranges of its joints.
    - since_s: Time since which it makes no progress, or since which requests fade, s.
    - task: Name of the task.
    """

    held_by: list[Obstacle]
    """What holds it back; empty while the arm leaves the posture, and where nothing but its own request does, which
    fades."""
    leaving: bool
    """Whether the arm leaves the posture, by a motion towards the middle of the ranges of its joints."""
    since_s: float
    """Time since which it makes no progress, or since which requests fade, s."""
    task: str
    """Name of the task."""


class StepAnswer(Answer):
    """Joint velocities for one control period and their explanation.

    Fields:

    - active_limits: Active limits: bounds that the answer reaches and that restrict it.
    - braking_deceleration: Deceleration with which a watchdog brakes each joint without `stop_time_s`, in joint
      order, rad/s² or m/s²; `null`: stop at once. With it every joint stops inside its range after `valid_for_ms`,
      if the `limits` include positions and the `solver` is not `closed_form`.
    - elapsed_us: Time to compute the answer, µs.
    - joint_limit_index: Joint-limit index H: 0 with all joints in the middle of their ranges, ½ with all at a
      limit.
    - joint_velocity: Joint velocity q̇, the command, in joint order, rad/s or m/s.
    - limit_conflict: Names of joints whose acceleration or jerk limit contradicts position or velocity limits and
      is not kept.
    - sequence: Sequence number of the state.
    - singularity: Distance of the tasks from singularities.
    - solver: Solver path, status and optimality check.
    - tasks: Outcome of each task, highest priority first.
    - valid_for_ms: Validity of the command from the time of measurement, ms. Without a newer answer, brake the
      joints then: together within `stop_time_s`, or each at `braking_deceleration` if there is none. At most the
      controller's `valid_for_ms`; shorter, but at least a period (in whole ms, rounded down, and at least 1), if a
      joint would otherwise leave its range before it stops, if the `limits` include positions and the `solver` is
      not `closed_form`. Obstacles, and a tool that approaches or presses with the law `contact`, shorten it too.
    - violated_limits: Violated limits. The solver `closed_form` may violate all; others exceed only speed limits
      that `limits` do not contain.
    - active_inequalities: Active inequalities.
    - channels: Commands of the channels by name, m, rad, N or N·m; a channel without target so far is absent.
    - collisions: Distances of the shapes; absent: the controller watches none.
    - contradictions: Contradictions: minimal sets of demands that cannot all be kept.
    - fading_since_s: Time since which the requests fade, s; default: they do not.
    - memory: Memory to send with the next state; only in answers without a session.
    - request_share: Share of the requests that remains, 0 to 1, because joints turn again and again although no
      task gains by it. At 0 the arm rests, perhaps short of its targets, until a target changes. Default: 1.
    - stop_time_s: Time in which a watchdog lowers the speeds of all joints evenly to rest, s, so that the tool
      keeps its direction: `joint_velocity` times 1 − t/`stop_time_s`. No joint then brakes faster than at its
      `braking_deceleration`, and every joint stops inside its range on the same terms. Absent: each joint brakes at
      its own. The law `contact` sets it where stopping together presses less, if the controller keeps no distances
      to obstacles.
    - stuck_tasks: Tasks that make no progress, and what holds them back.
    - violated_inequalities: Violated inequalities.
    - warnings: Warnings: what is not plausible about the state, and what to do.
    - why: Sentences that say what restricts the joint velocities, then what each task gives up; only if the
      controller has `"why": true`.
    - wrench: Wrench with which the laws computed: corrected, of the tool on the environment, at the tool point,
      base axes; absent without `wrench_sensor`.
    - wrenches: The same of tips with a sensor in `wrench_sensors`, by the name of the tip.
    """

    active_limits: list[ActiveLimit]
    """Active limits: bounds that the answer reaches and that restrict it."""
    braking_deceleration: FloatArray
    """Deceleration with which a watchdog brakes each joint without `stop_time_s`, in joint order, rad/s² or m/s²;
    `null`: stop at once. With it every joint stops inside its range after `valid_for_ms`, if the `limits` include
    positions and the `solver` is not `closed_form`."""
    elapsed_us: float
    """Time to compute the answer, µs."""
    joint_limit_index: float
    """Joint-limit index H: 0 with all joints in the middle of their ranges, ½ with all at a limit."""
    joint_velocity: FloatArray
    """Joint velocity q̇, the command, in joint order, rad/s or m/s."""
    limit_conflict: list[str]
    """Names of joints whose acceleration or jerk limit contradicts position or velocity limits and is not kept."""
    sequence: int
    """Sequence number of the state."""
    singularity: Singularity
    """Distance of the tasks from singularities."""
    solver: SolverReport
    """Solver path, status and optimality check."""
    tasks: list[TaskOutcome]
    """Outcome of each task, highest priority first."""
    valid_for_ms: int
    """Validity of the command from the time of measurement, ms. Without a newer answer, brake the joints then: together
    within `stop_time_s`, or each at `braking_deceleration` if there is none. At most the controller's `valid_for_ms`;
    shorter, but at least a period (in whole ms, rounded down, and at least 1), if a joint would otherwise leave its
    range before it stops, if the `limits` include positions and the `solver` is not `closed_form`. Obstacles, and a
    tool that approaches or presses with the law `contact`, shorten it too."""
    violated_limits: list[ViolatedLimit]
    """Violated limits. The solver `closed_form` may violate all; others exceed only speed limits that `limits` do not
    contain."""
    active_inequalities: list[ActiveInequality] = Field(default_factory=list)
    """Active inequalities."""
    channels: dict[str, float] | None = None
    """Commands of the channels by name, m, rad, N or N·m; a channel without target so far is absent."""
    collisions: CollisionReport | None = None
    """Distances of the shapes; absent: the controller watches none."""
    contradictions: list[Contradiction] = Field(default_factory=list)
    """Contradictions: minimal sets of demands that cannot all be kept."""
    fading_since_s: float | None = None
    """Time since which the requests fade, s; default: they do not."""
    memory: Memory | None = None
    """Memory to send with the next state; only in answers without a session."""
    request_share: float | None = None
    """Share of the requests that remains, 0 to 1, because joints turn again and again although no task gains by it. At
    0 the arm rests, perhaps short of its targets, until a target changes. Default: 1."""
    stop_time_s: float | None = None
    """Time in which a watchdog lowers the speeds of all joints evenly to rest, s, so that the tool keeps its direction:
    `joint_velocity` times 1 − t/`stop_time_s`. No joint then brakes faster than at its `braking_deceleration`, and
    every joint stops inside its range on the same terms. Absent: each joint brakes at its own. The law `contact` sets
    it where stopping together presses less, if the controller keeps no distances to obstacles."""
    stuck_tasks: list[StuckTask] = Field(default_factory=list)
    """Tasks that make no progress, and what holds them back."""
    violated_inequalities: list[ViolatedInequality] = Field(default_factory=list)
    """Violated inequalities."""
    warnings: list[str] = Field(default_factory=list)
    """Warnings: what is not plausible about the state, and what to do."""
    why: list[str] = Field(default_factory=list)
    """Sentences that say what restricts the joint velocities, then what each task gives up; only if the controller has
    `"why": true`."""
    wrench: Wrench | None = None
    """Wrench with which the laws computed: corrected, of the tool on the environment, at the tool point, base axes;
    absent without `wrench_sensor`."""
    wrenches: dict[str, Wrench] | None = None
    """The same of tips with a sensor in `wrench_sensors`, by the name of the tip."""


class StepRequest(Body):
    """`POST /v1/step`: controller, state and memory in one body, without a session.

    Fields:

    - controller: Controller; the same in every step, so that the service finds it again.
    - state: Measured state.
    - memory: Memory of the last answer, unchanged; `null` at the first step.
    """

    controller: ControllerConfig
    """Controller; the same in every step, so that the service finds it again."""
    state: State
    """Measured state."""
    memory: Memory | None = None
    """Memory of the last answer, unchanged; `null` at the first step."""


class TareAnswer(Answer):
    """What taring found. The session uses it from the next state on.

    Fields:

    - bias: Bias of the sensor, for `bias` of `wrench_sensor` in later controllers.
    - force_noise_n: Noise of a reading along the noisiest axis, rms, N. The field `noise` of the law `contact`
      wants it.
    - torque_noise_nm: Noise of a reading along the noisiest axis, rms, N·m.
    - warnings: Warnings: a weight that is not known.
    """

    bias: Wrench
    """Bias of the sensor, for `bias` of `wrench_sensor` in later controllers."""
    force_noise_n: float
    """Noise of a reading along the noisiest axis, rms, N. The field `noise` of the law `contact` wants it."""
    torque_noise_nm: float
    """Noise of a reading along the noisiest axis, rms, N·m."""
    warnings: list[str] = Field(default_factory=list)
    """Warnings: a weight that is not known."""


class TareRequest(Body):
    """`POST /v1/controllers/{id}/tare`: readings at rest, in one posture, without contact.

    Fields:

    - readings: At least 20 readings. More leave less noise in the bias.
    - tip: Name of the tip whose sensor is read; default: the tool.
    """

    readings: list[RestReading]
    """At least 20 readings. More leave less noise in the bias."""
    tip: str | None = None
    """Name of the tip whose sensor is read; default: the tool."""


class WatchedStep(Answer):
    """One control period of a session, as `GET /v1/controllers/{id}/watch` shows it.

    Fields:

    - answer: The answer to it.
    - state: The measured state.
    - arm: The arm at this state, for drawing.
    """

    answer: StepAnswer
    """The answer to it."""
    state: State
    """The measured state."""
    arm: ArmView | None = None
    """The arm at this state, for drawing."""
