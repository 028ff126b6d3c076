//! The wrench that a sensor measures, and the wrench on the environment that the laws read.
//!
//! | step | file | what it does |
//! |---|---|---|
//! | 1 | `convention.rs` | axes and sign of a reading |
//! | 2 | `sensor.rs` | bias b, and all that is known of a sensor |
//! | 3 | `load.rs` | weight and inertia of what the sensor carries |
//! | 4 | `process.rs` | the steps in order: bias, sign, load, low-pass, deadband, and from the sensor to the tip |
//!
//! `tare.rs` finds the bias with a known load in one posture; [`payload`](crate::payload) finds both in six postures or more.

mod convention;
mod load;
mod process;
mod sensor;
mod six;
mod tare;

pub use convention::{WrenchConvention, WrenchFrame, WrenchTerms};
pub use load::Load;
pub use process::{ArmReading, SensorState};
pub use sensor::{GRAVITY, WrenchSensor, WrenchSensorError};
pub use six::Wrench;
pub use tare::{MIN_TARE_READINGS, TARE_MOTION, TARE_NOISE, Tare, TareError, TareReading, tare};
