//! Streamed targets: targets that arrive one by one, more slowly than the control periods, as in teleoperation.
//!
//! A [`TargetStream`] keeps the last two targets and a *reference*, the target that the law of the task follows in this
//! period. Each period has two steps:
//!
//! 1. The targets give a desired value and its velocity: interpolated between the last two targets, or extrapolated
//!    from the last one for a bounded time. After that the desired value stays where it is.
//! 2. The reference follows the desired value within a maximum velocity and a maximum acceleration. So neither noise,
//!    nor a lost target, nor a jump of the target makes the command jump.
//!
//! The age of a target is the time of the state minus the time of the target minus [`Streaming::delay_s`].
//!
//! | age of the newest target | state | what the reference does |
//! |---|---|---|
//! | up to 0 | [`TargetState::Following`] | follows the line between the last two targets |
//! | up to `hold_after_s` | [`TargetState::Extrapolating`] | goes on with the velocity of the newest target |
//! | up to `brake_after_s` | [`TargetState::Holding`] | goes to the extrapolated target and stays there |
//! | above | [`TargetState::Braking`] | brakes to rest with the maximum acceleration |
//!
//! A *chunk* ([`StreamedChunk`]) brings the targets of the next seconds at once, as a policy computes them. The stream follows the curve
//! through its actions. A later chunk replaces the actions from its first one on, and the offset to the motion before fades.
//!
//! Velocities and forces are not extrapolated: the last one is kept instead. A motion is at rest at most
//! `brake_after_s` + maximum velocity / maximum acceleration (+ one period) after the newest target.

mod active_stream;
mod chunk;
mod curve;
mod fade;
mod reference;
mod rotation_rate;
mod settings;
mod stream;
mod streamed_chunk;
mod streamed_target;
mod value;

pub(crate) use active_stream::{ActiveStream, TaskStreams};
pub use active_stream::{ChunkReport, TargetReport};
pub(crate) use chunk::Arriving;
pub use chunk::{Chunk, MAX_KEPT_ACTIONS, Merged};
pub use curve::{LaterTarget, MIN_INTERVAL};
pub use fade::Fade;
pub use reference::{Bound, Reference};
pub use settings::{MAX_STREAMING_TIME, Streaming, StreamingError};
pub use stream::{Ignored, Target, TargetState, TargetStream};
pub use streamed_chunk::{Action, Align, ChannelChunk, ChunkError, MAX_ACTIONS, MAX_HORIZON, StreamedChunk};
pub use streamed_target::{
    MAX_AHEAD, MAX_FORESIGHT, MAX_TARGETS_AHEAD, StreamedTarget, StreamedValue, TargetAhead, TargetError,
};
pub use value::{Quantity, TargetValue};
