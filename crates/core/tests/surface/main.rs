//! A task that follows the normal of a surface which it is not told.

mod estimate;
mod wiping;
#[expect(dead_code, reason = "the example uses the rest")]
mod world;
