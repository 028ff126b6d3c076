//! The HTTP service.
//!
//! | route | what |
//! |---|---|
//! | `POST /v1/resolve`, `/v1/resolve/batch` | one stateless question, or up to 10 000 in one request |
//! | `POST /v1/step` | one control period, the controller's memory travelling with the request |
//! | `POST /v1/controllers` | opens a session; `GET` shows and `DELETE` ends `/v1/controllers/{id}` |
//! | `POST /v1/controllers/{id}/step` | one control period of a session |
//! | `GET /v1/controllers/{id}/stream` | the same over WebSocket |
//! | `GET /v1/controllers/{id}/watch` | states with their answers as server-sent events `step`, 30 a second at most |
//! | `POST /v1/kinematics` | pose, Jacobian, singular values, link frames at a posture |
//! | `POST /v1/stability` | how much lag, delay and how little damping one axis in contact bears |
//! | `GET /v1/robots`, `/v1/robots/{name}` | the arms that requests can name |
//! | `GET /v1/scenarios`, `/v1/scenarios/{name}` | the experiments that ship with the service |
//! | `POST /v1/simulations` | runs a scenario; `GET` shows, `DELETE` cancels (an ended one: forgets) `/v1/simulations/{id}` |
//! | `GET /v1/simulations/{id}/events`, `/trace` | server-sent events `progress` and `end`; CSV, JSON lines or JSON |
//! | `GET /docs`, `/openapi.json`, `/asyncapi.json` | the interactive reference and the documents behind it |
//! | `GET /healthz`, `/readyz`, `/metrics` | liveness; readiness, false while draining; Prometheus |
//!
//! # Bodies
//!
//! JSON or MessagePack (`application/msgpack`, structs as maps with field names), request by `Content-Type`, answer by
//! `Accept`, otherwise in the format of the request. MessagePack may hold only what JSON could: finite numbers, texts as
//! keys. Problems are always `application/problem+json`. Batches, traces and the list of scenarios are compressed (gzip)
//! for clients that say so; steps never.
//!
//! # Before an answer is too old: the client's watchdog
//!
//! The service cannot see whether its answer arrived, or whether the next state is on its way. Each answer to a state
//! therefore carries `valid_for_ms`. The rule for whoever commands the arm: count from the moment at which the *state*
//! was measured; when that time is over and no newer answer is there, whatever the reason (no connection, a problem
//! instead of an answer, a slow network), ramp the last joint velocities to zero within the arm's acceleration limits
//! and hold; begin again with a fresh state. Never go on with an old command, and never repeat it.
//!
//! # Streams
//!
//! `/stream` takes one state per message and sends one answer per state, as JSON in text frames (no subprotocol or
//! `revprio.json`) or as MessagePack in binary frames (`revprio.msgpack`). The rules of sequence numbers are those of
//! requests, and several streams and requests may share a session. What is refused gets a problem object, which has a
//! `status` where an answer has `joint_velocity`, and the stream goes on. A message has at most 64 KiB. The service
//! pings every 10 s and closes with code
//!
//! | code | because |
//! |---|---|
//! | 1001 | the service ends |
//! | 1002 | a message is no WebSocket message, or larger than 128 KiB |
//! | 1011 | the service has a defect |
//! | 4404 | the controller has ended |
//! | 4408 | nothing was heard of the client for 30 s, not even an answer to a ping |
//!
//! A client that does not read for 5 s is disconnected.
//!
//! # Long work
//!
//! One thread serves all steps. Batches and simulations run in others, and end when nobody waits for them any more:
//!
//! - batches one after the other on all cores, at a lower priority than steps, up to 4 at a time, others get 503;
//! - stability margins, which take seconds for long delays, one after the other, up to 8 at a time;
//! - simulations two at a time, the others queued; up to 100 000 control periods each and 250 000 all together, which
//!   bounds the memory of their traces to some 125 MB. Ended ones are forgotten after an hour, or, oldest first, when a
//!   new one needs the room; where that does not help, 503.
//!
//! # What keeps it safe and steady
//!
//! One thread answers all requests: a step takes microseconds, less than handing it to another thread. From the outside
//! in:
//!
//! - `server`: listening and ending. Told to end, the service first says so at `/readyz`, then stops listening, then
//!   answers what is in flight and ends streams.
//! - `connection`: at most [`ServiceConfig::max_connections`]; for one more, the connection without an answer for the
//!   longest time is closed, which is never that of a control loop or of a WebSocket. Headers, handshakes and answers
//!   that are not taken have their timeouts, after which a connection just ends. Bytes that are no HTTP, and headers
//!   beyond 64 KiB, get a bare 400, 414 or 431 from hyper, without a body; every other error is a problem (RFC 9457).
//! - `gate`: every request gets a name (`x-request-id`), is counted and logged. Those without the token get 401, those
//!   of a foreign web page 403.
//! - `line`: requests that stand too far back get 503 and Retry-After at once instead of a late answer. `/healthz`,
//!   `/readyz` and `/metrics` need not stand in line.
//! - `body`: size and time of bodies are bounded, and how many large ones are read at a time, so that memory is.
//!
//! On any but a loopback address [`serve`] wants a [`Token`].

mod accept;
mod access;
mod admission_queue;
mod app;
mod background;
mod body;
mod config;
mod connection;
mod convert;
mod drain;
mod error;
mod events;
mod format;
mod gate;
mod handlers;
mod in_process;
mod metrics;
mod openapi;
mod recent;
mod resolve;
mod robots;
mod segment;
mod server;
mod sessions;
mod simulations;
mod step;
mod stream;
mod tls;

pub use access::{Token, TokenError};
pub use app::{AppState, Service, router};
pub use config::ServiceConfig;
pub use convert::{controller, robot_answer};
pub use error::ApiError;
pub use openapi::{asyncapi_document, openapi_document};
pub use robots::{Robots, RobotsError};
pub use server::{RunningServer, ServeError, bind, serve};
pub use tls::{Tls, TlsError};
