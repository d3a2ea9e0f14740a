//! Winners that lose without a check of their own: by a fault, by a stop of everything, or because a sibling was
//! woken.

use jde_core::{
    Absence, ArbitrationReply, Effect, GroupId, GroupSpec, Health, Hierarchy, Kind, Operator, Policy,
    Restart, SchemaId, SchemaSpec, Spec, State,
};

use crate::family::{A, ANA, B, C, CHILDREN, FATHER, READY, effects, family};

#[test]
fn r15_a_fault_of_the_winner_is_recorded_as_a_switch() {
    // With a successor, without one, and with a pending arbitration of the father.
    for (policy, other) in [
        (Policy::PRIORITY, true),
        (Policy::PRIORITY, false),
        (Policy::FATHER, true),
    ] {
        let mut h = family(policy);
        effects(|out| h.checked(1, A, READY, out));
        assert!(h.begin(1, A, &mut Vec::new()));
        if other {
            effects(|out| h.checked(1, B, READY, out));
        }
        let mut out = effects(|out| {
            h.faulted(2, A, "a fault".into(), out);
            h.end(2, A, out);
        });
        if let Some(ticket) = h.pending_arbitration(CHILDREN) {
            let reply = ArbitrationReply::Chosen {
                child: Some(B),
                reason: "the only other one".into(),
            };
            out.extend(effects(|out| h.arbitrated(3, CHILDREN, ticket, reply, out)));
        }
        let records = out.iter().filter_map(|effect| match effect {
            Effect::Decided(record) => Some((record.before, record.choice, record.changed)),
            _ => None,
        });
        let first = records.clone().next();
        assert_eq!(first, Some((Some(A), other.then_some(B), true)), "{policy:?}");
        assert_eq!(records.filter(|(.., changed)| *changed).count(), 1, "once");
    }
}

#[test]
fn r15_a_chosen_schema_that_faults_before_it_wins_is_recorded() {
    let mut h = family(Policy::PRIORITY);
    effects(|out| h.checked(1, B, READY, out));
    assert!(h.begin(1, B, &mut Vec::new()));
    effects(|out| h.checked(1, A, READY, out));
    assert_eq!(h.handover(CHILDREN).and_then(|handover| handover.to), Some(A));
    let out = effects(|out| h.faulted(2, A, "a fault".into(), out));
    let recorded = out.iter().any(|effect| {
        matches!(effect, Effect::Decided(record) if (record.before, record.choice) == (Some(A), Some(B)))
    });
    assert!(recorded, "{out:?}");
}

#[test]
fn r6_a_switch_caused_by_waking_a_child_puts_unneeded_schemas_to_sleep() {
    let schema = |name| SchemaSpec::new(name, Kind::Motor, 10);
    let (child, eye) = (SchemaId(4), SchemaId(5));
    let mut spec = Spec {
        schemas: ["father", "a", "b", "c", "child"].map(schema).to_vec(),
        groups: vec![
            GroupSpec::new("roots", None, vec![FATHER]),
            GroupSpec::new("children", Some(FATHER), vec![A, B, C]),
            GroupSpec::new("below", Some(A), vec![child]),
        ],
    };
    spec.schemas[4].needs = vec![eye];
    spec.schemas.push(SchemaSpec::new("eye", Kind::Perceptive, 10));
    let mut h = Hierarchy::new(spec).expect("a valid specification");
    effects(|out| {
        h.start(0, out);
        h.checked(0, FATHER, READY, out);
        h.wake(0, FATHER, A, out).expect("authority");
        h.checked(0, A, READY, out);
        h.wake(0, A, child, out).expect("authority");
        h.operator(0, ANA, Operator::Force(B), out).expect("b is healthy");
    });
    assert!(h.is_awake(eye));
    effects(|out| h.wake(1, FATHER, B, out).expect("authority"));
    assert_eq!((h.winner(CHILDREN), h.is_awake(child)), (Some(B), false));
    assert!(!h.is_awake(eye), "no schema needs it");
}

