//! Cases that no scenario contains: unknown identifiers, late calls, and calls in the wrong order.

use jde_core::{
    ArbitrationReply, Check, Effect, GroupId, GroupSpec, Health, Hierarchy, Kind, Operator, Policy, Refused,
    SchemaId, SchemaSpec, Spec, State, Timer,
};

use crate::family::{A, ANA, B, C, CHILDREN, FATHER, READY, effects, family};

const UNKNOWN: SchemaId = SchemaId(99);

#[test]
fn calls_with_unknown_ids_are_refused_or_have_no_effect() {
    let mut h = family(Policy::PRIORITY);
    let before = h.clone();
    let out = effects(|out| {
        h.at(1, out).checked(UNKNOWN, READY);
        assert!(!h.at(1, out).begin(UNKNOWN));
        h.at(1, out).end(UNKNOWN);
        h.at(1, out).faulted(UNKNOWN, "?".into());
        h.at(1, out).restored(UNKNOWN);
        h.at(1, out).overrun(UNKNOWN);
        h.at(1, out).on_time(UNKNOWN);
        h.set_period(UNKNOWN, 5);
        h.at(1, out)
            .arbitrated(GroupId(99), 1, ArbitrationReply::Failed { reason: "?".into() });
        h.at(1, out).fire(Timer::Hold(GroupId(99)));
        assert_eq!(h.at(1, out).set_policy(GroupId(99), Policy::FATHER), Ok(()));
        assert_eq!(h.at(1, out).wake(UNKNOWN, A), Err(Refused::Unknown { index: 99 }));
        assert_eq!(
            h.at(1, out).sleep(FATHER, UNKNOWN),
            Err(Refused::Unknown { index: 99 })
        );
        assert_eq!(
            h.at(1, out).operator(ANA, Operator::Force(UNKNOWN)),
            Err(Refused::Unknown { index: 99 })
        );
    });
    assert_eq!(out, []);
    assert_eq!(h, before);
    assert!(!h.is_taking(UNKNOWN) && !h.is_awake(UNKNOWN) && !h.has_authority(UNKNOWN));
    assert_eq!(
        (h.state(UNKNOWN), h.father(UNKNOWN), h.winner(GroupId(99))),
        (State::Slept, None, None)
    );
}

#[test]
fn nothing_wakes_before_the_start_and_a_second_start_changes_nothing() {
    let mut h = Hierarchy::new(family(Policy::PRIORITY).spec().clone()).expect("a valid specification");
    let out = effects(|out| {
        assert_eq!(
            h.at(0, out).operator(ANA, Operator::Play(A)),
            Err(Refused::NotRunning)
        );
        assert_eq!(h.at(0, out).wake(FATHER, A), Err(Refused::NotRunning));
    });
    assert_eq!(out, []);
    assert!(!effects(|out| h.at(0, out).start()).is_empty());
    assert_eq!(effects(|out| h.at(1, out).start()), []);
}

#[test]
fn a_check_of_a_sleeping_schema_and_an_end_without_a_begin_have_no_effect() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.at(1, out).sleep(FATHER, A).expect("authority"));
    let before = h.clone();
    assert_eq!(effects(|out| h.at(2, out).checked(A, READY)), []);
    assert_eq!(effects(|out| h.at(2, out).end(B)), []);
    assert_eq!(h, before);
}

#[test]
fn r4_a_reply_to_an_old_arbitration_has_no_effect() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.at(1, out).checked(A, READY));
    effects(|out| h.at(1, out).checked(B, READY));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    effects(|out| h.at(h.next_timer().expect("a budget"), out).tick());
    assert_eq!(
        (h.winner(CHILDREN), h.pending_arbitration(CHILDREN)),
        (Some(A), None)
    );
    let late = ArbitrationReply::Chosen {
        child: Some(B),
        reason: "late".into(),
    };
    assert_eq!(effects(|out| h.at(9, out).arbitrated(CHILDREN, ticket, late)), []);
    assert_eq!(h.winner(CHILDREN), Some(A));
}

#[test]
fn r4_choosing_a_child_that_fell_asleep_during_the_arbitration_is_not_a_failure() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.at(1, out).checked(A, READY));
    effects(|out| h.at(1, out).checked(B, READY));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    effects(|out| h.at(2, out).faulted(B, "gone".into()));
    let reply = ArbitrationReply::Chosen {
        child: Some(B),
        reason: "it was ready".into(),
    };
    effects(|out| h.at(3, out).arbitrated(CHILDREN, ticket, reply));
    assert_eq!((h.winner(CHILDREN), h.health(FATHER)), (Some(A), &Health::Ok));
}

