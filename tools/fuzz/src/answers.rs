//! What must hold for each answer.

use std::fmt;

use revprio_api::wire::{self, Problem};
use serde::de::{DeserializeOwned, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::Defect;
use crate::connection::Answer;
use crate::limits::{SpeedLimits, violation};

const JSON: &str = "application/json";
const MESSAGE_PACK: &str = "application/msgpack";

/// Checks status and media type of an answer. Returns its value if the service accepted the request, otherwise `None`.
/// `may_be_late`: whether the service may answer that the work took too long.
pub fn value<T: DeserializeOwned>(answer: &Answer, may_be_late: bool) -> Result<Option<T>, Defect> {
    match answer.media_type.as_str() {
        _ if (200..300).contains(&answer.status) => decode(&answer.media_type, &answer.body).map(Some),
        "application/problem+json" => problem(&answer.body, Some(answer.status), may_be_late).map(|()| None),
        other => Err(wrong("status and media type", format!("{} {other}", answer.status), &answer.body)),
    }
}

/// Decodes a value whose numbers must all be finite.
pub fn decode<T: DeserializeOwned>(media_type: &str, body: &[u8]) -> Result<T, Defect> {
    match media_type {
        // A number that is not finite is `null` in JSON, which the type refuses.
        JSON => serde_json::from_slice(body).map_err(|error| wrong("the answer", error, body)),
        MESSAGE_PACK => {
            rmp_serde::from_slice::<Finite>(body).map_err(|error| wrong("the answer", error, body))?;
            rmp_serde::from_slice(body).map_err(|error| wrong("the answer", error, body))
        }
        other => Err(wrong("the media type", other, body)),
    }
}

/// Checks a problem object.
pub fn problem(body: &[u8], status: Option<u16>, may_be_late: bool) -> Result<(), Defect> {
    let problem: Problem = serde_json::from_slice(body).map_err(|error| wrong("the problem", error, body))?;
    let is_late = matches!(problem.kind.as_str(), "/problems/deadline" | "/problems/busy");
    if problem.status >= 500 && !(may_be_late && is_late) {
        return Err(wrong("the status", problem.status, body));
    }
    let texts = [&problem.kind, &problem.title, &problem.detail];
    if texts.iter().any(|text| text.is_empty()) || status.is_some_and(|status| status != problem.status) {
        return Err(wrong("the problem", "incomplete, or another status than the answer", body));
    }
    Ok(())
}

/// The parts that answers to problems and steps share.
pub trait Command {
    /// Returns the joint velocities.
    fn joint_velocity(&self) -> &[f64];
    /// Returns the limits that are reported as violated.
    fn violated_limits(&self) -> &[wire::ViolatedLimit];
}

impl Command for wire::ResolveAnswer {
    fn joint_velocity(&self) -> &[f64] {
        &self.joint_velocity
    }

    fn violated_limits(&self) -> &[wire::ViolatedLimit] {
        &self.violated_limits
    }
}

impl Command for wire::StepAnswer {
    fn joint_velocity(&self) -> &[f64] {
        &self.joint_velocity
    }

    fn violated_limits(&self) -> &[wire::ViolatedLimit] {
        &self.violated_limits
    }
}

/// Checks that a command respects the speed limits of its request.
pub fn command(answer: &impl Command, limits: Option<&SpeedLimits>) -> Result<(), Defect> {
    let Some(limits) = limits else { return Ok(()) };
    if let Some(violation) = violation(answer.joint_velocity(), limits) {
        return Err(Defect::Wrong(violation));
    }
    // Limits of the request may allow more than the speed limits of the robot. Those are reported, and are no defect.
    let is_stated = |limit: f64| limits.iter().any(|&(lower, upper)| limit == lower || limit == upper);
    match answer.violated_limits().iter().find(|violated| is_stated(violated.limit)) {
        None => Ok(()),
        Some(violated) => Err(Defect::Wrong(format!("{} is reported to violate a stated limit", violated.joint))),
    }
}

fn wrong(what: &str, cause: impl fmt::Display, body: &[u8]) -> Defect {
    Defect::Wrong(format!("{what}: {cause}: {}", String::from_utf8_lossy(body)))
}

/// Accepts any value whose numbers are finite.
struct Finite;

impl<'de> Deserialize<'de> for Finite {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Self)
    }
}

impl<'de> Visitor<'de> for Finite {
    type Value = Self;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("finite numbers, texts, lists and maps")
    }

    fn visit_bool<E>(self, _: bool) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_i64<E>(self, _: i64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_u64<E>(self, _: u64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<Self, E> {
        if value.is_finite() { Ok(self) } else { Err(E::custom(format!("{value}"))) }
    }

    fn visit_str<E>(self, _: &str) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_unit<E>(self) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self, A::Error> {
        while list.next_element::<Self>()?.is_some() {}
        Ok(self)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self, A::Error> {
        while map.next_entry::<Self, Self>()?.is_some() {}
        Ok(self)
    }
}
