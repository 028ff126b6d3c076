//! Where connections come from: a TCP port, or memory in the simulation of `tests/simulation`.

use std::future::Future;
use std::io;
use std::net::SocketAddr;

use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};

/// An accepted connection.
#[derive(Debug)]
pub struct Accepted<S> {
    /// The bytes.
    pub stream: S,
    /// The address that accepted the connection.
    pub local: Option<SocketAddr>,
    /// The address of the client.
    pub peer: SocketAddr,
}

/// Accepts connections. A dropped listener refuses further connections.
pub trait Listener: Send {
    /// The bytes of one connection.
    type Stream: AsyncRead + AsyncWrite + Unpin + Send + 'static;

    /// Waits for the next connection. No connection is lost if the future is dropped.
    fn accept(&mut self) -> impl Future<Output = io::Result<Accepted<Self::Stream>>> + Send;
}

impl Listener for TcpListener {
    type Stream = TcpStream;

    async fn accept(&mut self) -> io::Result<Accepted<TcpStream>> {
        let (stream, peer) = TcpListener::accept(self).await?;
        // Answers are small and the client waits for them: never delay one to fill a packet.
        let _ = stream.set_nodelay(true);
        Ok(Accepted { local: stream.local_addr().ok(), stream, peer })
    }
}
