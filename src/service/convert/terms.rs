//! Words of the interface and their meaning in the library.

use revprio_api::wire;
use revprio_core::controller::{WrenchConvention, WrenchFrame};
use revprio_core::limits::LimitKind;
use revprio_core::resolution::{Method, Path, Side, Solver, Status};
use revprio_robot::JointKind;
use revprio_robot::kinematics::Axis;

/// Pairs the variants of two enums of the same words.
macro_rules! same_words {
    ($name:ident: $from:ty => $to:ty { $($variant:ident),+ }) => {
        /// The same word.
        pub fn $name(word: $from) -> $to {
            match word { $(<$from>::$variant => <$to>::$variant),+ }
        }
    };
}

same_words!(axis: wire::Axis => Axis { X, Y, Z, Rx, Ry, Rz });
same_words!(method: wire::Method => Method { Pseudoinverse, DampedLeastSquares, TaskPriority, SingularityRobust, ReversePriority, StrictReversePriority });
same_words!(solver: wire::Solver => Solver { ClosedForm, Qp, Auto });
same_words!(limit_kind: wire::LimitKind => LimitKind { None, Velocity, PositionVelocity, PositionVelocityAcceleration });
same_words!(wrench_convention: wire::WrenchConvention => WrenchConvention { OnEnvironment, OnTool });
same_words!(wrench_frame: wire::WrenchFrame => WrenchFrame { Base, Tool });
same_words!(side: wire::Side => Side { Lower, Upper });
same_words!(side_answer: Side => wire::Side { Lower, Upper });
same_words!(path_answer: Path => wire::Path { ClosedForm, ActiveSet, Qp });
same_words!(status_answer: Status => wire::Status { Optimal, NotCertified, Failed });
same_words!(joint_kind_answer: JointKind => wire::JointKind { Revolute, Prismatic });
