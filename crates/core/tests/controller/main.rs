//! Tests of the controller and its laws in closed loop with a simulated arm.

mod anti_windup;
mod arms;
mod best_line;
mod bounds;
mod braking;
mod causes;
mod changing_room;
mod collisions;
mod constraints;
mod drives;
mod fast_targets;
mod frames;
mod free_space;
mod gaze;
mod hold;
mod jerk;
mod late_states;
mod laws;
mod lengths;
mod limits;
mod long_chains;
mod lost_link;
mod memory;
mod outstretched;
mod planes;
mod positions;
mod rest;
#[path = "../solvers/mod.rs"]
mod solvers;
mod stalls;
mod streaming;
mod stuck;
mod targets;
mod tracking;
mod transition;
mod two_arms;
