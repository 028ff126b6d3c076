//! Functions for `#[serde(default = …, skip_serializing_if = …)]`: defaults, which are not written.

/// The default `true`.
pub fn yes() -> bool {
    true
}

/// Returns whether the value is `true`.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
pub fn is_yes(value: &bool) -> bool {
    *value
}

/// Returns whether the value is `false`.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
pub fn is_no(value: &bool) -> bool {
    !*value
}

/// The default 1.
pub fn one() -> f64 {
    1.0
}

/// Returns whether the value is the default of its type.
pub fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
