//! Functions for `#[serde(deserialize_with = …)]` that read the bounds of the rows of a task.
//!
//! `null` is no bound. So is an infinity on the side of the bound, because TOML has no `null`.

use serde::de::Error;
use serde::{Deserialize, Deserializer};

/// One bound per row; `None`: no bound.
type Bounds = Vec<Option<f64>>;

/// Reads lower bounds. −∞ is no bound.
pub fn lower<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Bounds>, D::Error> {
    read(deserializer, f64::NEG_INFINITY)
}

/// Reads upper bounds. +∞ is no bound.
pub fn upper<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Bounds>, D::Error> {
    read(deserializer, f64::INFINITY)
}

fn read<'de, D: Deserializer<'de>>(deserializer: D, none: f64) -> Result<Option<Bounds>, D::Error> {
    let Some(bounds) = Option::<Bounds>::deserialize(deserializer)? else { return Ok(None) };
    let bound = |bound: Option<f64>| match bound {
        Some(value) if value == none => Ok(None),
        // JSON has no infinity and no NaN: these would become `null` on the way to the service.
        Some(value) if !value.is_finite() => Err(D::Error::custom(format!("{value} allows no velocity"))),
        bound => Ok(bound),
    };
    bounds.into_iter().map(bound).collect::<Result<_, _>>().map(Some)
}

#[cfg(test)]
mod tests {
    use crate::wire::ResolveTask;

    #[test]
    fn null_is_no_bound() {
        let text = r#"{"axes": ["z"], "lower": [null, -0.1], "upper": null}"#;
        let task: ResolveTask = serde_json::from_str(text).unwrap();
        assert_eq!((task.velocity, task.lower, task.upper), (None, Some(vec![None, Some(-0.1)]), None));
    }
}
