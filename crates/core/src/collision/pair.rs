//! A pair of shapes that must keep clear of each other.

use std::sync::Arc;

use nalgebra::Vector3;
use revprio_robot::RobotModel;
use revprio_robot::collision::{BodyPoint, CollisionModel, Levers, PlacedBody, Segment, Separation, levers};

use super::avoidance::CollisionAvoidance;
use super::obstacle::Obstacle;

/// What a capsule keeps clear of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Other {
    /// Another capsule of the robot.
    Capsule(usize),
    /// An obstacle, by its index.
    Obstacle(usize),
}

/// A capsule of the robot and what it keeps clear of.
#[derive(Debug)]
pub struct Pair {
    /// Name of its rows.
    pub name: Arc<str>,
    /// Names of the link and of the other link or the obstacle.
    pub names: [Arc<str>; 2],
    /// Index of the capsule.
    pub capsule: usize,
    /// What it keeps clear of.
    pub other: Other,
    /// How far the joints move one shape relative to the other.
    pub levers: Levers,
    /// Radius of the capsule, m.
    radius: f64,
    /// Sum of the capsules' radii, m. The radius of an obstacle is part of its shape.
    radii: f64,
    joint: Option<usize>,
    other_joint: Option<usize>,
    /// The last joint that carries both.
    common: Option<usize>,
}

/// The obstacles at a time.
#[derive(Debug, Clone, Copy)]
pub struct World<'a> {
    pub obstacles: &'a [Obstacle],
    /// Shift of each since the controller was made, m.
    pub shifts: &'a [Vector3<f64>],
    /// Velocity of each, m/s.
    pub velocities: &'a [Vector3<f64>],
}

impl World<'_> {
    /// Returns the largest speed of an obstacle, m/s.
    pub fn largest_speed(&self) -> f64 {
        self.velocities.iter().map(Vector3::norm).fold(0.0, f64::max)
    }

    /// Returns the shift of an obstacle after a time (s), m.
    #[inline]
    fn shift(&self, obstacle: usize, time: f64) -> Vector3<f64> {
        self.shifts[obstacle] + self.velocities[obstacle] * time
    }
}

/// Returns all pairs that a controller watches.
pub fn pairs(robot: &RobotModel, model: &CollisionModel, avoidance: &CollisionAvoidance) -> Vec<Pair> {
    let link = |capsule: usize| robot.links()[model.capsules()[capsule].link.index()].name.as_str();
    let own = model.pairs().iter().filter(|_| avoidance.own).map(|watched| {
        let [i, j] = watched.capsules;
        // The one farther from the base is the first.
        let (capsule, other) = if model.joint(i) > model.joint(j) { (i, j) } else { (j, i) };
        ([link(capsule), link(other)], capsule, Other::Capsule(other))
    });
    let moved = (0..model.capsules().len()).filter(|capsule| model.joint(*capsule).is_some());
    let with_obstacles = moved.flat_map(|capsule| {
        avoidance
            .obstacles
            .iter()
            .enumerate()
            .map(move |(k, obstacle)| ([link(capsule), &obstacle.name], capsule, Other::Obstacle(k)))
    });
    own.chain(with_obstacles).map(|(names, capsule, other)| Pair::new(robot, model, names, capsule, other)).collect()
}

impl Pair {
    fn new(
        robot: &RobotModel,
        model: &CollisionModel,
        [link, partner_name]: [&str; 2],
        capsule: usize,
        other: Other,
    ) -> Self {
        let partner = match other {
            Other::Capsule(other) => Some(other),
            Other::Obstacle(_) => None,
        };
        let radius = |capsule: usize| model.capsules()[capsule].radius;
        let (joint, other_joint) = (model.joint(capsule), partner.and_then(|other| model.joint(other)));
        Self {
            name: format!("collision:{link}/{partner_name}").into(),
            names: [link.into(), partner_name.into()],
            capsule,
            other,
            levers: levers(robot, model, capsule, partner),
            radius: radius(capsule),
            radii: radius(capsule) + partner.map_or(0.0, radius),
            joint,
            other_joint,
            common: revprio_robot::collision::last_common(robot, joint, other_joint),
        }
    }

    /// Returns the distance of both shapes; `time`: how long the obstacles have moved, s.
    #[inline]
    pub fn separation(&self, body: &PlacedBody, world: World, time: f64) -> Separation {
        let core = body.core(self.capsule);
        let found = match self.other {
            Other::Capsule(other) => core.to_segment(body.core(other)),
            Other::Obstacle(k) => world.obstacles[k].shape.separation(core, world.shift(k, time)),
        };
        Separation { distance: found.distance - self.radii, ..found }
    }

    /// Returns the nearest points on both surfaces for a separation, m.
    pub fn surface_points(&self, found: &Separation) -> [Vector3<f64>; 2] {
        let own = found.nearest - found.normal * self.radius;
        [own, own - found.normal * found.distance]
    }

    /// Returns how far a direction (a unit vector) separates both shapes, m: at most their distance.
    #[inline]
    pub fn along(&self, body: &PlacedBody, world: World, time: f64, normal: &Vector3<f64>) -> f64 {
        let support = match self.other {
            Other::Capsule(other) => body.core(other).support(normal),
            Other::Obstacle(k) => world.obstacles[k].shape.support(normal, world.shift(k, time)),
        };
        body.core(self.capsule).least(normal) - support - self.radii
    }

    /// Returns a direction of one posture as the last link that carries both shapes has it in another posture.
    #[inline]
    pub fn carried_normal(&self, normal: &Vector3<f64>, from: &PlacedBody, to: &PlacedBody) -> Vector3<f64> {
        if self.common.is_none() {
            return *normal;
        }
        to.frame(self.common).rotation * (from.frame(self.common).rotation.inverse() * normal)
    }

    /// Returns how far both shapes can move towards each other, m, for the ways of the joints (n) in a time, s.
    #[inline]
    pub fn way(&self, ways: &[f64], time: f64, world: World) -> f64 {
        self.levers.way(ways) + time * self.obstacle_speed(world)
    }

    /// Returns the largest speed at which an obstacle comes nearer, m/s.
    pub fn obstacle_speed(&self, world: World) -> f64 {
        match self.other {
            Other::Capsule(_) => 0.0,
            Other::Obstacle(k) => world.velocities[k].norm(),
        }
    }

    /// Returns the pairs of ends that a common normal separates, each with how far it does, m.
    pub fn ends(
        &self,
        body: &PlacedBody,
        world: World,
        time: f64,
        normal: &Vector3<f64>,
    ) -> impl Iterator<Item = ([BodyPoint; 2], f64)> {
        let (joint, other_joint, radii, normal) = (self.joint, self.other_joint, self.radii, *normal);
        let core = *body.core(self.capsule);
        let other = match self.other {
            Other::Capsule(other) => *body.core(other),
            Other::Obstacle(k) => {
                let support = world.obstacles[k].shape.support(&normal, world.shift(k, time));
                Segment::point(normal * support)
            }
        };
        let ends = |segment: Segment| segment.ends().into_iter().take(if segment.from == segment.to { 1 } else { 2 });
        ends(core).flat_map(move |x| {
            ends(other).map(move |y| {
                let points = [BodyPoint { joint, position: x }, BodyPoint { joint: other_joint, position: y }];
                (points, normal.dot(&(x - y)) - radii)
            })
        })
    }
}
