//! `POST /v1/resolve`.

use std::sync::Arc;

use crate::clock::Instant;
use revprio_api::wire;
use revprio_core::constraint::Inequality;
use revprio_core::controller::{Limits, NullSpaceMotion};
use revprio_core::limits::{JointMotion, LimitKind, LimitedBox};
use revprio_core::linalg::Vector;
use revprio_core::resolution::{Problem, ProblemError, Resolution, Solver};
use revprio_core::task::Task;
use revprio_lab::number::Exact;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Configuration, joint_limit_index};

use super::checks::{Missing, Refused, Result, check};
use super::inequalities::InequalityReader;
use super::null_space::null_space;
use super::numbers::{between, damping, joint_names, joint_vector, joint_vector_of, velocity_box};
use super::outcome::{Outcome, elapsed_us};
use super::pose::with_tool_offset;
use super::resolve_task::task_stack;
use super::solver::solver;
use super::terms;
use crate::error::ApiError;
use crate::request_warnings;
use crate::robots::Robots;
use crate::why::{Explained, NamedTask, Unit};

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
    /// The limits of the problem, with the limit that sets each bound.
    limited: LimitedBox,
    /// Joint limit index H, if robot and posture are known.
    joint_limit_index: Option<f64>,
    /// What the sentences of the answer need, if the request wants them.
    why: Option<WhyInputs>,
    /// Warnings about the request.
    warnings: Vec<String>,
}

/// What the sentences of an answer need besides the problem.
struct WhyInputs {
    robot: Option<Arc<RobotModel>>,
    /// Joint position, n, if position limits apply.
    position: Option<Vec<f64>>,
    /// Units of the rows of each task.
    units: Vec<Vec<Unit>>,
}

/// A request, with the robot and the configuration that it names.
struct Request<'a> {
    body: &'a wire::ResolveRequest,
    robot: Option<Arc<RobotModel>>,
    configuration: Option<Configuration>,
}

/// Reads a request.
pub fn resolve_problem(body: &wire::ResolveRequest, robots: &Robots) -> Result<ResolveProblem> {
    let request = Request::read(body, robots)?;
    let tasks = task_stack(body, request.at())?;
    if body.certificate {
        check_names(tasks.tasks())?;
    }
    let joints = tasks.joint_count();
    if let Some(robot) = &request.robot {
        let (name, given) = (robot.name(), robot.joint_count());
        let detail = format_args!("{joints} columns, but `{name}` has {given} joints");
        check(given == joints, "/tasks/0/jacobian", detail)?;
    }
    let limited = request.limits(joints)?;
    let null_space_velocity = request.null_space_velocity(joints)?;
    Ok(ResolveProblem {
        problem: Problem {
            tasks,
            limits: limited.velocity_box.clone(),
            inequalities: request.inequalities(joints)?,
            method: terms::method(body.method),
            damping: damping(body.damping)?,
            null_space_velocity,
            wants_certificate: body.certificate,
        },
        solver: solver(body.solver)?,
        joints: match &request.robot {
            Some(robot) => joint_names(robot).into_iter().map(str::to_owned).collect(),
            None => (1..=joints).map(|joint| format!("j{joint}")).collect(),
        },
        faster_than: request.robot.clone().filter(|_| request.has_other_limits()),
        limited,
        joint_limit_index: request.at().map(|(robot, at)| joint_limit_index(robot, at.joint_position())),
        why: body.why.then(|| request.why_inputs()),
        warnings: request_warnings::of_problem(body, request.robot.as_deref()),
    })
}

impl ResolveProblem {
    /// Returns the name of each constraint; the rows of a constraint follow each other.
    fn constraint_names(&self) -> Vec<&str> {
        let first_rows = self.problem.inequalities.iter().filter(|inequality| inequality.row() == 0);
        first_rows.map(Inequality::name).collect()
    }
}

