//! One contact at work.

use nalgebra::Vector3;
use revprio_robot::profile::Profile;

use super::contact::{Contact, ContactKind, Friction};
use super::energy::Energy;
use super::field_error::{FieldError, not_negative, number, positive};
use super::profile::profile;

/// A contact along one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Unit vector into the material.
    inward: Vector3<f64>,
    /// Whether it only pushes.
    is_unilateral: bool,
    /// X_0 along `inward`, m.
    offset: f64,
    /// What is added to it, and the sign with which it counts along `inward`.
    motion: Option<(Profile, f64)>,
    stiffness: f64,
    damping: f64,
    inertia: f64,
    friction: Option<Friction>,
    last: Option<Touch>,
    energy: Energy,
}

/// The tool at the surface at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Touch {
    /// Of the tool, from its start, m.
    way: Vector3<f64>,
    /// X − X_0 along `inward`, m; negative in free space.
    depth: f64,
    /// Its rate, m/s.
    speed: f64,
    /// Whether the surface is touched.
    is_held: bool,
    /// F_e along `inward`, N.
    press: f64,
    /// F_e along the surface, N.
    drag: Vector3<f64>,
    /// Power that is turned into heat, W.
    heating: f64,
}

impl Surface {
    /// The contact at a JSON pointer.
    pub fn new(contact: &Contact, pointer: &str) -> Result<Self, FieldError> {
        let at = |field: &str| format!("{pointer}/{field}");
        let offset = number(contact.offset_m, &at("offset_m"))?;
        let (inward, side) = direction(contact, pointer)?;
        let is_unilateral = contact.kind != ContactKind::Spring;
        if contact.friction.is_some() && !is_unilateral {
            return Err(FieldError::new(
                at("friction"),
                "needs a surface, which a spring has not; use a wall or a plane",
            ));
        }
        let friction = contact.friction.map(|friction| checked(friction, &at("friction"))).transpose()?;
        let motion = contact.motion.as_ref().map(|motion| profile(motion, 1, &at("motion"))).transpose()?;
        Ok(Self {
            inward,
            is_unilateral,
            offset: side * offset,
            motion: motion.map(|motion| (motion, side)),
            stiffness: not_negative(contact.stiffness, &at("stiffness"))?,
            damping: not_negative(contact.damping, &at("damping"))?,
            inertia: not_negative(contact.inertia, &at("inertia"))?,
            friction,
            last: None,
            energy: Energy::default(),
        })
    }

    /// Way of the tool to the surface, m, negative in contact, at the last step; `None` of a spring.
    pub fn distance(&self) -> Option<f64> {
        self.last.filter(|_| self.is_unilateral).map(|touch| -touch.depth)
    }

    /// What the contact took and kept so far.
    pub fn energy(&self) -> Energy {
        self.energy
    }

    /// F_e, N, with the tool at `way` from its start (m) and at a velocity (m/s), `dt` (s) after the last step.
    pub fn step(&mut self, way: Vector3<f64>, velocity: Vector3<f64>, time_s: f64, dt: f64) -> Vector3<f64> {
        let touch = self.touch(way, velocity, time_s, dt);
        match self.last {
            Some(last) => self.account(&last, &touch, dt),
            // What is strained from the start was strained before.
            None => self.energy.work_j = self.stored(&touch),
        }
        self.energy.stored_j = self.stored(&touch);
        self.last = Some(touch);
        self.inward * touch.press + touch.drag
    }

    fn touch(&self, way: Vector3<f64>, velocity: Vector3<f64>, time_s: f64, dt: f64) -> Touch {
        let (moved, rate) = self.motion.as_ref().map_or((0.0, 0.0), |(motion, side)| {
            let now = motion.at(time_s);
            (side * now.value[0], side * now.rate[0])
        });
        let depth = self.inward.dot(&way) - (self.offset + moved);
        let speed = self.inward.dot(&velocity) - rate;
        let is_held = !self.is_unilateral || depth > 0.0;
        let mut touch = Touch { way, depth, speed, is_held, press: 0.0, drag: Vector3::zeros(), heating: 0.0 };
        if is_held {
            let acceleration = self.last.map_or(0.0, |last| (speed - last.speed) / dt);
            let kept = self.inertia * acceleration + self.stiffness * depth;
            let force = self.inertia * acceleration + self.damping * speed + self.stiffness * depth;
            touch.press = if self.is_unilateral { force.max(0.0) } else { force };
            let slide = velocity - self.inward * self.inward.dot(&velocity);
            touch.drag = self.friction.map_or(Vector3::zeros(), |friction| drag(friction, touch.press, slide));
            // Damping, or what a surface that cannot follow the tool loses by itself.
            touch.heating = (touch.press - kept) * speed + touch.drag.dot(&slide);
        }
        touch
    }

