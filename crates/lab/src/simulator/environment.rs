//! All contacts of the tool: Eq. (36) along each direction.

use nalgebra::Vector3;

use super::contact::{Contact, ContactKind};
use super::door::Door;
use super::energy::Energy;
use super::field_error::FieldError;
use super::surface::Surface;

/// Largest number of contacts of a scenario.
const MAX_CONTACTS: usize = 100;

/// The state of all contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    bodies: Vec<Body>,
    start: Vector3<f64>,
}

/// What the tool touches or holds.
#[derive(Debug, Clone, PartialEq)]
enum Body {
    Surface(Box<Surface>),
    Door(Box<Door>),
}

impl Body {
    fn new(contact: &Contact, pointer: &str) -> Result<Self, FieldError> {
        if contact.kind == ContactKind::Door {
            return Door::new(contact, pointer).map(|door| Self::Door(Box::new(door)));
        }
        Surface::new(contact, pointer).map(|surface| Self::Surface(Box::new(surface)))
    }

    fn step(&mut self, displacement: Vector3<f64>, velocity: Vector3<f64>, time_s: f64, dt: f64) -> Vector3<f64> {
        match self {
            Self::Surface(surface) => surface.step(displacement, velocity, time_s, dt),
            Self::Door(door) => door.step(displacement, velocity, dt),
        }
    }

    fn distance(&self) -> Option<f64> {
        match self {
            Self::Surface(surface) => surface.distance(),
            Self::Door(_) => None,
        }
    }

    fn energy(&self) -> Energy {
        match self {
            Self::Surface(surface) => surface.energy(),
            Self::Door(door) => door.energy(),
        }
    }
}

impl Environment {
    /// Returns the contacts, placed relative to the tool's start position (base frame, m).
    pub fn new(contacts: &[Contact], start: [f64; 3]) -> Result<Self, FieldError> {
        if contacts.len() > MAX_CONTACTS {
            return Err(FieldError::new("/contacts", format!("has more than {MAX_CONTACTS} contacts")));
        }
        let body = |(i, contact)| Body::new(contact, &format!("/contacts/{i}"));
        let bodies = contacts.iter().enumerate().map(body).collect::<Result<_, _>>()?;
        Ok(Self { bodies, start: start.into() })
    }

    /// Advances by `dt` (s) to a tool position (m), a tool velocity (m/s) and a time (s). Returns the force F_e on the
    /// environment (N, base axes).
    pub fn step(&mut self, position: [f64; 3], velocity: [f64; 3], time_s: f64, dt: f64) -> [f64; 3] {
        let displacement = Vector3::from(position) - self.start;
        let forces = self.bodies.iter_mut().map(|body| body.step(displacement, velocity.into(), time_s, dt));
        forces.sum::<Vector3<f64>>().into()
    }

    /// Returns the distance to the nearest surface at the last step, m, negative in contact; `None` without one.
    pub fn wall_distance(&self) -> Option<f64> {
        self.bodies.iter().filter_map(Body::distance).min_by(f64::total_cmp)
    }

