//! One control period, in five steps. Each takes what the steps before it returned, and returns one value.
//!
//! | step | returns | what it decides |
//! |---|---|---|
//! | [`measure`] | [`ArmState`] | what the arm is like: posture, velocity, wrench, and where it comes to rest |
//! | [`aim`] | [`Wishes`] | what the tasks wish: a velocity or two bounds per row |
//! | [`allow`] | [`Allowed`] | what limits and constraints allow: the box, with the cause of each bound, and the rows |
//! | [`resolve`] | [`Answer`](self::resolve::Answer) | which joint velocities are the answer |
//! | [`record`] | [`Command`] | what the answer means, and what the next period must know |

mod aim;
mod allow;
mod measure;
mod record;
mod resolve;
mod row_space;

pub use self::aim::BRAKING_SHARE;
use self::aim::{Aiming, Wishes, aim};
use self::allow::{Allowed, allow};
use self::measure::measure;
pub use self::record::MAX_ATTEMPTS;
use self::record::{Recording, record};
use self::resolve::{Resolving, resolve};
use super::config::ControllerConfig;
use super::state::{Command, Measurement, Memory, StepError};
use crate::arm_state::ArmState;
use crate::collision::CollisionGuard;
use crate::resolution::Solve;

/// The values of one control period. They are allocated once and overwritten in each period. No result depends on their
/// previous content.
pub(super) struct Period {
    arm: ArmState,
    aiming: Aiming,
    allowed: Allowed,
    resolving: Resolving,
    recording: Recording,
    guard: Option<CollisionGuard>,
}

impl Period {
    /// Allocates the values for a checked configuration.
    pub fn new(config: &ControllerConfig, solver: Box<dyn Solve>) -> Result<Self, StepError> {
        let arm = config.allocate_arm()?;
        let (aiming, allowed) = (Aiming::new(config, config.moved_rows(&arm)?)?, Allowed::new(config));
        let resolving = Resolving::new(config, &arm, aiming.targets(), solver);
        let recording = Recording::new(config.robot.joint_count());
        Ok(Self { arm, aiming, allowed, resolving, recording, guard: config.allocate_guard()? })
    }

    /// Computes one control period. On an error the memory stays unchanged.
    pub fn run(
        &mut self,
        config: &ControllerConfig,
        memory: &mut Option<Memory>,
        measurement: &Measurement,
    ) -> Result<&Command, StepError> {
        let Self { arm, aiming, allowed, resolving, recording, guard } = self;
        measurement.check(config)?;
        memory.as_ref().map_or(Ok(()), |memory| memory.check(config))?;

        let (arm, known) = measure(config, memory.as_ref(), measurement, arm)?;
        let Wishes { problem, requests } = aim(config, arm, &known, measurement, aiming)?;
        let allowed = allow(config, (arm, &known, &measurement.obstacles), allowed, guard.as_mut());
        let answer = resolve(config, (arm, &known, requests), problem, (allowed, guard.as_mut()), resolving)?;

        let in_time = known.is_in_time();
        let memory = match known.into_new() {
            Some(new) => memory.insert(new),
            None => memory.get_or_insert_with(|| Memory::at_start(config, arm.measured())),
        };
        Ok(record(config, (measurement, in_time), (arm, requests, allowed), answer, memory, recording))
    }

    /// Returns the command of the last period.
    pub fn command(&mut self) -> &mut Command {
        self.resolving.command()
    }
}
