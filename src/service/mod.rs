//! The HTTP service.
//!
//! | route | purpose |
//! |---|---|
//! | `POST /v1/resolve`, `/v1/resolve/batch` | resolves one stateless problem, or up to 10 000 in one request |
//! | `POST /v1/step` | one control period; the controller's memory is part of the request |
//! | `GET /v1/controllers` | lists the sessions |
//! | `POST /v1/controllers` | opens a session |
//! | `GET`, `PUT`, `DELETE /v1/controllers/{id}` | shows a session, replaces its controller, or ends it |
//! | `POST /v1/controllers/{id}/tare` | measures the bias of a wrench sensor |
//! | `POST /v1/controllers/{id}/step` | one control period of a session |
//! | `GET /v1/controllers/{id}/stream` | control periods of a session over WebSocket |
//! | `GET /v1/controllers/{id}/watch` | server-sent events `step` with states and answers, at most 30 a second |
//! | `POST /v1/kinematics` | pose, Jacobian, singular values and link frames at a posture |
//! | `POST /v1/payload` | bias and payload of a wrench sensor from readings in six postures or more |
//! | `POST /v1/stability` | stability margins of one axis in contact: maximum lag, maximum delay, minimum damping |
//! | `GET`, `POST /v1/robots` | lists or registers the arms that requests can name |
//! | `GET`, `DELETE /v1/robots/{name}` | shows an arm, or deletes a registered one |
//! | `GET /v1/scenarios`, `/v1/scenarios/{name}` | the scenarios that ship with the service |
//! | `POST /v1/simulations` | simulates a scenario |
//! | `GET`, `DELETE /v1/simulations/{id}` | shows a simulation; cancels a running one, deletes an ended one |
//! | `GET /v1/simulations/{id}/events` | server-sent events `progress` and `end` |
//! | `GET /v1/simulations/{id}/trace` | the trace: CSV, JSON lines, JSON, Parquet or MCAP |
//! | `POST /v1/simulations/{id}/control` | controls an interactive simulation |
//! | `GET /v1/simulations/{id}/live`, `/cycle` | the live view and the last control period of an interactive simulation |
//! | `GET /`, `/docs` | the page in the browser, the interactive reference |
//! | `GET /openapi.json`, `/asyncapi.json` | the interface description |
//! | `GET /healthz`, `/readyz`, `/metrics` | liveness; readiness (503 during shutdown); metrics for Prometheus |
//!
//! # Bodies
//!
//! Bodies are JSON or MessagePack (`application/msgpack`, structs as maps with field names). `Content-Type` selects the
//! format of the request, `Accept` the format of the answer. Without `Accept`, the answer has the format of the request.
//!
//! MessagePack may contain only values of JSON: finite numbers, and strings as keys. Problems are always
//! `application/problem+json`. Batches, traces and the list of scenarios are compressed with gzip if the client accepts
//! it. Answers to steps are never compressed.
//!
//! # The watchdog of the client
//!
//! The service cannot see whether its answer arrived or whether the next state will come. Each answer to a state
//! therefore contains `valid_for_ms`. The program that commands the arm must follow this rule:
//!
//! 1. Count `valid_for_ms` from the moment at which the *state* was measured.
//! 2. If the time is over and there is no newer answer, for whatever reason (no connection, a problem instead of an
//!    answer, a slow network), brake all joints to rest together within `stop_time_s`, or each at its `braking_deceleration` if there is no
//!    `stop_time_s`. Then hold.
//! 3. The arm keeps a command until the next one. Send the velocity of the ramp at the time of the next command.
//! 4. Resume with a newly measured state.
//!
//! Never continue with an expired command. Never repeat it. With this rule every joint stops inside its position range, if
//! the controller's `limits` include positions and its solver is not `closed_form`. The module `limits` of the library
//! proves it.
//!
//! # Plausible states
//!
//! A state beyond the bounds of the controller's `state_checks` is refused (422, `implausible`). `warnings` of the answer
//! name everything else that is not plausible: time that goes back or jumps, a jump of the sequence number or of a joint,
//! a joint outside its range or too fast to stop, and two clients that step the same session.
//!
//! # Owners and keys
//!
//! A session that is opened with the header `Revprio-Owner` is stepped and ended only with the same header (403, `owner`).
//! Browsers, whose WebSockets send no headers, write `?revprio_owner=…` behind `/stream`. The owner token prevents
//! mistakes between clients. It is not a secret of the service.
//!
//! A request with `Idempotency-Key` that opens a session can be repeated if its answer was lost. The same request with the
//! same key gets the same session, as long as the session is open.
//!
//! # Streams
//!
//! `/stream` receives one state per message and sends one answer per state. Messages are JSON in text frames (no
//! subprotocol or `revprio.json`) or MessagePack in binary frames (`revprio.msgpack`). Sequence numbers follow the same
//! rules as in requests. Several streams and requests may share a session; if they alternate, the answers have a warning.
//!
//! A refused state gets a problem object, and the stream continues. A problem has `status` and no `joint_velocity`. A
//! message of more than 64 KiB gets a problem object too. The service pings every 10 s. It closes a stream with one of these
//! codes:
//!
//! | code | cause |
//! |---|---|
//! | 1001 | the service ends |
//! | 1002 | a message is not a WebSocket message, or is larger than 128 KiB |
//! | 1011 | the service has a defect |
//! | 4404 | the controller has ended |
//! | 4408 | the client sent nothing for 30 s, not even an answer to a ping |
//!
//! The service disconnects a client that does not read for 5 s.
//!
//! # Long work
//!
//! One thread serves all steps of arms. Other threads run the work that is not bounded by the size of an arm. Each kind has
//! a queue of its own. Work that has not started stops when its client is gone, and so do batches, margins and simulations.
//! Work that has not finished after `ServiceConfig::work_timeout` (batches: ten times as long) is abandoned with 503.
//!
//! The price of a resolution is known before it starts: tasks × (equations + 4 × (bounds + inequalities) + joints) ×
//! joints².
//!
//! | work | at a time | running and waiting, then 503 |
//! |---|---|---|
//! | batches | one, on all cores with a lower priority than steps | 4 |
//! | problems with a price above 4000, or above 16 KiB | one for each core but one, with a lower priority | 32 |
//! | steps with a price above 8000, or above 16 KiB | one for each core but one | 32 |
//! | stability margins, which take seconds at long delays | one, with a lower priority | 8 |
//! | new controllers (stability warnings), robots (URDF), simulations; other bodies above 16 KiB | one, with a lower priority | 64 |
//! | simulations, at most 100 000 control periods each | two | 64 |
//! | interactive simulations | four | 4 |
//!
//! The service keeps at most 64 simulations with 250 000 control periods together, so their traces use at most about
//! 250 MB. A new interactive simulation takes the place of one that no client has watched or commanded for five seconds;
//! without a new one, such a simulation ends after a minute. An ended simulation is deleted after an hour, or earlier if a new
//! one needs its place. If none is left to delete, a new one gets 503.
//!
//! # Protection against overload and misuse
//!
//! One thread answers all requests: a step takes microseconds, less than passing it to another thread. A request passes
//! these modules, from the outside in:
//!
//! | module | protection |
//! |---|---|
//! | `heartbeat` | A thread that watches this one. If this one is stuck, it answers new connections with 503 and has the process ended. |
//! | `server` | Connections take turns after each answer. Orderly shutdown: `/readyz` answers 503, then the service stops listening, then it answers the requests in flight and ends the streams. |
//! | `connection` | At most [`ServiceConfig::max_connections`]. If one more arrives, the service closes the connection that has been without an answer for the longest time. A connection in a control loop and a WebSocket are never closed this way. Headers, handshakes and unread answers have timeouts. |
//! | `gate` | Gives each request an ID (`x-request-id`), counts and logs it. A foreign or missing `Host` gets 403 or 400 on every route, unknown encodings 501 or 415. Requests without the token get 401 or 429, requests of other sites' pages 403. |
//! | `admission_queue` | Requests that have waited longer than `max_lag` get 503 and `Retry-After` at once. `/healthz`, `/readyz` and `/metrics` are always admitted. |
//! | `body` | Limits the size and the time of bodies, and the number of large bodies at a time. |
//!
//! Bytes that are not HTTP, and headers above 64 KiB, get status 400, 414 or 431 without a body. Every other error is a
//! problem (RFC 9457).
//!
//! On every address that is not a loopback address, [`serve`] requires a [`Token`].
//!
//! # Order of the modules
//!
//! A module imports only modules of its own line and of the lines above it, and there are no import circles:
//!
//! 1. The crate `revprio_local`: `error`, `robots`, `convert`, `step`, `price`: bodies to controllers and back, without a server
//! 2. `accept`, `format`, `request_id`, `token`, `tls`, `config`, `access`, `host`: one request, without state
//! 3. `log`, `metrics`, `connection`, `admission_queue`, `drain`, `failures`, `heartbeat`, `listener`, `background`,
//!    `platform`, `workers`, `events`: the running server
//! 4. `sessions`, `stepper_cache`, `in_process`, `simulations`: the controllers
//! 5. `state`: all of these together
//! 6. `body`, `resolve`, `step_once`, `stream`, `gate`: modules that use the state
//! 7. `handlers`, then `routes`, then `openapi`, then `app`, then `server`

