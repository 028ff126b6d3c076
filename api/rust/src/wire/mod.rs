//! The bodies of the service, in JSON or MessagePack, and nothing else.
//!
//! SI units; the unit stands in the name where a bare number stands alone. Unknown and repeated fields are refused.
//! Vectors of joints follow the robot's joint order, or name their joints.

mod batch;
mod controller;
mod inequality;
mod joints;
mod kinematics;
mod law;
mod live;
mod null_space;
pub mod object;
mod outcome;
mod pose;
mod problem;
mod profile;
mod resolve;
mod robot;
mod schema;
mod simulation;
mod stability;
mod step;
pub mod string_or_map;
mod terms;
mod watch;
mod words;

pub use batch::{BatchAnswer, BatchItem, BatchRequest};
pub use controller::{Controller, ControllerTask, CreatedController, SessionEntry, SessionList, SessionStatus};
pub use inequality::{ActiveInequality, Inequality, ViolatedInequality};
pub use joints::JointVector;
pub use kinematics::{KinematicsAnswer, KinematicsRequest, LinkFrame};
pub use law::{Law, PostureTarget};
pub use live::{ArmView, Interactive, JointView, LiveFrame, LiveSample, PathCounts, SimulationControl, TimeHistogram};
pub use null_space::{NullSpaceMotion, NullSpaceVelocity};
pub use object::Object;
pub use outcome::{ActiveLimit, Singularity, SolverReport, TaskOutcome, ViolatedLimit};
pub use pose::{Frame, Orientation, Pose, TargetPose};
pub use problem::Problem;
pub use profile::{PerAxis, Profile, ProfilePoint};
pub use resolve::{ResolveAnswer, ResolveRequest, ResolveTask};
pub use robot::{DenavitHartenberg, Robot, RobotJoint, RobotList, RobotRegistration, RobotSource};
pub use simulation::{Simulation, SimulationMetrics, SimulationState};
pub use stability::{Environment, EnvironmentAxis, StabilityAnswer, StabilityRequest};
pub use step::{ActiveLimitName, FramePose, Memory, State, StepAnswer, StepRequest, Wrench};
pub use terms::{
    Axis, Damping, JointKind, LimitKind, Limits, Method, Path, Side, Solver, Status, WrenchConvention, WrenchFrame,
};
pub use watch::WatchedStep;
