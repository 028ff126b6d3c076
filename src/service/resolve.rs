//! Stateless resolution: one problem, or a batch.

use std::sync::Arc;

use revprio_api::wire::{BatchAnswer, BatchRequest, ResolveAnswer, ResolveRequest};
use revprio_local::all_cores::map_on_all_cores;
use tokio::time::Instant;

use super::background::Abandoned;
use super::body::LargeBody;
use super::convert::{self, ResolveProblem};
use super::error::ApiError;
use super::format::RawBody;
use super::price;
use super::state::AppState;
use super::step::{self, ITEMS_PER_THREAD};

/// Resolves one problem. One above the budget is solved in another thread, so that steps do not wait.
pub async fn single(body: RawBody, app: &Arc<AppState>) -> Result<ResolveAnswer, ApiError> {
    let shared = Arc::clone(app);
    if body.is_large() {
        return app.large_problems.run(move |abandoned| one(&body.read()?, &shared, abandoned)).await?;
    }
    let start = Instant::now();
    let problem = convert::resolve_problem(&body.read()?, &app.robots)?;
    if price::of_problem(&problem.problem, problem.solver) > price::RESOLVE_BUDGET {
        return app.large_problems.run(move |abandoned| solve(&problem, start, &shared, abandoned)).await?;
    }
    solve(&problem, start, app, &Abandoned::default())
}

fn one(request: &ResolveRequest, app: &AppState, abandoned: &Abandoned) -> Result<ResolveAnswer, ApiError> {
    let start = Instant::now();
    solve(&convert::resolve_problem(request, &app.robots)?, start, app, abandoned)
}

fn solve(
    problem: &ResolveProblem,
    start: Instant,
    app: &AppState,
    abandoned: &Abandoned,
) -> Result<ResolveAnswer, ApiError> {
    let flag = abandoned.clone();
    let answer = step::resolve(problem, start, move || flag.is_set())?;
    if !abandoned.is_set() {
        app.metrics.count_resolution(&answer.solver);
    }
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
    step::check_batch_size(problems.len())?;
    let item = |i: usize, problem: &ResolveRequest| {
        let answer = one(problem, app, abandoned);
        let _ = answer.as_ref().inspect_err(|error| app.metrics.count_problem(error.kind()));
        step::batch_item(i, answer)
    };
    let items = map_on_all_cores(problems, ITEMS_PER_THREAD, || abandoned.is_set(), item);
    Ok(BatchAnswer { items: items.ok_or_else(ApiError::internal)? })
}
