"""The bodies of requests and answers. Generated from the OpenAPI document by `generate.py`; do not edit."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from revprio.bodies import Answer, ArrayLike, Body, FloatArray, JointVector, Tagged


__all__ = [
    "ActiveInequality",
    "ActiveLimit",
    "ActiveLimitName",
    "ArmView",
    "Axis",
    "BatchAnswer",
    "BatchItem",
    "BatchRequest",
    "ConstantProfile",
    "Contact",
    "ContactKind",
    "ControllerConfig",
    "ControllerTask",
    "CreatedController",
    "Damping",
    "DenavitHartenberg",
    "Environment",
    "EnvironmentAxis",
    "ExplicitLimits",
    "Faults",
    "ForceLaw",
    "Frame",
    "FramePose",
    "Friction",
    "HybridLaw",
    "ImpedanceLaw",
    "Inequality",
    "Interactive",
    "JointKind",
    "JointLimitsNullSpaceMotion",
    "JointView",
    "JointsInequality",
    "KinematicsAnswer",
    "KinematicsRequest",
    "Law",
    "LimitKind",
    "Limits",
    "LinkFrame",
    "LiveFrame",
    "LiveSample",
    "Memory",
    "Method",
    "NamedScenario",
    "NullSpaceMotion",
    "NullSpaceVelocity",
    "Orientation",
    "Outage",
    "Path",
    "PathCounts",
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
    "REMEDIES",
    "RampProfile",
    "ResolveAnswer",
    "ResolveRequest",
    "ResolveTask",
    "Robot",
    "RobotJoint",
    "RobotList",
    "RobotRegistration",
    "RobotSource",
    "Scenario",
    "ScenarioEntry",
    "ScenarioList",
    "Sensor",
    "Sensors",
    "SessionEntry",
    "SessionList",
    "SessionStatus",
    "Side",
    "Simulation",
    "SimulationControl",
    "SimulationMetrics",
    "SimulationRequest",
    "SimulationState",
    "SineProfile",
    "Singularity",
    "Solver",
    "SolverReport",
    "StabilityAnswer",
    "StabilityRequest",
    "State",
    "Status",
    "StepAnswer",
    "StepRequest",
    "StepsProfile",
    "TargetPose",
    "TaskOutcome",
    "TimeHistogram",
    "VelocityLaw",
    "VelocityLoop",
    "ViolatedInequality",
    "ViolatedLimit",
    "WatchedStep",
    "WaypointsProfile",
    "Wrench",
    "WrenchConvention",
    "WrenchFrame",
]


class ActiveInequality(Answer):
    """An inequality that holds the answer back."""

    bound: float
    """b."""
    multiplier: float
    """How much ½ residual² of the highest task that it holds back would fall per unit of a larger b."""
    name: str
    """Its name."""


Side = Literal["lower", "upper"]
"""A bound of a joint."""


class ActiveLimit(Answer):
    """A limit that holds the answer back."""

    joint: str
    """Joint name."""
    multiplier: float
    """How much ½ residual² of the highest task that the limit holds back would fall per unit of a wider bound."""
    side: Side
    """Which bound."""
    value: float
    """The bound, rad/s or m/s."""


class ActiveLimitName(Body):
    """A limit by joint and side, or an inequality by name."""

    side: Side
    """Which bound; inequalities have an upper one."""
    inequality: str | None = None
    """Name of an inequality, for that."""
    joint: str | None = None
    """Joint name, for a bound of a joint."""


class JointView(Answer):
    """A joint in space and the velocities that it may have."""

    axis: FloatArray
    """Direction of its axis, base frame, of unit length."""
    origin: FloatArray
    """A point of its axis, base frame, m."""
    lower: float | None = None
    """Smallest velocity that the limits allow in this period, rad/s or m/s; `null` without a bound."""
    upper: float | None = None
    """Largest velocity that they allow."""


class Orientation(Body):
    """A unit quaternion."""

    w: float
    """Scalar part."""
    x: float
    """x of the vector part."""
    y: float
    """y of the vector part."""
    z: float
    """z of the vector part."""


class Pose(Body):
    """A pose, in the frame that its field names."""

    orientation: Orientation
    """Orientation."""
    position: ArrayLike
    """x, y, z, m. Shape: 3."""


class ArmView(Answer):
    """An arm at a posture, for drawing it."""

    joints: list[JointView]
    """The joints, base first."""
    tool: Pose
    """The tool in the base frame."""


Axis = Literal["x", "y", "z", "rx", "ry", "rz"]
"""One row of a twist, at the point and along the axes of its task."""


class Singularity(Answer):
    """How near the tasks are to singularities."""

    algorithmic: bool
    """Whether a task depends on lower ones."""
    manipulability: float
    """Product of their singular values."""
    smallest_singular_value: float
    """σ_min of all task rows together."""


Path = Literal["closed_form", "active_set", "qp"]
"""Which way led to an answer."""

Status = Literal["optimal", "not_certified", "failed"]
"""How sure an answer is."""


class SolverReport(Answer):
    """How the answer was found and how sure it is."""

    iterations: int
    """Iterations of Clarabel over all levels."""
    path: Path
    """Which way led to it."""
    status: Status
    """How sure it is."""
    failures: int | None = None
    """Levels that Clarabel failed to solve; an exact active-set method stood in."""
    kkt_residual: float | None = None
    """Largest relative residual of the optimality conditions; `null` without an answer or beyond the numbers, never
    when `status` is `optimal`."""


class TaskOutcome(Answer):
    """What became of one task."""

    achieved: FloatArray
    """J_k q̇, m/s and rad/s."""
    algorithmic: bool
    """Whether the task depends on lower ones: its rank and theirs add up to more than that of all together, Eq.
    (12)."""
    name: str
    """The task's name."""
    rank: int
    """Rank of J_k."""
    requested: FloatArray
    """ẋ_k, m/s and rad/s."""
    residual_norm: float
    """‖J_k q̇ − ẋ_k‖."""
    scale: float | None = None
    """s of a task with `"scale": true`, J_k q̇ = s ẋ_k; left out where no s keeps its direction."""
    target_force: FloatArray | None = None
    """F_d of this period per row, N and N·m, `null` where no force is followed; only in answers to a state."""


