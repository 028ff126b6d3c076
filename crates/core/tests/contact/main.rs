//! The contact law against walls of unknown stiffness, one axis.
//!
//! `cargo run --release -p revprio-core --example contact_grid` measures all conditions; these tests are a part of them.

mod claim;
mod events;
#[expect(dead_code, reason = "the example uses the rest")]
mod grid;
mod held_back;
mod laws;
#[expect(dead_code, reason = "the example uses the rest")]
mod passivity;
mod plant;
mod pressing;
