//! Forward kinematics of a tree of joints: the constants of a model, and the loop over its joints.

mod angle;
mod factors;
mod joint_frame;
mod joint_rotations;
mod kinematics;
mod limb;
mod moving_frame;
mod sin_cos;

pub use joint_frame::JointFrame;
pub use kinematics::ForwardKinematics;
pub use moving_frame::vector;