#[test]
fn r4_no_second_arbitration_begins_without_a_new_trigger() {
    let mut h = family(Policy::FATHER);
    effects(|out| {
        h.at(1, out).checked(
            A,
            Check {
                ready: false,
                ..READY
            },
        )
    });
    let out = effects(|out| {
        h.at(1, out).checked(
            B,
            Check {
                ready: false,
                ..READY
            },
        )
    });
    assert!(matches!(out.last(), Some(Effect::Arbitrate { .. })));
    let ticket = h.pending_arbitration(CHILDREN).expect("an absence");
    let no_choice = ArbitrationReply::Chosen {
        child: None,
        reason: "wait".into(),
    };
    let out = effects(|out| h.at(2, out).arbitrated(CHILDREN, ticket, no_choice));
    assert!(!out.iter().any(|e| matches!(e, Effect::Arbitrate { .. })));
    assert!(out.contains(&Effect::Brake { group: CHILDREN }));
}

#[test]
fn r1_a_force_does_not_wait_for_the_fathers_arbitration() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.at(1, out).checked(A, READY));
    effects(|out| h.at(1, out).checked(B, READY));
    assert!(h.pending_arbitration(CHILDREN).is_some());
    effects(|out| {
        h.at(2, out)
            .operator(ANA, Operator::Force(B))
            .expect("b is healthy")
    });
    assert_eq!(
        (
            h.winner(CHILDREN),
            h.pending_arbitration(CHILDREN),
            h.next_timer()
        ),
        (Some(B), None, None)
    );
}

#[test]
fn back_off_doubles_without_overflowing() {
    let mut h = family(Policy::PRIORITY);
    let mut now = 0;
    for fault in 0..100u32 {
        effects(|out| h.at(now, out).faulted(A, "again".into()));
        let due = h.next_timer().expect("a restart");
        let doubled = 1u64
            .checked_shl(fault)
            .map_or(u64::MAX, |factor| factor.saturating_mul(10));
        assert_eq!(due, now.saturating_add(doubled));
        now = due;
        effects(|out| h.at(now, out).tick());
        assert_eq!(h.restarts_left(now, A), Some(u32::MAX - fault - 1));
    }
}

#[test]
fn a_second_report_of_a_fault_has_no_effect() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.at(1, out).faulted(A, "hung".into()));
    let before = h.clone();
    assert_eq!(
        effects(|out| h.at(2, out).faulted(A, "and then it panicked".into())),
        []
    );
    assert_eq!(h, before);
}

#[test]
fn an_overrun_is_reported_once_and_does_not_hide_a_fault() {
    let mut h = family(Policy::PRIORITY);
    let late = Effect::Health {
        id: A,
        health: Health::Overrun,
    };
    assert_eq!(effects(|out| h.at(1, out).overrun(A)), [late]);
    assert_eq!(effects(|out| h.at(1, out).overrun(A)), []);
    assert_eq!(
        effects(|out| h.at(1, out).on_time(A)),
        [Effect::Health {
            id: A,
            health: Health::Ok
        }]
    );
    effects(|out| h.at(1, out).faulted(A, "a fault".into()));
    assert_eq!(effects(|out| h.at(1, out).overrun(A)), []);
    assert_eq!(effects(|out| h.at(1, out).on_time(A)), []);
    assert_eq!(h.health(A), &Health::Faulted("a fault".into()));
}

#[test]
fn a_check_without_a_change_has_no_effect() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.at(1, out).checked(A, READY));
    assert_eq!(effects(|out| h.at(2, out).checked(A, READY)), []);
}

#[test]
fn r3_a_loser_that_hangs_is_no_longer_ready_so_the_level_selects_again() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.at(1, out).checked(A, READY));
    assert!(h.at(1, &mut Vec::new()).begin(A));
    effects(|out| h.at(1, out).checked(B, READY));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    let no_choice = ArbitrationReply::Chosen {
        child: None,
        reason: "neither".into(),
    };
    effects(|out| h.at(2, out).arbitrated(CHILDREN, ticket, no_choice));
    assert_eq!(h.winner(CHILDREN), Some(A), "a still iterates");
    effects(|out| h.at(9, out).fire(Timer::Patience(CHILDREN)));
    assert_eq!(h.winner(CHILDREN), Some(B), "only b is ready");
}

