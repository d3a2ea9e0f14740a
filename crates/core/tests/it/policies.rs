//! Each ready-made policy alone, on one group of roots.
//!
//! It checks only the winner and the reason, and refuses to check other effects.

use std::time::Duration;

use jde_core::{
    Check, Effect, GroupId, GroupSpec, Hierarchy, Kind, Nanos, Policy, Record, SchemaId, SchemaSpec, Spec,
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
    fn under(policy: Policy) -> Self {
        let schemas = ["a", "b", "c"]
            .map(|name| SchemaSpec::new(name, Kind::Motor, 10))
            .to_vec();
        let groups = vec![GroupSpec {
            policy,
            ..GroupSpec::new("level", None, vec![A, B, C])
        }];
        let mut h = Hierarchy::new(Spec { schemas, groups }).expect("a sound specification");
        let mut out = Vec::new();
        h.start(0, &mut out);
        Self { h, out }
    }

    fn offers(&mut self, now: Nanos, id: SchemaId, urgency: f64) -> Option<SchemaId> {
        self.h.checked(
            now,
            id,
            Check {
                ready: true,
                urgency,
                cause: now,
            },
            &mut self.out,
        );
        self.h.winner(GROUP)
    }

    fn drops(&mut self, now: Nanos, id: SchemaId) -> Option<SchemaId> {
        self.h.checked(
            now,
            id,
            Check {
                ready: false,
                urgency: 0.0,
                cause: now,
            },
            &mut self.out,
        );
        self.h.winner(GROUP)
    }

    /// The winner iterates and competes again.
    fn goes_on(&mut self, now: Nanos) -> Option<SchemaId> {
        let winner = self.h.winner(GROUP).expect("somebody wins");
        assert!(self.h.begin(now, winner, &mut self.out));
        self.h.end(now, winner, &mut self.out);
        self.h.winner(GROUP)
    }

    fn comes(&mut self, now: Nanos) -> Option<SchemaId> {
        self.h.tick(now, &mut self.out);
        self.h.winner(GROUP)
    }

    fn last(&self) -> &Record {
        let record = self.out.iter().rev().find_map(|e| match e {
            Effect::Decided(record) => Some(record),
            _ => None,
        });
        record.expect("something was decided")
    }
}

#[test]
fn r4_priority_is_the_fathers_order() {
    let mut level = Level::under(Policy::PRIORITY);
    assert_eq!(level.offers(1, C, 9.0), Some(C));
    assert_eq!(level.offers(2, B, 0.0), Some(B));
    assert_eq!(level.offers(3, A, -1.0), Some(A));
    assert_eq!(level.drops(4, A), Some(B));
}

#[test]
fn r4_the_highest_urgency_wins_and_a_tie_changes_nothing() {
    let mut level = Level::under(Policy::URGENCY);
    assert_eq!(level.offers(1, B, 1.0), Some(B));
    assert_eq!(level.offers(2, A, 1.0), Some(B));
    assert_eq!(level.offers(3, C, 1.5), Some(C));
}

#[test]
fn r4_a_tie_without_a_winner_goes_by_the_fathers_order() {
    let mut level = Level::under(Policy::URGENCY);
    level.offers(1, C, 5.0);
    level.offers(2, B, 1.0);
    level.offers(2, A, 1.0);
    assert_eq!(level.drops(3, C), Some(A));
}

#[test]
fn r4_an_urgency_that_is_no_number_is_the_lowest() {
    let mut level = Level::under(Policy::URGENCY);
    assert_eq!(level.offers(1, A, f64::NAN), Some(A));
    assert_eq!(level.offers(2, B, f64::MIN), Some(B));
    assert_eq!(level.last().candidates[0].urgency, f64::NEG_INFINITY);
}

#[test]
fn r2_a_changed_urgency_counts_when_the_winner_competes_again() {
    let mut level = Level::under(Policy::URGENCY);
    level.offers(1, A, 1.0);
    level.offers(2, B, 0.0);
    assert_eq!(
        level.offers(3, B, 2.0),
        Some(A),
        "no readiness changed, so nothing is selected yet"
    );
    assert_eq!(level.goes_on(4), Some(B));
}

#[test]
fn r4_sticky_waits_for_the_dwell_time_and_for_the_margin() {
    let mut level = Level::under(Policy::sticky(Duration::from_nanos(100), 0.5));
    assert_eq!(level.offers(10, B, 1.0), Some(B));
    assert_eq!(level.offers(20, A, 1.4), Some(B));
    assert_eq!(
        level.h.next_timer(),
        None,
        "at the end of the dwell time nothing would change"
    );
    level.offers(30, A, 1.5);
    assert_eq!(level.goes_on(40), Some(B));
    assert_eq!(level.h.next_timer(), Some(110));
    assert_eq!(level.comes(109), Some(B));
    assert_eq!(level.comes(110), Some(A));
}

#[test]
fn r4_sticky_without_a_margin_does_not_swing_between_equals() {
    let mut level = Level::under(Policy::sticky(Duration::ZERO, 0.0));
    level.offers(1, B, 1.0);
    assert_eq!(level.offers(2, A, 1.0), Some(B));
    assert_eq!(level.goes_on(3), Some(B));
}

#[test]
fn r4_sticky_lets_go_at_once_of_one_that_is_not_ready() {
    let mut level = Level::under(Policy::sticky(Duration::from_nanos(100), 0.5));
    level.offers(1, A, 3.0);
    level.offers(2, B, 1.0);
    level.offers(3, C, 2.0);
    assert_eq!(level.drops(4, A), Some(C));
}

#[test]
fn r4_round_robin_gives_each_ready_one_its_turn() {
    let mut level = Level::under(Policy::round_robin(Duration::from_nanos(10)));
    assert_eq!(level.offers(0, B, 0.0), Some(B));
    assert_eq!(level.h.next_timer(), None, "alone there are no turns");
    level.offers(1, A, 0.0);
    level.offers(2, C, 0.0);
    assert_eq!(level.goes_on(9), Some(B));
    assert_eq!(level.comes(10), Some(C));
    assert_eq!(level.comes(20), Some(A));
    assert_eq!(level.comes(30), Some(B));
    assert_eq!(level.drops(31, C), Some(B));
    assert_eq!(level.comes(40), Some(A), "c is passed over");
}

#[test]
fn r4_round_robin_goes_on_behind_one_that_left() {
    let mut level = Level::under(Policy::round_robin(Duration::from_nanos(10)));
    level.offers(0, B, 0.0);
    level.offers(1, A, 0.0);
    level.offers(1, C, 0.0);
    assert_eq!(level.drops(5, B), Some(C));
}
