//! What the stories omit: unknown identifiers, late calls, calls in the wrong order.
//!
//! It refuses to repeat what the random tests check for every order of calls.

use jde_core::{
    ArbitrationReply, Check, Effect, GroupId, GroupSpec, Health, Hierarchy, Kind, Operator, Policy, Refused,
    SchemaId, SchemaSpec, Spec, State, Timer,
};

use crate::family::{A, B, C, CHILDREN, FATHER, READY, effects, family};

const NOBODY: SchemaId = SchemaId(99);

#[test]
fn calls_about_nobody_are_refused_or_have_no_effect() {
    let mut h = family(Policy::PRIORITY);
    let before = h.clone();
    let out = effects(|out| {
        h.checked(1, NOBODY, READY, out);
        assert!(!h.begin(1, NOBODY, out));
        h.end(1, NOBODY, out);
        h.faulted(1, NOBODY, "?".into(), out);
        h.restored(1, NOBODY, out);
        h.overrun(NOBODY, out);
        h.on_time(NOBODY, out);
        h.set_period(NOBODY, 5);
        h.arbitrated(
            1,
            GroupId(99),
            1,
            ArbitrationReply::Failed { reason: "?".into() },
            out,
        );
        h.fire(1, Timer::Hold(GroupId(99)), out);
        assert_eq!(h.set_policy(1, GroupId(99), Policy::FATHER, out), Ok(()));
        assert_eq!(h.wake(1, NOBODY, A, out), Err(Refused::Unknown { index: 99 }));
        assert_eq!(
            h.sleep(1, FATHER, NOBODY, out),
            Err(Refused::Unknown { index: 99 })
        );
        assert_eq!(
            h.operator(1, Operator::Force(NOBODY), out),
            Err(Refused::Unknown { index: 99 })
        );
    });
    assert_eq!(out, []);
    assert_eq!(h, before);
    assert!(!h.is_taking(NOBODY) && !h.is_awake(NOBODY) && !h.has_authority(NOBODY));
    assert_eq!(
        (h.state(NOBODY), h.father(NOBODY), h.winner(GroupId(99))),
        (State::Slept, None, None)
    );
}

#[test]
fn nothing_wakes_before_the_start_and_a_second_start_changes_nothing() {
    let mut h = Hierarchy::new(family(Policy::PRIORITY).spec().clone()).expect("a sound specification");
    let out = effects(|out| {
        assert_eq!(h.operator(0, Operator::Play(A), out), Err(Refused::NotRunning));
        assert_eq!(h.wake(0, FATHER, A, out), Err(Refused::NotRunning));
    });
    assert_eq!(out, []);
    assert!(!effects(|out| h.start(0, out)).is_empty());
    assert_eq!(effects(|out| h.start(1, out)), []);
}

#[test]
fn a_check_of_one_asleep_and_the_end_of_nothing_have_no_effect() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.sleep(1, FATHER, A, out).expect("authority"));
    let before = h.clone();
    assert_eq!(effects(|out| h.checked(2, A, READY, out)), []);
    assert_eq!(effects(|out| h.end(2, B, out)), []);
    assert_eq!(h, before);
}

#[test]
fn r4_an_answer_to_an_old_question_has_no_effect() {
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
fn r4_one_that_fell_asleep_while_the_father_thought_is_not_its_fault() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.checked(1, A, READY, out));
    effects(|out| h.checked(1, B, READY, out));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    effects(|out| h.faulted(2, B, "gone".into(), out));
    let answer = ArbitrationReply::Chosen {
        child: Some(B),
        reason: "it was there".into(),
    };
    effects(|out| h.arbitrated(3, CHILDREN, ticket, answer, out));
    assert_eq!((h.winner(CHILDREN), h.health(FATHER)), (Some(A), &Health::Ok));
}

#[test]
fn r4_a_father_is_not_asked_again_without_a_new_trigger() {
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
    let nobody = ArbitrationReply::Chosen {
        child: None,
        reason: "wait".into(),
    };
    let out = effects(|out| h.arbitrated(2, CHILDREN, ticket, nobody, out));
    assert!(!out.iter().any(|e| matches!(e, Effect::Arbitrate { .. })));
    assert!(out.contains(&Effect::Brake { group: CHILDREN }));
}

