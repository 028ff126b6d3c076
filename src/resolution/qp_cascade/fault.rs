//! Faults that tests inject: what a solver returns when it fails, and a search that finds nothing.

use std::cell::Cell;

use clarabel::solver::{DefaultSolution, SolverStatus};

/// What goes wrong.
#[derive(Debug, Clone, Copy)]
pub struct Fault {
    /// Every solve ends with this status …
    pub status: SolverStatus,
    /// … and this value in all entries of x.
    pub entry: f64,
    /// Whether the active-set iteration finds nothing either.
    pub search: bool,
}

thread_local! {
    static FAULT: Cell<Option<Fault>> = const { Cell::new(None) };
}

/// Runs `f` with the fault on this thread.
pub fn with<T>(fault: Fault, f: impl FnOnce() -> T) -> T {
    FAULT.set(Some(fault));
    let result = f();
    FAULT.set(None);
    result
}

pub(super) fn strike(solution: &mut DefaultSolution<f64>) {
    if let Some(Fault { status, entry, .. }) = FAULT.get() {
        solution.status = status;
        solution.x.fill(entry);
    }
}

pub(super) fn strikes_search() -> bool {
    FAULT.get().is_some_and(|fault| fault.search)
}