#[test]
fn r2_changes_below_a_father_that_is_being_replaced_take_effect_when_it_stays() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.at(1, out).checked(B, READY));
    assert!(h.at(1, &mut Vec::new()).begin(B));
    // The father is being replaced while its child iterates. The child stops being READY in the meantime.
    effects(|out| {
        h.at(2, out).checked(
            FATHER,
            Check {
                ready: false,
                ..READY
            },
        )
    });
    effects(|out| {
        h.at(2, out).checked(
            B,
            Check {
                ready: false,
                ..READY
            },
        )
    });
    assert_eq!((h.winner(CHILDREN), h.handover(CHILDREN)), (Some(B), None));
    effects(|out| h.at(3, out).checked(FATHER, READY));
    let handover = h.handover(CHILDREN).expect("b is not ready any more");
    assert_eq!(handover.to, None);
}

#[test]
fn r10_a_winner_that_was_put_to_sleep_begins_no_iteration_during_an_arbitration() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.at(1, out).checked(A, READY));
    effects(|out| h.at(1, out).checked(B, READY));
    assert_eq!(
        (h.winner(CHILDREN), h.pending_arbitration(CHILDREN).is_some()),
        (Some(A), true)
    );
    effects(|out| h.at(2, out).sleep(FATHER, A).expect("authority"));
    assert_eq!(h.state(A), State::Winner);
    assert!(!h.at(2, &mut Vec::new()).begin(A));
}

#[test]
fn r2_a_loser_whose_last_iteration_finds_no_value_causes_a_selection() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.at(1, out).checked(A, READY));
    assert!(h.at(1, &mut Vec::new()).begin(A));
    effects(|out| h.at(1, out).checked(B, READY));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    let reply = ArbitrationReply::Chosen {
        child: None,
        reason: "nobody".into(),
    };
    effects(|out| h.at(2, out).arbitrated(CHILDREN, ticket, reply));
    assert_eq!(h.handover(CHILDREN).map(|handover| handover.to), Some(None));
    effects(|out| h.at(3, out).end_unready(A));
    assert_eq!(
        (h.state(A), h.winner(CHILDREN)),
        (State::Checking, Some(B)),
        "R3: B is the only one that is READY"
    );
}

#[test]
fn r5_a_handover_to_a_child_that_fell_asleep_leaves_no_winner_until_the_father_replies() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.at(0, out).wake(FATHER, C).expect("authority"));
    effects(|out| h.at(1, out).checked(A, READY));
    assert!(h.at(1, &mut Vec::new()).begin(A));
    effects(|out| h.at(1, out).checked(B, READY));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    let reply = ArbitrationReply::Chosen {
        child: Some(B),
        reason: "b".into(),
    };
    effects(|out| h.at(2, out).arbitrated(CHILDREN, ticket, reply));
    effects(|out| h.at(3, out).checked(C, READY));
    assert_eq!(h.handover(CHILDREN).and_then(|handover| handover.to), Some(B));
    assert!(h.pending_arbitration(CHILDREN).is_some());
    effects(|out| h.at(4, out).faulted(B, "gone".into()));
    effects(|out| h.at(5, out).end(A));
    assert_eq!(
        (h.state(A), h.state(B), h.winner(CHILDREN)),
        (State::Ready, State::Slept, None)
    );
}

#[test]
fn r7_a_played_winner_below_a_played_winner_has_no_authority_while_the_root_does_not_win() {
    let schema = |name| SchemaSpec::new(name, Kind::Motor, 10);
    let spec = Spec {
        schemas: ["root", "father", "child"].map(schema).to_vec().into(),
        groups: vec![
            GroupSpec::new("roots", None, vec![SchemaId(0)]),
            GroupSpec::new("middle", Some(SchemaId(0)), vec![SchemaId(1)]),
            GroupSpec::new("bottom", Some(SchemaId(1)), vec![SchemaId(2)]),
        ]
        .into(),
    };
    let mut h = Hierarchy::new(spec).expect("a valid specification");
    effects(|out| h.at(0, out).start());
    for id in [SchemaId(1), SchemaId(2)] {
        effects(|out| h.at(1, out).operator(ANA, Operator::Play(id)).expect("healthy"));
        effects(|out| h.at(1, out).checked(id, READY));
        assert_eq!((h.state(id), h.has_authority(id)), (State::Winner, false));
    }
    let out = effects(|out| h.at(2, out).checked(SchemaId(0), READY));
    let granted: Vec<_> = out.iter().filter(|e| matches!(e, Effect::Granted(_))).collect();
    let expected = [0, 1, 2].map(|id| Effect::Granted(SchemaId(id)));
    assert_eq!(
        granted,
        expected.iter().collect::<Vec<_>>(),
        "fathers before children"
    );
}

