//! Which selections wait for a takeover, and for how long. The rules of a real engine produce the events.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Arc, Mutex};

use jde_app::parse;
use jde_core::{Check, Nanos, Operator, SchemaId};
use jde_loader::{Plugins, SearchPath};
use jde_records::event::Event;
use jde_records::{Decision, DecisionTracker, MAX_QUEUED, MAX_WAIT};
use jde_schema::derived::raw;
use jde_schema::prelude::*;

use crate::clock::Clock;
use crate::engine::Engine;

/// Leads two, if it is a father.
#[expect(dead_code, reason = "the rules are told by hand what becomes of children")]
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Act {
    /// A child.
    #[child(group = "base", optional)]
    a: Child,
    /// Another.
    #[child(group = "base", optional)]
    b: Child,
}

impl Schema for Act {
    fn iterate(&mut self, _: &Context) -> jde_schema::Result {
        Ok(())
    }
}

static PLUGIN: raw::Plugin = jde_schema::plugin!("decided-tests", "Fathers and children.", [Act]);

const FAMILY: &str = r#"
    roots = ["top", "bottom"]
    [schemas.top]
    type = "decided-tests/act"
    [schemas.bottom]
    type = "decided-tests/act"
    children = { a = "first", b = "second" }
    [schemas.first]
    type = "decided-tests/act"
    [schemas.second]
    type = "decided-tests/act"
"#;

/// An application whose rules receive their input from the test, with the events that result.
struct Fixture {
    engine: Arc<Engine>,
    heard: Arc<Mutex<Vec<Event>>>,
    decided: DecisionTracker,
    /// Selections that the rules made and that were not emitted yet.
    withheld: BTreeSet<u64>,
    told: Vec<Decision>,
}

impl Fixture {
    fn new() -> Self {
        let mut plugins = Plugins::new(SearchPath::default());
        plugins.link(&PLUGIN).unwrap();
        let application = parse(FAMILY, Path::new("family.toml"), &[], &plugins).unwrap();
        let decided = DecisionTracker::new(&application);
        let heard = Arc::new(Mutex::new(Vec::new()));
        let ear = Arc::clone(&heard);
        let observer = Box::new(move |event: &Event| ear.lock().unwrap().push(event.clone()));
        let (engine, _ports) = Engine::new(
            application,
            Clock::new_virtual(),
            vec![observer],
            None,
            None,
            None,
        )
        .unwrap();
        engine.rules.start();
        Self {
            engine,
            heard,
            decided,
            withheld: BTreeSet::new(),
            told: Vec::new(),
        }
    }

    fn of(&self, name: &str) -> usize {
        self.engine.application.instance(name).unwrap()
    }

    fn check(&self, name: &str, ready: bool) {
        let check = Check {
            ready,
            urgency: 0.0,
            cause: 0,
        };
        self.engine.rules.report_check(self.of(name), check);
    }

    /// Iterates once, if that is permitted.
    fn iterate(&self, name: &str) {
        if self.engine.rules.request_iteration(self.of(name)).0 {
            self.engine.rules.report_iteration_end(self.of(name));
        }
    }

    /// Makes `bottom` win and wake both its children.
    fn lead(&self) {
        self.check("bottom", true);
        let father = self.of("bottom");
        assert!(self.engine.rules.request_iteration(father).0);
        for role in [0, 1] {
            assert_eq!(self.engine.request_child(father, role, true), jde_abi::raw::OK);
        }
        self.engine.rules.report_iteration_end(father);
    }

    fn at(&self, time: Nanos) {
        self.engine.clock.advance_to(time);
    }

    /// Returns the selections that were made and not emitted yet, after all events so far.
    fn withheld(&mut self) -> Vec<u64> {
        let heard = std::mem::take(&mut *self.heard.lock().unwrap());
        for event in heard {
            if let Event::Decided(record) = &event {
                self.withheld.insert(record.number);
            }
            let told = self.decided.process(&event);
            self.tell(told);
        }
        self.withheld.iter().copied().collect()
    }

    fn tell(&mut self, decisions: Vec<Decision>) {
        for decision in &decisions {
            assert!(self.withheld.remove(&decision.number), "told twice: {decision:?}");
        }
        self.told.extend(decisions);
    }

    /// Emits the rest and returns all, in the order of each group.
    fn end(mut self) -> Vec<Decision> {
        self.withheld();
        let rest = self.decided.drain();
        self.tell(rest);
        assert!(self.withheld.is_empty(), "never told: {:?}", self.withheld);
        for group in ["roots", "bottom/base"] {
            let of_group = self.told.iter().filter(|decision| decision.group == group);
            assert!(of_group.is_sorted_by_key(|decision| decision.number), "{group}");
        }
        self.told
    }
}

