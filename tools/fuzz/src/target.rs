//! The targets of the fuzzer, and the first line of their inputs.

/// What the bytes of an input are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A line with the route, then a body in JSON.
    Json,
    /// A line with the route, then a body in MessagePack.
    MessagePack,
    /// A body in JSON for `/v1/stability`, whose answers take longer than all others.
    Stability,
    /// A URDF text to register. A first line may have the names of base and tip.
    Urdf,
    /// A line with the kind of messages, then messages or bytes of a WebSocket.
    Stream,
    /// Lines of JSON: a controller, then states.
    Controller,
}

impl Target {
    /// All targets.
    pub const ALL: [Self; 6] =
        [Self::Json, Self::MessagePack, Self::Stability, Self::Urdf, Self::Stream, Self::Controller];

    /// Returns the name, which is the name of the folder of its corpus.
    pub fn name(self) -> &'static str {
        match self {
            Self::Json => "json",
            Self::MessagePack => "message_pack",
            Self::Stability => "stability",
            Self::Urdf => "urdf",
            Self::Stream => "stream",
            Self::Controller => "controller",
        }
    }

    /// Returns the target with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|target| target.name() == name)
    }
}

/// Splits the first line off.
pub fn split_line(input: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = input.iter().position(|byte| *byte == b'\n')?;
    Some((&input[..end], &input[end + 1..]))
}
