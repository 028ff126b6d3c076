//! Faults of the connection, as in a scenario.

use revprio_api::wire::{integer, object};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::field_error::{FieldError, between, not_negative, positive};

/// Largest delay of a late answer, periods.
const MAX_LATE_PERIODS: usize = 10_000;

/// Largest number of outages of a run.
const MAX_OUTAGES: usize = 100;

/// Faults of the connection between arm and service; none by default. The first answer always arrives.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Faults {
    /// Share of the answers that are lost, 0 to 1.
    pub dropped: f64,
    /// Share of the answers that are late. A late answer delays all later answers; they arrive together after
    /// `late_periods`.
    pub late: f64,
    /// Delay of a late answer, periods.
    #[serde(deserialize_with = "integer::deserialize")]
    pub late_periods: usize,
    /// Share of the answers that arrive a second time one period later.
    pub repeated: f64,
    /// Share of the answers that arrive one period late, after the next answer.
    pub reordered: f64,
    /// Times at which the service does not run.
    #[serde(deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub outages: Vec<Outage>,
}

/// A time in which the service does not run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Outage {
    /// Start, s; above zero.
    pub start_s: f64,
    /// Duration, s.
    pub duration_s: f64,
}

impl Faults {
    /// Checks the values; `pointer` is the JSON pointer of this object.
    pub fn check(&self, pointer: &str) -> Result<(), FieldError> {
        let shares = [
            ("dropped", self.dropped),
            ("late", self.late),
            ("repeated", self.repeated),
            ("reordered", self.reordered),
        ];
        for (field, share) in shares {
            not_negative(share, &format!("{pointer}/{field}"))?;
        }
        let sum: f64 = shares.iter().map(|(_, share)| share).sum();
        if sum > 1.0 {
            return Err(FieldError::new(
                pointer,
                format!("has shares that add up to {sum}; the sum must be at most 1"),
            ));
        }
        let least = usize::from(self.late > 0.0);
        between(self.late_periods, least, MAX_LATE_PERIODS, &format!("{pointer}/late_periods"))?;
        if self.outages.len() > MAX_OUTAGES {
            return Err(FieldError::new(format!("{pointer}/outages"), format!("has more than {MAX_OUTAGES} outages")));
        }
        for (i, outage) in self.outages.iter().enumerate() {
            positive(outage.start_s, &format!("{pointer}/outages/{i}/start_s"))?;
            not_negative(outage.duration_s, &format!("{pointer}/outages/{i}/duration_s"))?;
        }
        Ok(())
    }

    /// Returns whether the service is down at a time, s; never at the start.
    pub fn is_down(&self, time_s: f64) -> bool {
        self.outages.iter().any(|outage| (outage.start_s..outage.start_s + outage.duration_s).contains(&time_s))
    }
}
