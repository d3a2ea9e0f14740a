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
        effects(|out| h.at(1, out).checked(A, READY));
        assert!(h.at(1, &mut Vec::new()).begin(A));
        if other {
            effects(|out| h.at(1, out).checked(B, READY));
        }
        let mut out = effects(|out| {
            h.at(2, out).faulted(A, "a fault".into());
            h.at(2, out).end(A);
        });
        if let Some(ticket) = h.pending_arbitration(CHILDREN) {
            let reply = ArbitrationReply::Chosen {
                child: Some(B),
                reason: "the only other one".into(),
            };
            out.extend(effects(|out| h.at(3, out).arbitrated(CHILDREN, ticket, reply)));
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
    effects(|out| h.at(1, out).checked(B, READY));
    assert!(h.at(1, &mut Vec::new()).begin(B));
    effects(|out| h.at(1, out).checked(A, READY));
    assert_eq!(h.handover(CHILDREN).and_then(|handover| handover.to), Some(A));
    let out = effects(|out| h.at(2, out).faulted(A, "a fault".into()));
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
        schemas: ["father", "a", "b", "c", "child"].map(schema).to_vec().into(),
        groups: vec![
            GroupSpec::new("roots", None, vec![FATHER]),
            GroupSpec::new("children", Some(FATHER), vec![A, B, C]),
            GroupSpec::new("below", Some(A), vec![child]),
        ]
        .into(),
    };
    spec.schemas[child].needs = vec![eye];
    spec.schemas.push(SchemaSpec::new("eye", Kind::Perceptive, 10));
    let mut h = Hierarchy::new(spec).expect("a valid specification");
    effects(|out| {
        h.at(0, out).start();
        h.at(0, out).checked(FATHER, READY);
        h.at(0, out).wake(FATHER, A).expect("authority");
        h.at(0, out).checked(A, READY);
        h.at(0, out).wake(A, child).expect("authority");
        h.at(0, out)
            .operator(ANA, Operator::Force(B))
            .expect("b is healthy");
    });
    assert!(h.is_awake(eye));
    effects(|out| h.at(1, out).wake(FATHER, B).expect("authority"));
    assert_eq!((h.winner(CHILDREN), h.is_awake(child)), (Some(B), false));
    assert!(!h.is_awake(eye), "no schema needs it");
}

#[test]
fn restarts_are_counted_within_a_time_window() {
    let mut spec = Spec {
        schemas: vec![SchemaSpec::new("eye", Kind::Perceptive, 10)].into(),
        groups: Vec::new().into(),
    };
    spec.schemas[SchemaId(0)].restart = Restart::OnFault {
        backoff: 10,
        limit: 2,
        within: 1_000,
    };
    let eye = SchemaId(0);
    let mut h = Hierarchy::new(spec).expect("a valid specification");
    effects(|out| {
        h.at(0, out).start();
        h.at(0, out)
            .operator(ANA, Operator::Play(eye))
            .expect("it is healthy");
    });
    let fault = |h: &mut Hierarchy, now| {
        effects(|out| h.at(now, out).faulted(eye, "again".into()));
        let due = h.next_timer();
        effects(|out| h.at(due.unwrap_or(now), out).tick());
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
        h.at(2_062, out)
            .operator(ANA, Operator::Play(eye))
            .expect("a faulted schema can be played")
    });
    assert_eq!((h.is_awake(eye), h.health(eye)), (true, &Health::Ok));
    assert_eq!(h.restarts_left(2_062, eye), Some(2));
    assert_eq!(fault(&mut h, 2_063), Some(2_073), "with the first back-off");
}

#[test]
fn r14_roots_that_are_stopped_before_the_start_wake_when_everything_goes_on() {
    let spec = Spec {
        schemas: vec![SchemaSpec::new("father", Kind::Motor, 10)].into(),
        groups: vec![GroupSpec::new("roots", None, vec![FATHER])].into(),
    };
    let mut h = Hierarchy::new(spec).expect("a valid specification");
    assert_eq!(
        effects(|out| h.at(0, out).stop_all(ANA).expect("it is not over")),
        []
    );
    let woken = Effect::Woken(FATHER);
    assert!(!effects(|out| h.at(0, out).start()).contains(&woken));
    let released = effects(|out| drop(h.at(1, out).release_all().expect("it runs")));
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
        schemas: ["father", "a", "b"].map(schema).to_vec().into(),
        groups: vec![roots, GroupSpec::new("children", Some(FATHER), vec![A])].into(),
    };
    let mut h = Hierarchy::new(spec).expect("a valid specification");
    effects(|out| {
        h.at(0, out).start();
        h.at(0, out).checked(FATHER, READY);
        h.at(0, out).checked(B, READY);
        assert!(h.at(1, out).begin(FATHER));
        h.at(1, out).wake(FATHER, A).expect("authority");
        h.at(1, out).checked(A, READY);
        assert!(h.at(1, out).begin(A));
    });
    let out = effects(|out| h.at(2, out).stop_all(ANA).expect("it runs"));
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
        effects(|out| h.at(3, out).stop_all(ANA).expect("it runs")).len(),
        1,
        "only a record"
    );
    // A schema that is released before its iteration has ended begins again after the end.
    let mut released = Vec::new();
    effects(|out| released = h.at(4, out).release_all().expect("it runs"));
    assert_eq!(released, [FATHER, B]);
    effects(|out| h.at(4, out).checked(FATHER, READY));
    assert!(!h.has_authority(FATHER));
    effects(|out| h.at(5, out).end(FATHER));
    effects(|out| h.at(6, out).checked(FATHER, READY));
    assert!(h.has_authority(FATHER));
}
