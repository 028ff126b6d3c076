//! Stability margins of one axis in contact or in free space: maximum lag, maximum delay, minimum and maximum damping.
//!
//! One axis of a force, impedance or hybrid law touches an environment M_e Ẍ + B_e Ẋ + K_e X. The inner velocity loop
//! of the arm has a first-order lag τ and a delay of d whole periods. Together they are a linear map from period to
//! period:
//!
//! - F_e = M_e (v − v⁻)/T + B_e v + K_e x,
//! - u ← u + T M_d⁻¹ (−F_e − B_d Ẋ − K_d x), the integrator of the law. Its set-point does not affect stability. Ẋ = v if
//!   the joint velocity is measured; otherwise Ẋ = u, the last command.
//! - the velocity follows the delayed command a (u of d periods ago): v ← a + (v − a) e^(−T/τ); x ← the integral of v.
//!
//! The loop is stable if the spectral radius of the map is below 1. The map is exact, not an approximation: controller
//! and arm carry out the same recursion.
//!
//! For T → 0 and no delay, the characteristic polynomials are M_d τ s³ + M_d s² + B_d s + K_e (measured velocity) and
//! M_d τ s³ + (M_d + B_d τ) s² + B_d s + K_e (commanded velocity). They give the maximum lags B_d/K_e and
//! M_d B_d/(M_d K_e − B_d²).
//!
//! Free space is the environment M_e = B_e = K_e = 0. The loop then still contains the drive, so too large a B_d or K_d makes
//! it unstable.

mod contact_loop;
mod margin;
mod search;
mod spectrum;
mod stability_error;

pub use contact_loop::ContactLoop;
pub use margin::Margin;
pub use search::{MAX_DELAY_PERIODS, StableDamping};
pub use spectrum::EigenvalueError;
pub use stability_error::StabilityError;

#[cfg(test)]
mod tests;
