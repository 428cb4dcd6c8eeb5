//! Tests that every fault condition gets at least its reaction within its dwell time, whatever a
//! drive has latched.
//!
//! The test runs random sequences of controlwords, set-points, readings, heartbeats, switches,
//! rotors and times: 5 000, and with `TAUTRACK_SWEEPS=1` 100 000. The oracle derives the conditions
//! from inputs and published outputs alone, with the dwell times of docs/faults.md.
//! `DRIVE_FAULTS_SEED` repeats one sequence.

pub mod generator;
mod oracle;

use crate::sweep::{self, unless_unchanged};
use generator::{BRAKE_ENGAGE_MS, CURRENT_LIMIT, Generator, Kind, Random};
use oracle::{Oracle, Tally};
use std::thread;

/// Sequences of a complete campaign, and of a short one.
const SEQUENCES: [u64; 2] = [100_000, 5_000];
const EVENTS: usize = 200;
/// One sequence in so many reaches each condition.
const ONE_IN: u64 = 100;

/// Runs one sequence. The error says which guarantee was broken, and when.
fn run(seed: u64, tally: &mut Tally) -> Result<(), String> {
    let mut generator = Generator::new(Random::new(seed), Kind::of(seed));
    let engage_ticks = if Kind::of(seed).has_brake() {
        BRAKE_ENGAGE_MS as u32 + 2
    } else {
        0
    };
    let mut oracle = Oracle::new(
        CURRENT_LIMIT,
        generator.velocity_unit(),
        engage_ticks,
        Kind::of(seed).is_three_phase(),
    );
    for event in 0..EVENTS {
        for _ in 0..generator.next_event(event) {
            let (inputs, joint_us) = generator.inputs();
            let outputs = generator.tick(&inputs);
            oracle
                .check(&inputs, joint_us, &outputs, tally)
                .map_err(|broken| {
                    format!("seed {seed}, event {event}: {broken}\n{inputs:?}\n{outputs:?}")
                })?;
        }
    }
    Ok(())
}

#[test]
fn every_condition_gets_its_reaction_whatever_is_latched() {
    if let Ok(seed) = std::env::var("DRIVE_FAULTS_SEED") {
        let seed = seed.parse().expect("a number");
        run(seed, &mut Tally::default()).unwrap_or_else(|broken| panic!("{broken}"));
        return;
    }
    unless_unchanged("drive-faults", &["src", "tests/node/drive_faults"], run_all);
}

/// Runs `run` with each seed below `sequences`. Returns what each processor has counted.
///
/// # Panics
/// A sequence breaks a condition.
pub fn on_all_processors<T: Default + Send>(
    sequences: u64,
    run: fn(u64, &mut T) -> Result<(), String>,
) -> Vec<T> {
    let workers = thread::available_parallelism().map_or(1, |count| count.get() as u64);
    thread::scope(|scope| {
        let handles: Vec<_> = (0..workers)
            .map(|worker| {
                scope.spawn(move || {
                    let mut tally = T::default();
                    for seed in (worker..sequences).step_by(workers as usize) {
                        run(seed, &mut tally).unwrap_or_else(|broken| panic!("{broken}"));
                    }
                    tally
                })
            })
            .collect();
        let joined = handles.into_iter().map(thread::ScopedJoinHandle::join);
        joined
            .map(|result| result.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    })
}

fn run_all() {
    let [complete, short] = SEQUENCES;
    let sequences = if sweep::complete() { complete } else { short };
    let tallies: Vec<Tally> = on_all_processors(sequences, run);
    let total = tallies.iter().fold(Tally::default(), Tally::plus);
    println!("{total:#?}");
    for (name, count) in total.counts() {
        assert!(
            count >= sequences / ONE_IN,
            "{name} was reached {count} times"
        );
    }
}
