//! A door whose handle the tool holds.

use nalgebra::Vector3;

use super::contact::Contact;
use super::energy::Energy;
use super::field_error::{FieldError, not_negative};
use super::shape::{Form, Shape};

/// Iterations of Newton's method. The equation is smooth and nearly linear within a step, and one iteration gives nearly all.
const ITERATIONS: usize = 20;

/// A handle on a circle about a hinge. The tool holds it by a spring that is as stiff in all directions.
///
/// The door has an inertia I, a damping torque b θ̇ and a friction torque up to τ_f. A step is that of the implicit Euler
/// method, so that it is stable for any stiffness, and the door stays where it is while the torque of the tool is below τ_f.
#[derive(Debug, Clone, PartialEq)]
pub struct Door {
    /// The place of the axis of the hinge that is nearest to the handle, relative to the start of the tool, m.
    middle: Vector3<f64>,
    /// Unit vectors: from the hinge to the handle at the start, the motion of the handle there, and the axis.
    axes: [Vector3<f64>; 3],
    radius: f64,
    stiffness: f64,
    damping: f64,
    inertia: f64,
    hinge_damping: f64,
    hinge_friction: f64,
    /// Angle θ from the start, rad.
    angle: f64,
    /// θ̇, rad/s.
    rate: f64,
    last: Option<Grip>,
    energy: Energy,
}

/// The grip at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Grip {
    /// Displacement of the tool from its start, m.
    displacement: Vector3<f64>,
    /// Force of the tool on the handle, N.
    force: Vector3<f64>,
    /// Dissipated power, W.
    dissipation: f64,
}

impl Door {
    /// Returns the door at a JSON pointer.
    pub fn new(contact: &Contact, pointer: &str) -> Result<Self, FieldError> {
        let at = |field: &str| format!("{pointer}/{field}");
        let Shape { inward, form, .. } = Shape::new(contact, pointer)?;
        let Form::Round { axis: Some(axis), radius } = form else {
            return Err(FieldError::new(at("axis"), "is missing; it is x, y or z"));
        };
        for (is_stated, field) in [
            (contact.offset_m != 0.0, "offset_m"),
            (contact.motion.is_some(), "motion"),
            (contact.friction.is_some(), "friction"),
            (contact.inertia != 0.0, "inertia"),
        ] {
            if is_stated {
                return Err(FieldError::new(
                    at(field),
                    "is not for a door, which starts at the tool and has a `hinge`",
                ));
            }
        }
        let hinge = contact.hinge.unwrap_or_default();
        let hinge_value = |value: f64, field: &str| not_negative(value, &at(&format!("hinge/{field}")));
        Ok(Self {
            middle: inward * radius,
            axes: [-inward, axis.cross(&-inward), axis],
            radius,
            stiffness: not_negative(contact.stiffness, &at("stiffness"))?,
            damping: not_negative(contact.damping, &at("damping"))?,
            inertia: hinge_value(hinge.inertia, "inertia")?,
            hinge_damping: hinge_value(hinge.damping, "damping")?,
            hinge_friction: hinge_value(hinge.friction, "friction")?,
            angle: 0.0,
            rate: 0.0,
            last: None,
            energy: Energy::default(),
        })
    }

    /// Returns the energy of grip and door so far.
    pub fn energy(&self) -> Energy {
        self.energy
    }

    /// Returns the angle from the start, rad.
    #[cfg(test)]
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// Advances by `dt` (s) to a displacement of the tool from its start (m) and a velocity (m/s). Returns F_e, N.
    pub fn step(&mut self, displacement: Vector3<f64>, velocity: Vector3<f64>, dt: f64) -> Vector3<f64> {
        let place = displacement - self.middle;
        if self.last.is_some() {
            self.rate = self.next_rate(&place, &velocity, dt);
            self.angle += self.rate * dt;
        }
        let (stretch, slip) = self.grip(&place, &velocity);
        let grip = Grip {
            displacement,
            force: stretch * self.stiffness + slip * self.damping,
            dissipation: self.damping * slip.norm_squared()
                + self.hinge_damping * self.rate.powi(2)
                + self.hinge_friction * self.rate.abs(),
        };
        self.energy.stored_j = 0.5 * (self.stiffness * stretch.norm_squared() + self.inertia * self.rate.powi(2));
        match self.last.replace(grip) {
            Some(last) => {
                self.energy.work_j += 0.5 * (last.force + grip.force).dot(&(displacement - last.displacement));
                self.energy.dissipated_j += 0.5 * (last.dissipation + grip.dissipation) * dt;
            }
            // Energy that is stored at the start counts as work before the start.
            None => self.energy.work_j = self.energy.stored_j,
        }
        grip.force
    }

