//! Server-sent events that show the latest value at a limited rate.

use std::time::Duration;

use axum::Error;
use axum::response::sse::{Event, KeepAlive, Sse};
use futures_util::{Stream, stream};
use serde::Serialize;
use tokio::sync::watch;

use super::drain::Draining;

/// After this time without an event, a comment is sent. This detects readers that are gone.
const KEEP_ALIVE: Duration = Duration::from_secs(15);

/// The event for a value.
pub enum Shown<V> {
    /// No event.
    Nothing,
    /// An event with this name and data.
    Event(&'static str, V),
    /// The last event of the stream.
    Last(&'static str, V),
}

/// Sends the current value and later values, at least `pause` apart. Values that change faster are skipped. The stream
/// ends with the source, when the service shuts down, or after the last event.
pub fn latest<T: Clone + Send + Sync + 'static, V: Serialize + Send + 'static>(
    mut source: watch::Receiver<T>,
    draining: Draining,
    pause: Duration,
    show: impl FnMut(&T) -> Shown<V> + Send + 'static,
) -> Sse<impl Stream<Item = Result<Event, Error>>> {
    source.mark_changed();
    let reader = Reader { source, draining, pause, show, is_first: true };
    let events = stream::unfold(Some(reader), |reader| async { reader?.next().await });
    Sse::new(events).keep_alive(KeepAlive::new().interval(KEEP_ALIVE))
}

struct Reader<T, F> {
    source: watch::Receiver<T>,
    draining: Draining,
    pause: Duration,
    show: F,
    is_first: bool,
}

impl<T: Clone, F> Reader<T, F> {
    /// Returns the next event and, unless it is the last one, the reader of the later events.
    async fn next<V: Serialize>(mut self) -> Option<(Result<Event, Error>, Option<Self>)>
    where
        F: FnMut(&T) -> Shown<V>,
    {
        loop {
            if !std::mem::take(&mut self.is_first) {
                tokio::time::sleep(self.pause).await;
            }
            tokio::select! {
                biased;
                () = self.draining.begun() => return None,
                changed = self.source.changed() => changed.ok()?,
            }
            // Clones the value, because a long borrow would block the writer.
            let value = self.source.borrow_and_update().clone();
            let event = |name, value| Event::default().event(name).json_data(value);
            match (self.show)(&value) {
                Shown::Nothing => (),
                Shown::Event(name, value) => return Some((event(name, value), Some(self))),
                Shown::Last(name, value) => return Some((event(name, value), None)),
            }
        }
    }
}
