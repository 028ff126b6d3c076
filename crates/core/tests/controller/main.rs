//! The controller and its laws, through the library.

mod anti_windup;
mod arms;
mod barriers;
mod frames;
mod laws;
mod limits;
mod memory;
mod positions;
mod targets;
