//! Where an interactive run takes its orders.

use std::ops::ControlFlow;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use revprio_api::wire;
use revprio_core::controller::Controller;
use revprio_lab::simulator::{Ending, Influence, Observed, Operator};
use tokio::sync::watch;

use super::job::Job;
use super::live::{Camera, Live, Picture};
use crate::service::background::Abandoned;
use crate::service::convert;
use crate::service::error::ApiError;
use crate::service::robots::Robots;

/// A push ends this long after it was last ordered: the page that orders it may be gone.
const PUSH_TIME: Duration = Duration::from_secs(1);

/// A run that nobody looks at or orders about for this long is finished.
const ALONE_TIME: Duration = Duration::from_mins(1);

/// Longest sleep without a look whether the run still goes on.
const BLINK: Duration = Duration::from_millis(50);

/// A run that is this far behind the clock does not try to catch up.
const LATE: Duration = Duration::from_millis(100);

/// Orders and view of one interactive run.
pub struct RunControl {
    orders: Mutex<Orders>,
    word: Condvar,
    /// Robot, limits and period, which no order changes.
    controller: Controller,
    live: Live,
}

/// What is to happen.
struct Orders {
    pace: wire::Interactive,
    /// Periods to go on for although paused.
    steps: u64,
    force: [f64; 3],
    force_said: Instant,
    controller: wire::Controller,
    is_new: bool,
    finish: bool,
    /// When the last order came, or somebody looked.
    attended: Instant,
}

impl Orders {
    fn push(&self) -> [f64; 3] {
        if self.force_said.elapsed() < PUSH_TIME { self.force } else { [0.0; 3] }
    }
}

impl RunControl {
    /// A run that has not begun. The controller comes as it was asked for and as it was understood.
    pub fn new(
        pace: wire::Interactive,
        request: wire::Controller,
        controller: Controller,
        start: &[f64],
    ) -> Result<Self, ApiError> {
        let rest = vec![0.0; start.len()];
        let arm = convert::arm_view(controller.config(), start, &rest)
            .ok_or_else(|| ApiError::invalid("/scenario/start_joint_position", "is no posture of the robot"))?;
        let orders = Orders {
            pace,
            steps: 0,
            force: [0.0; 3],
            force_said: Instant::now(),
            controller: request,
            is_new: false,
            finish: false,
            attended: Instant::now(),
        };
        Ok(Self { orders: Mutex::new(orders), word: Condvar::new(), controller, live: Live::new(arm) })
    }

    /// Takes an order, all of it or nothing.
    pub fn order(&self, order: &wire::SimulationControl, robots: &Robots) -> Result<(), ApiError> {
        convert::control(order)?;
        let mut orders = self.lock();
        if let Some((controller, _)) = convert::changed_controller(order, &orders.controller, robots)? {
            orders.controller = controller;
            orders.is_new = true;
        }
        let Orders { pace, steps, force, force_said, finish, attended, .. } = &mut *orders;
        pace.paused = order.paused.unwrap_or(pace.paused || order.step.is_some());
        pace.speed = order.speed.unwrap_or(pace.speed);
        *steps = if pace.paused { *steps + order.step.unwrap_or(0) } else { 0 };
        if let Some(asked) = order.external_force {
            (*force, *force_said) = (asked, Instant::now());
        }
        *finish |= order.end;
        *attended = Instant::now();
        drop(orders);
        self.word.notify_all();
        self.live.touch();
        Ok(())
    }

    /// Wakes a run that waits, to let it see that it has ended.
    pub fn wake(&self) {
        self.word.notify_all();
        self.live.touch();
    }

    /// Hears of every picture.
    pub fn watch(&self) -> watch::Receiver<Arc<Picture>> {
        self.live.watch()
    }

    /// A picture with the samples after the first `seen`, which this counts up.
    pub fn frame(&self, picture: &Picture, run: wire::Simulation, seen: &mut usize) -> wire::LiveFrame {
        self.live.frame(picture, run, seen)
    }

    /// The latest period, as a request.
    pub fn cycle(&self) -> Result<wire::StepRequest, ApiError> {
        self.live.cycle().ok_or_else(|| ApiError::not_live("no control period is done yet"))
    }

