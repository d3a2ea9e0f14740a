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
        h.checked(1, UNKNOWN, READY, out);
        assert!(!h.begin(1, UNKNOWN, out));
        h.end(1, UNKNOWN, out);
        h.faulted(1, UNKNOWN, "?".into(), out);
        h.restored(1, UNKNOWN, out);
        h.overrun(UNKNOWN, out);
        h.on_time(UNKNOWN, out);
        h.set_period(UNKNOWN, 5);
        h.arbitrated(
            1,
            GroupId(99),
            1,
            ArbitrationReply::Failed { reason: "?".into() },
            out,
        );
        h.fire(1, Timer::Hold(GroupId(99)), out);
        assert_eq!(h.set_policy(1, GroupId(99), Policy::FATHER, out), Ok(()));
        assert_eq!(h.wake(1, UNKNOWN, A, out), Err(Refused::Unknown { index: 99 }));
        assert_eq!(
            h.sleep(1, FATHER, UNKNOWN, out),
            Err(Refused::Unknown { index: 99 })
        );
        assert_eq!(
            h.operator(1, ANA, Operator::Force(UNKNOWN), out),
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
            h.operator(0, ANA, Operator::Play(A), out),
            Err(Refused::NotRunning)
        );
        assert_eq!(h.wake(0, FATHER, A, out), Err(Refused::NotRunning));
    });
    assert_eq!(out, []);
    assert!(!effects(|out| h.start(0, out)).is_empty());
    assert_eq!(effects(|out| h.start(1, out)), []);
}

#[test]
fn a_check_of_a_sleeping_schema_and_an_end_without_a_begin_have_no_effect() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.sleep(1, FATHER, A, out).expect("authority"));
    let before = h.clone();
    assert_eq!(effects(|out| h.checked(2, A, READY, out)), []);
    assert_eq!(effects(|out| h.end(2, B, out)), []);
    assert_eq!(h, before);
}

#[test]
fn r4_a_reply_to_an_old_arbitration_has_no_effect() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.checked(1, A, READY, out));
    effects(|out| h.checked(1, B, READY, out));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    effects(|out| h.tick(h.next_timer().expect("a budget"), out));
    assert_eq!(
        (h.winner(CHILDREN), h.pending_arbitration(CHILDREN)),
        (Some(A), None)
    );
    let late = ArbitrationReply::Chosen {
        child: Some(B),
        reason: "late".into(),
    };
    assert_eq!(effects(|out| h.arbitrated(9, CHILDREN, ticket, late, out)), []);
    assert_eq!(h.winner(CHILDREN), Some(A));
}

#[test]
fn r4_choosing_a_child_that_fell_asleep_during_the_arbitration_is_not_a_failure() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.checked(1, A, READY, out));
    effects(|out| h.checked(1, B, READY, out));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    effects(|out| h.faulted(2, B, "gone".into(), out));
    let reply = ArbitrationReply::Chosen {
        child: Some(B),
        reason: "it was ready".into(),
    };
    effects(|out| h.arbitrated(3, CHILDREN, ticket, reply, out));
    assert_eq!((h.winner(CHILDREN), h.health(FATHER)), (Some(A), &Health::Ok));
}

#[test]
fn r4_no_second_arbitration_begins_without_a_new_trigger() {
    let mut h = family(Policy::FATHER);
    effects(|out| {
        h.checked(
            1,
            A,
            Check {
                ready: false,
                ..READY
            },
            out,
        )
    });
    let out = effects(|out| {
        h.checked(
            1,
            B,
            Check {
                ready: false,
                ..READY
            },
            out,
        )
    });
    assert!(matches!(out.last(), Some(Effect::Arbitrate { .. })));
    let ticket = h.pending_arbitration(CHILDREN).expect("an absence");
    let no_choice = ArbitrationReply::Chosen {
        child: None,
        reason: "wait".into(),
    };
    let out = effects(|out| h.arbitrated(2, CHILDREN, ticket, no_choice, out));
    assert!(!out.iter().any(|e| matches!(e, Effect::Arbitrate { .. })));
    assert!(out.contains(&Effect::Brake { group: CHILDREN }));
}

#[test]
fn r1_a_force_does_not_wait_for_the_fathers_arbitration() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.checked(1, A, READY, out));
    effects(|out| h.checked(1, B, READY, out));
    assert!(h.pending_arbitration(CHILDREN).is_some());
    effects(|out| h.operator(2, ANA, Operator::Force(B), out).expect("b is healthy"));
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
        effects(|out| h.faulted(now, A, "again".into(), out));
        let due = h.next_timer().expect("a restart");
        let doubled = 1u64
            .checked_shl(fault)
            .map_or(u64::MAX, |factor| factor.saturating_mul(10));
        assert_eq!(due, now.saturating_add(doubled));
        now = due;
        effects(|out| h.tick(now, out));
        assert_eq!(h.restarts_left(now, A), Some(u32::MAX - fault - 1));
    }
}