    /// Returns the unit vectors from the hinge to the handle and along its motion, at an angle.
    fn directions(&self, angle: f64) -> [Vector3<f64>; 2] {
        let (sin, cos) = angle.sin_cos();
        let [out, along, _] = self.axes;
        [out * cos + along * sin, along * cos - out * sin]
    }

    /// Returns how far and how fast the tool is from the handle, m and m/s.
    fn grip(&self, place: &Vector3<f64>, velocity: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let [out, along] = self.directions(self.angle);
        (place - out * self.radius, velocity - along * (self.radius * self.rate))
    }

    /// Returns the rate θ̇ at the end of a step: I (θ̇ − θ̇_0)/dt = τ − b θ̇ − friction, with the torque τ at the end.
    fn next_rate(&self, place: &Vector3<f64>, velocity: &Vector3<f64>, dt: f64) -> f64 {
        let drive = self.inertia * self.rate / dt;
        let at_rest = drive + self.torque(place, velocity, self.angle, 0.0)[0];
        if at_rest.abs() <= self.hinge_friction {
            return 0.0;
        }
        let drive = drive - self.hinge_friction.copysign(at_rest);
        let mut rate = 0.0;
        for _ in 0..ITERATIONS {
            let [torque, slope] = self.torque(place, velocity, self.angle + rate * dt, rate);
            let resistance = self.inertia / dt + self.hinge_damping;
            let next = rate - (resistance * rate - drive - torque) / (resistance - slope * dt + self.drag());
            if (next - rate).abs() <= 1e-12 * next.abs() {
                return next;
            }
            rate = next;
        }
        rate
    }

    /// Returns the torque of the tool about the hinge at an angle and a rate, N·m, and its slope over the angle, N·m/rad.
    fn torque(&self, place: &Vector3<f64>, velocity: &Vector3<f64>, angle: f64, rate: f64) -> [f64; 2] {
        let [out, along] = self.directions(angle);
        let spring = self.radius * self.stiffness;
        let torque =
            spring * place.dot(&along) + self.radius * self.damping * velocity.dot(&along) - self.drag() * rate;
        [torque, -spring * place.dot(&out) - self.radius * self.damping * velocity.dot(&out)]
    }

