//! The fuzzer: one target under libFuzzer. `tools/fuzz/run` builds it and starts it.
#![no_main]

use std::cell::LazyCell;
use std::path::PathBuf;

use fastrand::Rng;
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};
use revprio_fuzz::mutation::mutate;
use revprio_fuzz::seeds::seeds;
use revprio_fuzz::{Bound, Checker, Target};

/// Of this many mutations, one changes bytes without regard to their structure.
const BYTES_EVERY: u32 = 8;

thread_local! {
    static CHECKER: LazyCell<Checker> = LazyCell::new(|| Checker::start(TARGET.with(|target| **target), Bound::ProcessorTime));
    static TARGET: LazyCell<Target> = LazyCell::new(|| {
        let name = std::env::var("REVPRIO_FUZZ_TARGET").unwrap_or_default();
        Target::from_name(&name).expect("REVPRIO_FUZZ_TARGET names a target")
    });
}

/// Writes the seeds of the target into the folder that `REVPRIO_FUZZ_SEEDS` names, before libFuzzer reads it.
fn write_seeds() {
    let Some(folder) = std::env::var_os("REVPRIO_FUZZ_SEEDS").map(PathBuf::from) else { return };
    for (i, seed) in TARGET.with(|target| seeds(**target)).iter().enumerate() {
        std::fs::write(folder.join(format!("seed_{i:02}")), seed).expect("the folder of the seeds can be written");
    }
}

fuzz_target!(init: write_seeds(), |input: &[u8]| {
    if let Err(defect) = CHECKER.with(|checker| checker.check(input)) {
        panic!("{defect:?}");
    }
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let target = TARGET.with(|target| **target);
    let keeps_structure = !seed.is_multiple_of(BYTES_EVERY);
    let mutated = keeps_structure.then(|| mutate(target, &data[..size], &mut Rng::with_seed(seed.into()))).flatten();
    match mutated {
        Some(mutated) if mutated.len() <= max_size => {
            data[..mutated.len()].copy_from_slice(&mutated);
            mutated.len()
        }
        _ => fuzzer_mutate(data, size, max_size),
    }
});
