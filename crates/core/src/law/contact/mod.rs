//! The contact law: presses with a force on a surface whose stiffness is unknown.
//!
//! The law does not control the force through lag and delay. It estimates where the tool must rest to press with F_d, and
//! moves the position of rest there, which has neither lag nor delay:
//!
//! x* = x_s + (F_d − F)/K̂, u = (x* − p)/τ_c,
//!
//! where p is the position of rest behind the drive, x_s the position as the force sensor sees it, and K̂ an upper estimate of
//! the stiffness. `docs/contact.md` has the states, the derivation, the proofs and what was measured.
//!
//! All positions, velocities and forces are along the pressing direction of an axis: positive towards the surface.

mod approach;
mod axis;
mod contradiction;
mod estimate;
mod following;
mod law;
mod motion;
mod report;
mod settings;
mod step;
mod swing;
mod timing;
mod unchanged;

pub use approach::{largest_approach_speed, unavoidable_peak};
pub use axis::{ContactAxis, ContactPhase, FaultCause};
pub use contradiction::ContactContradiction;
pub use estimate::StiffnessEstimate;
pub use following::Following;
pub use law::{ContactLaw, ContactLawError};
pub use motion::SurfaceMotion;
pub use report::ContactReport;
pub use settings::ContactSettings;
pub use step::AxisInput;
pub use swing::Swing;
pub use timing::ContactTiming;
pub use unchanged::Unchanged;
