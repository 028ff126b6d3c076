//! Experiments with simulated robot arms: run a scenario against any [`revprio_api::Service`], record it, measure it, draw
//! it, and sweep its parameters.
//!
//! | to | use |
//! |---|---|
//! | choose or read an experiment | [`simulator::Scenario::find`] |
//! | run it against a service | [`simulator::run()`], [`simulator::run_robot`] for your own robot |
//! | save and read recordings as CSV, JSON lines, Parquet or MCAP | [`simulator::recording`] |
//! | send recorded states again and compare the answers | [`simulator::replay`] |
//! | compute metrics | [`metrics::Metrics`] |
//! | write tables, figures and an HTML page | [`report`] |
//! | run a scenario with many values of its parameters | [`sweep`] |
//!
//! ```no_run
//! use std::ops::ControlFlow;
//!
//! use revprio_api::Client;
//! use revprio_lab::metrics::Metrics;
//! use revprio_lab::simulator::{CallMode, Scenario, run};
//!
//! let scenario = Scenario::find("stiff_wall")?;
//! let client = Client::new("http://127.0.0.1:8080");
//! let recording = run(&scenario, &client, CallMode::Session, |_| ControlFlow::Continue(()))?;
//! println!("final force: {:?} N", Metrics::of(&recording).final_force);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Without the feature `files`, the crate has no files of recordings, reports, figures and sweeps, and fewer dependencies.
//!
//! The simulator does not use the control code of revprio. It sends measured states and moves with the velocities that it
//! receives, like a client with a real arm. The same scenario and seed give the same recording, to the last bit.

pub mod metrics;
pub mod number;
#[cfg(feature = "files")]
pub mod report;
pub mod simulator;
#[cfg(feature = "files")]
pub mod sweep;
