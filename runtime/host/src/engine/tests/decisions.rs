//! Which selections wait for a takeover, and for how long. The rules of a real engine produce the events.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use jde_app::{RoleId, parse};
use jde_core::{Check, Nanos, Operator, SchemaId};
use jde_loader::{Plugins, SearchPath};
use jde_records::event::Event;
use jde_records::{Decision, DecisionTracker, MAX_QUEUED, MAX_WAIT};
use jde_schema::derived::raw;
use jde_schema::prelude::*;
use parking_lot::Mutex;

use crate::clock::Clock;
use crate::engine::{Actor, Engine};

/// A motor schema that may have two children.
#[expect(
    dead_code,
    reason = "the test reports the states of the children to the rules"
)]
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
    events: Arc<Mutex<Vec<Event>>>,
    decided: DecisionTracker,
    /// Selections that the rules made and that were not emitted yet.
    withheld: BTreeSet<u64>,
    emitted: Vec<Decision>,
}

impl Fixture {
    fn new() -> Self {
        let mut plugins = Plugins::new(SearchPath::default());
        plugins.link(&PLUGIN).unwrap();
        let application = parse(FAMILY, Path::new("family.toml"), &[], &plugins).unwrap();
        let decided = DecisionTracker::new(&application);
        let events = Arc::new(Mutex::new(Vec::new()));
        let sink = Arc::clone(&events);
        let observer = Box::new(move |event: &Event| sink.lock().push(event.clone()));
        let (engine, _ports) = Engine::new(
            application,
            Clock::new_virtual(),
            vec![observer],
            None,
            None,
            None,
            BTreeMap::new(),
        )
        .unwrap();
        engine.rules.start();
        Self {
            engine,
            events,
            decided,
            withheld: BTreeSet::new(),
            emitted: Vec::new(),
        }
    }

