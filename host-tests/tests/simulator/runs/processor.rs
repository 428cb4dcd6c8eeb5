//! Tests that native nodes and their run take turns on one processor.

use super::{programs, scenario};
use rustix::process::Pid;
use rustix::thread::sched_getaffinity;
use std::fs;
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::simulator::record::Sample;
use tautrack_host_tests::simulator::run::processor::chosen;
use tautrack_host_tests::simulator::run::{Options, Sink, Unwritten, record};

/// Collects on which processors this thread and the processes of its nodes may run, at the first
/// sample.
struct Watch(Vec<Vec<usize>>);

fn processors(process: Option<Pid>) -> Vec<usize> {
    let allowed = sched_getaffinity(process).expect("of a process that runs");
    (0..1_024)
        .filter(|number| allowed.is_set(*number))
        .collect()
}

impl Sink for Watch {
    fn sample(&mut self, _: Sample) -> Result<(), Unwritten> {
        if self.0.is_empty() {
            self.0.push(processors(None));
            let nodes = fs::read_to_string("/proc/thread-self/children").expect("a list");
            for node in nodes.split_whitespace() {
                let pid = Pid::from_raw(node.parse().expect("a number"));
                self.0.push(processors(pid));
            }
        }
        Ok(())
    }
}

#[test]
fn a_run_and_its_native_nodes_stay_on_one_processor_while_it_lasts() {
    let before = processors(None);
    let short = scenario("flat", |description| {
        description.duration_s = 0.1;
        description.operator.events.clear();
    });
    let mut watch = Watch(Vec::new());
    let options = Options::default();
    record(&short, programs(Board::Native), options, &mut watch)
        .unwrap_or_else(|error| panic!("{error}"));
    let Watch(during) = watch;
    assert_eq!(during.len(), 1 + 5, "the run and five nodes: {during:?}");
    assert_eq!(during[0].len(), 1, "{during:?}");
    assert!(during.iter().all(|of| *of == during[0]), "{during:?}");
    assert_eq!(processors(None), before, "after the run");
}

#[test]
fn a_run_takes_the_processor_with_the_fewest_runs_and_moves_only_if_it_must() {
    let chosen = |runs: &[usize], present| chosen([1, 2, 4].into_iter(), runs, present);
    assert_eq!(chosen(&[0, 0, 0, 0, 0], 2), Some(2));
    assert_eq!(chosen(&[0, 1, 1, 0, 1], 4), Some(4));
    assert_eq!(chosen(&[0, 1, 2, 0, 2], 4), Some(1));
    assert_eq!(chosen(&[0, 3, 2, 0, 1], 1), Some(4));
    // The present processor may have been taken from this program.
    assert!(chosen(&[0, 0, 0, 0, 0], 0).is_some_and(|taken| taken != 0));
}
