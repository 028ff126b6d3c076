//! The bodies of requests and answers, for JSON or MessagePack.
//!
//! Units are SI; the name of a single number contains its unit. Unknown and repeated fields are refused. Vectors of
//! joints follow the joint order of the robot, or name their joints.

mod bounds;
mod certificate;
mod channel;
mod collision;
mod contact;
mod controller;
mod defaults;
mod drive;
mod enums;
mod inequality;
pub mod integer;
mod joints;
mod kinematics;
mod law;
mod live;
pub mod object;
mod outcome;
mod pose;
mod problem;
mod profile;
pub mod read_error;
mod resolve;
mod robot;
mod simulation;
mod stability;
mod state_checks;
mod step;
mod streaming;
pub mod string_or_map;
mod string_tags;
mod virtual_arm;
mod wrench;
mod wrench_sensor;

pub use certificate::{Certificate, CertificatePart, CertifiedLevel, CertifiedProblem, LevelMultipliers, RowName};
pub use channel::{Channel, ChannelInput, ChannelKind, ChannelMemory, ChannelTarget};
pub use collision::{
    Capsule, CollisionPairs, CollisionReport, CollisionRows, Collisions, Cuboid, HalfSpace, LeftOutPair, LinkShape,
    ObstacleState, PairDistance, RobotShapes, RoomObstacle, ShapeSource, Sphere,
};
pub use contact::{
    ContactFault, ContactMemory, ContactReport, ContactState, MeasuredContact, NormalMemory, SurfaceFollowing,
    SurfaceReport,
};
pub use controller::{Controller, ControllerTask, CreatedController, SessionEntry, SessionList, SessionStatus};
pub use drive::{DriveState, JointDrive};
pub use enums::{
    AntiWindup, Axis, Damping, JointKind, LimitKind, Limits, Method, Path, Side, Solver, Status, WrenchConvention,
    WrenchFrame,
};
pub use inequality::{ActiveInequality, Inequality, ViolatedInequality};
pub use joints::{JointVector, NullSpaceMotion, NullSpaceVelocity};
pub use kinematics::{KinematicsAnswer, KinematicsRequest, LinkFrame, TipPose};
pub use law::{Law, LawTarget, MotionPath, PostureTarget};
pub use live::{
    ArmView, ChainView, JointView, LiveContact, LiveFrame, LiveRoom, LiveSample, PathCounts, SimulationControl,
    TimeHistogram, WatchedStep,
};
pub use object::Object;
pub use outcome::{
    ActiveLimit, ActiveRow, Contradiction, ContradictionMember, Singularity, SolverLevel, SolverReport, TaskOutcome,
    ViolatedLimit,
};
pub use pose::{Frame, Orientation, Pose, TargetPose};
pub use problem::Problem;
pub use profile::{PerAxis, Profile, ProfilePoint};
pub use resolve::{BatchAnswer, BatchItem, BatchRequest, ResolveAnswer, ResolveRequest, ResolveTask};
pub use robot::{
    DenavitHartenberg, LeftOutJoint, LeftOutReason, RegisteredTip, Robot, RobotChain, RobotJoint, RobotList,
    RobotRegistration, RobotSource, RobotTip, StatedLimits, TipReason, VelocityEnvelope,
};
pub use simulation::{Interactive, Simulation, SimulationMetrics, SimulationState};
pub use stability::{Environment, EnvironmentAxis, StabilityAnswer, StabilityRequest};
pub use state_checks::StateChecks;
pub use step::{
    ActiveLimitName, FramePose, JerkState, JointTurns, Memory, Obstacle, Progress, RestState, Stall, State, StepAnswer,
    StepRequest, StuckTask, TaskGain,
};
pub use streaming::{
    ChunkAction, ChunkAlign, ChunkMemory, ChunkStatus, Fade, LaterTarget, StreamedPose, StreamedQuantity,
    StreamedTarget, Streaming, TargetAhead, TargetReference, TargetSample, TargetState, TargetStream,
};
pub use virtual_arm::{Line, VirtualArm};
pub use wrench::Wrench;
pub use wrench_sensor::{
    Payload, PayloadAnswer, PayloadReading, PayloadRequest, RestReading, TareAnswer, TareRequest, WrenchSensor,
    WrenchSensorMemory,
};