class ViolatedLimit(Answer):
    """A limit that the answer breaks; only the solver `closed_form` does."""

    joint: str
    """Joint name."""
    limit: float
    """The bound, rad/s or m/s."""
    side: Side
    """Which bound."""
    value: float
    """The velocity, rad/s or m/s."""


class ViolatedInequality(Answer):
    """An inequality that the answer breaks: by the solver `closed_form`, or because the joint limits leave no other
    way."""

    bound: float
    """b."""
    name: str
    """Its name."""
    value: float
    """a·q̇."""


class ResolveAnswer(Answer):
    """Joint velocities and why they are what they are."""

    active_limits: list[ActiveLimit]
    """Limits that hold the answer back."""
    elapsed_us: float
    """Time to compute it, µs."""
    joint_velocity: FloatArray
    """q̇, rad/s or m/s."""
    limit_conflict: list[str]
    """Joints whose acceleration limit was overruled by position or velocity."""
    singularity: Singularity
    """How near the tasks are to singularities."""
    solver: SolverReport
    """How the answer was found."""
    tasks: list[TaskOutcome]
    """What became of each task, highest priority first."""
    violated_limits: list[ViolatedLimit]
    """Limits that the answer breaks."""
    active_inequalities: list[ActiveInequality] = Field(default_factory=list)
    """Inequalities that hold the answer back."""
    joint_limit_index: float | None = None
    """H, how near the joints are to the ends of their ranges: 0 with all in the middle, ½ with all at an end; only
    where robot and posture are given."""
    violated_inequalities: list[ViolatedInequality] = Field(default_factory=list)
    """Inequalities that the answer breaks."""


class Problem(Answer):
    """What was wrong with a request and what to do about it."""

    detail: str
    """This occurrence in words, with the remedy."""
    status: int
    """HTTP status."""
    title: str
    """The kind in words."""
    type: Literal[
        "/problems/malformed",
        "/problems/unauthorized",
        "/problems/permanent",
        "/problems/foreign-origin",
        "/problems/not-found",
        "/problems/unknown-controller",
        "/problems/method-not-allowed",
        "/problems/not-acceptable",
        "/problems/timeout",
        "/problems/sequence",
        "/problems/name-taken",
        "/problems/no-trace",
        "/problems/not-live",
        "/problems/too-large",
        "/problems/media-type",
        "/problems/invalid",
        "/problems/upgrade-required",
        "/problems/internal",
        "/problems/too-many-controllers",
        "/problems/too-many-robots",
        "/problems/busy",
        "/problems/overloaded",
        "/problems/draining",
    ]
    """Stable identifier of the kind of problem, a relative reference."""
    pointer: str | None = None
    """JSON pointer of the offending field, where there is one."""
    request_id: str | None = None
    """Name of the request, as in the header `x-request-id` and in the log."""


BatchItem = ResolveAnswer | Problem
"""What became of one."""


class BatchAnswer(Answer):
    """What became of them."""

    items: list[BatchItem]
    """One answer or problem for each, in the order of the request."""


Frame = Literal["base", "tool"] | Pose
"""Along which axes a task counts: those of the base, those of the tool, or those of a frame with this pose in the
base (m, unit quaternion); target poses are counted in such a frame."""


class ResolveTask(Body):
    """One task: axes of the tool, or rows of its own."""

    velocity: ArrayLike
    """ẋ_k, m/s and rad/s, one entry per row."""
    axes: list[Axis] | None = None
    """Rows of the tool Jacobian."""
    frame: Frame | None = None
    """Along which axes the rows count."""
    jacobian: ArrayLike | None = None
    """Own rows, m × n."""
    name: str | None = None
    """Name; `task 1`, `task 2`, … if left out."""
    reference_point: ArrayLike | None = None
    """The point at which they count: x, y, z in the tool frame, m; the tool point if left out. Shape: 3."""
    scale: bool | None = None
    """Whether limits may slow the task down, but not bend it: J_k q̇ = s ẋ_k with the largest s ≤ 1."""


class Damping(Body):
    """Damping that sets in near a singularity."""

    max_factor: float
    """λ_max ≥ 0, the factor at a singular value of zero."""
    threshold: float
    """δ > 0, the smallest singular value below which damping acts."""


class JointsInequality(Tagged):
    """a·q̇ ≤ b."""

    coefficients: ArrayLike
    """a, one per joint, in joint order."""
    kind: Literal["joints"] = "joints"
    """Says which."""
    upper: float
    """b, rad/s times the unit of a."""
    name: str | None = None
    """Name, unique in the list; `inequality 1`, `inequality 2`, … if left out."""


