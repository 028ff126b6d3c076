//! Connections in memory. A process that dies cuts all of its connections at once.

use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::{Arc, Mutex, Weak};
use std::task::{Context, Poll, Waker};

use revprio::service::{Accepted, Listener};
use tokio::io::{AsyncRead, AsyncWrite, DuplexStream, ReadBuf, duplex};
use tokio::sync::mpsc;

/// The port of a service, as its clients see it.
pub struct Port {
    dial: mpsc::UnboundedSender<DuplexStream>,
    ends: Mutex<Vec<Weak<Mutex<End>>>>,
}

/// The port, as the service sees it.
pub struct MemoryListener {
    dialled: mpsc::UnboundedReceiver<DuplexStream>,
    count: u16,
}

/// The client's end of a connection. Dropping all clones of it kills the connection.
#[derive(Clone)]
pub struct Wire(Arc<Mutex<End>>);

#[derive(Default)]
struct End {
    /// `None` after the process at the other end died.
    stream: Option<DuplexStream>,
    reader: Option<Waker>,
    writer: Option<Waker>,
}

/// Opens a port.
pub fn open() -> (Port, MemoryListener) {
    let (dial, dialled) = mpsc::unbounded_channel();
    (Port { dial, ends: Mutex::default() }, MemoryListener { dialled, count: 0 })
}

impl Port {
    /// Connects; `buffer`: bytes that are on the way in each direction. Fails if nobody listens.
    pub fn connect(&self, buffer: usize) -> io::Result<Wire> {
        let (near, far) = duplex(buffer);
        self.dial.send(far).map_err(|_| io::ErrorKind::ConnectionRefused)?;
        let end = Arc::new(Mutex::new(End { stream: Some(near), ..End::default() }));
        let mut ends = self.ends.lock().unwrap();
        ends.retain(|end| end.strong_count() > 0);
        ends.push(Arc::downgrade(&end));
        Ok(Wire(end))
    }

    /// Cuts all connections.
    pub fn cut(&self) {
        for end in self.ends.lock().unwrap().drain(..).filter_map(|end| end.upgrade()) {
            let End { reader, writer, .. } = std::mem::take(&mut *end.lock().unwrap());
            reader.into_iter().chain(writer).for_each(Waker::wake);
        }
    }
}

impl Listener for MemoryListener {
    type Stream = DuplexStream;

    async fn accept(&mut self) -> io::Result<Accepted<DuplexStream>> {
        match self.dialled.recv().await {
            Some(stream) => {
                self.count += 1;
                let local = Some(SocketAddr::from(([127, 0, 0, 1], 8080)));
                Ok(Accepted { stream, local, peer: SocketAddr::from(([127, 0, 0, 1], self.count)) })
            }
            None => std::future::pending().await,
        }
    }
}

impl AsyncRead for Wire {
    fn poll_read(self: Pin<&mut Self>, context: &mut Context, into: &mut ReadBuf) -> Poll<io::Result<()>> {
        let mut end = self.0.lock().unwrap();
        end.reader = Some(context.waker().clone());
        match &mut end.stream {
            Some(stream) => Pin::new(stream).poll_read(context, into),
            None => Poll::Ready(Err(io::ErrorKind::ConnectionReset.into())),
        }
    }
}

impl AsyncWrite for Wire {
    fn poll_write(self: Pin<&mut Self>, context: &mut Context, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let mut end = self.0.lock().unwrap();
        end.writer = Some(context.waker().clone());
        match &mut end.stream {
            Some(stream) => Pin::new(stream).poll_write(context, bytes),
            None => Poll::Ready(Err(io::ErrorKind::ConnectionReset.into())),
        }
    }

    fn poll_flush(self: Pin<&mut Self>, _: &mut Context) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(self: Pin<&mut Self>, context: &mut Context) -> Poll<io::Result<()>> {
        match &mut self.0.lock().unwrap().stream {
            Some(stream) => Pin::new(stream).poll_shutdown(context),
            None => Poll::Ready(Ok(())),
        }
    }
}
