//! Robots read from URDF, the Unified Robot Description Format.
//!
//! Only links and joints are read, and `<collision>` elements if they are asked for. Materials, inertias, transmissions and plug-ins
//! are ignored, and no file that the text names is opened. A robot is either the serial chain from one link, the base, to another, the tip, and
//! other branches are left out; or it is the whole tree below the base. Fixed joints become constant transforms; the other
//! joints become the joints of the model.

mod arms;
mod bodies;
mod chain;
mod document;
mod error;
mod joint;
mod joints;
mod options;
mod serial;
mod tree;
mod words;

pub use bodies::{BodyForm, LinkBodies, LinkBody};
pub(crate) use document::{parse, robot};
pub use error::UrdfError;
pub use options::{UrdfOptions, UrdfTip, UrdfTreeOptions};

#[cfg(test)]
mod tests;