#[test]
fn r4_a_reply_that_chooses_a_child_that_is_no_longer_ready_changes_nothing() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.at(1, out).checked(A, READY));
    effects(|out| h.at(1, out).checked(B, READY));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    effects(|out| {
        h.at(2, out).checked(
            B,
            Check {
                ready: false,
                ..READY
            },
        )
    });
    let reply = ArbitrationReply::Chosen {
        child: Some(B),
        reason: "b".into(),
    };
    let out = effects(|out| h.at(3, out).arbitrated(CHILDREN, ticket, reply));
    assert!(!out.contains(&Effect::Demoted(A)) && !out.contains(&Effect::Promoted(B)));
    assert_eq!((h.winner(CHILDREN), h.health(FATHER)), (Some(A), &Health::Ok));
}

#[test]
fn r5_a_fault_below_a_father_that_is_being_replaced_ends_its_handover_at_once() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.at(1, out).checked(B, READY));
    assert!(h.at(1, &mut Vec::new()).begin(B));
    effects(|out| {
        h.at(2, out).checked(
            FATHER,
            Check {
                ready: false,
                ..READY
            },
        )
    });
    assert_eq!(h.state(FATHER), State::Winner);
    effects(|out| h.at(3, out).faulted(B, "hung".into()));
    assert_eq!(h.state(FATHER), State::Checking);
}

#[test]
fn r1_the_chosen_child_wins_when_the_loser_faults_during_another_arbitration() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.at(0, out).wake(FATHER, C).expect("authority"));
    effects(|out| h.at(1, out).checked(A, READY));
    assert!(h.at(1, &mut Vec::new()).begin(A));
    effects(|out| h.at(1, out).checked(B, READY));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    let reply = ArbitrationReply::Chosen {
        child: Some(B),
        reason: "b".into(),
    };
    effects(|out| h.at(2, out).arbitrated(CHILDREN, ticket, reply));
    effects(|out| h.at(3, out).checked(C, READY));
    assert!(h.pending_arbitration(CHILDREN).is_some() && h.handover(CHILDREN).is_some());
    effects(|out| h.at(4, out).faulted(A, "hung".into()));
    assert_eq!(h.winner(CHILDREN), Some(B));
}

#[test]
fn r14_forcing_a_sleeping_schema_ends_the_force_on_its_sibling() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.at(1, out).checked(A, READY));
    effects(|out| h.at(2, out).operator(ANA, Operator::Force(B)).expect("healthy"));
    assert_eq!(h.winner(CHILDREN), Some(B));
    effects(|out| h.at(3, out).operator(ANA, Operator::Force(C)).expect("healthy"));
    assert_eq!((h.winner(CHILDREN), h.forced(CHILDREN)), (Some(A), None));
    effects(|out| h.at(4, out).wake(FATHER, C).expect("authority"));
    assert_eq!(h.winner(CHILDREN), Some(C));
}

#[test]
fn a_new_winner_is_taking_over_until_it_begins() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.at(1, out).checked(A, READY));
    assert!(h.is_taking(A) && !h.is_taking(B));
    assert!(h.at(2, &mut Vec::new()).begin(A));
    assert!(!h.is_taking(A));
}

#[test]
fn r4_a_father_that_the_machine_delayed_is_overruled_without_a_failure() {
    for excused in [false, true] {
        let mut h = family(Policy::FATHER);
        let out = effects(|out| {
            h.at(1, out).checked(A, READY);
            h.at(1, out).checked(B, READY);
            h.excuse(GroupId(99));
            if excused {
                h.excuse(CHILDREN);
            }
            let (due, timer) = h.timers().next().expect("the arbitration has a budget");
            assert_eq!(timer, Timer::Arbitration(CHILDREN));
            h.at(due, out).tick();
        });
        assert_eq!(h.winner(CHILDREN), Some(A), "the priority order decides");
        assert_eq!(*h.health(FATHER) == Health::Ok, excused, "{:?}", h.health(FATHER));
        let last = out.iter().rev().find_map(|effect| match effect {
            Effect::Decided(record) => Some(record.reason.to_string()),
            _ => None,
        });
        assert!(last.is_some_and(|reason| reason.starts_with("no answer within 5000 us")));
    }
}
