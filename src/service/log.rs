//! Log lines on an output that may fail or block, such as standard error on a full disk or in a pipe without a reader.
//!
//! Another thread writes the lines, so that the service never waits for the output. A line that cannot be written is
//! dropped and counted.

use std::io::{self, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, SyncSender};
use std::time::Duration;

/// Maximum number of lines that wait for the output.
const MAX_WAITING: usize = 4096;

/// Number of lines of this process that were dropped.
static DROPPED: AtomicU64 = AtomicU64::new(0);

/// Returns the number of lines of this process that were dropped.
pub fn dropped_lines() -> u64 {
    DROPPED.load(Ordering::Relaxed)
}

fn drop_line() {
    DROPPED.fetch_add(1, Ordering::Relaxed);
}

/// Passes lines to the thread that writes them. Writing never fails and never waits.
#[derive(Debug, Clone)]
pub struct LogWriter(SyncSender<Message>);

#[derive(Debug)]
enum Message {
    Line(Vec<u8>),
    /// All lines before it are written.
    Flushed(SyncSender<()>),
}

impl LogWriter {
    /// Starts the thread for an output.
    pub fn start(mut output: impl Write + Send + 'static) -> io::Result<Self> {
        let (sender, messages) = mpsc::sync_channel(MAX_WAITING);
        let write = move || {
            for message in messages {
                match message {
                    Message::Line(line) => output.write_all(&line).unwrap_or_else(|_| drop_line()),
                    Message::Flushed(sender) => drop(sender.send(())),
                }
            }
        };
        std::thread::Builder::new().name("log".to_owned()).spawn(write)?;
        Ok(Self(sender))
    }

    /// Waits until all lines are written, or until the timeout.
    pub fn finish(&self, timeout: Duration) {
        let (sender, flushed) = mpsc::sync_channel(1);
        if self.0.try_send(Message::Flushed(sender)).is_ok() {
            let _ = flushed.recv_timeout(timeout);
        }
    }
}

/// Each call writes one line.
impl Write for LogWriter {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        self.0.try_send(Message::Line(line.to_vec())).unwrap_or_else(|_| drop_line());
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fails, or blocks until the channel closes.
    enum Output {
        Full,
        Blocked(mpsc::Receiver<()>),
    }

    impl Write for Output {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            if let Self::Blocked(released) = self {
                let _ = released.recv();
            }
            Err(io::ErrorKind::StorageFull.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// Both outputs in one test: the counter belongs to the process.
    #[test]
    fn lines_for_an_output_that_fails_or_blocks_are_dropped_and_counted() {
        let mut log = LogWriter::start(Output::Full).unwrap();
        (0..10).for_each(|_| log.write_all(b"a line\n").unwrap());
        log.finish(Duration::from_secs(20));
        assert_eq!(dropped_lines(), 10);

        let (release, released) = mpsc::channel();
        let mut log = LogWriter::start(Output::Blocked(released)).unwrap();
        (0..MAX_WAITING + 100).for_each(|_| log.write_all(b"a line\n").unwrap());
        log.finish(Duration::from_millis(10));
        // The thread may have taken one line from the queue.
        assert!((99..=110).contains(&(dropped_lines() - 10)), "{}", dropped_lines());
        drop(release);
    }
}