class PlaneInequality(Tagged):
    """A point of the arm stays on one side of a plane: n·ṗ ≤ rate (offset − n·p)."""

    kind: Literal["plane"] = "plane"
    """Says which."""
    normal: ArrayLike
    """n, base frame, towards the forbidden side; its length does not matter. Shape: 3."""
    offset_m: float
    """Distance of the plane from the base along n, m."""
    name: str | None = None
    """Name, unique in the list; `inequality 1`, `inequality 2`, … if left out."""
    point: str | None = None
    """`tool`, or the name of a joint whose frame origin is held back."""
    rate_per_s: float | None = None
    """How fast the distance may close, 1/s; 10 if left out, at most one over the period."""


Inequality = Annotated[JointsInequality | PlaneInequality, Field(discriminator="kind")]
"""What the joint velocities must obey beside the box."""

LimitKind = Literal["none", "velocity", "position_velocity", "position_velocity_acceleration"]
"""Which of the robot's limits count."""


class ExplicitLimits(Body):
    """lower ≤ q̇ ≤ upper, rad/s or m/s."""

    lower: ArrayLike
    """Lower bounds, n."""
    upper: ArrayLike
    """Upper bounds, n."""


Limits = LimitKind | ExplicitLimits
"""The robot's own limits by name, or a box of joint velocities."""

Method = Literal[
    "pseudoinverse",
    "damped_least_squares",
    "task_priority",
    "singularity_robust",
    "reverse_priority",
    "strict_reverse_priority",
]
"""How priorities are understood."""


class JointLimitsNullSpaceMotion(Tagged):
    """−k ∇H, away from the ends of the joints' ranges."""

    gain: float
    """k, rad²/s or m²/s."""
    kind: Literal["joint_limits"] = "joint_limits"
    """Says which."""


class PostureNullSpaceMotion(Tagged):
    """K (q_d − q), towards a posture."""

    gain: float
    """K, 1/s."""
    joint_position: JointVector
    """q_d, rad or m."""
    kind: Literal["posture"] = "posture"
    """Says which."""


NullSpaceMotion = Annotated[JointLimitsNullSpaceMotion | PostureNullSpaceMotion, Field(discriminator="kind")]
"""A velocity that depends on the posture."""

NullSpaceVelocity = NullSpaceMotion | JointVector
"""ζ̇ as such, or what makes it from the posture."""

Solver = Literal["closed_form", "qp", "auto"]
"""How the problem is solved."""


class ResolveRequest(Body):
    """Prioritised tasks at one posture."""

    tasks: list[ResolveTask]
    """The tasks, highest priority first."""
    damping: Damping | None = None
    """Damping near singularities; none (exact) if left out."""
    inequalities: list[Inequality] | None = None
    """What the velocities must obey beside the limits."""
    joint_position: JointVector | None = None
    """q, rad or m."""
    joint_velocity: JointVector | None = None
    """q̇⁻, the last command, rad/s or m/s; for acceleration limits."""
    limits: Limits | None = None
    """Allowed joint velocities; default `position_velocity` with a robot and a period, else `none`."""
    method: Method | None = None
    """How priorities are understood."""
    null_space_velocity: NullSpaceVelocity | None = None
    """ζ̇, what the joints do as far as the tasks allow; rest if left out."""
    period_s: float | None = None
    """T, s; for position and acceleration limits."""
    robot: str | None = None
    """Name of a robot; may be left out when every task has its own `jacobian`."""
    solver: Solver | None = None
    """How the problem is solved."""
    tool_offset: Pose | None = None
    """Where the tool point is, and how the tool's axes lie, in the robot's own tool frame; there if left out."""


class BatchRequest(Body):
    """Problems that have nothing to do with each other."""

    items: list[ResolveRequest]
    """The problems, 10 000 at most."""


ContactKind = Literal["spring", "wall", "plane"]
"""What kind of thing is touched."""


class Friction(Body):
    """Friction of a tool with velocity v along a surface that it presses with F_n: (μ F_n/√(v² + v_s²) + B_t) v."""

    coulomb: float | None = None
    """μ."""
    sticking_speed_m_s: float | None = None
    """v_s, m/s: below it dry friction falls towards zero, so that a tool at rest feels none."""
    viscous: float | None = None
    """B_t, N·s/m, wherever the tool touches."""


class ConstantProfile(Tagged):
    """The same for ever."""

    kind: Literal["constant"] = "constant"
    """Says which."""
    value: ArrayLike
    """The value."""


class SineProfile(Tagged):
    """offset + amplitude sin(ω t + φ)."""

    amplitude: ArrayLike
    """Swing."""
    angular_frequency_rad_s: float
    """ω, rad/s."""
    kind: Literal["sine"] = "sine"
    """Says which."""
    offset: ArrayLike
    """Mean value."""
    phase_rad: float | None = None
    """φ, rad."""


class RampProfile(Tagged):
    """Straight from one value to another; constant before and after."""

    duration_s: float
    """How long it takes, s."""
    end: ArrayLike
    """Last value."""
    kind: Literal["ramp"] = "ramp"
    """Says which."""
    start: ArrayLike
    """First value."""
    start_time_s: float | None = None
    """When it begins, s."""


class ProfilePoint(Body):
    """A value at a time."""

    time_s: float
    """t, s."""
    value: ArrayLike
    """The value then."""


class StepsProfile(Tagged):
    """The value of the last point whose time has come; of the first one before it."""

    kind: Literal["steps"] = "steps"
    """Says which."""
    points: list[ProfilePoint]
    """The points, in the order of their times."""


class WaypointsProfile(Tagged):
    """Smoothly through all points, at rest at the first and the last one."""

    kind: Literal["waypoints"] = "waypoints"
    """Says which."""
    points: list[ProfilePoint]
    """The points, in the order of their times."""


Profile = Annotated[
    ConstantProfile | SineProfile | RampProfile | StepsProfile | WaypointsProfile, Field(discriminator="kind")
]
"""A set-point over time."""


