//! The targets `json` and `message_pack`: a body for one of four routes.

use revprio_api::wire::{
    BatchAnswer, BatchItem, BatchRequest, KinematicsAnswer, ResolveAnswer, ResolveRequest, StepAnswer, StepRequest,
};

use crate::answers::{command, value};
use crate::budget::Work;
use crate::target::split_line;
use crate::timed_service::{Format, TimedService, accepted};
use crate::{Defect, limits};

/// Sends a line with the route, then a body.
pub fn check(service: &TimedService, input: &[u8], format: Format) -> Result<(), Defect> {
    let Some((route, body)) = split_line(input) else { return Ok(()) };
    match route {
        b"resolve" => resolve(service, body, format),
        b"resolve/batch" => batch(service, body, format),
        b"step" => step(service, body, format),
        b"kinematics" => {
            let answer = service.post_as(format, "/v1/kinematics", body, Work::default())?;
            value::<KinematicsAnswer>(&answer, false).map(drop)
        }
        _ => Ok(()),
    }
}

fn resolve(service: &TimedService, body: &[u8], format: Format) -> Result<(), Defect> {
    let request: Option<ResolveRequest> = format.read(body);
    let work = request.as_ref().map(Work::of_problem).unwrap_or_default();
    let answer = service.post_as(format, "/v1/resolve", body, work)?;
    let Some(answer) = value::<ResolveAnswer>(&answer, work.exceeds_arm())? else { return Ok(()) };
    command(&answer, limits::of_problem(&accepted(request)?).as_ref())
}

fn batch(service: &TimedService, body: &[u8], format: Format) -> Result<(), Defect> {
    let request: Option<BatchRequest> = format.read(body);
    let problems = request.as_ref().map(|batch| batch.items.as_slice()).unwrap_or_default();
    let price = problems.iter().map(|item| Work::of_problem(item).price).sum();
    let tasks = problems.iter().map(|item| item.tasks.len()).max().unwrap_or_default();
    let work = Work { price, tasks, items: problems.len(), ..Work::default() };
    let answer = service.post_as(format, "/v1/resolve/batch", body, work)?;
    let Some(answer) = value::<BatchAnswer>(&answer, work.exceeds_arm())? else { return Ok(()) };
    let request = accepted(request)?;
    if answer.items.len() != request.items.len() {
        return Err(Defect::Wrong(format!("{} answers to {} items", answer.items.len(), request.items.len())));
    }
    for (problem, item) in request.items.iter().zip(&answer.items) {
        match item {
            BatchItem::Answer(answer) => command(&**answer, limits::of_problem(problem).as_ref())?,
            BatchItem::Problem(problem) if problem.status < 500 => {}
            BatchItem::Problem(problem) => return Err(Defect::Wrong(format!("an item is answered {problem:?}"))),
        }
    }
    Ok(())
}

fn step(service: &TimedService, body: &[u8], format: Format) -> Result<(), Defect> {
    let request: Option<StepRequest> = format.read(body);
    let work = request.as_ref().map(Work::of_step).unwrap_or_default();
    let answer = service.post_as(format, "/v1/step", body, work)?;
    let Some(answer) = value::<StepAnswer>(&answer, work.exceeds_arm())? else { return Ok(()) };
    command(&answer, limits::of_controller(&accepted(request)?.controller).as_ref())
}