#[test]
fn a_second_report_of_a_fault_has_no_effect() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.faulted(1, A, "hung".into(), out));
    let before = h.clone();
    assert_eq!(
        effects(|out| h.faulted(2, A, "and then it panicked".into(), out)),
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
    assert_eq!(effects(|out| h.overrun(A, out)), [late]);
    assert_eq!(effects(|out| h.overrun(A, out)), []);
    assert_eq!(
        effects(|out| h.on_time(A, out)),
        [Effect::Health {
            id: A,
            health: Health::Ok
        }]
    );
    effects(|out| h.faulted(1, A, "a fault".into(), out));
    assert_eq!(effects(|out| h.overrun(A, out)), []);
    assert_eq!(effects(|out| h.on_time(A, out)), []);
    assert_eq!(h.health(A), &Health::Faulted("a fault".into()));
}

#[test]
fn a_check_without_a_change_has_no_effect() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.checked(1, A, READY, out));
    assert_eq!(effects(|out| h.checked(2, A, READY, out)), []);
}

#[test]
fn r3_a_loser_that_hangs_is_no_longer_ready_so_the_level_selects_again() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.checked(1, A, READY, out));
    assert!(h.begin(1, A, &mut Vec::new()));
    effects(|out| h.checked(1, B, READY, out));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    let no_choice = ArbitrationReply::Chosen {
        child: None,
        reason: "neither".into(),
    };
    effects(|out| h.arbitrated(2, CHILDREN, ticket, no_choice, out));
    assert_eq!(h.winner(CHILDREN), Some(A), "a still iterates");
    effects(|out| h.fire(9, Timer::Patience(CHILDREN), out));
    assert_eq!(h.winner(CHILDREN), Some(B), "only b is ready");
}

#[test]
fn r2_changes_below_a_father_that_is_being_replaced_take_effect_when_it_stays() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.checked(1, B, READY, out));
    assert!(h.begin(1, B, &mut Vec::new()));
    // The father is being replaced while its child iterates. The child stops being READY in the meantime.
    effects(|out| {
        h.checked(
            2,
            FATHER,
            Check {
                ready: false,
                ..READY
            },
            out,
        )
    });
    effects(|out| {
        h.checked(
            2,
            B,
            Check {
                ready: false,
                ..READY
            },
            out,
        )
    });
    assert_eq!((h.winner(CHILDREN), h.handover(CHILDREN)), (Some(B), None));
    effects(|out| h.checked(3, FATHER, READY, out));
    let handover = h.handover(CHILDREN).expect("b is not ready any more");
    assert_eq!(handover.to, None);
}

#[test]
fn r10_a_winner_that_was_put_to_sleep_begins_no_iteration_during_an_arbitration() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.checked(1, A, READY, out));
    effects(|out| h.checked(1, B, READY, out));
    assert_eq!(
        (h.winner(CHILDREN), h.pending_arbitration(CHILDREN).is_some()),
        (Some(A), true)
    );
    effects(|out| h.sleep(2, FATHER, A, out).expect("authority"));
    assert_eq!(h.state(A), State::Winner);
    assert!(!h.begin(2, A, &mut Vec::new()));
}

#[test]
fn r2_a_loser_whose_last_iteration_finds_no_value_causes_a_selection() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.checked(1, A, READY, out));
    assert!(h.begin(1, A, &mut Vec::new()));
    effects(|out| h.checked(1, B, READY, out));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    let reply = ArbitrationReply::Chosen {
        child: None,
        reason: "nobody".into(),
    };
    effects(|out| h.arbitrated(2, CHILDREN, ticket, reply, out));
    assert_eq!(h.handover(CHILDREN).map(|handover| handover.to), Some(None));
    effects(|out| h.end_unready(3, A, out));
    assert_eq!(
        (h.state(A), h.winner(CHILDREN)),
        (State::Checking, Some(B)),
        "R3: B is the only one that is READY"
    );
}

#[test]
fn r5_a_handover_to_a_child_that_fell_asleep_leaves_no_winner_until_the_father_replies() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.wake(0, FATHER, C, out).expect("authority"));
    effects(|out| h.checked(1, A, READY, out));
    assert!(h.begin(1, A, &mut Vec::new()));
    effects(|out| h.checked(1, B, READY, out));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    let reply = ArbitrationReply::Chosen {
        child: Some(B),
        reason: "b".into(),
    };
    effects(|out| h.arbitrated(2, CHILDREN, ticket, reply, out));
    effects(|out| h.checked(3, C, READY, out));
    assert_eq!(h.handover(CHILDREN).and_then(|handover| handover.to), Some(B));
    assert!(h.pending_arbitration(CHILDREN).is_some());
    effects(|out| h.faulted(4, B, "gone".into(), out));
    effects(|out| h.end(5, A, out));
    assert_eq!(
        (h.state(A), h.state(B), h.winner(CHILDREN)),
        (State::Ready, State::Slept, None)
    );
}

