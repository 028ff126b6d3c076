//! What `revprio serve` does about signals and about a thread that is stuck.

use std::io;
use std::time::Duration;

use crate::service::{LogWriter, Supervisor};

/// Exit status of a service whose thread of the requests was stuck (`EX_SOFTWARE` of sysexits.h).
const STUCK: i32 = 70;

/// Maximum time for the last lines of the log.
pub const LOG_TIMEOUT: Duration = Duration::from_millis(500);

/// Tells systemd the state of the service, and ends the process if the service is stuck.
pub struct ProcessSupervisor {
    log: LogWriter,
}

impl ProcessSupervisor {
    /// Creates a supervisor that ends the process after the last lines of this log.
    pub fn new(log: LogWriter) -> Self {
        Self { log }
    }
}

impl Supervisor for ProcessSupervisor {
    fn ready(&self) {
        notify::ready();
    }

    fn alive(&self) {
        notify::alive();
    }

    fn stopping(&self) {
        notify::stopping();
    }

    fn stuck(&self) {
        tracing::error!("the service is stuck and ends with status {STUCK}");
        self.log.finish(LOG_TIMEOUT);
        std::process::exit(STUCK);
    }
}

/// Lets the second SIGINT or SIGTERM end the process at once, as without a handler. This works in a stuck process too.
#[cfg(unix)]
pub fn end_on_second_signal() -> io::Result<()> {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::flag::{register, register_conditional_default};

    let is_second = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // The handlers of a signal run in this order.
        register_conditional_default(signal, Arc::clone(&is_second))?;
        register(signal, Arc::clone(&is_second))?;
    }
    Ok(())
}

#[cfg(not(unix))]
pub fn end_on_second_signal() -> io::Result<()> {
    Ok(())
}

/// Messages to systemd, if it started this process with `Type=notify`. An error only means that nobody listens.
#[cfg(target_os = "linux")]
mod notify {
    use sd_notify::{NotifyState, notify};

    pub fn ready() {
        let _ = notify(false, &[NotifyState::Ready]);
    }

    pub fn alive() {
        let _ = notify(false, &[NotifyState::Watchdog]);
    }

    pub fn stopping() {
        let _ = notify(false, &[NotifyState::Stopping]);
    }
}

#[cfg(not(target_os = "linux"))]
mod notify {
    pub fn ready() {}
    pub fn alive() {}
    pub fn stopping() {}
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    /// Runs in a process of its own.
    #[test]
    #[ignore = "ends the process"]
    fn end_of_a_stuck_process() {
        ProcessSupervisor::new(LogWriter::start(std::io::stderr()).unwrap()).stuck();
    }

    #[test]
    fn a_stuck_process_ends_with_status_70() {
        let test = ["--exact", "cli::supervisor::tests::end_of_a_stuck_process", "--ignored"];
        let ended = Command::new(std::env::current_exe().unwrap()).args(test).output().unwrap();
        assert_eq!(ended.status.code(), Some(70));
    }
}
