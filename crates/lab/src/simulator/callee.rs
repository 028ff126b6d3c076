//! The service that a run calls.

use std::ops::Deref;

use revprio_api::Service;

/// The service that a run calls.
pub enum Callee<'a> {
    Borrowed(&'a dyn Service),
    Owned(Box<dyn Service>),
}

impl<'a> Deref for Callee<'a> {
    type Target = dyn Service + 'a;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Borrowed(service) => *service,
            Self::Owned(service) => &**service,
        }
    }
}