class Contact(Body):
    """A contact: F_e = M_e Ẍ + B_e Ẋ + K_e (X − X_0) along one direction, and friction across it.  Paper: Eq. (36).
    Departs: X_0, where the surface is, is not printed; it may move, and velocity and acceleration count relative to
    it."""

    kind: ContactKind
    """What it is."""
    stiffness: float
    """K_e, N/m."""
    axis: Literal["x", "y", "z"] | None = None
    """Base axis of a spring or a wall."""
    damping: float | None = None
    """B_e, N·s/m."""
    friction: Friction | None = None
    """Along a wall or a plane; none if left out."""
    inertia: float | None = None
    """M_e, kg."""
    motion: Profile | None = None
    """Added to `offset_m` over time, m, one value."""
    normal: ArrayLike | None = None
    """Direction out of a plane's material, base axes; of any length but zero. Shape: 3."""
    offset_m: float | None = None
    """X_0 from the tool's start position, m: along the axis, where a wall with a negative offset stands in the negative
    direction; of a plane, the tool's way to it against the normal."""


class VelocityLaw(Tagged):
    """ẋ as given."""

    kind: Literal["velocity"] = "velocity"
    """Says which."""
    target_velocity: Profile
    """ẋ, m/s and rad/s."""


TargetPose = Literal["initial"] | Pose
"""The pose that displacements are counted from: `initial`, where the tool was at the first step, or a pose of the
reference point (m, unit quaternion), in the task's stated frame where it has one, else in the base."""


class PoseLaw(Tagged):
    """Go to a pose: ẋ = ẋ_d + K (x_d − x)."""

    gain: ArrayLike
    """K, 1/s."""
    kind: Literal["pose"] = "pose"
    """Says which."""
    target_displacement: Profile | None = None
    """Added to X_d, m and rad (rotation vector)."""
    target_pose: TargetPose | None = None
    """X_d."""


PostureTarget = Literal["mid_range"] | Profile
"""Where a posture leads its joints: `mid_range`, the middle of their ranges, or positions over time, one per joint,
rad or m."""


class PostureLaw(Tagged):
    """Lead joints: q̇ = q̇_d + K (q_d − q), or −K ∇H towards the middle of their ranges."""

    gain: ArrayLike
    """K, one for all or one per joint, 1/s; towards `mid_range` rad²/s or m²/s."""
    kind: Literal["posture"] = "posture"
    """Says which."""
    target_position: PostureTarget
    """q_d."""
    joints: list[str] | None = None
    """Names of the joints; if left out all, towards `mid_range` all that have a range."""


class ForceLaw(Tagged):
    """Follow a force."""

    damping: ArrayLike
    """B_d, N·s/m and N·m·s/rad."""
    inertia: ArrayLike
    """M_d, kg and kg·m²."""
    kind: Literal["force"] = "force"
    """Says which."""
    target_force: Profile
    """F_d, N and N·m."""


class ImpedanceLaw(Tagged):
    """Behave as mass, damper and spring about a pose."""

    damping: ArrayLike
    """B_d, N·s/m and N·m·s/rad."""
    inertia: ArrayLike
    """M_d, kg and kg·m²."""
    kind: Literal["impedance"] = "impedance"
    """Says which."""
    stiffness: ArrayLike
    """K_d, N/m and N·m/rad."""
    target_displacement: Profile | None = None
    """Added to X_d, m and rad (rotation vector)."""
    target_pose: TargetPose | None = None
    """X_d."""


PerAxisBool = bool | list[bool]
"""One value that counts for every axis of the task, or a list with one value per axis."""


class HybridLaw(Tagged):
    """Some axes follow a force, the others a pose."""

    damping: ArrayLike
    """B_d, N·s/m and N·m·s/rad."""
    inertia: ArrayLike
    """M_d, kg and kg·m²."""
    kind: Literal["hybrid"] = "hybrid"
    """Says which."""
    position_controlled: PerAxisBool
    """S: true = position-controlled, false = force-controlled."""
    stiffness: ArrayLike
    """K_d, N/m and N·m/rad; counts on position-controlled axes."""
    target_force: Profile
    """F_d, N and N·m; counts on force-controlled axes."""
    target_displacement: Profile | None = None
    """Added to X_d, m and rad (rotation vector)."""
    target_pose: TargetPose | None = None
    """X_d."""


Law = Annotated[VelocityLaw | PoseLaw | PostureLaw | ForceLaw | ImpedanceLaw | HybridLaw, Field(discriminator="kind")]
"""How a task's velocity is made."""


class ControllerTask(Body):
    """One task with its law."""

    law: Law
    """How the task's velocity is made."""
    name: str
    """Name, unique in the controller."""
    axes: list[Axis] | None = None
    """Rows of the tool Jacobian; every law but `posture` needs them."""
    frame: Frame | None = None
    """Along which axes rows, displacements and wrench count."""
    reference_point: ArrayLike | None = None
    """The point at which rows, pose and wrench count: x, y, z in the tool frame, m; the tool point if left out. Shape:
    3."""
    scale: bool | None = None
    """Whether limits may slow the task down, but not bend it: J_k q̇ = s ẋ_k with the largest s ≤ 1."""


class EnvironmentAxis(Body):
    """M_e Ẍ + B_e Ẋ + K_e X on one axis."""

    stiffness: float
    """K_e."""
    damping: float | None = None
    """B_e."""
    inertia: float | None = None
    """M_e."""