#[test]
fn r1_a_force_does_not_wait_for_the_father() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.checked(1, A, READY, out));
    effects(|out| h.checked(1, B, READY, out));
    assert!(h.pending_arbitration(CHILDREN).is_some());
    effects(|out| h.operator(2, Operator::Force(B), out).expect("b is healthy"));
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
fn a_second_report_of_a_fault_is_the_same_fault() {
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
fn an_overrun_is_noted_once_and_hides_nothing_worse() {
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
fn a_check_that_brings_nothing_new_has_no_effect() {
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
    let nobody = ArbitrationReply::Chosen {
        child: None,
        reason: "neither".into(),
    };
    effects(|out| h.arbitrated(2, CHILDREN, ticket, nobody, out));
    assert_eq!(h.winner(CHILDREN), Some(A), "it iterates still");
    effects(|out| h.fire(9, Timer::Patience(CHILDREN), out));
    assert_eq!(h.winner(CHILDREN), Some(B), "it is alone now");
}

#[test]
fn r2_what_changed_below_a_father_on_its_way_out_counts_once_it_stays() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.checked(1, B, READY, out));
    assert!(h.begin(1, B, &mut Vec::new()));
    // The father is being replaced, but its child iterates. Meanwhile the child stops being READY.
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
fn r10_a_winner_that_was_put_to_sleep_begins_no_other_iteration_while_the_father_thinks() {
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
fn r5_a_handover_to_one_that_fell_asleep_goes_to_nobody_until_the_father_has_answered() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.wake(0, FATHER, C, out).expect("authority"));
    effects(|out| h.checked(1, A, READY, out));
    assert!(h.begin(1, A, &mut Vec::new()));
    effects(|out| h.checked(1, B, READY, out));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    let answer = ArbitrationReply::Chosen {
        child: Some(B),
        reason: "b".into(),
    };
    effects(|out| h.arbitrated(2, CHILDREN, ticket, answer, out));
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
    let mut h = Hierarchy::new(spec).expect("a sound specification");
    effects(|out| h.start(0, out));
    for id in [SchemaId(1), SchemaId(2)] {
        effects(|out| h.operator(1, Operator::Play(id), out).expect("healthy"));
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
fn r4_an_answer_that_came_too_late_for_its_child_changes_nothing() {
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
    let answer = ArbitrationReply::Chosen {
        child: Some(B),
        reason: "b".into(),
    };
    let out = effects(|out| h.arbitrated(3, CHILDREN, ticket, answer, out));
    assert!(!out.contains(&Effect::Demoted(A)) && !out.contains(&Effect::Promoted(B)));
    assert_eq!((h.winner(CHILDREN), h.health(FATHER)), (Some(A), &Health::Ok));
}

#[test]
fn r5_a_fault_below_a_father_on_its_way_out_lets_it_go_at_once() {
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
fn r1_a_place_that_was_promised_is_taken_when_the_loser_faults_while_the_father_thinks() {
    let mut h = family(Policy::FATHER);
    effects(|out| h.wake(0, FATHER, C, out).expect("authority"));
    effects(|out| h.checked(1, A, READY, out));
    assert!(h.begin(1, A, &mut Vec::new()));
    effects(|out| h.checked(1, B, READY, out));
    let ticket = h.pending_arbitration(CHILDREN).expect("a collision");
    let answer = ArbitrationReply::Chosen {
        child: Some(B),
        reason: "b".into(),
    };
    effects(|out| h.arbitrated(2, CHILDREN, ticket, answer, out));
    effects(|out| h.checked(3, C, READY, out));
    assert!(h.pending_arbitration(CHILDREN).is_some() && h.handover(CHILDREN).is_some());
    effects(|out| h.faulted(4, A, "hung".into(), out));
    assert_eq!(h.winner(CHILDREN), Some(B));
}

#[test]
fn r14_forcing_a_sleeper_takes_back_the_force_on_its_sibling() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.checked(1, A, READY, out));
    effects(|out| h.operator(2, Operator::Force(B), out).expect("healthy"));
    assert_eq!(h.winner(CHILDREN), Some(B));
    effects(|out| h.operator(3, Operator::Force(C), out).expect("healthy"));
    assert_eq!((h.winner(CHILDREN), h.forced(CHILDREN)), (Some(A), Some(C)));
    effects(|out| h.wake(4, FATHER, C, out).expect("authority"));
    assert_eq!(h.winner(CHILDREN), Some(C));
}

#[test]
fn a_new_winner_is_taking_its_place_until_it_begins() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.checked(1, A, READY, out));
    assert!(h.is_taking(A) && !h.is_taking(B));
    assert!(h.begin(2, A, &mut Vec::new()));
    assert!(!h.is_taking(A));
}

#[test]
fn r4_a_father_whom_the_machine_held_up_is_overruled_and_not_blamed() {
    for excused in [false, true] {
        let mut h = family(Policy::FATHER);
        let out = effects(|out| {
            h.checked(1, A, READY, out);
            h.checked(1, B, READY, out);
            h.excuse(GroupId(99));
            if excused {
                h.excuse(CHILDREN);
            }
            let (due, timer) = h.timers().next().expect("it is being asked");
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
