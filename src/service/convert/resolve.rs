//! `POST /v1/resolve`.

use std::sync::Arc;

use revprio_api::wire;
use revprio_core::controller::{Limits, NullSpaceMotion};
use revprio_core::limits::{Barrier, Inequality, JointMotion, LimitKind, LimitedBox, VelocityBox};
use revprio_core::linalg::Vector;
use revprio_core::resolution::{Problem, ProblemError, Resolution, Solver};
use revprio_core::task::Task;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Configuration, joint_limit_index};
use tokio::time::Instant;

use super::inequalities::InequalityReader;
use super::null_space::null_space;
use super::numbers::{damping, joint_vector, joint_vector_of, number, velocity_box};
use super::outcome::{Outcome, elapsed_us};
use super::pose::with_tool_offset;
use super::resolve_task::task_stack;
use super::terms;
use super::why::{Explained, LimitedState, NamedTask, Unit};
use crate::service::error::ApiError;
use crate::service::robots::Robots;

/// Minimum control period, s.
pub const MIN_PERIOD_S: f64 = 1e-6;
/// Maximum control period, s.
pub const MAX_PERIOD_S: f64 = 10.0;

/// A problem to resolve, with the names for its answer.
pub struct ResolveProblem {
    /// The problem.
    pub problem: Problem,
    /// The solver.
    pub solver: Solver,
    /// Names of the joints.
    joints: Vec<String>,
    /// The robot, if the limits of the problem are not the robot's.
    faster_than: Option<Arc<RobotModel>>,
    /// Joints whose acceleration limit was dropped because it contradicts another limit.
    conflicts: Vec<usize>,
    /// Joint limit index H, if robot and posture are known.
    joint_limit_index: Option<f64>,
    /// What the sentences of the answer need, if the request wants them.
    why: Option<WhyInputs>,
}

/// What the sentences of an answer need besides the problem.
struct WhyInputs {
    robot: Option<Arc<RobotModel>>,
    /// The state that the limits depend on, if they are the robot's.
    state: Option<LimitedState>,
    /// Units of the rows of each task.
    units: Vec<Vec<Unit>>,
}

/// Reads a request.
pub fn resolve_problem(request: &wire::ResolveRequest, robots: &Robots) -> Result<ResolveProblem, ApiError> {
    let robot = robot(request, robots)?;
    let robot = robot.as_ref();
    let configuration = configuration(request, robot)?;
    let tasks = task_stack(request, configuration.as_ref())?;
    if request.certificate {
        check_names(tasks.tasks())?;
    }
    let joints = tasks.joint_count();
    if let Some(robot) = robot.filter(|robot| robot.joint_count() != joints) {
        let detail = format!("{joints} columns, but `{}` has {} joints", robot.name(), robot.joint_count());
        return Err(ApiError::invalid("/tasks/0/jacobian", detail));
    }
    let limited = limits(request, robot, configuration.as_ref(), joints)?;
    let are_others =
        matches!(request.limits, Some(wire::Limits::Box { .. } | wire::Limits::Robot(wire::LimitKind::None)));
    let zeta = null_space_velocity(request, robot, configuration.as_ref(), joints)?;
    let why = request.why.then(|| why_inputs(request, robot, configuration.as_ref(), are_others));
    Ok(ResolveProblem {
        problem: Problem {
            tasks,
            limits: limited.velocity_box,
            inequalities: inequalities(request, robot, configuration.as_ref(), joints)?,
            method: terms::method(request.method),
            damping: damping(request.damping)?,
            null_space_velocity: zeta,
            wants_certificate: request.certificate,
        },
        solver: terms::solver(request.solver),
        joints: joint_names(robot.map(Arc::as_ref), joints),
        faster_than: robot.filter(|_| are_others).cloned(),
        conflicts: limited.conflicts,
        joint_limit_index: robot.zip(configuration).map(|(robot, at)| joint_limit_index(robot, at.joint_position())),
        why,
    })
}