#[test]
fn r7_a_played_winner_below_a_played_winner_has_no_authority_while_the_root_does_not_win() {
    let schema = |name| SchemaSpec::new(name, Kind::Motor, 10);
    let spec = Spec {
        schemas: ["root", "father", "child"].map(schema).to_vec(),
        groups: vec![
            GroupSpec::new("roots", None, vec![SchemaId(0)]),
            GroupSpec::new("middle", Some(SchemaId(0)), vec![SchemaId(1)]),
            GroupSpec::new("bottom", Some(SchemaId(1)), vec![SchemaId(2)]),
        ],
    };
    let mut h = Hierarchy::new(spec).expect("a valid specification");
    effects(|out| h.start(0, out));
    for id in [SchemaId(1), SchemaId(2)] {
        effects(|out| h.operator(1, ANA, Operator::Play(id), out).expect("healthy"));
        effects(|out| h.checked(1, id, READY, out));
        assert_eq!((h.state(id), h.has_authority(id)), (State::Winner, false));
    }
    let out = effects(|out| h.checked(2, SchemaId(0), READY, out));
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
    effects(|out| h.checked(1, A, READY, out));
    effects(|out| h.checked(1, B, READY, out));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    effects(|out| {
        h.checked(
            2,
            B,
            Check {
                ready: false,
                ..READY
            },
            out,
        )
    });
    let reply = ArbitrationReply::Chosen {
        child: Some(B),
        reason: "b".into(),
    };
    let out = effects(|out| h.arbitrated(3, CHILDREN, ticket, reply, out));
    assert!(!out.contains(&Effect::Demoted(A)) && !out.contains(&Effect::Promoted(B)));
    assert_eq!((h.winner(CHILDREN), h.health(FATHER)), (Some(A), &Health::Ok));
}

#[test]
fn r5_a_fault_below_a_father_that_is_being_replaced_ends_its_handover_at_once() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.checked(1, B, READY, out));
    assert!(h.begin(1, B, &mut Vec::new()));
    effects(|out| {
        h.checked(
            2,
            FATHER,
            Check {
                ready: false,
                ..READY
            },
            out,
        )
    });
    assert_eq!(h.state(FATHER), State::Winner);
    effects(|out| h.faulted(3, B, "hung".into(), out));
    assert_eq!(h.state(FATHER), State::Checking);
}

#[test]
fn r1_the_chosen_child_wins_when_the_loser_faults_during_another_arbitration() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.wake(0, FATHER, C, out).expect("authority"));
    effects(|out| h.checked(1, A, READY, out));
    assert!(h.begin(1, A, &mut Vec::new()));
    effects(|out| h.checked(1, B, READY, out));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    let reply = ArbitrationReply::Chosen {
        child: Some(B),
        reason: "b".into(),
    };
    effects(|out| h.arbitrated(2, CHILDREN, ticket, reply, out));
    effects(|out| h.checked(3, C, READY, out));
    assert!(h.pending_arbitration(CHILDREN).is_some() && h.handover(CHILDREN).is_some());
    effects(|out| h.faulted(4, A, "hung".into(), out));
    assert_eq!(h.winner(CHILDREN), Some(B));
}

#[test]
fn r14_forcing_a_sleeping_schema_ends_the_force_on_its_sibling() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.checked(1, A, READY, out));
    effects(|out| h.operator(2, ANA, Operator::Force(B), out).expect("healthy"));
    assert_eq!(h.winner(CHILDREN), Some(B));
    effects(|out| h.operator(3, ANA, Operator::Force(C), out).expect("healthy"));
    assert_eq!((h.winner(CHILDREN), h.forced(CHILDREN)), (Some(A), None));
    effects(|out| h.wake(4, FATHER, C, out).expect("authority"));
    assert_eq!(h.winner(CHILDREN), Some(C));
}

#[test]
fn a_new_winner_is_taking_over_until_it_begins() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.checked(1, A, READY, out));
    assert!(h.is_taking(A) && !h.is_taking(B));
    assert!(h.begin(2, A, &mut Vec::new()));
    assert!(!h.is_taking(A));
}

#[test]
fn r4_a_father_that_the_machine_delayed_is_overruled_without_a_failure() {
    for excused in [false, true] {
        let mut h = family(Policy::FATHER);
        let out = effects(|out| {
            h.checked(1, A, READY, out);
            h.checked(1, B, READY, out);
            h.excuse(GroupId(99));
            if excused {
                h.excuse(CHILDREN);
            }
            let (due, timer) = h.timers().next().expect("the arbitration has a budget");
            assert_eq!(timer, Timer::Arbitration(CHILDREN));
            h.tick(due, out);
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