/// Checks that the rows of a certificate can be told apart: its tasks have different names.
fn check_names(tasks: &[Task]) -> Result<()> {
    let is_known = |k: usize| tasks[..k].iter().any(|task| task.name == tasks[k].name);
    let Some(k) = (0..tasks.len()).find(|&k| is_known(k)) else { return Ok(()) };
    let detail = format!("two tasks are named `{}`; a certificate needs different names", tasks[k].name);
    Err(ApiError::invalid(format!("/tasks/{k}/name"), detail))
}

impl<'a> Request<'a> {
    /// Finds the robot of a request, with its tool offset, and reads its configuration.
    fn read(body: &'a wire::ResolveRequest, robots: &Robots) -> Result<Self> {
        let robot = body.robot.as_ref().map(|name| known_robot(name, robots)).transpose()?;
        let robot = robot.map(|robot| with_tool_offset(&robot, body.tool_offset.as_ref())).transpose()?;
        for (field, is_given) in
            [("tool_offset", body.tool_offset.is_some()), ("joint_position", body.joint_position.is_some())]
        {
            check(robot.is_some() || !is_given, "/robot", format_args!("`{field}` needs the name of a robot"))?;
        }
        let configuration = robot.as_ref().zip(body.joint_position.as_ref()).map(|(robot, position)| {
            let position: Vec<f64> = joint_vector(position, robot, "/joint_position")?;
            Configuration::new(robot, &position).at("/joint_position")
        });
        Ok(Self { body, configuration: configuration.transpose()?, robot })
    }

    /// Returns the robot and its configuration, if both are known.
    fn at(&self) -> Option<(&RobotModel, &Configuration)> {
        self.robot.as_deref().zip(self.configuration.as_ref())
    }

    /// Returns whether the limits are not the robot's.
    fn has_other_limits(&self) -> bool {
        matches!(self.body.limits, Some(wire::Limits::Box { .. } | wire::Limits::Robot(wire::LimitKind::None)))
    }

    /// Collects what the sentences of the answer need.
    fn why_inputs(&self) -> WhyInputs {
        let applies = self.robot.is_some() && self.limit_kind().includes_position();
        let position = self.configuration.as_ref().filter(|_| applies).map(|at| at.joint_position().to_vec());
        let units = |task: &wire::ResolveTask| match (&task.axes, &task.jacobian) {
            (Some(axes), _) => axes.iter().map(|axis| Unit::of_axis(*axis)).collect(),
            (None, rows) => vec![Unit::Unknown; rows.as_ref().map_or(0, Vec::len)],
        };
        WhyInputs { robot: self.robot.clone(), position, units: self.body.tasks.iter().map(units).collect() }
    }

    /// Reads the null-space velocity ζ̇, if the request has one.
    fn null_space_velocity(&self, joints: usize) -> Result<Option<Vector>> {
        let Some(motion) = &self.body.null_space_velocity else { return Ok(None) };
        let motion = match null_space(motion, self.robot.as_deref(), joints)? {
            None => return Ok(None),
            Some(NullSpaceMotion::Constant(velocity)) => return Ok(Some(velocity)),
            Some(NullSpaceMotion::InitialPosture { .. }) => {
                let detail = "a single problem has no first state; use it in a controller, or give `posture`";
                return Err(ApiError::invalid("/null_space_velocity/kind", detail));
            }
            Some(motion) => motion,
        };
        let detail = "this null-space velocity needs `joint_position`";
        let (robot, configuration) = self.at().or_invalid("/joint_position", detail)?;
        Ok(Some(motion.velocity(robot, configuration.joint_position())))
    }

    fn inequalities(&self, joints: usize) -> Result<Vec<Inequality>> {
        let robot = self.at().map(|(robot, _)| robot);
        let constraints =
            InequalityReader { robot, joints, period_s: self.body.period_s }.read(&self.body.inequalities)?;
        let configuration = self.configuration.as_ref();
        Ok(constraints.iter().flat_map(|constraint| constraint.rows_at(configuration)).collect())
    }

