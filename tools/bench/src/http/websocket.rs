//! The WebSocket stream compared with HTTP requests: states of a session, one after the other on one core.

use std::net::TcpStream;

use tungstenite::{Message, WebSocket};

use super::affinity::Pinned;
use super::connection::{Connection, OWNER, Request};
use super::subject::{Call, UnderTest};
use crate::error::BenchError;
use crate::row::Row;
use crate::timing::{Budget, Subject, side_by_side};

pub fn rows(budget: Budget) -> Result<Vec<Row>, BenchError> {
    let _pinned = Pinned::to(0);
    let service = UnderTest::start()?;
    let mut stream = Stream::open(&service)?;
    let mut requests = Connection::open(service.address, service.request(Call::Session))?;
    let times = side_by_side(
        budget,
        vec![
            Subject::fallible("WebSocket, a state and its answer, one core", || stream.call()),
            Subject::fallible("POST /v1/controllers/{id}/step", || Ok(requests.call()?)),
        ],
    )?;
    Ok(Row::against_each(&times))
}

/// The JSON stream of a session.
struct Stream {
    socket: WebSocket<TcpStream>,
    states: Request,
}

impl Stream {
    fn open(service: &UnderTest) -> Result<Self, BenchError> {
        let stream = TcpStream::connect(service.address)?;
        stream.set_nodelay(true)?;
        let session = service.another_session()?;
        let url = format!("ws://{}/v1/controllers/{session}/stream?revprio_owner={OWNER}", service.address);
        let (socket, _) = tungstenite::client(url, stream).map_err(BenchError::defect)?;
        Ok(Self { socket, states: Request::from_text(service.state()) })
    }

    fn call(&mut self) -> Result<Message, BenchError> {
        let state = String::from_utf8_lossy(self.states.next_bytes()).into_owned();
        self.socket.send(Message::text(state)).map_err(BenchError::defect)?;
        match self.socket.read().map_err(BenchError::defect)? {
            Message::Text(text) if text.contains("joint_velocity") => Ok(Message::Text(text)),
            other => Err(BenchError::Defect(format!("the stream answered {other:?}"))),
        }
    }
}
