//! The bodies of the service, in JSON or MessagePack, and nothing else.
//!
//! SI units; the unit stands in the name where a bare number stands alone. Unknown and repeated fields are refused.
//! Vectors of joints follow the robot's joint order, or name their joints.

mod batch;
mod controller;
mod joints;
mod kinematics;
pub(crate) mod object;
mod outcome;
mod pose;
mod problem;
mod resolve;
mod robot;
mod simulation;
mod stability;
mod step;
pub(crate) mod string_or_map;
mod terms;
mod watch;

pub use batch::{BatchAnswer, BatchItem, BatchRequest};
pub use controller::{Controller, ControllerTask, CreatedController, Law, Profile, SessionStatus};
pub use joints::JointVector;
pub use kinematics::{KinematicsAnswer, KinematicsRequest, LinkFrame};
pub use object::Object;
pub use outcome::{ActiveLimit, Singularity, SolverReport, TaskOutcome, ViolatedLimit};
pub use pose::{Orientation, Pose, TargetPose};
pub use problem::Problem;
pub use resolve::{ResolveAnswer, ResolveRequest, ResolveTask};
pub use robot::{DenavitHartenberg, Robot, RobotJoint, RobotList};
pub use simulation::{Simulation, SimulationMetrics, SimulationState};
pub use stability::{EnvironmentAxis, StabilityAnswer, StabilityRequest};
pub use step::{ActiveLimitName, FramePose, Memory, State, StepAnswer, StepRequest, Wrench};
pub use terms::{Axis, Damping, JointKind, LimitKind, Limits, Method, Path, Side, Solver, Status, WrenchConvention};
pub use watch::WatchedStep;