    /// Returns which limits of the robot apply: the stated ones, or those that the other fields suffice for.
    fn limit_kind(&self) -> LimitKind {
        match &self.body.limits {
            Some(wire::Limits::Robot(kind)) => terms::limit_kind(*kind),
            None if self.configuration.is_some() && self.body.period_s.is_some() => LimitKind::PositionVelocity,
            None if self.robot.is_some() => LimitKind::Velocity,
            None | Some(wire::Limits::Box { .. }) => LimitKind::None,
        }
    }

    fn limits(&self, joints: usize) -> Result<LimitedBox> {
        let period = self.body.period_s.map(|period| positive_period(period, "/period_s")).transpose()?;
        if let Some(wire::Limits::Box { lower, upper }) = &self.body.limits {
            return Ok(LimitedBox::given(velocity_box(lower, upper, joints)?));
        }
        let kind = self.limit_kind();
        let last = self.body.joint_velocity.as_ref();
        let last =
            last.map(|last| joint_vector_of(last, self.robot.as_deref(), joints, "/joint_velocity")).transpose()?;
        if kind == LimitKind::None {
            return Ok(LimitedBox::unbounded(joints));
        }
        let detail = "the limits of a robot need `robot`; or give `lower` and `upper`";
        let robot = self.robot.as_ref().or_invalid("/limits", detail)?;
        for (is_missing, pointer, what) in [
            (kind.includes_position() && self.configuration.is_none(), "/joint_position", "`joint_position`"),
            (kind.includes_position() && period.is_none(), "/period_s", "`period_s`"),
            (kind.includes_acceleration() && last.is_none(), "/joint_velocity", "`joint_velocity`, the last command"),
        ] {
            check(!is_missing, pointer, format_args!("these limits need {what}"))?;
        }
        let zeros = vec![0.0; joints];
        let position = self.configuration.as_ref().map_or(zeros.as_slice(), Configuration::joint_position);
        let last_command = last.as_ref().map_or(zeros.as_slice(), Vector::as_slice);
        let motion = JointMotion { position, distance_to_rest: &[], last_command, last_acceleration: &[] };
        Ok(Limits::Robot(kind).at(robot, motion, period.unwrap_or(1.0)))
    }
}

/// Returns the robot with the name at `/robot`.
pub fn known_robot(name: &str, robots: &Robots) -> Result<Arc<RobotModel>> {
    robots.get(name).at("/robot")
}

/// Checks a control period.
pub fn positive_period(period: f64, pointer: &str) -> Result<f64> {
    let detail = format_args!("{} is out of range; give a control period from 1e-6 to 10 s", Exact(period));
    between(period, MIN_PERIOD_S..=MAX_PERIOD_S, pointer, detail)
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
        inequalities: problem.constraint_names().into(),
        faster_than: problem.faster_than.as_deref(),
    };
    wire::ResolveAnswer {
        joint_velocity: outcome.joint_velocity(),
        warnings: problem.warnings.clone(),
        why: problem.why.as_ref().map(|inputs| why(problem, inputs, resolution)).unwrap_or_default(),
        tasks: outcome.tasks(|k| (requested(&tasks[k], &resolution.tasks[k].achieved), None)),
        active_limits: outcome.active_limits(),
        violated_limits: outcome.violated_limits(),
        active_inequalities: outcome.active_inequalities(),
        violated_inequalities: outcome.violated_inequalities(),
        contradictions: outcome.contradictions(),
        limit_conflict: outcome.names(&problem.limited.conflicts),
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
        is_posture: false,
        contacts: &[],
        released_by: None,
    });
    let explained = Explained {
        held_by: None,
        comes_too_near: false,
        resolution,
        joints: problem.joints.iter().map(String::as_str).collect(),
        inequalities: problem.constraint_names().into(),
        robot: inputs.robot.as_deref(),
        position: inputs.position.as_deref(),
        causes: resolution
            .active_limits()
            .map(|(joint, active)| problem.limited.cause(joint, active.bound.side))
            .collect(),
        keeps_jerk: false,
        threshold: problem.problem.damping.map(|damping| damping.threshold()),
        conflicts: &problem.limited.conflicts,
        tasks: tasks.collect(),
        request_share: 1.0,
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
