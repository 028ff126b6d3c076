//! The calls that clients make, and their requests.

use std::sync::Arc;

use revprio_api::wire;

use crate::controllers::Design;
use crate::http::Request;
use crate::random::Random;

/// Format of a request and of its answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    Json,
    MessagePack,
}

/// What is wrong with the body of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The body ends too early.
    Syntax,
    /// A number is not finite.
    Infinite,
    /// A field is missing.
    Missing,
    /// The media type is unknown.
    MediaType,
}

/// A request to open a session.
#[derive(Debug, Clone)]
pub struct Open {
    pub design: Design,
    pub owner: Option<String>,
    pub key: Option<String>,
}

/// A call of the service.
#[derive(Debug, Clone)]
pub enum Call {
    Open(Open),
    Step {
        session: String,
        owner: Option<String>,
        state: Arc<wire::State>,
        fault: Option<Fault>,
    },
    Show {
        session: String,
    },
    Delete {
        session: String,
        owner: Option<String>,
    },
    List,
    /// Another route, and the status of its answer.
    Other {
        method: &'static str,
        path: &'static str,
        host: &'static str,
        status: u16,
    },
    /// Readiness: 503 while the service shuts down.
    Ready,
    /// A step without a session.
    Once {
        request: Arc<wire::StepRequest>,
    },
}

impl Format {
    pub fn random(random: &mut Random) -> Self {
        if random.one_in(4) { Self::MessagePack } else { Self::Json }
    }

    pub fn media_type(self) -> &'static str {
        match self {
            Self::Json => "application/json",
            Self::MessagePack => "application/msgpack",
        }
    }

    pub fn write(self, value: &impl serde::Serialize) -> Vec<u8> {
        match self {
            Self::Json => serde_json::to_vec(value).unwrap(),
            Self::MessagePack => rmp_serde::to_vec_named(value).unwrap(),
        }
    }
}

impl Fault {
    /// Returns a body with this fault, in JSON.
    fn body(self, state: &wire::State) -> Vec<u8> {
        let mut text = serde_json::to_string(state).unwrap();
        match self {
            Self::Syntax => text.truncate(text.len() - 1),
            Self::Infinite => text = text.replacen("\"time_s\":", "\"time_s\":1e999,\"unused\":", 1),
            Self::Missing => text = text.replacen("\"time_s\":", "\"time\":", 1),
            Self::MediaType => (),
        }
        text.into_bytes()
    }

    /// Returns the status of its refusal.
    pub fn status(self) -> u16 {
        match self {
            Self::Syntax | Self::Infinite => 400,
            Self::Missing => 422,
            Self::MediaType => 415,
        }
    }
}

impl Call {
    /// Returns the request.
    pub fn request(&self, id: String, format: Format) -> Request {
        let optional = |request: Request, name: &'static str, value: &Option<String>| match value {
            Some(value) => request.with(name, value.as_str()),
            None => request,
        };
        match self {
            Self::Open(Open { design, owner, key }) => {
                let request = Request::new("POST", "/v1/controllers", id);
                let request = request.with_body(format.media_type(), format.write(&*design.wire));
                optional(optional(request, "revprio-owner", owner), "idempotency-key", key)
            }
            Self::Step { session, owner, state, fault } => {
                let request = Request::new("POST", format!("/v1/controllers/{session}/step"), id);
                let request = match fault {
                    None => request.with_body(format.media_type(), format.write(&**state)),
                    Some(Fault::MediaType) => request.with_body("text/plain", Fault::MediaType.body(state)),
                    Some(fault) => request.with_body("application/json", fault.body(state)),
                };
                optional(request, "revprio-owner", owner)
            }
            Self::Show { session } => Request::new("GET", format!("/v1/controllers/{session}"), id),
            Self::Delete { session, owner } => {
                optional(Request::new("DELETE", format!("/v1/controllers/{session}"), id), "revprio-owner", owner)
            }
            Self::List => Request::new("GET", "/v1/controllers", id),
            Self::Ready => Request::new("GET", "/readyz", id),
            Self::Other { method, path, host, .. } => {
                let mut request = Request::new(method, *path, id);
                (*host).clone_into(&mut request.headers[0].1);
                request
            }
            Self::Once { request } => {
                Request::new("POST", "/v1/step", id).with_body(format.media_type(), format.write(&**request))
            }
        }
    }

    /// Returns a short description for the transcript.
    pub fn text(&self) -> String {
        let short = |id: &str| id.get(..8).unwrap_or(id).to_owned();
        match self {
            Self::Open(Open { design, owner, key }) => {
                let is = |word: &Option<String>| word.as_deref().map_or("none".to_owned(), short);
                format!("open {} owner {} key {}", design.wire.robot, is(owner), is(key))
            }
            Self::Step { session, state, fault, owner } => {
                let owner = owner.as_deref().map_or("none".to_owned(), short);
                let fault = fault.map_or(String::new(), |fault| format!(" {fault:?}"));
                format!(
                    "step {} sequence {} time {} owner {owner}{fault}",
                    short(session),
                    state.sequence,
                    state.time_s
                )
            }
            Self::Show { session } => format!("show {}", short(session)),
            Self::Delete { session, owner } => {
                format!("delete {} owner {}", short(session), owner.as_deref().map_or("none".to_owned(), short))
            }
            Self::List => "list".to_owned(),
            Self::Ready => "ready?".to_owned(),
            Self::Other { method, path, host, .. } => format!("{method} {path} host {host}"),
            Self::Once { request } => format!("step once sequence {}", request.state.sequence),
        }
    }
}
