//! Controllers of stateless steps, ready for the next one.
//!
//! A client sends its controller with every state, and as a rule the same text as the last time. What was read, checked and
//! given a workspace for that one is found again by the text. Nothing depends on it but the time: no answer depends on
//! what is in a workspace, and a text that is not known, or stands in MessagePack, is read as if there were no others.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use revprio_api::wire::{self, object};
use revprio_core::controller::Stepper;
use serde::Deserialize;
use serde_json::value::RawValue;

use super::body::Unread;
use super::convert;
use super::error::ApiError;
use super::format::Format;
use super::robots::Robots;

/// Controllers that are kept, each with its text: those of as many loops, in a megabyte or two.
const MOST: usize = 16;

/// Longest text of one, bytes: some dozens of tasks.
const LONGEST: usize = 16 << 10;

/// A stepper and the text that its controller was read from.
pub struct Kept {
    /// `None` if it may not be kept.
    text: Option<String>,
    /// Ready to step.
    pub stepper: Stepper,
}

/// A request for a step, with its controller read and checked.
pub struct StepCall {
    /// The controller.
    pub kept: Box<Kept>,
    /// The state.
    pub state: wire::State,
    /// The last answer's memory.
    pub memory: Option<wire::Memory>,
}

/// A [`wire::StepRequest`] of which the controller is not read yet.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Glance<'a> {
    #[serde(borrow)]
    controller: &'a RawValue,
    #[serde(deserialize_with = "object::deserialize")]
    state: wire::State,
    #[serde(default, deserialize_with = "object::optional")]
    memory: Option<wire::Memory>,
}

/// The last controllers, the one that stepped last at the end.
#[derive(Default)]
pub struct Recent(Mutex<VecDeque<Box<Kept>>>);

impl Recent {
    /// Reads a request; its stepper is the caller's until it is given back by [`Self::keep`].
    pub fn read(&self, body: &Unread, robots: &Robots) -> Result<StepCall, ApiError> {
        if let Some(Glance { controller, state, memory }) = body.format.glance(&body.bytes) {
            let text = controller.get();
            if let Some(kept) = self.take(text) {
                return Ok(StepCall { kept, state, memory });
            }
            if let Some(controller) = Format::Json.glance(text.as_bytes()) {
                return Ok(StepCall { kept: Kept::new(&controller, Some(text), robots)?, state, memory });
            }
        }
        // What is wrong is explained by reading the whole.
        let wire::StepRequest { controller, state, memory } = body.read()?;
        Ok(StepCall { kept: Kept::new(&controller, None, robots)?, state, memory })
    }

    fn take(&self, text: &str) -> Option<Box<Kept>> {
        let mut steppers = self.steppers();
        let place = steppers.iter().rposition(|stepper| stepper.text.as_deref() == Some(text))?;
        steppers.remove(place)
    }

    /// Keeps a stepper for the next request with its text, in the place of the one that was not used for longest.
    pub fn keep(&self, kept: Box<Kept>) {
        if kept.text.is_none() {
            return;
        }
        let mut steppers = self.steppers();
        if steppers.len() == MOST {
            steppers.pop_front();
        }
        steppers.push_back(kept);
    }

    fn steppers(&self) -> MutexGuard<'_, VecDeque<Box<Kept>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Kept {
    fn new(controller: &wire::Controller, text: Option<&str>, robots: &Robots) -> Result<Box<Self>, ApiError> {
        // A registered robot that is not used ends, and its name may be given to another.
        let may_be_kept = |text: &&str| text.len() <= LONGEST && robots.is_permanent(&controller.robot);
        let text = text.filter(may_be_kept).map(str::to_owned);
        let controller = convert::controller(controller, robots).map_err(|problem| problem.inside("/controller"))?;
        let stepper = Stepper::new(controller).map_err(|error| convert::step_problem(&error, "/state"))?;
        Ok(Box::new(Self { text, stepper }))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use revprio_robot::{RobotModel, built_in};

    const STEP: &str = include_str!("../../api/examples/step.json");

    fn body(text: String) -> Unread {
        Unread { format: Format::Json, bytes: text.into_bytes() }
    }

    /// Reads a request and gives its stepper back; whether there was one for its text.
    fn is_known(recent: &Recent, text: &str, robots: &Robots) -> bool {
        let before = recent.steppers().len();
        let call = recent.read(&body(text.to_owned()), robots).unwrap();
        let known = recent.steppers().len() < before;
        recent.keep(call.kept);
        known
    }

    #[test]
    fn a_controller_is_found_by_its_text_with_any_state() {
        let (recent, robots) = (Recent::default(), Robots::built_in());
        assert!(!is_known(&recent, STEP, &robots));
        let later = STEP.replace("\"sequence\": 17", "\"sequence\": 18");
        assert!(later != STEP && is_known(&recent, &later, &robots));
        let slower = STEP.replace("0.001", "0.002");
        assert!(!is_known(&recent, &slower, &robots));
        let period = |text: &str| {
            recent.read(&body(text.to_owned()), &robots).unwrap().kept.stepper.controller().config().period_s
        };
        assert_eq!((period(&slower), period(STEP)), (0.002, 0.001));
    }

    #[test]
    fn only_some_are_kept_and_the_last_ones_of_them() {
        let (recent, robots) = (Recent::default(), Robots::built_in());
        let text = |i: usize| STEP.replace("\"push\"", &format!("\"push {i}\""));
        (0..=MOST).for_each(|i| assert!(!is_known(&recent, &text(i), &robots)));
        assert_eq!(recent.steppers().len(), MOST);
        assert!(!is_known(&recent, &text(0), &robots) && is_known(&recent, &text(MOST), &robots));
    }

    #[test]
    fn controllers_of_registered_robots_and_long_ones_are_not_kept() {
        let (recent, robots) = (Recent::default(), Robots::built_in());
        robots.register(Arc::new(RobotModel::clone(&built_in()[0]).renamed("mine"))).unwrap();
        let mine = STEP.replace("\"sawyer_dh\"", "\"mine\"");
        let long = STEP.replace("\"push\"", &format!("\"{}\"", "a".repeat(LONGEST)));
        for text in [&mine, &long] {
            assert!(!is_known(&recent, text, &robots) && !is_known(&recent, text, &robots));
        }
        robots.remove("mine").unwrap();
        let refused = recent.read(&body(mine), &robots).err().unwrap().into_wire();
        assert_eq!(refused.pointer.as_deref(), Some("/controller/robot"));
    }

    #[test]
    fn what_is_wrong_is_said_as_if_nothing_were_known() {
        let (recent, robots) = (Recent::default(), Robots::built_in());
        is_known(&recent, STEP, &robots);
        for (from, to) in [("17,", "-17,"), ("null", "[]"), ("\"push\"", "7"), ("\"memory\"", "\"state\""), ("}", "]")]
        {
            let wrong = body(STEP.replace(from, to));
            let whole = wrong.read::<wire::StepRequest>().unwrap_err();
            assert_eq!(recent.read(&wrong, &robots).err().unwrap(), whole, "{to} for {from}");
        }
    }
}