mod accept;
mod access;
mod admission_queue;
mod app;
mod background;
mod body;
mod config;
mod connection;
mod drain;
mod events;
mod failures;
mod format;
mod gate;
mod handlers;
mod heartbeat;
mod host;
mod in_process;
mod interleaving;
mod listener;
mod log;
mod metrics;
mod openapi;
mod ownership;
mod platform;
mod published;
mod request_id;
mod resolve;
mod routes;
mod server;
mod sessions;
mod simulations;
mod state;
mod step_once;
mod stepper_cache;
mod stream;
mod tls;
mod token;
mod workers;

use revprio_local::{checked_stepper, convert, error, price, robots, solvers, stateless_service, step};

pub use app::{Service, router};
pub use checked_stepper::ComputedStep;
pub use config::ServiceConfig;
pub use convert::{
    check_tip_names, controller, frames_of_srdf, overrides, registered_tips, robot_answer, shapes_answer, with_shapes,
};
pub use error::ApiError;
pub use heartbeat::Supervisor;
pub use host::is_host_name;
pub(crate) use in_process::InProcess;
pub use listener::{Accepted, Listener};
pub use log::{LogWriter, dropped_lines};
pub use openapi::{asyncapi_document, openapi_document};
pub use platform::{Job, JobQueue, OperatingSystem, Platform, WorkKind};
pub use revprio_local::{LocalController, LocalService, Price};
pub use robots::{Robots, RobotsError};
pub use server::{RunningServer, ServeError, bind, serve, serve_on, serve_supervised};
pub use solvers::{solver, stepper};
pub use state::AppState;
pub use tls::{Tls, TlsError};
pub use token::{Token, TokenError};
