//! `All` wakes every child that the application names, including none; `Steps` one after another.

use jde_schema::State;
use jde_schema::bench::Bench;

use super::*;

#[test]
fn all_children_are_woken_whatever_their_number() {
    let names: Vec<String> = (0..20).map(|number| format!("robot-{number}")).collect();
    let children: Vec<_> = names.iter().map(|name| (name.as_str(), "all")).collect();
    for number in [0, 1, 20] {
        let mut all = Bench::<All>::new();
        all.name_children(&children[..number]);
        all.iterate().expect("the iteration succeeds");
        assert_eq!(all.awake_children(), names[..number]);
    }
}

#[test]
fn a_child_that_went_to_sleep_is_woken_again() {
    let mut all = Bench::<All>::new();
    all.name_children(&[("left", "left"), ("right", "right")]);
    all.iterate().expect("the iteration succeeds");
    all.set_child("right", State::Slept);
    assert_eq!(all.awake_children(), ["left"]);
    all.iterate().expect("the iteration succeeds");
    assert_eq!(all.awake_children(), ["left", "right"]);
}

#[test]
fn r7_without_authority_no_child_is_woken() {
    let mut all = Bench::<All>::new();
    all.name_children(&[("left", "left"), ("right", "right")]);
    all.set_authority(false);
    all.iterate().expect("a refusal is not a fault");
    assert!(all.awake_children().is_empty());
}

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
    errand.bench.awake().expect("it awakes");
    assert_eq!(errand.after(9.0), ["a"]);
    assert_eq!(errand.after(9.0), ["a"]);
    assert!(errand.after(1.1).is_empty());
}
