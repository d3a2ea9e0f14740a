//! Each ready-made policy alone, on one group of roots.
//!
//! It checks only the winner and the reason.

use std::time::Duration;

use jde_core::{
    Check, Effect, GroupId, GroupSpec, Hierarchy, Kind, Nanos, POLICIES, Policy, PolicyKind, Record,
    SchemaId, SchemaSpec, Spec,
};

const A: SchemaId = SchemaId(0);
const B: SchemaId = SchemaId(1);
const C: SchemaId = SchemaId(2);
const GROUP: GroupId = GroupId(0);

struct Level {
    h: Hierarchy,
    out: Vec<Effect>,
}

impl Level {
    fn with_policy(policy: Policy) -> Self {
        let schemas = ["a", "b", "c"]
            .map(|name| SchemaSpec::new(name, Kind::Motor, 10))
            .to_vec()
            .into();
        let groups = vec![GroupSpec {
            policy,
            ..GroupSpec::new("level", None, vec![A, B, C])
        }]
        .into();
        let mut h = Hierarchy::new(Spec { schemas, groups }).expect("a valid specification");
        let mut out = Vec::new();
        h.at(0, &mut out).start();
        Self { h, out }
    }

    fn check_ready(&mut self, now: Nanos, id: SchemaId, urgency: f64) -> Option<SchemaId> {
        self.h.at(now, &mut self.out).checked(
            id,
            Check {
                ready: true,
                urgency,
                cause: now,
            },
        );
        self.h.winner(GROUP)
    }

    fn check_unready(&mut self, now: Nanos, id: SchemaId) -> Option<SchemaId> {
        self.h.at(now, &mut self.out).checked(
            id,
            Check {
                ready: false,
                urgency: 0.0,
                cause: now,
            },
        );
        self.h.winner(GROUP)
    }

    /// Iterates the winner, which then competes again.
    fn iterate_winner(&mut self, now: Nanos) -> Option<SchemaId> {
        let winner = self.h.winner(GROUP).expect("the level has a winner");
        assert!(self.h.at(now, &mut self.out).begin(winner));
        self.h.at(now, &mut self.out).end(winner);
        self.h.winner(GROUP)
    }

    fn tick(&mut self, now: Nanos) -> Option<SchemaId> {
        self.h.at(now, &mut self.out).tick();
        self.h.winner(GROUP)
    }

    fn last(&self) -> &Record {
        let record = self.out.iter().rev().find_map(|e| match e {
            Effect::Decided(record) => Some(record),
            _ => None,
        });
        record.expect("a decision")
    }
}

#[test]
fn r4_priority_is_the_fathers_order() {
    let mut level = Level::with_policy(Policy::PRIORITY);
    assert_eq!(level.check_ready(1, C, 9.0), Some(C));
    assert_eq!(level.check_ready(2, B, 0.0), Some(B));
    assert_eq!(level.check_ready(3, A, -1.0), Some(A));
    assert_eq!(level.check_unready(4, A), Some(B));
}

#[test]
fn r4_the_highest_urgency_wins_and_a_tie_changes_nothing() {
    let mut level = Level::with_policy(Policy::URGENCY);
    assert_eq!(level.check_ready(1, B, 1.0), Some(B));
    assert_eq!(level.check_ready(2, A, 1.0), Some(B));
    assert_eq!(level.check_ready(3, C, 1.5), Some(C));
}

#[test]
fn r4_the_fathers_order_decides_a_tie_without_a_winner() {
    let mut level = Level::with_policy(Policy::URGENCY);
    level.check_ready(1, C, 5.0);
    level.check_ready(2, B, 1.0);
    level.check_ready(2, A, 1.0);
    assert_eq!(level.check_unready(3, C), Some(A));
}

#[test]
fn r4_an_urgency_of_nan_is_the_lowest() {
    let mut level = Level::with_policy(Policy::URGENCY);
    assert_eq!(level.check_ready(1, A, f64::NAN), Some(A));
    assert_eq!(level.check_ready(2, B, f64::MIN), Some(B));
    assert_eq!(level.last().candidates[0].urgency, f64::NEG_INFINITY);
}

