//! Problems to resolve, one or many.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use revprio_api::wire::{BatchAnswer, BatchItem, BatchRequest, ResolveAnswer, ResolveRequest};

use super::app::AppState;
use super::background::{Abandoned, on_all_cores};
use super::body::LargeBody;
use super::convert;
use super::error::ApiError;

/// Problems in a batch.
pub const MOST_ITEMS: usize = 10_000;

/// Batches at a time, one at work and the others waiting; each may hold a body and an answer of some 20 MB.
pub const MAX_BATCHES: usize = 4;

/// Starting a thread costs as much as some of them.
const WORTH_A_THREAD: usize = 16;

/// Resolves one problem.
pub fn one(request: &ResolveRequest, app: &AppState) -> Result<ResolveAnswer, ApiError> {
    let start = Instant::now();
    let question = convert::question(request, &app.robots)?;
    let resolution = revprio_core::resolution::resolve(&question.problem, &[]).map_err(convert::resolution_problem)?;
    let answer = convert::resolve_answer(&question, &resolution, start);
    app.metrics.solved(&answer.solver);
    Ok(answer)
}

/// Resolves a batch on all cores when its turn comes; steps go first.
pub async fn batch(body: LargeBody<BatchRequest>, app: &Arc<AppState>) -> Result<BatchAnswer, ApiError> {
    let shared = Arc::clone(app);
    app.batches.run("batches", move |abandoned| many(&body.read()?, &shared, abandoned)).await?
}

/// Resolves many problems, each as if it were the only one.
fn many(request: &BatchRequest, app: &AppState, abandoned: &Abandoned) -> Result<BatchAnswer, ApiError> {
    let problems = &request.items;
    if problems.len() > MOST_ITEMS {
        return Err(ApiError::invalid("/items", format!("{} items; a batch has at most {MOST_ITEMS}", problems.len())));
    }
    let answers: Vec<Mutex<Option<BatchItem>>> = problems.iter().map(|_| Mutex::default()).collect();
    let next = AtomicUsize::new(0);
    let work = || {
        while !abandoned.is_set() {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let (Some(problem), Some(answer)) = (problems.get(i), answers.get(i)) else { break };
            let item = item(i, one(problem, app), app);
            *answer.lock().unwrap_or_else(PoisonError::into_inner) = Some(item);
        }
    };
    on_all_cores(problems.len() / WORTH_A_THREAD, work);
    let items = answers.into_iter().map(|answer| answer.into_inner().ok().flatten());
    Ok(BatchAnswer { items: items.collect::<Option<_>>().ok_or_else(ApiError::internal)? })
}

fn item(i: usize, answer: Result<ResolveAnswer, ApiError>, app: &AppState) -> BatchItem {
    match answer {
        Ok(answer) => BatchItem::Answer(Box::new(answer)),
        Err(problem) => {
            app.metrics.refused(problem.kind());
            BatchItem::Problem(problem.inside(&format!("/items/{i}")).into_wire())
        }
    }
}
