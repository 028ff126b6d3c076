//! What the oracle finds.

/// A broken promise of the service, in words.
pub type Violation = String;
