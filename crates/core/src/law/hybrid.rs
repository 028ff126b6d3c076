//! The hybrid law.
//!
//! It gives an acceleration from the measured wrench. [`Law`](super::Law) integrates it to the velocity of the task.

use revprio_robot::profile::Profile;

use super::gains::Gains;
use super::task_state::{TargetForce, TaskState};
use super::task_vector::TaskVector;

/// The hybrid law M_d ΔẌ + B_d ΔẊ + K_d S ΔX = (I − S) F_d − F_e: some axes follow a force, the others a pose.
///
/// S is diagonal, 1 on position-controlled axes and 0 on force-controlled axes. The target X_d may move.
///
/// Paper: Eqs. (48)-(51). Departs: (53) prints the wrong index; the resolution uses each task's own velocity.
#[derive(Debug, Clone, PartialEq)]
pub struct HybridLaw {
    gains: Gains,
    pub(super) target_force: Profile,
    position_controlled: Vec<bool>,
}

impl HybridLaw {
    /// Builds a law with S = `position_controlled` (true: the axis follows the pose) and F_d = `target_force` (N, N·m).
    ///
    /// Returns `None` unless both have as many rows as the gains.
    pub fn new(gains: Gains, target_force: Profile, position_controlled: Vec<bool>) -> Option<Self> {
        let rows = gains.rows();
        (target_force.rows() == rows && position_controlled.len() == rows).then_some(Self {
            gains,
            target_force,
            position_controlled,
        })
    }

    /// Returns m, the number of rows.
    pub fn rows(&self) -> usize {
        self.gains.rows()
    }

    /// Returns F_d at time t, N and N·m; `None` on position-controlled axes.
    pub fn target_force(&self, time_s: f64) -> TargetForce {
        let force = self.target_force.at(time_s).value;
        force.iter().zip(&self.position_controlled).map(|(&f, &position)| (!position).then_some(f)).collect()
    }

    /// Returns Ẍ = Ẍ_d + M_d⁻¹ ((I − S) F_d − F_e − B_d ΔẊ − K_d S ΔX), m/s² and rad/s².
    pub fn acceleration(&self, state: &TaskState) -> TaskVector {
        let (target, damping) = (state.set_point(&self.target_force), self.gains.damping());
        let relative_velocity = state.relative_velocity();
        let pull = |row: usize| {
            if self.position_controlled[row] {
                -self.gains.stiffness()[row] * state.displacement[row]
            } else {
                target[row]
            }
        };
        let relative =
            self.gains.accelerate(|row| pull(row) - state.force[row] - damping[row] * relative_velocity[row]);
        &state.target_acceleration + &relative
    }
}

#[cfg(test)]
mod tests {
    use super::super::force::ForceLaw;
    use super::super::impedance::ImpedanceLaw;
    use super::*;

    fn gains() -> Gains {
        Gains::new(2, &[15.0, 80.0], &[150.0, 280.0], &[1000.0, 100.0]).unwrap()
    }

    fn state() -> TaskState {
        TaskState {
            time_s: 0.3,
            velocity: TaskVector::from_slice(&[0.1, -0.2]),
            displacement: TaskVector::from_slice(&[0.01, 0.05]),
            target_velocity: TaskVector::from_slice(&[0.0, 0.3]),
            target_acceleration: TaskVector::from_slice(&[0.0, -0.7]),
            force: TaskVector::from_slice(&[4.0, -3.0]),
            streamed: None,
        }
    }

    fn target() -> Profile {
        Profile::constant(vec![30.0, 2.0]).unwrap()
    }

    #[test]
    fn hybrid_is_the_force_law_on_force_axes_and_the_impedance_law_on_position_axes() {
        let hybrid = |s: [bool; 2]| HybridLaw::new(gains(), target(), s.to_vec()).unwrap().acceleration(&state());
        let impedance = ImpedanceLaw::new(gains()).acceleration(&state());
        // The force law has no target pose. On the first axis the target rests, so there both laws must agree.
        let force = ForceLaw::new(gains(), target()).unwrap().acceleration(&state());
        assert_eq!(hybrid([false, false])[0], force[0]);
        assert!((&hybrid([true, true]) - &impedance).to_vector().amax() < 1e-15);
        assert!(
            (&hybrid([false, true]) - &TaskVector::from_slice(&[force[0], impedance[1]])).to_vector().amax() < 1e-15
        );
    }

    #[test]
    fn the_laws_are_the_printed_equations() {
        let force = ForceLaw::new(gains(), target()).unwrap().acceleration(&state());
        assert!((force[0] - (30.0 - 4.0 - 150.0 * 0.1) / 15.0).abs() < 1e-15);
        let impedance = ImpedanceLaw::new(gains()).acceleration(&state());
        assert!((impedance[1] - (-0.7 + (280.0 * (0.2 + 0.3) - 100.0 * 0.05 + 3.0) / 80.0)).abs() < 1e-15);
    }
}