    /// How the run is paced.
    pub fn pace(&self) -> wire::Interactive {
        self.lock().pace
    }

    /// Method and solver of the present controller.
    pub fn method_and_solver(&self) -> (wire::Method, wire::Solver) {
        let orders = self.lock();
        (orders.controller.method, orders.controller.solver)
    }

    /// Somebody who carries out the orders.
    pub fn operator<'a>(&'a self, job: &'a Job, abandoned: &'a Abandoned) -> DeskOperator<'a> {
        let camera = Camera::new(&self.live, self.controller.config());
        let period_s = self.controller.config().period_s;
        DeskOperator { run_control: self, job, abandoned, camera, period_s, due: Instant::now(), push: [0.0; 3] }
    }

    fn lock(&self) -> MutexGuard<'_, Orders> {
        self.orders.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn sleep<'a>(&self, orders: MutexGuard<'a, Orders>, time: Duration) -> MutexGuard<'a, Orders> {
        let (orders, _) = self.word.wait_timeout(orders, time).unwrap_or_else(PoisonError::into_inner);
        orders
    }
}

/// Carries out the orders of a run_control.
pub struct DeskOperator<'a> {
    run_control: &'a RunControl,
    job: &'a Job,
    abandoned: &'a Abandoned,
    camera: Camera<'a>,
    period_s: f64,
    /// When the next period begins.
    due: Instant,
    push: [f64; 3],
}

impl DeskOperator<'_> {
    fn has_ended(&self, orders: &Orders) -> bool {
        orders.finish || self.abandoned.is_set() || self.job.has_ended()
    }

    /// Waits until the next period is due; at a pause, until it is over.
    fn wait(&mut self) -> MutexGuard<'_, Orders> {
        let mut orders = self.run_control.lock();
        loop {
            if self.run_control.live.readers() > 0 {
                orders.attended = Instant::now();
            }
            orders.finish |= orders.attended.elapsed() > ALONE_TIME;
            let now = Instant::now();
            if self.has_ended(&orders) {
                return orders;
            }
            if orders.pace.paused {
                self.due = now;
                if orders.steps > 0 {
                    orders.steps -= 1;
                    return orders;
                }
                self.camera.show();
                orders = self.run_control.sleep(orders, BLINK);
                continue;
            }
            match self.due.checked_duration_since(now) {
                Some(left) if !left.is_zero() => orders = self.run_control.sleep(orders, left.min(BLINK)),
                _ => {
                    let start = if now.duration_since(self.due) > LATE { now } else { self.due };
                    self.due = start + Duration::from_secs_f64(self.period_s / orders.pace.speed);
                    return orders;
                }
            }
        }
    }
}

impl Operator for DeskOperator<'_> {
    fn influence(&mut self, _period: u64) -> Influence {
        let mut orders = self.wait();
        let controller = std::mem::take(&mut orders.is_new).then(|| orders.controller.clone());
        let external_force = orders.push();
        drop(orders);
        self.push = external_force;
        Influence { external_force, controller }
    }

    fn see(&mut self, done: u64, period: &Observed) {
        self.camera.see(done, period, self.push);
        self.job.advance(done);
    }

    fn goes_on(&mut self) -> ControlFlow<Ending> {
        if self.abandoned.is_set() || self.job.has_ended() {
            return ControlFlow::Break(Ending::Stop);
        }
        if self.run_control.lock().finish { ControlFlow::Break(Ending::Finish) } else { ControlFlow::Continue(()) }
    }
}

impl Drop for DeskOperator<'_> {
    fn drop(&mut self) {
        self.camera.show();
    }
}

/// The run_control of a run that has one and goes on.
pub fn live_run_control(job: &Job) -> Result<&Arc<RunControl>, ApiError> {
    let run_control = run_control(job)?;
    if job.has_ended() {
        Err(ApiError::not_live("the simulation has ended; start another one"))
    } else {
        Ok(run_control)
    }
}

/// The run_control of a run that has one.
pub fn run_control(job: &Job) -> Result<&Arc<RunControl>, ApiError> {
    job.run_control().ok_or_else(|| ApiError::not_live("the simulation was not started as `interactive`"))
}