    fn of(&self, name: &str) -> SchemaId {
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
    fn wake_children(&self) {
        self.check("bottom", true);
        let father = self.of("bottom");
        assert!(self.engine.rules.request_iteration(father).0);
        for role in [0, 1].map(RoleId) {
            assert_eq!(self.engine.request_child(father, role, true), jde_abi::raw::OK);
        }
        self.engine.rules.report_iteration_end(father);
    }

    fn at(&self, time: Nanos) {
        self.engine.clock.advance_to(time);
    }

    /// Returns the selections that were made and not emitted yet, after all events so far.
    fn withheld(&mut self) -> Vec<u64> {
        let events = std::mem::take(&mut *self.events.lock());
        for event in events {
            if let Event::Decision(record) = &event {
                self.withheld.insert(record.number);
            }
            let emitted = self.decided.process(&event);
            self.record_emitted(emitted);
        }
        self.withheld.iter().copied().collect()
    }

    fn record_emitted(&mut self, decisions: Vec<Decision>) {
        for decision in &decisions {
            assert!(
                self.withheld.remove(&decision.number),
                "emitted twice: {decision:?}"
            );
        }
        self.emitted.extend(decisions);
    }

    /// Emits the rest and returns all, in the order of each group.
    fn end(mut self) -> Vec<Decision> {
        self.withheld();
        let rest = self.decided.drain();
        self.record_emitted(rest);
        assert!(self.withheld.is_empty(), "never emitted: {:?}", self.withheld);
        for group in ["roots", "bottom/base"] {
            let of_group = self.emitted.iter().filter(|decision| decision.group == group);
            assert!(of_group.is_sorted_by_key(|decision| decision.number), "{group}");
        }
        self.emitted
    }
}

#[test]
fn r15_a_takeover_is_emitted_with_its_latency() {
    let mut fixture = Fixture::new();
    fixture.withheld();
    fixture.at(1_000);
    fixture.check("bottom", true);
    assert_eq!(fixture.withheld().len(), 1, "it has not begun");
    fixture.at(3_500);
    fixture.iterate("bottom");
    assert_eq!(fixture.withheld(), [0; 0]);
    let decisions = fixture.end();
    let took: Vec<_> = decisions
        .iter()
        .filter_map(|decision| decision.takeover_us)
        .collect();
    assert_eq!(took, [3.5]);
}

#[test]
fn r15_a_cancelled_handover_withholds_nothing() {
    let mut fixture = Fixture::new();
    fixture.check("bottom", true);
    assert!(fixture.engine.rules.request_iteration(fixture.of("bottom")).0);
    fixture.check("top", true);
    assert_eq!(
        fixture.withheld().len(),
        1,
        "top waits for the end of the iteration"
    );
    fixture.check("top", false);
    assert_eq!(
        fixture.withheld(),
        [0; 0],
        "bottom was chosen again and continues"
    );
    fixture.engine.rules.report_iteration_end(fixture.of("bottom"));
    fixture.wake_children();
    fixture.check("first", true);
    fixture.iterate("first");
    assert_eq!(
        fixture.withheld(),
        [0; 0],
        "selections of other groups are not withheld"
    );
    fixture.end();
}

#[test]
fn r15_a_winner_lost_before_its_first_iteration_withholds_nothing() {
    let mut fixture = Fixture::new();
    fixture.wake_children();
    fixture.check("first", true);
    assert_eq!(fixture.withheld().len(), 1, "it has not begun");
    // Its father sleeps, and its group has no further selection.
    fixture.check("top", true);
    fixture.iterate("top");
    assert_eq!(fixture.withheld(), [0; 0]);
    let decisions = fixture.end();
    let of_first = decisions
        .iter()
        .find(|decision| decision.choice.as_deref() == Some("first"));
    assert_eq!(of_first.unwrap().takeover_us, None);
}

#[test]
fn r15_a_schema_that_sleeps_before_its_takeover_withholds_nothing() {
    let mut fixture = Fixture::new();
    fixture.wake_children();
    fixture.check("second", true);
    assert!(fixture.engine.rules.request_iteration(fixture.of("second")).0);
    fixture.check("first", true);
    assert_eq!(
        fixture.withheld().len(),
        1,
        "first waits for the end of the iteration"
    );
    let first = fixture.of("first");
    fixture
        .engine
        .operators
        .operate(&Actor::lasting("somebody"), Operator::Stop(first))
        .unwrap();
    assert_eq!(fixture.withheld(), [0; 0]);
    fixture.end();
}

#[test]
fn r15_one_group_that_waits_withholds_no_other() {
    let mut fixture = Fixture::new();
    fixture.wake_children();
    fixture.check("first", true);
    assert_eq!(fixture.withheld().len(), 1);
    for _ in 0..100 {
        fixture.iterate("bottom");
    }
    assert_eq!(fixture.withheld().len(), 1, "only its own");
    fixture.end();
}

#[test]
fn r15_what_waits_behind_a_winner_that_does_not_begin_is_bounded() {
    let mut fixture = Fixture::new();
    fixture.check("bottom", true);
    let all = 2 * MAX_QUEUED + 2;
    let mut most = 0;
    for turn in 0..all {
        fixture.check("top", turn % 2 == 0);
        // The handover is carried out at once, and each takeover has another winner.
        most = most.max(fixture.withheld().len());
    }
    assert_eq!(most, 1);
    // An operator forces `bottom`, so selections change nothing.
    let bottom = fixture.of("bottom");
    fixture
        .engine
        .operators
        .operate(&Actor::lasting("somebody"), Operator::Force(bottom))
        .unwrap();
    for turn in 0..all {
        fixture.check("top", turn % 2 == 0);
        most = most.max(fixture.withheld().len());
    }
    assert!(most > MAX_QUEUED / 2, "they waited: {most}");
    assert!(most <= MAX_QUEUED + 1, "{most}");
    fixture.end();
}

#[test]
fn r15_a_winner_that_does_not_begin_is_emitted_after_the_longest_wait() {
    let mut fixture = Fixture::new();
    fixture.wake_children();
    fixture.at(1_000);
    fixture.check("first", true);
    assert_eq!(fixture.withheld().len(), 1);
    fixture.at(MAX_WAIT);
    fixture.iterate("bottom");
    assert_eq!(fixture.withheld().len(), 1);
    fixture.at(MAX_WAIT + 1_000);
    fixture.iterate("bottom");
    assert_eq!(fixture.withheld(), [0; 0], "the next event emits it");
    fixture.iterate("first");
    fixture.end();
}
