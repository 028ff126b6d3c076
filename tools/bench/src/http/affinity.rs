//! CPU affinity of threads.

/// Keeps this thread, and threads that it starts, on one core until dropped. Only on Linux.
pub struct Pinned(#[cfg(target_os = "linux")] Option<rustix::thread::CpuSet>);

#[cfg(target_os = "linux")]
impl Pinned {
    /// Pins to the core with this index, from 0, among the cores available to this thread; to the last one if there are
    /// fewer.
    pub fn to(core: usize) -> Self {
        use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
        let Ok(before) = sched_getaffinity(None) else { return Self(None) };
        let usable: Vec<usize> = (0..CpuSet::MAX_CPU).filter(|&cpu| before.is_set(cpu)).collect();
        let mut one = CpuSet::new();
        usable.get(core).or(usable.last()).inspect(|&&cpu| one.set(cpu));
        Self(sched_setaffinity(None, &one).is_ok().then_some(before))
    }
}

#[cfg(target_os = "linux")]
impl Drop for Pinned {
    fn drop(&mut self) {
        if let Some(before) = &self.0 {
            let _ = rustix::thread::sched_setaffinity(None, before);
        }
    }
}

#[cfg(not(target_os = "linux"))]
impl Pinned {
    /// Leaves the thread where it is.
    pub fn to(_: usize) -> Self {
        Self()
    }
}
