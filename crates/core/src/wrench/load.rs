//! What a sensor carries.

use nalgebra::Vector3;

use super::Wrench;

/// A rigid body behind a sensor: all that moves with the tool and is no part of the environment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Load {
    /// m, kg.
    pub mass: f64,
    /// c, centre of mass along the axes of the sensor, from its origin, m.
    pub center_of_mass: Vector3<f64>,
}

impl Load {
    /// Returns the wrench of the load on its sensor, along the axes of the sensor, about its origin: f = m (g − a), t = c × f.
    ///
    /// `specific_force`: g − a, gravity less the acceleration of the centre of mass, along the axes of the sensor, m/s². The
    /// angular acceleration is left out: the load has no moment of inertia about its centre.
    pub fn wrench(&self, specific_force: &Vector3<f64>) -> Wrench {
        let force = self.mass * specific_force;
        Wrench { force, torque: self.center_of_mass.cross(&force) }
    }
}
