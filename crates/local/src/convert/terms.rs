//! Conversion of the enums of the interface to those of the library and back.

use revprio_api::wire;
use revprio_core::controller::{AntiWindup, Obstacle, WrenchConvention, WrenchFrame};
use revprio_core::law::{FaultCause, MotionPath};
use revprio_core::limits::LimitKind;
use revprio_core::resolution::{Method, Path, Side, Solver, Status};
use revprio_core::streaming::{Quantity, TargetState};
use revprio_robot::kinematics::Axis;
use revprio_robot::{JointKind, LeftOutReason, TipReason};

/// Defines a conversion between two enums with the same variants. Two names define it in both directions.
macro_rules! same_variants {
    ($name:ident, $back:ident: $from:ty => $to:ty { $($variant:ident),+ }) => {
        same_variants!($name: $from => $to { $($variant),+ });
        same_variants!($back: $to => $from { $($variant),+ });
    };
    ($name:ident: $from:ty => $to:ty { $($variant:ident),+ }) => {
        /// Converts to the variant of the same name.
        pub fn $name(value: $from) -> $to {
            match value { $(<$from>::$variant => <$to>::$variant),+ }
        }
    };
}

same_variants!(motion_path: wire::MotionPath => MotionPath { Joint, Straight });
same_variants!(fault, fault_answer: wire::ContactFault => FaultCause { Pull, StaysInRetreat, ForceLimit, Stuck });
same_variants!(axis: wire::Axis => Axis { X, Y, Z, Rx, Ry, Rz });
same_variants!(method: wire::Method => Method { Pseudoinverse, DampedLeastSquares, TaskPriority, SingularityRobust, ReversePriority, StrictReversePriority });
same_variants!(solver: wire::Solver => Solver { ClosedForm, Qp, Auto });
same_variants!(limit_kind: wire::LimitKind => LimitKind { None, Velocity, PositionVelocity, PositionVelocityAcceleration });
same_variants!(wrench_convention: wire::WrenchConvention => WrenchConvention { OnEnvironment, OnTool });
same_variants!(anti_windup: wire::AntiWindup => AntiWindup { Always, ExceptDamping });
same_variants!(wrench_frame: wire::WrenchFrame => WrenchFrame { Base, Tool });
same_variants!(side, side_answer: wire::Side => Side { Lower, Upper });
same_variants!(quantity, quantity_answer: wire::StreamedQuantity => Quantity { Pose, JointPosition, Velocity, Force });
same_variants!(target_state, target_state_answer: wire::TargetState => TargetState { Following, Extrapolating, Holding, Braking });
same_variants!(tip_reason_answer: TipReason => wire::TipReason { Request, OnlyEnd, ToolName, BeforeGripper, LastLink });
same_variants!(left_out_answer: LeftOutReason => wire::LeftOutReason { Gripper, Head, LegOrWheel, Sensor, Unsupported, BeyondTip, OtherBranch, NotBelowBase });
same_variants!(path_answer: Path => wire::Path { ClosedForm, ActiveSet, Qp });
same_variants!(status_answer: Status => wire::Status { Optimal, NotCertified, Failed });
same_variants!(obstacle_answer: Obstacle => wire::Obstacle { Limits, Singularity, HigherTasks });
same_variants!(joint_kind_answer: JointKind => wire::JointKind { Revolute, Prismatic });
