//! One run: a seed, a world, its clients and the audit.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use revprio::service::LogWriter;
use tokio::task::JoinSet;

use crate::audit::audit;
use crate::clients;
use crate::exchange::Client;
use crate::plan::Plan;
use crate::random::Random;
use crate::transcript::Transcript;
use crate::world::World;

/// The result of a run.
pub struct Outcome {
    pub transcript: Transcript,
    /// What was violated.
    pub failure: Option<String>,
}

/// Runs a seed.
pub fn run(seed: u64) -> Outcome {
    let transcript = Transcript::default();
    let noted = transcript.clone();
    let result = catch_unwind(AssertUnwindSafe(|| simulate(seed, noted)));
    let failure = result.err().map(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned())).unwrap_or_default()
    });
    Outcome { transcript, failure }
}

fn simulate(seed: u64, transcript: Transcript) {
    let mut random = Random::new(seed);
    let plan = Plan::random(&mut random);
    let fails = plan.log_fails;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().start_paused(true).build().unwrap();
    let run = || runtime.block_on(live(plan, transcript, random));
    if fails { tracing::subscriber::with_default(failing_log(), run) } else { run() }
}

async fn live(plan: Plan, transcript: Transcript, mut random: Random) {
    let roles = plan.roles.clone();
    let world = World::start(plan, transcript, random.fork());
    world.note("world", &format!("{:?}", world.plan));
    let mut tasks = JoinSet::new();
    for (number, role) in roles.into_iter().enumerate() {
        let name = format!("{role:?}{number}");
        tasks.spawn(clients::run(Client { world: Arc::clone(&world), name, random: random.fork() }, role));
    }
    while let Some(ended) = tasks.join_next().await {
        if let Err(error) = ended {
            std::panic::resume_unwind(error.into_panic());
        }
    }
    audit(&mut Client { world: Arc::clone(&world), name: "audit".to_owned(), random }).await;
    let replayed = world.oracle().replay();
    replayed.unwrap_or_else(|violation| panic!("{violation}"));
}

/// A log whose output has no space left.
fn failing_log() -> impl tracing::Subscriber + Send + Sync {
    struct Full;
    impl io::Write for Full {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::StorageFull.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Err(io::ErrorKind::StorageFull.into())
        }
    }
    let writer = LogWriter::start(Full).unwrap();
    tracing_subscriber::fmt().with_max_level(tracing::Level::DEBUG).with_writer(move || writer.clone()).finish()
}
