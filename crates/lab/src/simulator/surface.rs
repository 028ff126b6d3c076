//! The force and energy of one contact.

use nalgebra::Vector3;
use revprio_robot::profile::Profile;

use super::contact::{Contact, ContactKind, Friction};
use super::energy::Energy;
use super::field_error::{FieldError, not_negative, positive};
use super::profile::profile;
use super::shape::{Depth, Shape};

/// A contact along the normal of a shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    shape: Shape,
    /// Whether the contact only pushes.
    is_unilateral: bool,
    /// Motion that is added to the offset, and its sign along `inward` of the shape.
    motion: Option<(Profile, f64)>,
    stiffness: f64,
    damping: f64,
    inertia: f64,
    friction: Option<Friction>,
    last: Option<ContactState>,
    energy: Energy,
}

/// State of the contact at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ContactState {
    /// Displacement of the tool from its start, relative to the motion of the shape, m.
    displacement: Vector3<f64>,
    /// X − X_0 along the normal, m; negative without contact.
    depth: f64,
    /// Rate of `depth`, m/s.
    speed: f64,
    /// Whether the tool touches the surface.
    in_contact: bool,
    /// Unit vector into the material.
    inward: Vector3<f64>,
    /// F_e along `inward`, N.
    normal_force: f64,
    /// F_e along the surface, N.
    friction_force: Vector3<f64>,
    /// Dissipated power, W.
    dissipation: f64,
}

impl Surface {
    /// Returns the contact at a JSON pointer.
    pub fn new(contact: &Contact, pointer: &str) -> Result<Self, FieldError> {
        let at = |field: &str| format!("{pointer}/{field}");
        let shape = Shape::new(contact, pointer)?;
        let is_unilateral = contact.kind != ContactKind::Spring;
        if contact.friction.is_some() && !is_unilateral {
            return Err(FieldError::new(at("friction"), "needs a surface; a spring has none"));
        }
        let friction = contact.friction.map(|friction| checked(friction, &at("friction"))).transpose()?;
        if contact.hinge.is_some() {
            return Err(FieldError::new(at("hinge"), "is for a door"));
        }
        let motion = contact.motion.as_ref().map(|motion| profile(motion, 1, &at("motion"))).transpose()?;
        // The motion of a wall is along its axis, also if the wall is in the negative direction.
        let side = if contact.kind == ContactKind::Wall { shape.inward.sum() } else { 1.0 };
        Ok(Self {
            shape,
            is_unilateral,
            motion: motion.map(|motion| (motion, side)),
            stiffness: not_negative(contact.stiffness, &at("stiffness"))?,
            damping: not_negative(contact.damping, &at("damping"))?,
            inertia: not_negative(contact.inertia, &at("inertia"))?,
            friction,
            last: None,
            energy: Energy::default(),
        })
    }

    /// Returns the distance of the tool to the surface at the last step, m, negative in contact; `None` for a spring.
    pub fn distance(&self) -> Option<f64> {
        self.last.filter(|_| self.is_unilateral).map(|touch| -touch.depth)
    }

    /// Returns the energy of the contact so far.
    pub fn energy(&self) -> Energy {
        self.energy
    }

    /// Advances by `dt` (s) to a displacement of the tool from its start (m) and a velocity (m/s). Returns F_e, N.
    pub fn step(&mut self, displacement: Vector3<f64>, velocity: Vector3<f64>, time_s: f64, dt: f64) -> Vector3<f64> {
        let state = self.state(displacement, velocity, time_s, dt);
        match self.last {
            Some(last) => self.account(&last, &state, dt),
            // Energy that is stored at the start counts as work before the start.
            None => self.energy.work_j = self.stored(&state),
        }
        self.energy.stored_j = self.stored(&state);
        self.last = Some(state);
        state.inward * state.normal_force + state.friction_force
    }

