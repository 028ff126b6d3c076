//! Who opened a session, and who may step, replace and end it.

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use axum::http::{HeaderName, HeaderValue};
use subtle::ConstantTimeEq;
use utoipa::IntoParams;
use utoipa::openapi::Required;
use utoipa::openapi::path::{Parameter, ParameterBuilder, ParameterIn};
use utoipa::openapi::schema::{ObjectBuilder, SchemaType, Type};

use super::error::ApiError;

/// The header with the owner token of a session.
pub const OWNER: HeaderName = HeaderName::from_static("revprio-owner");

/// The header with the key of a request that opens a session.
pub const IDEMPOTENCY_KEY: HeaderName = HeaderName::from_static("idempotency-key");

/// Parameter of a stream with the owner token, for browsers, whose WebSockets send no headers of their own.
const OWNER_PARAMETER: &str = "revprio_owner";

/// Maximum length of a token or key.
const MAX_LENGTH: usize = 128;

/// A word that the client chose: an owner token or an idempotency key.
#[derive(Clone, PartialEq, Eq)]
struct Word(String);

impl Word {
    fn read(text: &str, name: &HeaderName) -> Result<Self, ApiError> {
        let is_word = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.~".contains(&byte);
        if (1..=MAX_LENGTH).contains(&text.len()) && text.bytes().all(is_word) {
            return Ok(Self(text.to_owned()));
        }
        Err(ApiError::malformed(format!("`{name}` must have 1 to {MAX_LENGTH} letters, digits and -_.~; send a UUID")))
    }

    fn from_header(parts: &Parts, name: &HeaderName) -> Result<Option<Self>, ApiError> {
        let mut values = parts.headers.get_all(name).iter();
        let read = |value: &HeaderValue| Self::read(value.to_str().unwrap_or_default(), name);
        let word = values.next().map(read).transpose()?;
        match values.next() {
            Some(_) => Err(ApiError::malformed(format!("`{name}` is sent twice; send it once"))),
            None => Ok(word),
        }
    }
}

/// Describes a parameter whose value is a [`Word`].
fn parameter(name: &str, place: ParameterIn, description: &str) -> Parameter {
    let text = ObjectBuilder::new().schema_type(SchemaType::from_iter([Type::String, Type::Null]));
    let word = text.min_length(Some(1)).max_length(Some(MAX_LENGTH)).pattern(Some("^[A-Za-z0-9_.~-]+$"));
    let parameter = ParameterBuilder::new().name(name).parameter_in(place).required(Required::False);
    parameter.description(Some(description)).schema(Some(word)).build()
}

/// The owner token of a request, if it has one.
#[derive(Clone, Default)]
pub struct Owner(Option<Word>);

impl Owner {
    /// Refuses a change of a session with this owner by another client. A session without owner is open to all.
    pub fn allow(&self, client: &Self) -> Result<(), ApiError> {
        let Some(Word(owner)) = &self.0 else { return Ok(()) };
        match &client.0 {
            Some(Word(token)) if token.as_bytes().ct_eq(owner.as_bytes()).into() => Ok(()),
            _ => Err(ApiError::not_owner()),
        }
    }
}

impl<S: Send + Sync> FromRequestParts<S> for Owner {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, ApiError> {
        let header = Word::from_header(parts, &OWNER)?;
        let mut parameters = parts.uri.query().unwrap_or_default().split('&');
        let word = parameters.find_map(|parameter| parameter.strip_prefix(OWNER_PARAMETER)?.strip_prefix('='));
        // Both are checked; the header has priority.
        let parameter = word.map(|word| Word::read(word, &OWNER)).transpose()?;
        Ok(Self(header.or(parameter)))
    }
}

impl IntoParams for Owner {
    fn into_params(_: impl Fn() -> Option<ParameterIn>) -> Vec<Parameter> {
        let header = "Owner token of the session; required if the session was opened with one.";
        let query = "The same for browsers, whose WebSockets send no headers.";
        let header = parameter("Revprio-Owner", ParameterIn::Header, header);
        vec![header, parameter(OWNER_PARAMETER, ParameterIn::Query, query)]
    }
}

/// How a session is opened: its owner, and the key of the request.
#[derive(Clone, Default)]
pub struct Ownership {
    /// The owner of the session.
    pub owner: Owner,
    key: Option<Word>,
}

impl Ownership {
    /// Returns whether both requests have the same key. Requests without a key are all different.
    pub fn has_key_of(&self, other: &Self) -> bool {
        self.key.is_some() && self.key == other.key
    }

    /// Returns whether both requests have the same owner token or none.
    pub fn has_owner_of(&self, other: &Self) -> bool {
        self.owner.0 == other.owner.0
    }
}

impl<S: Send + Sync> FromRequestParts<S> for Ownership {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        let owner = Owner::from_request_parts(parts, state).await?;
        Ok(Self { owner, key: Word::from_header(parts, &IDEMPOTENCY_KEY)? })
    }
}

impl IntoParams for Ownership {
    fn into_params(_: impl Fn() -> Option<ParameterIn>) -> Vec<Parameter> {
        let owner = "Owner token, a word that the client chooses. Every request that steps, replaces or ends the session must send it too.";
        let key = "A word that the client chooses for this request. The same request with the same key gets the same \
                   session again.";
        let owner = parameter("Revprio-Owner", ParameterIn::Header, owner);
        vec![owner, parameter("Idempotency-Key", ParameterIn::Header, key)]
    }
}
