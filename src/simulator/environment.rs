//! All that the tool touches: Eq. (36) along each direction.

use nalgebra::Vector3;

use super::contact::Contact;
use super::energy::Energy;
use super::flaw::Flaw;
use super::surface::Surface;

/// Most contacts of a scenario.
const MOST_CONTACTS: usize = 100;

/// All contacts at work.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    surfaces: Vec<Surface>,
    start: Vector3<f64>,
}

impl Environment {
    /// Contacts placed relative to the tool's start position (base frame, m).
    pub fn new(contacts: &[Contact], start: [f64; 3]) -> Result<Self, Flaw> {
        if contacts.len() > MOST_CONTACTS {
            return Err(Flaw::new("/contacts", format!("are more than {MOST_CONTACTS}")));
        }
        let surface = |(i, contact)| Surface::new(contact, &format!("/contacts/{i}"));
        let surfaces = contacts.iter().enumerate().map(surface).collect::<Result<_, _>>()?;
        Ok(Self { surfaces, start: start.into() })
    }

    /// F_e on the environment (N, base axes) at a tool position (m) and velocity (m/s), at a time (s) that is `dt` (s)
    /// after that of the last step.
    pub fn step(&mut self, position: [f64; 3], velocity: [f64; 3], time_s: f64, dt: f64) -> [f64; 3] {
        let way = Vector3::from(position) - self.start;
        let forces = self.surfaces.iter_mut().map(|surface| surface.step(way, velocity.into(), time_s, dt));
        forces.sum::<Vector3<f64>>().into()
    }

    /// Way to the nearest wall or plane, m, negative in contact, at the last step; `None` without one.
    pub fn wall_distance(&self) -> Option<f64> {
        self.surfaces.iter().filter_map(Surface::distance).min_by(f64::total_cmp)
    }

    /// What all contacts took and kept so far.
    pub fn energy(&self) -> Energy {
        self.surfaces.iter().map(Surface::energy).sum()
    }
}