class Environment(Body):
    """What a controller's tool touches and how the arm follows, as far as it is known: enough to be warned of a loop
    that bounces for ever. It changes no command."""

    delay_periods: int | None = None
    """Whole periods that a command waits."""
    lag_s: float | None = None
    """τ of the arm's velocity loop, s."""
    rx: EnvironmentAxis | None = None
    """About x."""
    ry: EnvironmentAxis | None = None
    """About y."""
    rz: EnvironmentAxis | None = None
    """About z."""
    velocity_measured: bool | None = None
    """Whether states will carry the measured joint velocity; otherwise the last command stands for it."""
    x: EnvironmentAxis | None = None
    """Along x, base axes."""
    y: EnvironmentAxis | None = None
    """Along y."""
    z: EnvironmentAxis | None = None
    """Along z."""


WrenchConvention = Literal["on_environment", "on_tool"]
"""Whose wrench a state carries."""

WrenchFrame = Literal["base", "tool"]
"""Along which axes a state carries its wrench."""


class ControllerConfig(Body):
    """Robot, tasks with their laws, method, solver, limits, period."""

    period_s: float
    """T, s."""
    robot: str
    """Name of a robot."""
    tasks: list[ControllerTask]
    """The tasks, highest priority first."""
    damping: Damping | None = None
    """Damping near singularities; 0.05 and 0.1 if left out, exact if `null`."""
    environment: Environment | None = None
    """What the tool touches; `POST /v1/controllers` warns where a loop with it is unstable, a stateless step does
    not."""
    inequalities: list[Inequality] | None = None
    """What the velocities must obey beside the limits."""
    limits: Limits | None = None
    """Allowed joint velocities."""
    method: Method | None = None
    """How priorities are understood."""
    null_space_velocity: NullSpaceVelocity | None = None
    """ζ̇, what the joints do as far as the tasks allow; rest if left out."""
    solver: Solver | None = None
    """How each period's problem is solved."""
    tool_offset: Pose | None = None
    """Where the tool point is, and how the tool's axes lie, in the robot's own tool frame; there if left out."""
    wrench_convention: WrenchConvention | None = None
    """Whose wrench the states carry."""
    wrench_frame: WrenchFrame | None = None
    """Along which axes they carry it."""


class CreatedController(Answer):
    """Answer to `POST /v1/controllers`."""

    id: str
    """Name of the session, part of its address."""
    idle_timeout_s: int
    """The session ends when it gets no state for this long, s; looking at it does not count."""
    joints: list[str]
    """Joint order of positions and velocities."""
    warnings: list[str] = Field(default_factory=list)
    """What is likely to go wrong: axes whose loop with the stated environment is unstable, and what would help."""


class DenavitHartenberg(Answer):
    """Rot_z(θ) Trans_z(d) Trans_x(a) Rot_x(α); the joint position adds to θ (revolute) or d (prismatic)."""

    a_m: float
    """a, m."""
    alpha_rad: float
    """α, rad."""
    d_m: float
    """d, m."""
    theta_rad: float
    """θ at joint position zero, rad."""


class Outage(Body):
    """A time in which the service hears nothing and says nothing."""

    duration_s: float
    """How long, s."""
    start_s: float
    """Since the start, s; above zero."""


class Faults(Body):
    """Faults on the line between the arm and the service; none if nothing is set. The first answer always arrives."""

    dropped: float | None = None
    """Part of the answers that are lost, 0 to 1."""
    late: float | None = None
    """Part of the answers at which the line jams: they and all after them arrive together, `late_periods` later."""
    late_periods: int | None = None
    """How long a jam lasts, periods."""
    outages: list[Outage] | None = None
    """When the service is dead."""
    reordered: float | None = None
    """Part of the answers that arrive a period later, after the next one."""
    repeated: float | None = None
    """Part of the answers that arrive once more a period later."""


class FramePose(Body):
    """A pose that survives writing and reading to the last bit: a rotation matrix, not a quaternion."""

    position: ArrayLike
    """x, y, z in the base frame, m. Shape: 3."""
    rotation: ArrayLike
    """Rotation matrix, row by row. Shape: 3 × 3."""


class Interactive(Body):
    """How a run is paced."""

    paused: bool | None = None
    """Whether simulated time stands still."""
    speed: float | None = None
    """Simulated seconds per second of real time, as far as the machine keeps up."""


JointKind = Literal["revolute", "prismatic"]
"""How a joint moves."""


class LinkFrame(Answer):
    """The frame of one link."""

    joint: str
    """The joint that moves it."""
    pose: Pose
    """Origin on the joint's axis, z along it, in the base frame."""


class KinematicsAnswer(Answer):
    """Poses, Jacobian and its singular values."""

    jacobian: FloatArray
    """J, 6 × n, row by row: linear x y z (m/s), then angular x y z (rad/s), base axes, at the tool point. Shape: 6."""
    links: list[LinkFrame]
    """Frame of each joint after its motion, base first: what the link behind it is fixed to."""
    manipulability: float
    """Their product."""
    pose: Pose
    """The tool in the base frame."""
    singular_values: FloatArray
    """Singular values of J, largest first; as many as the smaller of 6 and n."""


class KinematicsRequest(Body):
    """A posture of a robot."""

    joint_position: JointVector
    """q, rad or m."""
    robot: str
    """Name of a robot."""


class PathCounts(Answer):
    """How many periods each way solved."""

    active_set: int
    """By active sets that start from the last one."""
    closed_form: int
    """By pseudo-inverses."""
    qp: int
    """By Clarabel."""


