//! A deterministic simulation: the service, its clients, the network between them and the clock in one thread.
//!
//! The code of the service is the real one, from the accepted connection to the last digit of an answer. Connections are
//! in memory, time is simulated, and a seed decides everything else. [`oracle`] knows what each answer must be.
//! `docs/simulation.md` says what is simulated, and how to run more seeds.

mod arm;
mod audit;
mod call;
mod clients;
mod controllers;
mod coverage;
mod exchange;
mod http;
mod network;
mod oracle;
mod plan;
mod platform;
mod random;
mod reference;
mod run;
mod seeds;
mod transcript;
mod violation;
mod world;

#[test]
fn all_seeds_keep_what_the_documentation_promises() {
    seeds::Seeds::from_environment().run_all();
}

#[test]
fn the_same_seed_gives_the_same_transcript() {
    for seed in 0..40 {
        let (first, second) = (run::run(seed).transcript, run::run(seed).transcript);
        let difference = first.lines().into_iter().zip(second.lines()).find(|(first, second)| first != second);
        assert_eq!(difference, None, "seed {seed}");
        assert_eq!(first.hash(), second.hash(), "seed {seed}");
    }
}