#[test]
fn r15_a_takeover_is_told_with_its_time() {
    let mut desk = Fixture::new();
    desk.withheld();
    desk.at(1_000);
    desk.check("bottom", true);
    assert_eq!(desk.withheld().len(), 1, "it has yet to begin");
    desk.at(3_500);
    desk.iterate("bottom");
    assert_eq!(desk.withheld(), [0; 0]);
    let told = desk.end();
    let took: Vec<_> = told.iter().filter_map(|decision| decision.takeover_us).collect();
    assert_eq!(took, [3.5]);
}

#[test]
fn r15_a_cancelled_handover_withholds_nothing() {
    let mut desk = Fixture::new();
    desk.check("bottom", true);
    assert!(desk.engine.rules.request_iteration(desk.of("bottom")).0);
    desk.check("top", true);
    assert_eq!(desk.withheld().len(), 1, "top waits for the end of the iteration");
    desk.check("top", false);
    assert_eq!(
        desk.withheld(),
        [0; 0],
        "bottom was chosen again, and goes on as it was"
    );
    desk.engine.rules.report_iteration_end(desk.of("bottom"));
    desk.lead();
    desk.check("first", true);
    desk.iterate("first");
    assert_eq!(desk.withheld(), [0; 0], "nor does it withhold what others decide");
    desk.end();
}

#[test]
fn r15_a_winner_lost_before_its_first_iteration_withholds_nothing() {
    let mut desk = Fixture::new();
    desk.lead();
    desk.check("first", true);
    assert_eq!(desk.withheld().len(), 1, "it has yet to begin");
    // Its father sleeps, and its group has no further selection.
    desk.check("top", true);
    desk.iterate("top");
    assert_eq!(desk.withheld(), [0; 0]);
    let told = desk.end();
    let of_first = told
        .iter()
        .find(|decision| decision.choice.as_deref() == Some("first"));
    assert_eq!(of_first.unwrap().takeover_us, None);
}

#[test]
fn r15_whoever_was_to_take_over_and_falls_asleep_withholds_nothing() {
    let mut desk = Fixture::new();
    desk.lead();
    desk.check("second", true);
    assert!(desk.engine.rules.request_iteration(desk.of("second")).0);
    desk.check("first", true);
    assert_eq!(
        desk.withheld().len(),
        1,
        "first waits for the end of the iteration"
    );
    let first = SchemaId(desk.of("first") as u32);
    desk.engine
        .operators
        .operate("somebody", Operator::Stop(first))
        .unwrap();
    assert_eq!(desk.withheld(), [0; 0]);
    desk.end();
}

#[test]
fn r15_one_group_that_waits_withholds_no_other() {
    let mut desk = Fixture::new();
    desk.lead();
    desk.check("first", true);
    assert_eq!(desk.withheld().len(), 1);
    for _ in 0..100 {
        desk.iterate("bottom");
    }
    assert_eq!(desk.withheld().len(), 1, "only its own");
    desk.end();
}

#[test]
fn r15_what_waits_behind_a_winner_that_does_not_begin_is_bounded() {
    let mut desk = Fixture::new();
    desk.check("bottom", true);
    let all = 2 * MAX_QUEUED + 2;
    let mut most = 0;
    for turn in 0..all {
        desk.check("top", turn % 2 == 0);
        // The handover is carried out at once, and each takeover has another winner.
        most = most.max(desk.withheld().len());
    }
    assert_eq!(most, 1);
    // An operator forces `bottom`, so selections change nothing.
    let bottom = SchemaId(desk.of("bottom") as u32);
    desk.engine
        .operators
        .operate("somebody", Operator::Force(bottom))
        .unwrap();
    for turn in 0..all {
        desk.check("top", turn % 2 == 0);
        most = most.max(desk.withheld().len());
    }
    assert!(most > MAX_QUEUED / 2, "they waited: {most}");
    assert!(most <= MAX_QUEUED + 1, "{most}");
    desk.end();
}

#[test]
fn r15_a_winner_that_does_not_begin_is_told_of_after_a_while() {
    let mut desk = Fixture::new();
    desk.lead();
    desk.at(1_000);
    desk.check("first", true);
    assert_eq!(desk.withheld().len(), 1);
    desk.at(MAX_WAIT);
    desk.iterate("bottom");
    assert_eq!(desk.withheld().len(), 1);
    desk.at(MAX_WAIT + 1_000);
    desk.iterate("bottom");
    assert_eq!(desk.withheld(), [0; 0], "whatever happens next tells of it");
    desk.iterate("first");
    desk.end();
}