class TimeHistogram(Answer):
    """How often a time took how long."""

    counts: list[int]
    """Counts, ten bins per decade: the first one below 1 µs, bin k from 10^((k−1)/10) µs on, the last one from 0.1 s
    on."""
    worst_us: float
    """The longest time, µs."""


SimulationState = Literal["queued", "running", "finished", "failed", "cancelled"]
"""What a run is doing."""


class SimulationMetrics(Answer):
    """Measures of a run; `null` where one has no meaning. In contact: touching a wall or, without one, feeling a
    force."""

    contacts: int
    """Separate intervals in contact."""
    calls_per_second: float | None = None
    """Control periods per second of real time."""
    final_force_n: float | None = None
    """F_x in the end, N."""
    first_contact_s: float | None = None
    """Time of the first contact, s."""
    largest_joint_speed_rad_s: float | None = None
    """Largest joint speed, rad/s."""
    overshoot_n: float | None = None
    """Largest excess of F_x over its target, N."""
    overshoot_percent: float | None = None
    """The same as a percentage of the target."""
    peak_force_n: float | None = None
    """Largest F_x, N."""
    rmse_force_x_n: float | None = None
    """Root mean square of F_x − F_d,x, N; from 5 s on in runs longer than 10 s, else from the first contact on."""
    rmse_force_y_n: float | None = None
    """The same for y, N."""
    settling_time_s: float | None = None
    """Time from which F_x stays within 5 % of its target, s."""


class Simulation(Answer):
    """A run of a scenario."""

    id: str
    """Name of the run, part of its address."""
    method: Method
    """How priorities are understood."""
    periods: int
    """Control periods of the whole run."""
    progress: float
    """Part of the run that is done, 0 to 1."""
    scenario: str
    """Name of the scenario."""
    solver: Solver
    """How each period's problem is solved."""
    state: SimulationState
    """What it is doing."""
    error: str | None = None
    """Why it failed."""
    interactive: Interactive | None = None
    """How it is paced, if it is interactive."""
    metrics: SimulationMetrics | None = None
    """Measures of the run, once it is finished."""


class LiveSample(Answer):
    """One control period, to single precision. Vectors of joints follow the robot's joint order."""

    answered: bool
    """Whether the service answered in this period."""
    at_lower: list[int]
    """Joints, counted from 0, that were at their lower bound since the sample before."""
    at_upper: list[int]
    """Joints, counted from 0, that were at their upper bound since the sample before."""
    force: FloatArray
    """F_e on the environment, N."""
    joint_position: FloatArray
    """q, rad or m."""
    joint_velocity: FloatArray
    """q̇ as commanded, rad/s or m/s."""
    path: Path
    """Which way led to the command."""
    position: FloatArray
    """Tool position in the base frame, m."""
    residual_norms: FloatArray
    """‖J_k q̇ − ẋ_k‖ per task, highest priority first."""
    round_trip_us: float
    """Time between state and answer, µs."""
    smallest_singular_value: float
    """σ_min of all task rows together."""
    solve_us: float
    """Time to compute the answer, µs."""
    status: Status
    """How sure the command is."""
    target_force: FloatArray
    """F_d, N; `null` where the axis is not force-controlled."""
    time_s: float
    """Simulated time, s."""
    kkt_residual: float | None = None
    """Residual of the optimality conditions."""
    wall_distance_m: float | None = None
    """Distance to the wall, m, positive when free; `null` without a wall."""


class LiveFrame(Answer):
    """What is seen of a run at one moment, and what happened since the frame before."""

    arm: ArmView
    """The arm as it stands now."""
    done: int
    """Control periods done."""
    external_force: FloatArray
    """What pushes the tool from outside, N, base axes."""
    paths: PathCounts
    """How many periods each way solved."""
    reached_speed: float
    """Simulated seconds per second of real time that were reached of late."""
    round_trip: TimeHistogram
    """Time between states and answers."""
    run: Simulation
    """The run with its pace, method and solver as they are now."""
    samples: list[LiveSample]
    """Periods since the frame before, oldest first: some of them, evenly spread."""
    solve_time: TimeHistogram
    """Time to compute the answers."""
    time_s: float
    """Simulated time, s."""


class Memory(Body):
    """What a controller remembers; opaque to clients, who send it back as it came."""

    active_set: list[list[ActiveLimitName]]
    """Active limits of the last command, level by level."""
    initial_pose: FramePose
    """Tool pose at the first step."""
    last_command: ArrayLike
    """q̇ of the last command, rad/s or m/s."""
    sequence: int
    """Sequence number of the state that led here."""
    task_velocities: list[ArrayLike]
    """Integrator of each task, m/s and rad/s."""


class Sensor(Body):
    """What a sensor adds: quantum · round((value + bias + noise)/quantum). One number for all values, or one for
    each."""

    bias: ArrayLike | None = None
    """Added to the value."""
    noise: ArrayLike | None = None
    """Standard deviation of normally distributed noise, new in each period."""
    quantum: ArrayLike | None = None
    """Step of the values that it can tell apart; any if 0."""


class Sensors(Body):
    """Sensors of the arm; perfect if nothing is set."""

    force: Sensor | None = None
    """Force along the sensor's x, y and z, N."""
    joint_position: Sensor | None = None
    """q, rad or m; per joint."""
    joint_velocity: Sensor | None = None
    """q̇, rad/s or m/s; per joint."""
    torque: Sensor | None = None
    """Torque about them, N·m."""
    wrench_filter_s: float | None = None
    """τ of a first-order low-pass filter of force and torque, s; none if 0."""