#[test]
fn restarts_are_counted_within_a_time_window() {
    let mut spec = Spec {
        schemas: vec![SchemaSpec::new("eye", Kind::Perceptive, 10)],
        groups: Vec::new(),
    };
    spec.schemas[0].restart = Restart::OnFault {
        backoff: 10,
        limit: 2,
        within: 1_000,
    };
    let eye = SchemaId(0);
    let mut h = Hierarchy::new(spec).expect("a valid specification");
    effects(|out| {
        h.start(0, out);
        h.operator(0, ANA, Operator::Play(eye), out)
            .expect("it is healthy");
    });
    let fault = |h: &mut Hierarchy, now| {
        effects(|out| h.faulted(now, eye, "again".into(), out));
        let due = h.next_timer();
        effects(|out| h.tick(due.unwrap_or(now), out));
        due
    };
    assert_eq!(h.restarts_left(0, eye), Some(2));
    // The schema restarts at 10 and at 120. It restarts again when the first restart is 1000 ago, and so on,
    // unless it fails more often.
    let dues = [0, 100, 1_010, 1_120, 2_040].map(|now| fault(&mut h, now));
    assert_eq!(dues, [10, 120, 1_030, 1_140, 2_060].map(Some));
    assert_eq!(h.restarts_left(2_060, eye), Some(0));
    assert_eq!(fault(&mut h, 2_061), None, "at most two restarts in 1000");
    assert!(!h.is_awake(eye));
    assert_eq!(h.restarts_left(2_061, eye), Some(0));
    effects(|out| {
        h.operator(2_062, ANA, Operator::Play(eye), out)
            .expect("a faulted schema can be played")
    });
    assert_eq!((h.is_awake(eye), h.health(eye)), (true, &Health::Ok));
    assert_eq!(h.restarts_left(2_062, eye), Some(2));
    assert_eq!(fault(&mut h, 2_063), Some(2_073), "with the first back-off");
}

#[test]
fn r14_roots_that_are_stopped_before_the_start_wake_when_everything_goes_on() {
    let spec = Spec {
        schemas: vec![SchemaSpec::new("father", Kind::Motor, 10)],
        groups: vec![GroupSpec::new("roots", None, vec![FATHER])],
    };
    let mut h = Hierarchy::new(spec).expect("a valid specification");
    assert_eq!(
        effects(|out| h.stop_all(0, ANA, out).expect("it is not over")),
        []
    );
    let woken = Effect::Woken(FATHER);
    assert!(!effects(|out| h.start(0, out)).contains(&woken));
    let released = effects(|out| drop(h.release_all(1, out).expect("it runs")));
    assert!(released.contains(&woken));
}

#[test]
fn r14_stop_all_is_one_transaction_and_brakes_groups_that_would_hold() {
    let schema = |name| SchemaSpec::new(name, Kind::Motor, 10);
    let roots = GroupSpec {
        absence: Absence::Hold { for_: 1_000 },
        ..GroupSpec::new("roots", None, vec![FATHER, B])
    };
    let spec = Spec {
        schemas: ["father", "a", "b"].map(schema).to_vec(),
        groups: vec![roots, GroupSpec::new("children", Some(FATHER), vec![A])],
    };
    let mut h = Hierarchy::new(spec).expect("a valid specification");
    effects(|out| {
        h.start(0, out);
        h.checked(0, FATHER, READY, out);
        h.checked(0, B, READY, out);
        assert!(h.begin(1, FATHER, out));
        h.wake(1, FATHER, A, out).expect("authority");
        h.checked(1, A, READY, out);
        assert!(h.begin(1, A, out));
    });
    let out = effects(|out| h.stop_all(2, ANA, out).expect("it runs"));
    let [father, a, b] = [FATHER, A, B].map(|id| (h.state(id), h.has_authority(id)));
    assert_eq!(
        [father, a, b],
        [(State::Slept, false); 3],
        "also schemas inside an iteration"
    );
    assert!(out.contains(&Effect::Brake { group: GroupId(0) }));
    assert!(
        !out.iter()
            .any(|effect| matches!(effect, Effect::Hold { .. } | Effect::Promoted(_)))
    );
    let record = out.iter().find_map(|effect| match effect {
        Effect::Decided(record) => Some((record.before, record.choice, record.changed)),
        _ => None,
    });
    assert_eq!(record, Some((Some(FATHER), None, true)));
    assert_eq!(
        effects(|out| h.stop_all(3, ANA, out).expect("it runs")).len(),
        1,
        "only a record"
    );
    // A schema that is released before its iteration has ended begins again after the end.
    let mut released = Vec::new();
    effects(|out| released = h.release_all(4, out).expect("it runs"));
    assert_eq!(released, [FATHER, B]);
    effects(|out| h.checked(4, FATHER, READY, out));
    assert!(!h.has_authority(FATHER));
    effects(|out| h.end(5, FATHER, out));
    effects(|out| h.checked(6, FATHER, READY, out));
    assert!(h.has_authority(FATHER));
}
