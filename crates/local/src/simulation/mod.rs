//! Interactive simulations: commands, pace, live view and progress, without threads and connections.

mod camera;
mod controller_change;
mod live;
mod pacer;
mod progress;
mod run_control;
mod status;

pub use camera::Camera;
pub use live::{LiveView, Picture};
pub use pacer::{Pacer, Turn};
pub use progress::{Finished, Progress, ProgressPublisher};
pub use run_control::{Commands, RunControl};
pub use status::{check_size, status};