class VelocityLoop(Body):
    """How the arm follows a commanded velocity; ideal if nothing is set."""

    clamp: bool | None = None
    """Whether the drives cut commands at the limits that the controller is given, each joint by itself."""
    delay_periods: int | None = None
    """Whole periods that a command waits before it acts."""
    lag_s: float | None = None
    """τ of a first-order lag, s."""


class Scenario(Body):
    """An experiment: a controller, where the arm starts, what it touches, for how long."""

    controller: ControllerConfig
    """The controller, as in a request."""
    description: str
    """What it is about, one line."""
    duration_s: float
    """Simulated time, s."""
    name: str
    """Name, as in `force_tracking`."""
    start_joint_position: ArrayLike
    """q at the start, n, rad or m."""
    contacts: list[Contact] | None = None
    """What the tool touches."""
    expectation: str | None = None
    """What is to be seen, in words."""
    external_wrench: Profile | None = None
    """Force and torque with which somebody pushes the tool, base axes, at the tool point, N and N·m: six values over
    time."""
    faults: Faults | None = None
    """What goes wrong between the arm and the service."""
    seed: int | None = None
    """Seed of noise and faults: the same seed, the same run."""
    sensors: Sensors | None = None
    """What the arm's sensors make of the truth."""
    substeps: int | None = None
    """Steps of arm and contacts in a period."""
    velocity_loop: VelocityLoop | None = None
    """How the arm follows its commands."""


NamedScenario = str | Scenario
"""A scenario by name or as it is."""


class RobotJoint(Answer):
    """A joint and its limits; `null` where there is none."""

    kind: JointKind
    """How it moves."""
    name: str
    """Name."""
    unit: str
    """Unit of its position: `rad` or `m`; velocity and acceleration are per s and s²."""
    acceleration_limit: float | None = None
    """Largest acceleration, rad/s² or m/s²."""
    denavit_hartenberg: DenavitHartenberg | None = None
    """Standard Denavit-Hartenberg row, where the robot was described by one."""
    position_limit: FloatArray | None = None
    """Smallest and largest position, rad or m. Shape: 2."""
    published_range: FloatArray | None = None
    """Position range that a publication prints instead; informative. Shape: 2."""
    velocity_limit: float | None = None
    """Largest speed, rad/s or m/s."""


RobotSource = Literal["denavit_hartenberg", "urdf"]
"""How an arm was described."""


class Robot(Answer):
    """An arm."""

    description: str
    """One line for people."""
    joints: list[RobotJoint]
    """The joints, base first: the order of every vector of joints."""
    name: str
    """Name."""
    source: RobotSource
    """How it was described."""


class RobotList(Answer):
    """Answer to `GET /v1/robots`."""

    robots: list[Robot]
    """The robots that requests can name."""


class RobotRegistration(Body):
    """`POST /v1/robots`: the chain of a URDF text from one link to another."""

    name: str
    """Name by which requests will call it: letters, digits, `_`, `-` and `.`, at most 64."""
    urdf: str
    """The text, `<robot …>`."""
    base: str | None = None
    """Link that the arm stands on; the root of the tree if left out."""
    tip: str | None = None
    """Link of the tool frame; the only leaf of the tree if left out."""


class ScenarioEntry(Answer):
    """One scenario of the list."""

    description: str
    """What it is about, one line."""
    name: str
    """Name."""
    robot: str
    """Name of its robot."""
    scenario: Scenario
    """All of it."""


class ScenarioList(Answer):
    """Answer to `GET /v1/scenarios`."""

    scenarios: list[ScenarioEntry]
    """The scenarios that ship with the service."""


class SessionEntry(Answer):
    """One session of the list."""

    id: str
    """Name of the session."""
    idle_s: float
    """Time since its last state came, or since it was opened, s."""
    method: Method
    """How priorities are understood."""
    period_s: float
    """T, s."""
    robot: str
    """Its robot."""
    solver: Solver
    """How each period's problem is solved."""
    steps: int
    """States answered by a step."""


class SessionList(Answer):
    """Answer to `GET /v1/controllers`."""

    controllers: list[SessionEntry]
    """The sessions that are open, the one that stepped last first."""


class SessionStatus(Answer):
    """Answer to `GET /v1/controllers/{id}`."""

    controller: ControllerConfig
    """Its configuration, defaults filled in."""
    id: str
    """Name of the session."""
    retries: int
    """States answered again, because they were sent again."""
    steps: int
    """States answered by a step."""
    last_sequence: int | None = None
    """Sequence number of the last state; `null` before the first."""
    missed_periods: int | None = None
    """Steps that came more than 1.5 periods after the one before."""


class SimulationControl(Body):
    """`POST /v1/simulations/{id}/control`: what is to change; everything else stays."""

    controller: ControllerConfig | None = None
    """The controller from now on; from the one before it may differ in method, solver, and the laws `force`,
    `impedance` and `hybrid`, which integrate and so do not jump."""
    end: bool | None = None
    """Whether the run is finished here: what there is of it becomes its trace. A run that is paused does one more
    period."""
    external_force: ArrayLike | None = None
    """Pushes the tool, N, base axes. It ends a second of real time after it was last said, so say it again to hold it.
    Shape: 3."""
    method: Method | None = None
    """How priorities are understood from now on."""
    paused: bool | None = None
    """Whether simulated time stands still."""
    solver: Solver | None = None
    """How each period's problem is solved from now on."""
    speed: float | None = None
    """Simulated seconds per second of real time."""
    step: int | None = None
    """Control periods to go on for, and to pause after."""


