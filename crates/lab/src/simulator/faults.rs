//! What goes wrong on the line, as a scenario says it.

use revprio_api::wire::object;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::field_error::{FieldError, between, not_negative, positive};

/// Longest that a late answer takes, periods.
const LATEST: usize = 10_000;

/// Most outages of a run.
const MOST_OUTAGES: usize = 100;

/// Faults on the line between the arm and the service; none if nothing is set. The first answer always arrives.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Faults {
    /// Part of the answers that are lost, 0 to 1.
    pub dropped: f64,
    /// Part of the answers at which the line jams: they and all after them arrive together, `late_periods` later.
    pub late: f64,
    /// How long a jam lasts, periods.
    pub late_periods: usize,
    /// Part of the answers that arrive once more a period later.
    pub repeated: f64,
    /// Part of the answers that arrive a period later, after the next one.
    pub reordered: f64,
    /// When the service is dead.
    #[serde(deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub outages: Vec<Outage>,
}

/// A time in which the service hears nothing and says nothing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Outage {
    /// Since the start, s; above zero.
    pub start_s: f64,
    /// How long, s.
    pub duration_s: f64,
}

impl Faults {
    /// Whether the numbers make sense; `pointer` says where they stand.
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
            return Err(FieldError::new(pointer, format!("add up to {sum} of all answers; at most 1 makes sense")));
        }
        let least = usize::from(self.late > 0.0);
        between(self.late_periods, least, LATEST, &format!("{pointer}/late_periods"))?;
        if self.outages.len() > MOST_OUTAGES {
            return Err(FieldError::new(format!("{pointer}/outages"), format!("are more than {MOST_OUTAGES}")));
        }
        for (i, outage) in self.outages.iter().enumerate() {
            positive(outage.start_s, &format!("{pointer}/outages/{i}/start_s"))?;
            not_negative(outage.duration_s, &format!("{pointer}/outages/{i}/duration_s"))?;
        }
        Ok(())
    }

    /// Whether the service is dead at a time, s; never at the start.
    pub fn is_dead(&self, time_s: f64) -> bool {
        self.outages.iter().any(|outage| (outage.start_s..outage.start_s + outage.duration_s).contains(&time_s))
    }
}
