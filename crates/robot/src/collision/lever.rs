//! How far joints can move a shape: levers that hold in every posture.
//!
//! Let joint i turn by δ. A point that it carries moves by at most ρ_i |δ|, where ρ_i is its largest distance from the axis: the
//! sum of the lengths of the links between, and of what sliding joints between add. A sliding joint has ρ = 1.
//!
//! The second derivative of the point, ∂²x/∂q_i ∂q_j = z_i × ∂x/∂q_j for a turning joint i at or above j, is at most ρ_j; it is zero
//! for a sliding joint i. So on a straight way δ between two postures a point leaves its chord by at most
//!
//! > ⅛ (Σ_i |δ_i|) (Σ_j ρ_j |δ_j|),
//!
//! the first sum over turning joints. In the product, a turning joint i above a turning joint j stands for twice ρ_j at least,
//! because ρ_i ≥ ρ_j. If a sliding joint hangs on a turning one, its share is counted twice, by a ρ of 2 in that sum.

use nalgebra::Vector3;

use crate::RobotModel;
use crate::shape::CollisionModel;

/// How far a sliding joint may be measured beyond its limits, m.
const BEYOND_LIMIT: f64 = 0.05;

/// Bounds of how far the joints move one shape relative to another one, for one pair.
#[derive(Debug, Clone, PartialEq)]
pub struct Levers {
    /// ρ, m per rad or m per m, n.
    pub lever: Vec<f64>,
    /// How much each joint turns what it carries: 1, or 0 for a sliding joint, n; times the multipliers of mimic joints.
    pub turn: Vec<f64>,
    /// Whether a sliding joint hangs on a turning one.
    slides_on_turning: bool,
}

impl Levers {
    /// Returns a bound of the way of any point of one shape relative to the other one, m; `way`: |δ|, n.
    #[inline]
    pub fn way(&self, way: &[f64]) -> f64 {
        self.lever.iter().zip(way).map(|(lever, way)| lever * way).sum()
    }

    /// Returns a bound of the distance of a point from its chord, m, on a straight way of the joints; `way`: |δ|, n.
    #[inline]
    pub fn bend(&self, way: &[f64]) -> f64 {
        let turned: f64 = self.turn.iter().zip(way).map(|(turn, way)| turn * way).sum();
        let share = if self.slides_on_turning { 0.25 } else { 0.125 };
        share * turned * self.way(way)
    }
}

/// Returns the levers of a pair of shapes: a capsule, and another one or, for `None`, something that stands still.
///
/// A lever is infinite if a sliding joint without limits hangs on a turning joint.
pub fn levers(robot: &RobotModel, model: &CollisionModel, capsule: usize, other: Option<usize>) -> Levers {
    let n = robot.joint_count();
    let mut levers = Levers { lever: vec![0.0; n], turn: vec![0.0; n], slides_on_turning: false };
    let joint = model.joint(capsule);
    let other_joint = other.and_then(|other| model.joint(other));
    let common = last_common(robot, joint, other_joint);
    add_path(robot, (joint, common), farthest(model, capsule), &mut levers);
    if let Some(other) = other {
        add_path(robot, (other_joint, common), farthest(model, other), &mut levers);
    }
    levers
}

/// Returns the largest distance of a point of a capsule from the origin of the frame that its joint moves, m.
fn farthest(model: &CollisionModel, capsule: usize) -> f64 {
    let ends = model.carried_core(capsule).ends();
    ends.iter().map(Vector3::norm).fold(0.0, f64::max) + model.capsules()[capsule].radius
}

/// Adds the levers of the joints from one that carries a point, at most `distance` (m) from its frame, up to a common one.
fn add_path(
    robot: &RobotModel,
    (carrier, common): (Option<usize>, Option<usize>),
    mut distance: f64,
    levers: &mut Levers,
) {
    let joints = robot.moving_joints();
    let mut slides = false;
    let mut next = carrier;
    while let Some(index) = next.filter(|_| next != common) {
        let joint = &joints[index];
        let (coordinate, scale) = (joint.coordinate, joint.multiplier.abs());
        if joint.kind.is_translation() {
            levers.lever[coordinate] += scale;
            let limits = &robot.joints()[coordinate].limits;
            let farthest = limits.lower.abs().max(limits.upper.abs()) + BEYOND_LIMIT;
            distance += if scale == 0.0 { 0.0 } else { scale * farthest } + joint.offset.abs();
            slides = true;
        } else {
            levers.lever[coordinate] += scale * distance;
            levers.turn[coordinate] += scale;
            levers.slides_on_turning |= slides;
        }
        distance += joint.placement.translation.vector.norm();
        next = joint.parent;
    }
}

/// Returns the last joint that carries both of two joints; `None`: the base.
pub fn last_common(robot: &RobotModel, first: Option<usize>, second: Option<usize>) -> Option<usize> {
    let (mut first, mut second) = (first, second);
    // A parent has a smaller index than its child, and `None` is below all.
    while first != second {
        let larger = if first > second { &mut first } else { &mut second };
        *larger = larger.and_then(|joint| robot.moving_joints()[joint].parent);
    }
    first
}
