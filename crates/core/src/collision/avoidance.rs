//! What a controller keeps clear of.

use revprio_robot::RobotModel;
use revprio_robot::collision::{CollisionModel, WatchedPair, levers};

use super::obstacle::Obstacle;
use super::stop::{longest_stop, samples_of_stop};

/// Default γ, 1/s: an approach at 0.5 m/s slows down with at most 5 m/s².
const APPROACH_RATE: f64 = 10.0;

/// Number of rows that a controller has for its nearest pairs.
///
/// The guarantee does not depend on it: the stop of each command is checked for all pairs.
pub const ROWS: usize = 64;

/// Maximum number of obstacles.
pub const MAX_OBSTACLES: usize = 256;

/// Maximum number of pairs of shapes that one controller watches.
pub const MAX_PAIRS: usize = 1024;

/// Maximum number of periods of a stop from full speed.
pub const MAX_STOP_PERIODS: usize = 2048;

/// What a controller keeps clear of, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct CollisionAvoidance {
    /// d_min, the distance that shapes keep, m.
    pub min_distance_m: f64,
    /// γ, 1/s: near d_min the distance shrinks at most like e^(−γ t).
    pub rate_per_s: f64,
    /// Whether the links keep clear of each other.
    pub own: bool,
    /// The shapes of the world.
    pub obstacles: Vec<Obstacle>,
}

/// Why a controller cannot keep clear.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CollisionAvoidanceError {
    /// The robot has no shapes.
    #[error("the robot `{0}` has no shapes; give it `shape_list` when you register it")]
    NoShapes(String),
    /// d_min or γ is not allowed.
    #[error("the minimum distance must be from 0 to 1 m, and the rate positive")]
    Number,
    /// Two obstacles share a name.
    #[error("two obstacles are named `{0}`; give each its own name")]
    DuplicateObstacle(String),
    /// Two links are never d_min apart.
    #[error(
        "`{}` and `{}` are never `min_distance_m` apart; give less, or leave the pair out: register the robot under another name without it", .0[0], .0[1]
    )]
    AlwaysNear([String; 2]),
    /// There are too many obstacles or pairs.
    #[error("{pairs} pairs of shapes and {obstacles} obstacles; at most {MAX_PAIRS} and {MAX_OBSTACLES} are allowed")]
    TooMany {
        /// Number of pairs.
        pairs: usize,
        /// Number of obstacles.
        obstacles: usize,
    },
    /// The limits do not say how the joints stop.
    #[error("collisions need the robot's own limits of position and speed, and a solver that keeps them")]
    Limits,
    /// A joint has no speed limit, so its stop has no bound.
    #[error("joint `{0}` needs a speed limit, because its way to a stop has no bound without one")]
    Speed(String),
    /// A stop takes too many periods.
    #[error("a stop takes more than {MAX_STOP_PERIODS} periods. Use a longer period or larger acceleration limits")]
    LongStop,
    /// A sliding joint without limits hangs on a turning joint.
    #[error(
        "a sliding joint without position limits hangs on a turning joint, so nothing bounds how far that one swings a link"
    )]
    Unbounded,
}

impl Default for CollisionAvoidance {
    fn default() -> Self {
        Self { min_distance_m: 0.01, rate_per_s: APPROACH_RATE, own: true, obstacles: Vec::new() }
    }
}

impl CollisionAvoidance {
    /// Returns the number of pairs that a robot with these shapes watches, at most.
    fn pairs(&self, model: &CollisionModel) -> usize {
        let moving = (0..model.capsules().len()).filter(|capsule| model.joint(*capsule).is_some()).count();
        (if self.own { model.pairs().len() } else { 0 }) + moving * self.obstacles.len()
    }

    /// Returns how much work a period is: the number of pairs times that of the samples of a stop from full speed. `period`: T, s.
    pub fn work(&self, robot: &RobotModel, period: f64) -> usize {
        let pairs = robot.collision().map_or(0, |model| self.pairs(model));
        pairs.saturating_mul(samples_of_stop(robot, period))
    }

    /// Checks that a robot can keep clear; `period`: T, s.
    pub(crate) fn check(&self, robot: &RobotModel, period: f64) -> Result<(), CollisionAvoidanceError> {
        let Some(model) = robot.collision() else {
            return Err(CollisionAvoidanceError::NoShapes(robot.name().to_owned()));
        };
        let is_valid =
            (0.0..=1.0).contains(&self.min_distance_m) && self.rate_per_s > 0.0 && self.rate_per_s.is_finite();
        if !is_valid {
            return Err(CollisionAvoidanceError::Number);
        }
        for (i, obstacle) in self.obstacles.iter().enumerate() {
            if self.obstacles[..i].iter().any(|earlier| earlier.name == obstacle.name) {
                return Err(CollisionAvoidanceError::DuplicateObstacle(obstacle.name.to_string()));
            }
        }
        let (pairs, obstacles) = (self.pairs(model), self.obstacles.len());
        if pairs > MAX_PAIRS || obstacles > MAX_OBSTACLES {
            return Err(CollisionAvoidanceError::TooMany { pairs, obstacles });
        }
        let is_near = |pair: &&WatchedPair| self.own && pair.farthest_m <= self.min_distance_m;
        if let Some(pair) = model.pairs().iter().find(is_near) {
            let name = |capsule: usize| robot.links()[model.capsules()[capsule].link.index()].name.clone();
            return Err(CollisionAvoidanceError::AlwaysNear(pair.capsules.map(name)));
        }
        if levers_of(robot, model).any(|lever| !lever.is_finite()) {
            return Err(CollisionAvoidanceError::Unbounded);
        }
        if let Some(joint) = robot.joints().iter().find(|joint| joint.limits.velocity.is_infinite()) {
            return Err(CollisionAvoidanceError::Speed(joint.name.clone()));
        }
        let periods = longest_stop(robot, period);
        if periods > MAX_STOP_PERIODS {
            return Err(CollisionAvoidanceError::LongStop);
        }
        Ok(())
    }
}

/// Returns the levers of all capsules against the base.
fn levers_of(robot: &RobotModel, model: &CollisionModel) -> impl Iterator<Item = f64> {
    (0..model.capsules().len()).flat_map(|capsule| levers(robot, model, capsule, None).lever)
}
