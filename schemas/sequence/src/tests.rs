//! The children of a sequence act one after another, whatever interrupts them.

use jde_schema::State;
use jde_schema::bench::Bench;

use super::*;

/// Steps of two children, and what is done with them.
struct Errand {
    bench: Bench<Steps>,
    now: Duration,
}

impl Errand {
    fn new() -> Self {
        let mut bench = Bench::<Steps>::new();
        bench.name_children(&[("a", "step"), ("b", "step")]);
        bench.set("timeout", 10.0);
        bench.set("retries", 1_u32);
        Self {
            bench,
            now: Duration::ZERO,
        }
    }

    /// Lets it iterate after some seconds, if it is READY. Returns who is awake.
    fn after(&mut self, seconds: f64) -> Vec<String> {
        self.now += Duration::from_secs_f64(seconds);
        self.bench.set_now(self.now);
        if self.bench.check().expect("the check succeeds").ready {
            self.bench.iterate().expect("the iteration succeeds");
        }
        self.bench
            .awake_children()
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    fn mission(&self) -> (u8, u32) {
        let mission: Mission = self.bench.exported("mission").expect("it is published");
        (mission.state, mission.reached)
    }
}

#[test]
fn children_act_one_after_another_and_are_done_when_they_are_no_longer_ready() {
    let mut errand = Errand::new();
    assert_eq!(errand.after(0.1), ["a"]);
    errand.bench.set_child("a", State::Winner);
    assert_eq!(errand.after(5.0), ["a"]);
    errand.bench.set_child("a", State::Checking);
    assert_eq!(errand.after(0.1), ["a"]);
    assert_eq!(errand.after(0.5), ["a"], "a guard may have refused its command");
    errand.after(0.1);
    assert_eq!(errand.after(0.1), ["b"]);
    assert_eq!(errand.mission(), (Mission::RUNNING, 1));
    errand.bench.set_child("b", State::Winner);
    errand.after(0.1);
    errand.bench.set_child("b", State::Checking);
    errand.after(0.1);
    assert!(errand.after(0.7).is_empty());
    assert_eq!(errand.mission(), (Mission::DONE, 2));
    assert!(!errand.bench.check().expect("the check succeeds").ready);
}

#[test]
fn a_child_that_takes_too_long_is_tried_again_and_then_the_mission_fails() {
    let mut errand = Errand::new();
    errand.after(0.1);
    assert!(errand.after(10.0).is_empty(), "the first try is over");
    assert_eq!(errand.after(0.1), ["a"]);
    assert_eq!(errand.mission(), (Mission::RUNNING, 0));
    assert!(errand.after(10.0).is_empty());
    assert_eq!(errand.mission(), (Mission::FAILED, 0));
    assert!(!errand.bench.check().expect("the check succeeds").ready);
}

#[test]
fn a_try_that_is_interrupted_begins_again() {
    let mut errand = Errand::new();
    errand.after(0.1);
    errand.after(9.0);
    // A sibling acts: the child sleeps, and its father stays awake (R5).
    errand.bench.set_child("a", State::Slept);
    assert_eq!(errand.after(9.0), ["a"]);
    assert_eq!(errand.after(9.0), ["a"]);
    assert!(errand.after(1.1).is_empty());
}

#[test]
fn a_child_that_was_refused_and_then_interrupted_is_not_done() {
    let mut errand = Errand::new();
    errand.after(0.1);
    errand.bench.set_child("a", State::Winner);
    errand.after(0.1);
    errand.bench.set_child("a", State::Checking);
    errand.after(0.1);
    errand.bench.set_child("a", State::Slept);
    assert_eq!(errand.after(5.0), ["a"]);
    assert_eq!(errand.after(1.0), ["a"]);
    assert_eq!(errand.mission(), (Mission::RUNNING, 0));
}

#[test]
fn without_a_timeout_each_fault_ends_one_try_however_long_the_child_is_faulted() {
    let mut errand = Errand::new();
    errand.bench.set("timeout", 0.0);
    errand.after(0.1);
    errand.bench.set_faulted("a", true);
    assert!(errand.after(0.05).is_empty(), "the first try is over");
    for _ in 0..5 {
        assert_eq!(errand.after(0.05), ["a"], "it may restart");
    }
    assert_eq!(errand.mission(), (Mission::RUNNING, 0));
    errand.bench.set_faulted("a", false);
    assert_eq!(errand.after(0.05), ["a"]);
    errand.bench.set_faulted("a", true);
    assert!(errand.after(0.05).is_empty());
    assert_eq!(errand.mission(), (Mission::FAILED, 0));
}