#[test]
fn r2_a_changed_urgency_counts_when_the_winner_competes_again() {
    let mut level = Level::with_policy(Policy::URGENCY);
    level.check_ready(1, A, 1.0);
    level.check_ready(2, B, 0.0);
    assert_eq!(
        level.check_ready(3, B, 2.0),
        Some(A),
        "no readiness has changed, so there is no selection yet"
    );
    assert_eq!(level.iterate_winner(4), Some(B));
}

#[test]
fn r4_sticky_waits_for_the_dwell_time_and_for_the_margin() {
    let mut level = Level::with_policy(Policy::sticky(Duration::from_nanos(100), 0.5));
    assert_eq!(level.check_ready(10, B, 1.0), Some(B));
    assert_eq!(level.check_ready(20, A, 1.4), Some(B));
    assert_eq!(
        level.h.next_timer(),
        None,
        "at the end of the dwell time nothing would change"
    );
    level.check_ready(30, A, 1.5);
    assert_eq!(level.iterate_winner(40), Some(B));
    assert_eq!(level.h.next_timer(), Some(110));
    assert_eq!(level.tick(109), Some(B));
    assert_eq!(level.tick(110), Some(A));
}

#[test]
fn r4_sticky_without_a_margin_does_not_switch_between_equal_urgencies() {
    let mut level = Level::with_policy(Policy::sticky(Duration::ZERO, 0.0));
    level.check_ready(1, B, 1.0);
    assert_eq!(level.check_ready(2, A, 1.0), Some(B));
    assert_eq!(level.iterate_winner(3), Some(B));
}

#[test]
fn r4_sticky_replaces_at_once_a_winner_that_is_not_ready() {
    let mut level = Level::with_policy(Policy::sticky(Duration::from_nanos(100), 0.5));
    level.check_ready(1, A, 3.0);
    level.check_ready(2, B, 1.0);
    level.check_ready(3, C, 2.0);
    assert_eq!(level.check_unready(4, A), Some(C));
}

#[test]
fn r4_round_robin_gives_each_ready_schema_a_turn() {
    let mut level = Level::with_policy(Policy::round_robin(Duration::from_nanos(10)));
    assert_eq!(level.check_ready(0, B, 0.0), Some(B));
    assert_eq!(level.h.next_timer(), None, "a single schema has no turns");
    level.check_ready(1, A, 0.0);
    level.check_ready(2, C, 0.0);
    assert_eq!(level.iterate_winner(9), Some(B));
    assert_eq!(level.tick(10), Some(C));
    assert_eq!(level.tick(20), Some(A));
    assert_eq!(level.tick(30), Some(B));
    assert_eq!(level.check_unready(31, C), Some(B));
    assert_eq!(level.tick(40), Some(A), "c is skipped");
}

#[test]
fn r4_round_robin_continues_after_a_winner_that_is_no_longer_ready() {
    let mut level = Level::with_policy(Policy::round_robin(Duration::from_nanos(10)));
    level.check_ready(0, B, 0.0);
    level.check_ready(1, A, 0.0);
    level.check_ready(1, C, 0.0);
    assert_eq!(level.check_unready(5, B), Some(C));
}

#[test]
fn r4_every_policy_has_its_own_name_and_code() {
    for kind in POLICIES {
        let same = POLICIES
            .iter()
            .filter(|other| other.code == kind.code || other.name == kind.name);
        assert_eq!(same.count(), 1, "{}", kind.name);
        let named = PolicyKind::named(kind.name).expect("it is in the table");
        assert_eq!(named.code, kind.code);
    }
    // Plugins of version 1.0 of the ABI use these.
    let names = (0..5).map(|code| Policy::from_code(code, 1, 0.0).map(Policy::name));
    let expected = ["priority", "urgency", "sticky", "round-robin", "father"].map(Some);
    assert!(names.eq(expected));
}

#[test]
fn r4_a_father_cannot_set_an_unknown_policy_or_a_refused_parameter() {
    assert_eq!(Policy::from_code(99, 1, 0.0), None);
    assert_eq!(Policy::from_code(3, 0, 0.0), None, "a turn of 0");
    for hysteresis in [-0.1, f64::NAN, f64::INFINITY] {
        assert_eq!(Policy::from_code(2, 1, hysteresis), None);
        assert_eq!(
            Policy::from_code(0, 1, hysteresis),
            Some(Policy::PRIORITY),
            "a parameter that the policy does not have is ignored"
        );
    }
}
