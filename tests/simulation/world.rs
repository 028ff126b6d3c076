//! The world of one run: the service that runs now, what the clients know, and the transcript.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

use revprio::service::{AppState, Platform, Robots, router, serve_on};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::Instant;

use crate::network::{Port, open};
use crate::oracle::Oracle;
use crate::plan::Plan;
use crate::platform::Simulated;
use crate::random::Random;
use crate::transcript::Transcript;

/// Everything that the parts of a run share.
pub struct World {
    pub plan: Plan,
    pub transcript: Transcript,
    start: Instant,
    oracle: Mutex<Oracle>,
    random: Mutex<Random>,
    instance: Mutex<Arc<Instance>>,
    next_request: AtomicU64,
}

/// One process of the service.
pub struct Instance {
    pub number: u32,
    pub port: Port,
    phase: Mutex<Phase>,
    stop: Mutex<Option<oneshot::Sender<()>>>,
    server: Mutex<Option<JoinHandle<()>>>,
}

/// Phase of a process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    Serving,
    /// It was told to stop at this time.
    Stopping(Instant),
    /// It has ended after it was told to stop at this time.
    Ended(Instant),
    Killed,
}

impl World {
    /// Starts a service.
    pub fn start(plan: Plan, transcript: Transcript, mut random: Random) -> Arc<Self> {
        let instance = Mutex::new(Arc::new(Instance::start(0, &plan, &mut random)));
        let oracle = Mutex::new(Oracle::new(plan.config.clone()));
        let (start, next_request) = (Instant::now(), AtomicU64::new(1));
        Arc::new(Self { plan, transcript, start, oracle, random: Mutex::new(random), instance, next_request })
    }

    pub fn note(&self, who: &str, text: &str) {
        self.transcript.note(self.start, who, text);
    }

    /// Time since the start of the run, s.
    pub fn time_s(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    pub fn oracle(&self) -> MutexGuard<'_, Oracle> {
        self.oracle.lock().unwrap()
    }

    /// Returns the process that clients reach now.
    pub fn instance(&self) -> Arc<Instance> {
        Arc::clone(&self.instance.lock().unwrap())
    }

    /// Starts another process, which clients reach from now on.
    pub fn replace(&self) {
        let number = self.instance().number + 1;
        let next = Instance::start(number, &self.plan, &mut self.random.lock().unwrap());
        *self.instance.lock().unwrap() = Arc::new(next);
        self.note("world", &format!("service {number} starts"));
    }

    /// Returns the ID of the next request.
    pub fn request_id(&self, client: &str) -> String {
        format!("{client}-{}", self.next_request.fetch_add(1, Ordering::Relaxed))
    }
}

impl Instance {
    fn start(number: u32, plan: &Plan, random: &mut Random) -> Self {
        let platform: Arc<dyn Platform> = Arc::new(Simulated::new(random.fork(), plan.max_wait));
        let service = router(AppState::on_platform(Robots::built_in(), plan.config.clone(), &platform));
        let (port, listener) = open();
        let (stop, stopped) = oneshot::channel();
        let stopped = async { drop(stopped.await) };
        let server = tokio::spawn(serve_on(listener, service, stopped));
        Self {
            number,
            port,
            phase: Mutex::new(Phase::Serving),
            stop: Mutex::new(Some(stop)),
            server: Mutex::new(Some(server)),
        }
    }

    pub fn phase(&self) -> Phase {
        *self.phase.lock().unwrap()
    }

    pub fn is_serving(&self) -> bool {
        self.phase() == Phase::Serving
    }

    /// Tells the process to stop.
    pub fn stop(&self) {
        if self.is_serving() {
            *self.phase.lock().unwrap() = Phase::Stopping(Instant::now());
            self.stop.lock().unwrap().take();
        }
    }

    /// Waits until the process has ended. Connections that it dropped are cut.
    pub async fn ended(&self) {
        let server = self.server.lock().unwrap().take();
        if let Some(server) = server {
            server.await.expect("the task that accepts connections does not fail");
        }
        if let Phase::Stopping(at) = self.phase() {
            *self.phase.lock().unwrap() = Phase::Ended(at);
        }
        self.port.cut();
    }

    /// Kills the process.
    pub fn kill(&self) {
        *self.phase.lock().unwrap() = Phase::Killed;
        if let Some(server) = self.server.lock().unwrap().take() {
            server.abort();
        }
        self.port.cut();
    }
}
