//! Server-sent events that show the latest value, never more often than a reader needs.

use std::time::Duration;

use axum::Error;
use axum::response::sse::{Event, KeepAlive, Sse};
use futures_util::{Stream, stream};
use serde::Serialize;
use tokio::sync::watch;

use super::drain::Draining;

/// Comments are sent after this time without an event, so that a reader that is gone is noticed.
const KEEP_ALIVE: Duration = Duration::from_secs(15);

/// What a reader gets of a value.
pub enum Shown<V> {
    /// Nothing.
    Nothing,
    /// An event of that name.
    Event(&'static str, V),
    /// The same, and nothing after it.
    Last(&'static str, V),
}

/// Sends the present value and later ones, `pause` apart at least; what passes meanwhile is left out. Ends with the
/// source, when the service drains, or after the last one.
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
    /// The next event and, unless it is the last one, the reader of those after it.
    async fn next<V: Serialize>(mut self) -> Option<(Result<Event, Error>, Option<Self>)>
    where
        F: FnMut(&T) -> Shown<V>,
    {
        loop {
            if !std::mem::take(&mut self.is_first) {
                tokio::time::sleep(self.pause).await;
            }
            tokio::select! {
                changed = self.source.changed() => changed.ok()?,
                () = self.draining.begun() => return None,
            }
            // Not shown while it is borrowed: that would hold up whoever changes it.
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
