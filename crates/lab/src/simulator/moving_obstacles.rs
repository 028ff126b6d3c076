//! Obstacles of a controller that move.

use revprio_api::wire;
use revprio_robot::profile::Profile;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::field_error::FieldError;
use super::profile::profile;

/// Largest coordinate of an obstacle that a controller accepts in a state, m.
const MAX_DISTANCE_M: f64 = 1e3;

/// Largest speed of an obstacle along each axis that a controller accepts in a state, m/s.
const MAX_SPEED_M_S: f64 = 100.0;

/// How an obstacle of the controller moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ObstacleMotion {
    /// Name of the obstacle, which has `moves: true`.
    pub name: String,
    /// How far it is from where the controller has it, over time: three values, base axes, m.
    #[schema(example = json!({"kind": "constant", "value": [0, 0.1, 0]}))]
    pub displacement: wire::Profile,
}

/// The obstacles of a controller that move.
#[derive(Debug, Clone, Default)]
pub struct MovingObstacles(Vec<MovingObstacle>);

#[derive(Debug, Clone)]
struct MovingObstacle {
    obstacle: wire::RoomObstacle,
    /// `None`: it stands.
    displacement: Option<Profile>,
}

impl MovingObstacles {
    /// Reads how obstacles move. Those that move, and that no motion names, stand.
    pub fn new(controller: &wire::Controller, motions: &[ObstacleMotion]) -> Result<Self, FieldError> {
        let stated = controller.collisions.iter().flat_map(|collisions| &collisions.obstacles);
        let standing =
            |obstacle: &wire::RoomObstacle| MovingObstacle { obstacle: obstacle.clone(), displacement: None };
        let mut all: Vec<_> = stated.filter(|obstacle| obstacle.moves).map(standing).collect();
        for (i, motion) in motions.iter().enumerate() {
            let at = |field: &str| format!("/obstacle_motions/{i}/{field}");
            let problem = "names no obstacle of the controller with `moves: true`";
            let found = all.iter_mut().find(|moving| moving.obstacle.name == motion.name);
            let moving = found.ok_or_else(|| FieldError::new(at("name"), problem))?;
            if moving.displacement.is_some() {
                return Err(FieldError::new(at("name"), "names an obstacle that has another motion"));
            }
            let displacement = profile(&motion.displacement, 3, &at("displacement"))?;
            moving.check(&displacement, &at("displacement"))?;
            moving.displacement = Some(displacement);
        }
        Ok(Self(all))
    }

    /// Returns where the obstacles are, as a state says it.
    pub fn states(&self, time_s: f64) -> Vec<wire::ObstacleState> {
        let state = |moving: &MovingObstacle| {
            let [displacement, velocity] = moving.motion(time_s);
            let middle = middle(&moving.obstacle);
            let position = [0, 1, 2].map(|axis| middle[axis] + displacement[axis]);
            wire::ObstacleState { name: moving.obstacle.name.clone(), position, velocity }
        };
        self.0.iter().map(state).collect()
    }

    /// Returns the obstacles where they are.
    #[cfg(feature = "files")]
    pub fn shapes(&self, time_s: f64) -> impl Iterator<Item = wire::RoomObstacle> {
        self.0.iter().map(move |moving| shifted(&moving.obstacle, moving.motion(time_s)[0]))
    }
}

impl MovingObstacle {
    /// Checks that the service accepts the obstacle at all times.
    fn check(&self, displacement: &Profile, pointer: &str) -> Result<(), FieldError> {
        let middle = middle(&self.obstacle);
        let [way, rate] = displacement.bounds();
        let is_near = (0..3).all(|axis| middle[axis].abs() + way[axis] <= MAX_DISTANCE_M);
        let is_slow = rate.iter().all(|rate| *rate <= MAX_SPEED_M_S);
        let problem = "must keep the obstacle within 1000 m of the base and its speed at 100 m/s or less, on each axis";
        if is_near && is_slow { Ok(()) } else { Err(FieldError::new(pointer, problem)) }
    }

    /// Returns displacement and velocity, m and m/s.
    fn motion(&self, time_s: f64) -> [[f64; 3]; 2] {
        let point = self.displacement.as_ref().map(|displacement| displacement.at(time_s));
        point.map_or([[0.0; 3]; 2], |point| {
            [&point.value, &point.rate].map(|entries| [entries[0], entries[1], entries[2]])
        })
    }
}

/// Returns the position of the middle of a shape, base frame, m.
fn middle(obstacle: &wire::RoomObstacle) -> [f64; 3] {
    if let Some(sphere) = obstacle.sphere {
        return sphere.center;
    }
    if let Some(wire::Capsule { start, end, .. }) = obstacle.capsule {
        return [0, 1, 2].map(|axis| 0.5 * (start[axis] + end[axis]));
    }
    if let Some(cuboid) = obstacle.cuboid {
        return cuboid.pose.position;
    }
    // A controller without any of these shapes is refused by the service.
    obstacle.half_space.map_or([0.0; 3], |plane| {
        let length = plane.normal.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        plane.normal.map(|entry| entry / length * plane.offset_m)
    })
}

/// Returns the same shape, shifted by a way, base axes, m.
#[cfg(feature = "files")]
fn shifted(obstacle: &wire::RoomObstacle, way: [f64; 3]) -> wire::RoomObstacle {
    let shift = |point: &mut [f64; 3]| point.iter_mut().zip(way).for_each(|(entry, way)| *entry += way);
    let mut shifted = obstacle.clone();
    if let Some(sphere) = &mut shifted.sphere {
        shift(&mut sphere.center);
    }
    if let Some(capsule) = &mut shifted.capsule {
        shift(&mut capsule.start);
        shift(&mut capsule.end);
    }
    if let Some(cuboid) = &mut shifted.cuboid {
        shift(&mut cuboid.pose.position);
    }
    if let Some(plane) = &mut shifted.half_space {
        let length = plane.normal.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
        plane.offset_m += plane.normal.iter().zip(way).map(|(entry, way)| entry / length * way).sum::<f64>();
    }
    shifted
}
