//! A cache of the controllers of stateless steps.
//!
//! A client sends its controller with every state, usually as the same text. The cache finds the stepper of that text: the
//! controller that was already read and checked, with its workspace. The cache saves time only. No answer depends on the
//! content of a workspace. A controller that is not cached, or arrives in MessagePack, is read in the usual way.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use revprio_api::wire::{self, object};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::checked_stepper::CheckedStepper;
use super::error::ApiError;
use super::format::{Format, RawBody};
use super::robots::Robots;
use super::step::stateless_stepper;

/// Maximum number of cached controllers: enough for 16 control loops, in a few megabytes.
const MAX_CACHED: usize = 16;

/// Maximum length of the text of a cached controller, bytes: a few dozen tasks, or a thousand entries of constant rows with
/// all digits.
const MAX_TEXT: usize = 32 << 10;

/// A stepper and the text of its controller.
pub struct CachedStepper {
    /// `None` if the stepper must not be cached.
    text: Option<String>,
    /// The stepper, ready for a step.
    pub stepper: CheckedStepper,
}

/// A request for a step, with its controller read and checked.
pub struct StepCall {
    /// The controller.
    pub cached: Box<CachedStepper>,
    /// The state.
    pub state: wire::State,
    /// The memory from the last answer.
    pub memory: Option<wire::Memory>,
}

/// A [`wire::StepRequest`] with the unread text of its controller.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawStepRequest<'a> {
    #[serde(borrow)]
    controller: &'a RawValue,
    #[serde(deserialize_with = "object::deserialize")]
    state: wire::State,
    #[serde(default, deserialize_with = "object::optional")]
    memory: Option<wire::Memory>,
}

/// The cached steppers, the last used one at the end.
#[derive(Default)]
pub struct StepperCache(Mutex<VecDeque<Box<CachedStepper>>>);

impl StepperCache {
    /// Reads a request and removes its stepper from the cache. [`Self::put`] gives the stepper back.
    pub fn read(&self, body: &RawBody, robots: &Robots) -> Result<StepCall, ApiError> {
        if let Some(RawStepRequest { controller, state, memory }) = body.format.read_borrowed(&body.bytes) {
            let text = controller.get();
            if let Some(cached) = self.take(text) {
                return Ok(StepCall { cached, state, memory });
            }
            if let Some(controller) = Format::Json.read_borrowed(text.as_bytes()) {
                return Ok(StepCall { cached: CachedStepper::new(&controller, Some(text), robots)?, state, memory });
            }
        }
        // Reading the whole request again explains what is wrong.
        let wire::StepRequest { controller, state, memory } = body.read()?;
        Ok(StepCall { cached: CachedStepper::new(&controller, None, robots)?, state, memory })
    }

    fn take(&self, text: &str) -> Option<Box<CachedStepper>> {
        let mut steppers = self.lock();
        let index = steppers.iter().rposition(|stepper| stepper.text.as_deref() == Some(text))?;
        steppers.remove(index)
    }

    /// Caches a stepper for the next request with the same text. A full cache drops the least recently used stepper.
    pub fn put(&self, cached: Box<CachedStepper>) {
        if cached.text.is_none() {
            return;
        }
        let mut steppers = self.lock();
        if steppers.len() == MAX_CACHED {
            steppers.pop_front();
        }
        steppers.push_back(cached);
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<Box<CachedStepper>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl CachedStepper {
    fn new(controller: &wire::Controller, text: Option<&str>, robots: &Robots) -> Result<Box<Self>, ApiError> {
        // A registered robot can end, and another robot can get its name.
        let is_cacheable = |text: &&str| text.len() <= MAX_TEXT && robots.is_permanent(&controller.robot);
        let text = text.filter(is_cacheable).map(str::to_owned);
        Ok(Box::new(Self { text, stepper: stateless_stepper(controller, robots)? }))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use revprio_robot::{RobotModel, built_in};

    const STEP: &str = include_str!("../../api/examples/step.json");

    fn body(text: String) -> RawBody {
        RawBody { format: Format::Json, bytes: text.into_bytes() }
    }

    /// Reads a request and gives its stepper back. Returns whether the stepper was cached.
    fn is_cached(cache: &StepperCache, text: &str, robots: &Robots) -> bool {
        let before = cache.lock().len();
        let call = cache.read(&body(text.to_owned()), robots).unwrap();
        let was_cached = cache.lock().len() < before;
        cache.put(call.cached);
        was_cached
    }

    #[test]
    fn a_controller_is_found_by_its_text_whatever_the_state() {
        let (cache, robots) = (StepperCache::default(), Robots::built_in());
        assert!(!is_cached(&cache, STEP, &robots));
        let later = STEP.replace("\"sequence\": 17", "\"sequence\": 18");
        assert!(later != STEP && is_cached(&cache, &later, &robots));
        let slower = STEP.replace("0.001", "0.002");
        assert!(!is_cached(&cache, &slower, &robots));
        let period = |text: &str| {
            cache.read(&body(text.to_owned()), &robots).unwrap().cached.stepper.controller().config().period_s
        };
        assert_eq!((period(&slower), period(STEP)), (0.002, 0.001));
    }

    #[test]
    fn a_full_cache_drops_the_least_recently_used_controller() {
        let (cache, robots) = (StepperCache::default(), Robots::built_in());
        let text = |i: usize| STEP.replace("\"push\"", &format!("\"push {i}\""));
        (0..=MAX_CACHED).for_each(|i| assert!(!is_cached(&cache, &text(i), &robots)));
        assert_eq!(cache.lock().len(), MAX_CACHED);
        assert!(!is_cached(&cache, &text(0), &robots) && is_cached(&cache, &text(MAX_CACHED), &robots));
    }

    #[test]
    fn long_controllers_and_those_of_registered_robots_are_not_cached() {
        let (cache, robots) = (StepperCache::default(), Robots::built_in());
        robots.register(Arc::new(RobotModel::clone(&built_in()[0]).renamed("mine"))).unwrap();
        let mine = STEP.replace("\"sawyer_dh\"", "\"mine\"");
        let long = STEP.replace("\"push\"", &format!("\"{}\"", "a".repeat(MAX_TEXT)));
        for text in [&mine, &long] {
            assert!(!is_cached(&cache, text, &robots) && !is_cached(&cache, text, &robots));
        }
        robots.remove("mine").unwrap();
        let refused = cache.read(&body(mine), &robots).err().unwrap().into_wire();
        assert_eq!(refused.pointer.as_deref(), Some("/controller/robot"));
    }

    #[test]
    fn errors_do_not_depend_on_the_cache() {
        let (cache, robots) = (StepperCache::default(), Robots::built_in());
        is_cached(&cache, STEP, &robots);
        for (from, to) in [("17,", "-17,"), ("null", "[]"), ("\"push\"", "7"), ("\"memory\"", "\"state\""), ("}", "]")]
        {
            let wrong = body(STEP.replace(from, to));
            let whole = wrong.read::<wire::StepRequest>().unwrap_err();
            assert_eq!(cache.read(&wrong, &robots).err().unwrap(), whole, "{to} for {from}");
        }
    }
}
