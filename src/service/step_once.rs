//! A step without a session: `POST /v1/step`.

use std::sync::Arc;

use revprio_api::wire::StepAnswer;

use super::error::ApiError;
use super::format::RawBody;
use super::price;
use super::state::AppState;
use super::step::stateless_step;
use super::stepper_cache::StepCall;

/// Reads a request and steps its controller. A step above the budget runs in another thread.
pub async fn step(body: RawBody, app: &Arc<AppState>) -> Result<StepAnswer, ApiError> {
    let shared = Arc::clone(app);
    if body.is_large() {
        return app.large_steps.run(move |_| finish(read(&body, &shared)?, &shared)).await?;
    }
    let call = read(&body, app)?;
    if price::of_controller(call.cached.stepper.controller().config()) > price::STEP_BUDGET {
        return app.large_steps.run(move |_| finish(call, &shared)).await?;
    }
    finish(call, app)
}

fn read(body: &RawBody, app: &AppState) -> Result<StepCall, ApiError> {
    app.stepper_cache.read(body, &app.robots)
}

fn finish(call: StepCall, app: &AppState) -> Result<StepAnswer, ApiError> {
    let StepCall { mut cached, state, memory } = call;
    let answer = stateless_step(&mut cached.stepper, &state, memory.as_ref())?;
    app.metrics.count_resolution(&answer.solver);
    app.stepper_cache.put(cached);
    Ok(answer)
}
