//! Every kept input of the fuzzer, and every seed, without the fuzzer.

use std::path::Path;

use revprio_fuzz::seeds::seeds;
use revprio_fuzz::{Bound, Checker, Target};

/// Inputs of a target with their names.
fn inputs(target: Target) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(target.name());
    let kept = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut inputs: Vec<_> = kept
        .map(|entry| {
            let path = entry.unwrap().path();
            (path.display().to_string(), std::fs::read(&path).unwrap())
        })
        .collect();
    inputs.sort();
    assert!(!inputs.is_empty(), "{} is empty", folder.display());
    inputs.extend(seeds(target).into_iter().enumerate().map(|(i, seed)| (format!("seed {i}"), seed)));
    inputs
}

fn assert_without_defect(target: Target) {
    let checker = Checker::start(target, Bound::Hang);
    let defects: Vec<_> =
        inputs(target).into_iter().filter_map(|(name, input)| Some((name, checker.check(&input).err()?))).collect();
    assert!(defects.is_empty(), "{defects:#?}");
}

#[test]
fn json_bodies_of_the_corpus_have_no_defect() {
    assert_without_defect(Target::Json);
}

#[test]
fn message_pack_bodies_of_the_corpus_have_no_defect() {
    assert_without_defect(Target::MessagePack);
}

#[test]
fn margins_of_the_corpus_have_no_defect() {
    assert_without_defect(Target::Stability);
}

#[test]
fn robots_of_the_corpus_have_no_defect() {
    assert_without_defect(Target::Urdf);
}

#[test]
fn streams_of_the_corpus_have_no_defect() {
    assert_without_defect(Target::Stream);
}

#[test]
fn controllers_of_the_corpus_have_no_defect() {
    assert_without_defect(Target::Controller);
}
