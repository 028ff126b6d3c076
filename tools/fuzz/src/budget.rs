//! Processor time that a request may use.
//!
//! The clock of the processor time of this process counts all its threads, and no other process. So a busy machine does not
//! make an answer late.

use std::time::Duration;

use revprio_api::wire::{ResolveRequest, StepRequest};

use crate::limits::{joint_count, known_robot};

/// Time for a request the size of an arm: at most 9 joints, 8 tasks and 64 KiB.
const ARM: Duration = Duration::from_millis(50);

/// Price of the largest request the size of an arm, in the unit of the service: 8 tasks of 6 rows with bounds, 16
/// inequalities and 9 joints.
const ARM_PRICE: usize = 8 * (8 * 6 * 4 + 16 * 4 + 9) * 81;

/// Tasks of the largest request the size of an arm.
const ARM_TASKS: usize = 8;

/// Bytes of the largest request the size of an arm.
const ARM_BYTES: usize = 64 << 10;

/// Number of problems in a batch that may take as long as one at its worst.
const ARM_ITEMS: usize = 50;

/// What decides that an answer is late.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// Processor time above the budget. Nothing else may run in this process.
    ProcessorTime,
    /// No answer for 20 s.
    Hang,
}

/// The work of one request, as its budget sees it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Work {
    /// Price, as `service::price` computes it.
    pub price: usize,
    /// Number of tasks.
    pub tasks: usize,
    /// Size of the body.
    pub bytes: usize,
    /// Number of problems.
    pub items: usize,
}

impl Work {
    /// Returns the work of a problem without its size in bytes.
    pub fn of_problem(request: &ResolveRequest) -> Self {
        let of_rows = request.tasks.iter().find_map(|task| Some(task.jacobian.as_ref()?.first()?.len()));
        let joints = of_rows.or_else(|| known_robot(request.robot.as_ref()?).map(|robot| robot.joint_count()));
        let rows = request.tasks.iter().map(|task| {
            let rows = task.jacobian.as_ref().map(Vec::len).or_else(|| task.axes.as_ref().map(Vec::len));
            (rows.unwrap_or_default(), task.velocity.is_none())
        });
        let price = price(rows, request.inequalities.len(), joints.unwrap_or_default());
        Self { price, tasks: request.tasks.len(), bytes: 0, items: 1 }
    }

    /// Returns the work of a step without its size in bytes.
    pub fn of_step(request: &StepRequest) -> Self {
        let controller = &request.controller;
        let joints = joint_count(&controller.robot);
        let rows = controller.tasks.iter().map(|task| {
            let rows = task.jacobian.as_ref().map(Vec::len).or_else(|| task.axes.as_ref().map(Vec::len));
            (rows.unwrap_or(joints), task.law.is_none())
        });
        let price = price(rows, controller.inequalities.len(), joints);
        Self { price, tasks: controller.tasks.len(), bytes: 0, items: 1 }
    }

    /// Returns the processor time that the work may use: 50 ms for a request the size of an arm, and more for a larger one
    /// in proportion to its price, its number of tasks, its size or its number of problems.
    pub fn budget(self) -> Duration {
        let factor = |value: usize, arm: usize| value as f64 / arm as f64;
        let factors = [
            factor(self.price, ARM_PRICE),
            factor(self.tasks, ARM_TASKS),
            factor(self.bytes, ARM_BYTES),
            factor(self.items, ARM_ITEMS),
        ];
        ARM.mul_f64(factors.into_iter().fold(1.0, f64::max))
    }

    /// Returns whether the request is larger than an arm, so that the service may answer `deadline`.
    pub fn exceeds_arm(self) -> bool {
        self.budget() > ARM
    }
}

/// Returns tasks × (equations + 4 × (bounds + inequalities) + joints) × joints², as documented by the service.
fn price(tasks: impl Iterator<Item = (usize, bool)>, inequalities: usize, joints: usize) -> usize {
    let (mut count, mut rows) = (0, 0);
    for (task_rows, are_bounds) in tasks {
        count += 1;
        rows += task_rows * if are_bounds { 4 } else { 1 };
    }
    count * (rows + 4 * inequalities + joints) * joints * joints
}

/// Returns the processor time of all threads of this process.
#[cfg(target_os = "linux")]
pub fn processor_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec.unsigned_abs(), u32::try_from(time.tv_nsec).unwrap_or_default())
}

/// Returns zero: the clock is read on Linux only.
#[cfg(not(target_os = "linux"))]
pub fn processor_time() -> Duration {
    Duration::ZERO
}