    /// Work over the way and heat over the time between two steps, by the trapezoidal rule.
    fn account(&mut self, from: &Touch, to: &Touch, dt: f64) {
        let share_outside = from.depth / (from.depth - to.depth);
        let border = from.way + (to.way - from.way) * share_outside;
        match (from.is_held, to.is_held) {
            (false, false) => (),
            (true, true) => self.add(from, to, dt),
            (false, true) => {
                // The mass M_e is taken along at once: half of the work is lost, as between a heavy body and a light one
                // that stay together.
                let taken = self.inertia * to.speed * to.speed;
                self.energy.work_j += taken;
                self.energy.dissipated_j += 0.5 * taken;
                let press = (self.damping * to.speed).max(0.0);
                self.add(&Touch { depth: 0.0, press, way: border, ..*to }, to, dt * (1.0 - share_outside));
            }
            (true, false) => {
                // The mass stays behind and comes to rest by itself.
                self.energy.dissipated_j += 0.5 * self.inertia * from.speed * from.speed;
                let left = Touch { depth: 0.0, press: 0.0, drag: Vector3::zeros(), heating: 0.0, way: border, ..*to };
                self.add(from, &left, dt * share_outside);
            }
        }
    }

    fn add(&mut self, from: &Touch, to: &Touch, dt: f64) {
        let pressed = 0.5 * (from.press + to.press) * (to.depth - from.depth);
        let dragged = 0.5 * (from.drag + to.drag).dot(&(to.way - from.way));
        self.energy.work_j += pressed + dragged;
        self.energy.dissipated_j += 0.5 * (from.heating + to.heating) * dt;
    }

    fn stored(&self, touch: &Touch) -> f64 {
        if !touch.is_held {
            return 0.0;
        }
        0.5 * (self.stiffness * touch.depth * touch.depth + self.inertia * touch.speed * touch.speed)
    }
}

/// The unit vector into the material, and the sign with which `offset_m` counts along it.
fn direction(contact: &Contact, pointer: &str) -> Result<(Vector3<f64>, f64), FieldError> {
    let missing =
        |field: &str, whose: &str| FieldError::new(format!("{pointer}/{field}"), format!("is missing; {whose}"));
    match (contact.kind, contact.axis, contact.normal) {
        (ContactKind::Plane, None, Some(normal)) => {
            normal.iter().enumerate().try_for_each(|(i, v)| number(*v, &format!("{pointer}/normal/{i}")).map(drop))?;
            let inward = (-Vector3::from(normal)).try_normalize(1e-9);
            let inward = inward.ok_or_else(|| FieldError::new(format!("{pointer}/normal"), "must not be zero"))?;
            Ok((inward, 1.0))
        }
        (ContactKind::Plane, None, None) => Err(missing("normal", "a plane has one, such as [0, 0, 1]")),
        (ContactKind::Plane, Some(_), _) => {
            Err(FieldError::new(format!("{pointer}/axis"), "belongs to a spring or a wall; a plane has a `normal`"))
        }
        (_, _, Some(_)) => {
            Err(FieldError::new(format!("{pointer}/normal"), "belongs to a plane; a spring or a wall has an `axis`"))
        }
        (_, None, _) => Err(missing("axis", "a spring or a wall has one of x, y, z")),
        (kind, Some(axis), None) => {
            let side = if kind == ContactKind::Wall && contact.offset_m < 0.0 { -1.0 } else { 1.0 };
            let mut inward = Vector3::zeros();
            inward[axis] = side;
            Ok((inward, side))
        }
    }
}

fn checked(friction: Friction, pointer: &str) -> Result<Friction, FieldError> {
    not_negative(friction.coulomb, &format!("{pointer}/coulomb"))?;
    not_negative(friction.viscous, &format!("{pointer}/viscous"))?;
    positive(friction.sticking_speed_m_s, &format!("{pointer}/sticking_speed_m_s"))?;
    Ok(friction)
}

/// F_e along a surface that is pressed with a force (N), at a velocity along it (m/s).
fn drag(friction: Friction, press: f64, slide: Vector3<f64>) -> Vector3<f64> {
    let speed = slide.norm().hypot(friction.sticking_speed_m_s);
    slide * (friction.coulomb * press / speed + friction.viscous)
}
