//! Every kept input of the fuzzer, and every seed, without the fuzzer.

use revprio_fuzz::corpus::kept;
use revprio_fuzz::seeds::seeds;
use revprio_fuzz::{Bound, Checker, Target};

/// Inputs of a target with their names.
fn inputs(target: Target) -> Vec<(String, Vec<u8>)> {
    let mut inputs = kept(target).unwrap();
    inputs.extend(seeds(target).into_iter().enumerate().map(|(i, seed)| (format!("seed {i}"), seed)));
    inputs
}

#[test]
fn as_many_inputs_are_replayed_as_the_page_about_testing_says() {
    let page = include_str!("../../../docs/testing.md");
    for target in Target::ALL {
        let row = format!("| `{}` | ", target.name());
        let row = page.lines().find(|line| line.starts_with(&row) && line.matches('|').count() == 6).unwrap();
        let count: usize = row.split('|').nth(5).unwrap().trim().parse().unwrap();
        let mut inputs: Vec<Vec<u8>> = kept(target).unwrap().into_iter().map(|(_, input)| input).collect();
        inputs.sort();
        inputs.dedup();
        assert_eq!(inputs.len(), count, "{row}");
    }
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