    /// Returns the energy of all contacts so far.
    pub fn energy(&self) -> Energy {
        self.bodies.iter().map(Body::energy).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::contact::{ContactKind, Friction};
    use super::*;
    use revprio_api::wire::{PerAxis, Profile};

    fn contact(kind: ContactKind, offset_m: f64) -> Contact {
        Contact {
            axis: Some(0),
            normal: None,
            kind,
            offset_m,
            radius_m: None,
            motion: None,
            stiffness: 1000.0,
            damping: 10.0,
            inertia: 2.0,
            friction: None,
            hole: None,
            edge: None,
            hinge: None,
        }
    }

    fn environment(contact: Contact, start: [f64; 3]) -> Environment {
        Environment::new(&[contact], start).unwrap()
    }

    #[test]
    fn spring_pushes_and_pulls() {
        let mut spring = environment(contact(ContactKind::Spring, 0.0), [1.0, 2.0, 3.0]);
        assert!((spring.step([0.9, 2.5, 3.0], [0.0; 3], 0.0, 0.01)[0] + 100.0).abs() < 1e-9);
        let force = spring.step([1.1, 2.5, 3.0], [0.5, 9.0, 0.0], 0.01, 0.01);
        assert!((force[0] - (100.0 + 5.0 + 2.0 * 50.0)).abs() < 1e-9);
        assert_eq!(force[1..], [0.0, 0.0]);
        assert_eq!(spring.wall_distance(), None);
    }

    #[test]
    fn wall_never_pulls() {
        for side in [1.0, -1.0] {
            let mut wall = environment(contact(ContactKind::Wall, 0.05 * side), [0.0; 3]);
            let mut step = |x: f64, v: f64| wall.step([x * side, 0.0, 0.0], [v * side, 0.0, 0.0], 0.0, 0.01)[0];
            assert_eq!(step(0.04, 0.0), 0.0);
            assert!((step(0.06, 0.0) - 10.0 * side).abs() < 1e-9);
            // Fast withdrawal: damping alone would pull.
            assert_eq!(step(0.051, -1.0), 0.0);
            step(0.02, 0.0);
            assert!((wall.wall_distance().unwrap() - 0.03).abs() < 1e-15);
        }
    }

    #[test]
    fn plane_normal_to_an_axis_equals_a_wall() {
        let wall = contact(ContactKind::Wall, -0.05);
        let plane = Contact {
            axis: None,
            normal: Some([3.0, 0.0, 0.0]),
            kind: ContactKind::Plane,
            offset_m: 0.05,
            ..wall.clone()
        };
        let force = |contact: &Contact| {
            environment(contact.clone(), [0.0; 3]).step([-0.07, 1.0, 2.0], [-0.1, 0.0, 0.0], 0.0, 0.01)
        };
        assert_eq!(force(&plane), force(&wall));
    }

    #[test]
    fn moving_wall_follows_its_profile() {
        let motion =
            Profile::Ramp { start: PerAxis::All(0.0), end: PerAxis::All(-0.03), start_time_s: 0.0, duration_s: 1.0 };
        let mut wall =
            environment(Contact { motion: Some(motion), inertia: 0.0, ..contact(ContactKind::Wall, 0.05) }, [0.0; 3]);
        assert_eq!(wall.step([0.04, 0.0, 0.0], [0.0; 3], 0.1, 0.1)[0], 0.0);
        // Depth 5 mm; the wall approaches at 0.03 m/s.
        assert!((wall.step([0.04, 0.0, 0.0], [0.0; 3], 0.5, 0.4)[0] - (5.0 + 0.3)).abs() < 1e-9);
    }

    #[test]
    fn friction_acts_along_the_motion_and_not_at_rest() {
        let friction = Friction { coulomb: 0.5, viscous: 2.0, sticking_speed_m_s: 1e-6 };
        let floor = Contact { friction: Some(friction), damping: 0.0, inertia: 0.0, ..contact(ContactKind::Wall, 0.0) };
        let force = |y: f64| environment(floor.clone(), [0.0; 3]).step([0.01, 0.0, 0.0], [0.0, y, 0.0], 0.0, 0.01);
        assert!((force(0.1)[1] - (0.5 * 10.0 + 0.2)).abs() < 1e-6);
        assert!((force(-0.1)[1] + 5.2).abs() < 1e-6);
        assert_eq!(force(0.0)[1], 0.0);
    }

    /// A ball of 0.4 m that is 1 mm deep in the tool's way, on a tool that slides around it at a constant depth.
    #[test]
    fn curved_surface_presses_along_its_normal_and_rubs_along_the_motion() {
        let ball = Contact {
            axis: None,
            normal: Some([0.0, 0.0, 1.0]),
            radius_m: Some(0.4),
            friction: Some(Friction { coulomb: 0.5, viscous: 0.0, sticking_speed_m_s: 1e-9 }),
            ..contact(ContactKind::Sphere, 0.001)
        };
        let mut ball = environment(ball, [0.5, 0.1, 0.2]);
        // The middle is 0.401 m below the start.
        let middle = Vector3::new(0.5, 0.1, 0.2 - 0.401);
        let work = |steps: u32, ball: &mut Environment| {
            for step in 0..=steps {
                let angle = 0.5 * f64::from(step) / f64::from(steps);
                let [outward, along] = [[angle.sin(), 0.0, angle.cos()], [angle.cos(), 0.0, -angle.sin()]];
                let [outward, along] = [outward, along].map(Vector3::from);
                let place = middle + outward * 0.399;
                let force = ball.step(place.into(), (along * 0.1).into(), 0.0, 0.399 * 5.0 / f64::from(steps));
                // 1000 N/m and 1 mm; the speed along the normal is zero.
                assert!((Vector3::from(force) - (-outward + along * 0.5)).norm() < 1e-6, "{force:?}");
            }
            ball.energy()
        };
        let energy = work(1000, &mut ball);
        // 0.5 N along an arc of 0.5 rad, and the 0.5 mJ that the surface has stored at the start.
        assert!((energy.dissipated_j - 0.5 * 0.399 * 0.5).abs() < 1e-6, "{energy:?}");
        assert!((energy.stored_j - 0.5e-3).abs() < 1e-9 && energy.imbalance_j().abs() < 1e-6, "{energy:?}");
    }

    #[test]
    fn moving_cylinder_shifts_as_a_whole() {
        let motion = Profile::Constant { value: PerAxis::All(0.02) };
        let bar = Contact {
            axis: Some(1),
            normal: Some([0.0, 0.0, 1.0]),
            radius_m: Some(0.3),
            motion: Some(motion),
            ..contact(ContactKind::Cylinder, 0.01)
        };
        let mut bar = environment(bar, [0.0; 3]);
        bar.step([0.1, 0.7, 0.0], [0.0; 3], 0.0, 0.01);
        let distance = 0.1_f64.hypot(0.33) - 0.3;
        assert!((bar.wall_distance().unwrap() - distance).abs() < 1e-15);
    }

    /// Moves a tool into a wall, along it and out again within 1 s, in `steps` time steps. Returns the normal force every
    /// 10 ms, and the energy.
    fn bounce(steps: u32) -> (Vec<f64>, Energy) {
        let dt = 1.0 / f64::from(steps);
        let friction = Friction { coulomb: 0.3, viscous: 1.0, sticking_speed_m_s: 1e-2 };
        let wall =
            Contact { stiffness: 1e4, damping: 20.0, friction: Some(friction), ..contact(ContactKind::Wall, 0.01) };
        let mut wall = environment(wall, [0.0; 3]);
        let mut forces = Vec::new();
        for step in 0..=steps {
            let t = f64::from(step) * dt;
            let position = [0.02 * (std::f64::consts::TAU * t).sin(), 0.1 * t, 0.0];
            let velocity = [0.02 * std::f64::consts::TAU * (std::f64::consts::TAU * t).cos(), 0.1, 0.0];
            let force = wall.step(position, velocity, t, dt);
            if step % (steps / 100) == 0 {
                forces.push(force[0]);
            }
        }
        (forces, wall.energy())
    }

    #[test]
    fn forces_converge_with_finer_steps() {
        let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let [coarse, fine, finest] = [1000, 10_000, 100_000].map(|steps| bounce(steps).0);
        assert!(distance(&coarse, &finest) < 0.1, "{}", distance(&coarse, &finest));
        assert!(distance(&fine, &finest) < 0.2 * distance(&coarse, &finest));
    }

    #[test]
    fn energy_balance_improves_with_finer_steps() {
        let [coarse, fine] = [1000, 10_000].map(|steps| bounce(steps).1);
        assert!(coarse.work_j > 0.01 && coarse.dissipated_j > 0.01, "{coarse:?}");
        assert!(coarse.imbalance_j().abs() < 0.02 * coarse.work_j, "{coarse:?}");
        assert!(fine.imbalance_j().abs() < 0.002 * fine.work_j, "{fine:?}");
        // The tool has left the wall, so no energy is stored.
        assert_eq!(coarse.stored_j, 0.0);
    }

    #[test]
    fn surface_dissipates_its_energy_if_the_tool_leaves_too_fast() {
        let mut wall = environment(Contact { inertia: 0.0, ..contact(ContactKind::Wall, 0.0) }, [0.0; 3]);
        wall.step([0.01, 0.0, 0.0], [-5.0, 0.0, 0.0], 0.0, 1e-3);
        for step in 1..=20 {
            let t = f64::from(step) * 1e-3;
            wall.step([0.01 - 5.0 * t, 0.0, 0.0], [-5.0, 0.0, 0.0], t, 1e-3);
        }
        let energy = wall.energy();
        assert!(energy.dissipated_j > 0.7 * 0.5 * 1000.0 * 1e-4 && energy.stored_j == 0.0, "{energy:?}");
    }
}