    /// Returns the damping of the grip about the hinge, N·m·s/rad.
    fn drag(&self) -> f64 {
        self.damping * self.radius.powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const RADIUS: f64 = 0.3;

    /// A door with its hinge 0.3 m from the tool in the direction of y, about z.
    fn door(hinge: &serde_json::Value) -> Door {
        let contact = json!({"kind": "door", "axis": "z", "normal": [0, -1, 0], "radius_m": RADIUS, "stiffness": 1e4,
            "hinge": hinge});
        Door::new(&serde_json::from_value(contact).unwrap(), "").unwrap()
    }

    /// Pulls along x with a constant force (N) by the tool that a spring of the grip holds there, for a time (s). Returns the
    /// angles every step (s).
    fn pulled(door: &mut Door, force: f64, time_s: f64, dt: f64) -> Vec<f64> {
        let mut step = 0.0;
        let mut angles = Vec::new();
        while step * dt < time_s {
            // The force along the motion of the handle is constant: the tool is ahead of it by force / stiffness.
            let [out, along] = door.directions(door.angle + door.rate * dt);
            let tool = door.middle + out * RADIUS + along * (force / door.stiffness);
            door.step(tool, along * (RADIUS * door.rate), dt);
            angles.push(door.angle());
            step += 1.0;
        }
        angles
    }

    #[test]
    fn door_stays_below_the_friction_of_its_hinge() {
        let mut door = door(&json!({"friction": 1.0}));
        // 3.3 N at 0.3 m is 0.99 N·m.
        assert!(pulled(&mut door, 3.3, 1.0, 1e-3).iter().all(|angle| *angle == 0.0));
        assert!(*pulled(&mut door, 3.4, 0.1, 1e-3).last().unwrap() > 0.0);
    }

    /// I θ̈ = F r − τ_f − b θ̇ has the solution θ = ω t − ω τ (1 − exp(−t/τ)), ω = (F r − τ_f)/b, τ = I/b.
    #[test]
    fn pulled_door_follows_its_equation_of_motion() {
        let (force, inertia, damping, friction): (f64, f64, f64, f64) = (10.0, 0.2, 0.5, 1.0);
        let hinge = json!({"friction": friction, "damping": damping, "inertia": inertia});
        let (omega, tau) = ((force * RADIUS - friction) / damping, inertia / damping);
        let exact = omega * 0.3 - omega * tau * (1.0 - (-0.3 / tau).exp());
        let error = |dt: f64| (pulled(&mut door(&hinge), force, 0.3, dt).last().unwrap() - exact).abs();
        let [coarse, fine] = [1e-3, 1e-4].map(error);
        assert!(exact > 0.3 && coarse < 0.02 && fine < 0.15 * coarse, "{exact} {coarse} {fine}");
    }

    /// A tool on the circle, and one that is 1 mm outside of it.
    #[test]
    fn grip_pushes_and_pulls_across_the_motion() {
        let mut door = door(&json!({"inertia": 0.1}));
        assert_eq!(door.step(Vector3::zeros(), Vector3::zeros(), 1e-3), Vector3::zeros());
        for sign in [1.0, -1.0] {
            let force = door.step(Vector3::new(0.0, -1e-3 * sign, 2e-3), Vector3::zeros(), 1e-3);
            assert!((force - Vector3::new(0.0, -10.0 * sign, 20.0)).norm() < 1e-9, "{force}");
            assert!(door.angle().abs() < 1e-15);
        }
    }

    /// A tool on the circle that turns by one radian within a second and rests.
    #[test]
    fn work_of_the_tool_is_stored_or_dissipated() {
        let balance = |steps: u32| {
            let mut door = door(&json!({"friction": 1.0, "damping": 0.5, "inertia": 0.2}));
            let dt = 1.0 / f64::from(steps);
            for step in 0..=steps {
                let t = f64::from(step) * dt;
                let angle = 0.5 * (1.0 - (std::f64::consts::PI * t).cos());
                let rate = 0.5 * std::f64::consts::PI * (std::f64::consts::PI * t).sin();
                let [out, along] = door.directions(angle);
                door.step(door.middle + out * RADIUS, along * (RADIUS * rate), dt);
            }
            (door.energy(), door.angle())
        };
        let [(coarse, angle), (fine, _)] = [1000, 10_000].map(balance);
        // Friction takes 1 J per radian, and the damping ∫ b θ̇² dt = b π²/8.
        let exact = 1.0 + 0.5 * std::f64::consts::PI.powi(2) / 8.0;
        assert!((angle - 1.0).abs() < 5e-3 && (fine.dissipated_j - exact).abs() < 0.02 * exact, "{angle} {fine:?}");
        assert!(coarse.imbalance_j().abs() < 0.02 * coarse.work_j, "{coarse:?}");
        assert!(fine.imbalance_j().abs() < 0.2 * coarse.imbalance_j().abs(), "{fine:?}");
    }

    #[test]
    fn a_door_has_a_hinge_in_place_of_the_fields_of_a_surface() {
        let refusal = |field: &str, value: serde_json::Value| {
            let mut contact =
                json!({"kind": "door", "axis": "z", "normal": [0, -1, 0], "radius_m": 0.3, "stiffness": 1e4});
            contact[field] = value;
            let contact: Contact = serde_json::from_value(contact).unwrap();
            Door::new(&contact, "/contacts/0").unwrap_err().pointer
        };
        assert_eq!(refusal("inertia", json!(1.0)), "/contacts/0/inertia");
        assert_eq!(refusal("offset_m", json!(0.1)), "/contacts/0/offset_m");
        assert_eq!(refusal("friction", json!({"coulomb": 0.3})), "/contacts/0/friction");
        assert_eq!(refusal("hinge", json!({"friction": -1.0})), "/contacts/0/hinge/friction");
        assert_eq!(refusal("radius_m", json!(0.0)), "/contacts/0/radius_m");
    }
}