/// Checks that the rows of a certificate can be told apart: its tasks have different names.
fn check_names(tasks: &[Task]) -> Result<(), ApiError> {
    let is_known = |k: usize| tasks[..k].iter().any(|task| task.name == tasks[k].name);
    let Some(k) = (0..tasks.len()).find(|&k| is_known(k)) else { return Ok(()) };
    let detail = format!("two tasks are named `{}`; a certificate needs different names", tasks[k].name);
    Err(ApiError::invalid(format!("/tasks/{k}/name"), detail))
}

/// Collects what the sentences of the answer need. `are_others`: the limits are not the robot's.
fn why_inputs(
    request: &wire::ResolveRequest,
    robot: Option<&Arc<RobotModel>>,
    configuration: Option<&Configuration>,
    are_others: bool,
) -> WhyInputs {
    let kind = match request.limits {
        Some(wire::Limits::Robot(kind)) => kind,
        _ => wire::LimitKind::PositionVelocity,
    };
    let last = |robot| joint_vector(request.joint_velocity.as_ref()?, robot, "").ok().zip(request.period_s);
    let state = robot.filter(|_| !are_others).map(|robot| LimitedState {
        position: configuration.filter(|_| kind.includes_position()).map(|at| at.joint_position().to_vec()),
        last_command: Some(robot).filter(|_| kind.includes_acceleration()).and_then(|robot| last(robot)),
        keeps_jerk: false,
    });
    let units = |task: &wire::ResolveTask| match (&task.axes, &task.jacobian) {
        (Some(axes), _) => axes.iter().map(|axis| Unit::of_axis(*axis)).collect(),
        (None, rows) => vec![Unit::Unknown; rows.as_ref().map_or(0, Vec::len)],
    };
    WhyInputs { robot: robot.cloned(), state, units: request.tasks.iter().map(units).collect() }
}

/// Returns the robot of the request, with its tool offset.
fn robot(request: &wire::ResolveRequest, robots: &Robots) -> Result<Option<Arc<RobotModel>>, ApiError> {
    match (&request.robot, &request.tool_offset) {
        (Some(name), offset) => with_tool_offset(&known_robot(name, robots)?, offset.as_ref()).map(Some),
        (None, Some(_)) => Err(ApiError::invalid("/robot", "`tool_offset` needs the name of a robot")),
        (None, None) => Ok(None),
    }
}

/// Reads the null-space velocity ζ̇, if the request has one.
fn null_space_velocity(
    request: &wire::ResolveRequest,
    robot: Option<&Arc<RobotModel>>,
    configuration: Option<&Configuration>,
    joints: usize,
) -> Result<Option<Vector>, ApiError> {
    let Some(motion) = &request.null_space_velocity else { return Ok(None) };
    let motion = match null_space(motion, robot.map(Arc::as_ref), joints)? {
        None => return Ok(None),
        Some(NullSpaceMotion::Constant(velocity)) => return Ok(Some(velocity)),
        Some(NullSpaceMotion::InitialPosture { .. }) => {
            let detail = "a single problem has no first state; use it in a controller, or give `posture`";
            return Err(ApiError::invalid("/null_space_velocity/kind", detail));
        }
        Some(motion) => motion,
    };
    let missing = || ApiError::invalid("/joint_position", "this null-space velocity needs `joint_position`");
    let (robot, configuration) = robot.zip(configuration).ok_or_else(missing)?;
    Ok(Some(motion.velocity(robot, configuration.joint_position())))
}

/// Returns the robot with the name at `/robot`.
pub fn known_robot(name: &str, robots: &Robots) -> Result<Arc<RobotModel>, ApiError> {
    robots.get(name).map_err(|error| ApiError::invalid("/robot", error))
}

fn joint_names(robot: Option<&RobotModel>, joints: usize) -> Vec<String> {
    match robot {
        Some(robot) => robot.joints().iter().map(|joint| joint.name.clone()).collect(),
        None => (1..=joints).map(|joint| format!("j{joint}")).collect(),
    }
}