class SimulationRequest(Body):
    """A run to make."""

    scenario: NamedScenario
    """A scenario that ships with the service, by name, or one of the client's own."""
    interactive: Interactive | None = None
    """Paced by the clock, shown live and open to `POST /v1/simulations/{id}/control`; as fast as it goes if left
    out."""
    method: Method | None = None
    """Method, instead of the scenario's."""
    solver: Solver | None = None
    """Solver, instead of the scenario's."""


class StabilityAnswer(Answer):
    """How stable the loop is, and how far it could go."""

    spectral_radius: float
    """Largest |eigenvalue| from period to period; stable below 1."""
    stable: bool
    """Whether the loop is stable."""
    stable_at_any_lag: bool
    """Whether no lag makes it unstable."""
    largest_delay_periods: int | None = None
    """Largest delay at which it is stable, periods; `null` if at none."""
    largest_lag_s: float | None = None
    """Largest lag at which it is stable, s; `null` if at none, or at any (see `stable_at_any_lag`)."""
    smallest_damping: float | None = None
    """Smallest B_d that makes it stable; `null` if none does."""


class StabilityRequest(Body):
    """One axis of a law in contact. Linear: kg, N·s/m, N/m; angular: kg·m², N·m·s/rad, N·m/rad."""

    damping: float
    """B_d."""
    environment: EnvironmentAxis
    """What the tool touches."""
    inertia: float
    """M_d > 0."""
    period_s: float
    """T, s."""
    delay_periods: int | None = None
    """Whole periods that a command waits."""
    lag_s: float | None = None
    """τ of the arm's velocity loop, s."""
    stiffness: float | None = None
    """K_d; 0 (left out) where a force is followed."""
    velocity_measured: bool | None = None
    """Whether states carry the measured joint velocity; otherwise the last command stands for it."""


class Wrench(Body):
    """Force and torque at the tool point, along the axes of the controller's `wrench_frame`."""

    force: ArrayLike
    """N. Shape: 3."""
    torque: ArrayLike
    """N·m. Shape: 3."""


class State(Body):
    """The measured state."""

    joint_position: JointVector
    """q, rad or m."""
    sequence: int
    """Number of the period; must grow."""
    time_s: float
    """t, s."""
    joint_velocity: JointVector | None = None
    """q̇, rad/s or m/s; the last command stands for it if left out."""
    wrench: Wrench | None = None
    """Measured wrench; may be left out where no law needs it."""


class StepAnswer(Answer):
    """Joint velocities for one period and why they are what they are."""

    active_limits: list[ActiveLimit]
    """Limits that hold the answer back."""
    elapsed_us: float
    """Time to compute it, µs."""
    joint_limit_index: float
    """H, how near the joints are to the ends of their ranges: 0 with all in the middle, ½ with all at an end."""
    joint_velocity: FloatArray
    """q̇, rad/s or m/s."""
    limit_conflict: list[str]
    """Joints whose acceleration limit was overruled by position or velocity."""
    sequence: int
    """Sequence number of the state."""
    singularity: Singularity
    """How near the tasks are to singularities."""
    solver: SolverReport
    """How the answer was found."""
    tasks: list[TaskOutcome]
    """What became of each task, highest priority first."""
    valid_for_ms: int
    """Time from the measurement of the state after which, without a newer answer, the arm is to ramp to zero, ms."""
    violated_limits: list[ViolatedLimit]
    """Limits that the answer breaks."""
    active_inequalities: list[ActiveInequality] = Field(default_factory=list)
    """Inequalities that hold the answer back."""
    memory: Memory | None = None
    """To be sent with the next state; only in stateless answers."""
    violated_inequalities: list[ViolatedInequality] = Field(default_factory=list)
    """Inequalities that the answer breaks."""


class StepRequest(Body):
    """`POST /v1/step`: controller, state and memory in one body."""

    controller: ControllerConfig
    """The controller."""
    state: State
    """The state."""
    memory: Memory | None = None
    """The last answer's memory; `null` at the first step."""


class WatchedStep(Answer):
    """One control period."""

    answer: StepAnswer
    """What was answered."""
    state: State
    """What was measured."""
    arm: ArmView | None = None
    """The arm at that state."""


REMEDIES: dict[str, str] = {
    "/problems/malformed": "Mend the body's syntax where `detail` says.",
    "/problems/unauthorized": "Send `Authorization: Bearer` with the service's token.",
    "/problems/permanent": "Delete only what was registered.",
    "/problems/foreign-origin": "Allow its origin when the service is started.",
    "/problems/not-found": "Take the name from a list or from the answer that made it.",
    "/problems/unknown-controller": "Open it again.",
    "/problems/method-not-allowed": "Use a method that `Allow` names.",
    "/problems/not-acceptable": "Accept one of the types that `detail` names.",
    "/problems/timeout": "Send it whole and at once.",
    "/problems/sequence": "Count up with every new state; only an unchanged state may be sent again.",
    "/problems/name-taken": "Choose another.",
    "/problems/no-trace": "Wait for its end; see its state.",
    "/problems/not-live": "Start one with `interactive`.",
    "/problems/too-large": "Send less; `detail` names the limit.",
    "/problems/media-type": "Say with `Content-Type` what is sent.",
    "/problems/invalid": "Change the field at `pointer` as `detail` says.",
    "/problems/upgrade-required": "Use a WebSocket client.",
    "/problems/internal": "See the service's log.",
    "/problems/too-many-controllers": "Delete one, or wait until an idle one ends.",
    "/problems/too-many-robots": "Delete one, or wait until an idle one ends.",
    "/problems/busy": "Try again after the time that `Retry-After` says.",
    "/problems/overloaded": "Send fewer, or start another server.",
    "/problems/draining": "Call another one.",
}
"""What to do about each type of problem."""
