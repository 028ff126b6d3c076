//! Stateless resolution: one problem, or a batch.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use revprio_api::wire::{BatchAnswer, BatchItem, BatchRequest, ResolveAnswer, ResolveRequest};
use tokio::time::Instant;

use super::background::{Abandoned, on_all_cores};
use super::body::LargeBody;
use super::convert::{self, ResolveProblem};
use super::error::ApiError;
use super::format::RawBody;
use super::price;
use super::state::AppState;

/// Maximum number of problems in a batch.
pub const MAX_ITEMS: usize = 10_000;

/// Number of problems that justify one more thread. Starting a thread costs as much as several problems.
const ITEMS_PER_THREAD: usize = 16;

/// Resolves one problem. One above the budget is solved in another thread, so that steps do not wait.
pub async fn single(body: RawBody, app: &Arc<AppState>) -> Result<ResolveAnswer, ApiError> {
    let shared = Arc::clone(app);
    if body.is_large() {
        return app.large_problems.run(move |_| one(&body.read()?, &shared)).await?;
    }
    let start = Instant::now();
    let problem = convert::resolve_problem(&body.read()?, &app.robots)?;
    if price::of_problem(&problem.problem) > price::RESOLVE_BUDGET {
        return app.large_problems.run(move |_| solve(&problem, start, &shared)).await?;
    }
    solve(&problem, start, app)
}

fn one(request: &ResolveRequest, app: &AppState) -> Result<ResolveAnswer, ApiError> {
    let start = Instant::now();
    solve(&convert::resolve_problem(request, &app.robots)?, start, app)
}

fn solve(problem: &ResolveProblem, start: Instant, app: &AppState) -> Result<ResolveAnswer, ApiError> {
    let resolution = revprio_core::resolution::resolve(&problem.problem, &[]).map_err(convert::resolution_error)?;
    let answer = convert::resolve_answer(problem, &resolution, start);
    app.metrics.count_resolution(&answer.solver);
    Ok(answer)
}

/// Resolves a batch on all cores, after the batches before it. Steps have priority.
pub async fn batch(body: LargeBody<BatchRequest>, app: &Arc<AppState>) -> Result<BatchAnswer, ApiError> {
    let shared = Arc::clone(app);
    app.batches.run(move |abandoned| many(&body.read()?, &shared, abandoned)).await?
}

/// Resolves many independent problems.
fn many(request: &BatchRequest, app: &AppState, abandoned: &Abandoned) -> Result<BatchAnswer, ApiError> {
    let problems = &request.items;
    if problems.len() > MAX_ITEMS {
        return Err(ApiError::invalid("/items", format!("{} items; a batch has at most {MAX_ITEMS}", problems.len())));
    }
    let answers: Vec<Mutex<Option<BatchItem>>> = problems.iter().map(|_| Mutex::default()).collect();
    let next = AtomicUsize::new(0);
    let work = || {
        while !abandoned.is_set() {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let (Some(problem), Some(answer)) = (problems.get(i), answers.get(i)) else { break };
            let item = batch_item(i, one(problem, app), app);
            *answer.lock().unwrap_or_else(PoisonError::into_inner) = Some(item);
        }
    };
    on_all_cores(problems.len() / ITEMS_PER_THREAD, work);
    let items = answers.into_iter().map(|answer| answer.into_inner().ok().flatten());
    Ok(BatchAnswer { items: items.collect::<Option<_>>().ok_or_else(ApiError::internal)? })
}

fn batch_item(i: usize, answer: Result<ResolveAnswer, ApiError>, app: &AppState) -> BatchItem {
    match answer {
        Ok(answer) => BatchItem::Answer(Box::new(answer)),
        Err(error) => {
            app.metrics.count_problem(error.kind());
            BatchItem::Problem(error.inside(&format!("/items/{i}")).into_wire())
        }
    }
}