fn configuration(
    request: &wire::ResolveRequest,
    robot: Option<&Arc<RobotModel>>,
) -> Result<Option<Configuration>, ApiError> {
    match (robot, &request.joint_position) {
        (Some(robot), Some(position)) => {
            let position = joint_vector(position, robot, "/joint_position")?;
            let invalid = |error| ApiError::invalid("/joint_position", error);
            Configuration::new(robot, &position).map(Some).map_err(invalid)
        }
        (None, Some(_)) => Err(ApiError::invalid("/robot", "`joint_position` needs the name of a robot")),
        (_, None) => Ok(None),
    }
}

fn inequalities(
    request: &wire::ResolveRequest,
    robot: Option<&Arc<RobotModel>>,
    configuration: Option<&Configuration>,
    joints: usize,
) -> Result<Vec<Inequality>, ApiError> {
    let robot = robot.filter(|_| configuration.is_some()).map(Arc::as_ref);
    let reader = InequalityReader { robot, joints, period_s: request.period_s };
    let barriers = reader.read(&request.inequalities)?;
    let inequality = |barrier: &Barrier| match configuration {
        Some(configuration) => Some(barrier.at(configuration, None, None)),
        None => barrier.constant().cloned(),
    };
    Ok(barriers.iter().filter_map(inequality).collect())
}

fn limits(
    request: &wire::ResolveRequest,
    robot: Option<&Arc<RobotModel>>,
    configuration: Option<&Configuration>,
    joints: usize,
) -> Result<LimitedBox, ApiError> {
    let period = request.period_s.map(|period| positive_period(period, "/period_s")).transpose()?;
    let kind = match &request.limits {
        Some(wire::Limits::Box { lower, upper }) => {
            let velocity_box = velocity_box(lower, upper, joints)?;
            return Ok(LimitedBox { velocity_box, conflicts: Vec::new() });
        }
        Some(wire::Limits::Robot(kind)) => terms::limit_kind(*kind),
        None if configuration.is_some() && period.is_some() => LimitKind::PositionVelocity,
        None if robot.is_some() => LimitKind::Velocity,
        None => LimitKind::None,
    };
    let last = request.joint_velocity.as_ref();
    let last = last.map(|last| joint_vector_of(last, robot.map(Arc::as_ref), joints, "/joint_velocity")).transpose()?;
    match (kind, robot) {
        (LimitKind::None, _) => Ok(LimitedBox { velocity_box: VelocityBox::unbounded(joints), conflicts: Vec::new() }),
        (_, None) => {
            Err(ApiError::invalid("/limits", "the limits of a robot need `robot`; or give `lower` and `upper`"))
        }
        (kind, Some(robot)) => {
            let state = RobotState { configuration, last: last.as_ref(), period };
            state.limited_box(kind, robot)
        }
    }
}

/// The state that the limits of a robot depend on, as far as the request has it.
struct RobotState<'a> {
    configuration: Option<&'a Configuration>,
    last: Option<&'a Vector>,
    period: Option<f64>,
}

impl RobotState<'_> {
    fn limited_box(&self, kind: LimitKind, robot: &RobotModel) -> Result<LimitedBox, ApiError> {
        let needs_state = kind.includes_position();
        let needs_last = kind.includes_acceleration();
        let missing = |pointer: &str, what: &str| ApiError::invalid(pointer, format!("these limits need {what}"));
        if needs_state && self.configuration.is_none() {
            return Err(missing("/joint_position", "`joint_position`"));
        }
        if needs_state && self.period.is_none() {
            return Err(missing("/period_s", "`period_s`"));
        }
        if needs_last && self.last.is_none() {
            return Err(missing("/joint_velocity", "`joint_velocity`, the last command"));
        }
        let zeros = vec![0.0; robot.joint_count()];
        let position = self.configuration.map_or(zeros.as_slice(), Configuration::joint_position);
        let last = self.last.map_or(zeros.as_slice(), Vector::as_slice);
        let motion = JointMotion { position, distance_to_rest: &[], last_command: last, last_acceleration: &[] };
        Ok(Limits::Robot(kind).at(robot, motion, self.period.unwrap_or(1.0)))
    }
}

