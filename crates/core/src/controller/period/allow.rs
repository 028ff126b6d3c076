//! The third step: what limits and constraints allow.

use crate::arm_state::ArmState;
use crate::collision::{CollisionGuard, Moment, ObstacleState};
use crate::constraint::{self, Inequality};
use crate::controller::config::{ControllerConfig, Limits};
use crate::controller::state::Memory;
use crate::limits::{LimitKind, LimitedBox, may_jump};

/// The joint velocities that a period allows.
#[derive(Debug)]
pub(super) struct Allowed {
    /// The box of all limits.
    pub limits: LimitedBox,
    /// In a transition: the box of the controller alone, without the limits of the transition. `None`: no joint may jump.
    pub alone: Option<LimitedBox>,
    /// The box without limits of acceleration and jerk, in which joints with a jerk limit first look for the velocity that their
    /// tasks want; `None`: the controller keeps no jerk limit.
    pub without_jerk: Option<LimitedBox>,
    /// The rows of the constraints, one block after the other.
    pub inequalities: Vec<Inequality>,
}

impl Allowed {
    /// Allocates the box and the rows of a checked configuration.
    pub fn new(config: &ControllerConfig) -> Self {
        let n = config.robot.joint_count();
        Self {
            limits: match &config.limits {
                Limits::Robot(_) => LimitedBox::unbounded(n),
                Limits::Fixed(velocity_box) => LimitedBox::given(velocity_box.clone()),
            },
            alone: config.limits_let_joints_jump().then(|| LimitedBox::unbounded(n)),
            without_jerk: config.keeps_jerk().then(|| LimitedBox::unbounded(n)),
            inequalities: constraint::allocate(&config.constraints, n),
        }
    }
}

/// Returns what a period allows.
pub(super) fn allow<'a>(
    config: &ControllerConfig,
    (arm, previous, obstacles): (&ArmState, &Memory, &[ObstacleState]),
    allowed: &'a mut Allowed,
    guard: Option<&mut CollisionGuard>,
) -> &'a Allowed {
    let Allowed { limits, alone, without_jerk, inequalities } = &mut *allowed;
    let (robot, motion, period) = (&config.robot, arm.motion(), config.period_s);
    let in_transition = previous.in_transition;
    if let Some(alone) = alone.as_mut().filter(|_| in_transition) {
        limit_joints(alone, config, arm, false);
    }
    limit_joints(limits, config, arm, in_transition);
    if let Some(without_jerk) = without_jerk {
        without_jerk.update(robot, LimitKind::PositionVelocity, motion, period);
    }
    constraint::write(&config.constraints, arm, inequalities);
    if let (Some(guard), Some((_, rows))) = (guard, constraint::distances(&config.constraints)) {
        let moment = Moment { arm, drive_state: &previous.drive };
        guard.begin(moment, obstacles, &limits.velocity_box, &mut inequalities[rows]);
    }
    allowed
}

/// Writes the limits of a controller, with those of a transition or without.
fn limit_joints(limits: &mut LimitedBox, config: &ControllerConfig, arm: &ArmState, in_transition: bool) {
    let (robot, motion, period) = (&config.robot, arm.motion(), config.period_s);
    match &config.limits {
        Limits::Robot(LimitKind::PositionVelocity) if in_transition => {
            limits.update(robot, LimitKind::PositionVelocityAcceleration, motion, period);
        }
        Limits::Robot(kind) => limits.update(robot, *kind, motion, period),
        Limits::Fixed(velocity_box) => limits.set_given(velocity_box),
    }
    if in_transition {
        // With positions, joints with an acceleration limit keep it already.
        let keeps_positions = matches!(&config.limits, Limits::Robot(kind) if kind.includes_position());
        limits.bound_changes(robot, &arm.last_command, period, |limits| !keeps_positions || may_jump(limits));
    }
}