    fn state(&self, displacement: Vector3<f64>, velocity: Vector3<f64>, time_s: f64, dt: f64) -> ContactState {
        let (moved, rate) = self.motion.as_ref().map_or((0.0, 0.0), |(motion, side)| {
            let now = motion.at(time_s);
            (side * now.value[0], side * now.rate[0])
        });
        let displacement = displacement - self.shape.inward * moved;
        let velocity = velocity - self.shape.inward * rate;
        let Depth { depth, inward } = self.shape.depth(&displacement);
        let speed = inward.dot(&velocity);
        let in_contact = !self.is_unilateral || depth > 0.0;
        let mut state = ContactState {
            displacement,
            depth,
            speed,
            in_contact,
            inward,
            normal_force: 0.0,
            friction_force: Vector3::zeros(),
            dissipation: 0.0,
        };
        if in_contact {
            let acceleration = self.last.map_or(0.0, |last| (speed - last.speed) / dt);
            let conservative = self.inertia * acceleration + self.stiffness * depth;
            let force = self.inertia * acceleration + self.damping * speed + self.stiffness * depth;
            state.normal_force = if self.is_unilateral { force.max(0.0) } else { force };
            let slide = velocity - inward * speed;
            state.friction_force =
                self.friction.map_or(Vector3::zeros(), |friction| friction_force(friction, state.normal_force, slide));
            // Damping, or the energy that a surface loses if it cannot follow the tool.
            state.dissipation = (state.normal_force - conservative) * speed + state.friction_force.dot(&slide);
        }
        state
    }

    /// Adds work (over distance) and dissipation (over time) between two steps, by the trapezoidal rule.
    fn account(&mut self, from: &ContactState, to: &ContactState, dt: f64) {
        let share_outside = from.depth / (from.depth - to.depth);
        let crossing = from.displacement + (to.displacement - from.displacement) * share_outside;
        match (from.in_contact, to.in_contact) {
            (false, false) => (),
            (true, true) => self.add(from, to, dt),
            (false, true) => {
                // The mass M_e accelerates at once to the speed of the tool. Half of the work is lost, as in a perfectly
                // inelastic impact.
                let work = self.inertia * to.speed * to.speed;
                self.energy.work_j += work;
                self.energy.dissipated_j += 0.5 * work;
                let normal_force = (self.damping * to.speed).max(0.0);
                self.add(
                    &ContactState { depth: 0.0, normal_force, displacement: crossing, ..*to },
                    to,
                    dt * (1.0 - share_outside),
                );
            }
            (true, false) => {
                // The mass M_e stays behind and loses its kinetic energy.
                self.energy.dissipated_j += 0.5 * self.inertia * from.speed * from.speed;
                let left = ContactState {
                    depth: 0.0,
                    normal_force: 0.0,
                    friction_force: Vector3::zeros(),
                    dissipation: 0.0,
                    displacement: crossing,
                    ..*to
                };
                self.add(from, &left, dt * share_outside);
            }
        }
    }

    fn add(&mut self, from: &ContactState, to: &ContactState, dt: f64) {
        let normal = 0.5 * (from.normal_force + to.normal_force) * (to.depth - from.depth);
        let tangential = 0.5 * (from.friction_force + to.friction_force).dot(&(to.displacement - from.displacement));
        self.energy.work_j += normal + tangential;
        self.energy.dissipated_j += 0.5 * (from.dissipation + to.dissipation) * dt;
    }

    fn stored(&self, state: &ContactState) -> f64 {
        if !state.in_contact {
            return 0.0;
        }
        0.5 * (self.stiffness * state.depth * state.depth + self.inertia * state.speed * state.speed)
    }
}

fn checked(friction: Friction, pointer: &str) -> Result<Friction, FieldError> {
    not_negative(friction.coulomb, &format!("{pointer}/coulomb"))?;
    not_negative(friction.viscous, &format!("{pointer}/viscous"))?;
    positive(friction.sticking_speed_m_s, &format!("{pointer}/sticking_speed_m_s"))?;
    Ok(friction)
}

/// Returns the friction force along a surface under a normal force (N), at a velocity along the surface (m/s).
fn friction_force(friction: Friction, normal_force: f64, slide: Vector3<f64>) -> Vector3<f64> {
    let speed = slide.norm().hypot(friction.sticking_speed_m_s);
    slide * (friction.coulomb * normal_force / speed + friction.viscous)
}