/// Checks a control period.
pub fn positive_period(period: f64, pointer: &str) -> Result<f64, ApiError> {
    if (MIN_PERIOD_S..=MAX_PERIOD_S).contains(&period) {
        return number(period, pointer);
    }
    Err(ApiError::invalid(pointer, format!("{period} is out of range; give a control period from 1e-6 to 10 s")))
}

/// Converts the error of a problem whose parts were checked one by one.
pub fn resolution_error(error: ProblemError) -> ApiError {
    let pointer = match error {
        ProblemError::Limits { .. } => "/limits",
        ProblemError::Size { .. } => "/tasks",
        ProblemError::Inequality { .. } => "/inequalities",
        ProblemError::NullSpaceVelocity { .. } => "/null_space_velocity",
    };
    ApiError::invalid(pointer, error)
}

/// Returns the body of the answer.
pub fn resolve_answer(problem: &ResolveProblem, resolution: &Resolution, start: Instant) -> wire::ResolveAnswer {
    let tasks = problem.problem.tasks.tasks();
    let outcome = Outcome {
        resolution,
        joints: problem.joints.iter().map(String::as_str).collect(),
        tasks: tasks.iter().map(|task| task.name.as_str()).collect(),
        inequalities: problem.problem.inequalities.iter().map(Inequality::name).collect(),
        faster_than: problem.faster_than.as_deref(),
    };
    wire::ResolveAnswer {
        joint_velocity: outcome.joint_velocity(),
        why: problem.why.as_ref().map(|inputs| why(problem, inputs, resolution)).unwrap_or_default(),
        tasks: outcome.tasks(|k| (requested(&tasks[k], &resolution.tasks[k].achieved), None)),
        active_limits: outcome.active_limits(),
        violated_limits: outcome.violated_limits(),
        active_inequalities: outcome.active_inequalities(),
        violated_inequalities: outcome.violated_inequalities(),
        contradictions: outcome.contradictions(),
        limit_conflict: outcome.names(&problem.conflicts),
        solver: outcome.solver(),
        singularity: outcome.singularity(),
        joint_limit_index: problem.joint_limit_index,
        certificate: resolution.certificate.as_ref().map(|found| outcome.certificate(found)),
        elapsed_us: elapsed_us(start),
    }
}

/// Returns the sentences of the answer.
fn why(problem: &ResolveProblem, inputs: &WhyInputs, resolution: &Resolution) -> Vec<String> {
    let tasks = problem.problem.tasks.tasks().iter().zip(&resolution.tasks).zip(&inputs.units);
    let tasks = tasks.map(|((task, outcome), units)| NamedTask {
        name: &task.name,
        requested: requested(task, &outcome.achieved),
        units: units.clone(),
    });
    let explained = Explained {
        resolution,
        joints: problem.joints.iter().map(String::as_str).collect(),
        inequalities: problem.problem.inequalities.iter().map(Inequality::name).collect(),
        robot: inputs.robot.as_deref(),
        state: inputs.state.as_ref(),
        threshold: problem.problem.damping.map(|damping| damping.threshold()),
        conflicts: &problem.conflicts,
        tasks: tasks.collect(),
    };
    explained.sentences()
}

/// Returns the requested velocity of a task: the allowed velocity nearest to the achieved one.
fn requested(task: &Task, achieved: &Vector) -> Vec<f64> {
    if task.is_equation() {
        return task.lower.as_slice().to_vec();
    }
    achieved.zip_zip_map(&task.lower, &task.upper, f64::clamp).as_slice().to_vec()
}
