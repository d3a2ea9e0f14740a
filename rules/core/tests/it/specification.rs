//! Specifications: all their errors are reported at once before the start; and the arithmetic of contracts.

use std::time::Duration;

use jde_core::{
    Absence, GroupContract, GroupId, GroupSpec, Hierarchy, Kind, Policy, SchemaId, SchemaSpec, Spec,
    SpecError, TakeoverBound, contract,
};

const MS: u64 = 1_000_000;
const LASER: SchemaId = SchemaId(0);
const EXAMPLE: SchemaId = SchemaId(1);
const STOP: SchemaId = SchemaId(2);
const GOON: SchemaId = SchemaId(3);
const ROOTS: GroupId = GroupId(0);
const MOTION: GroupId = GroupId(1);

fn valid() -> Spec {
    let motor = |name| SchemaSpec {
        needs: vec![LASER],
        ..SchemaSpec::new(name, Kind::Motor, 75 * MS)
    };
    Spec {
        schemas: vec![
            SchemaSpec::new("laser", Kind::Perceptive, 100 * MS),
            motor("example"),
            motor("stop"),
            motor("goon"),
        ]
        .into(),
        groups: vec![
            GroupSpec::new("roots", None, vec![EXAMPLE]),
            GroupSpec::new("motion", Some(EXAMPLE), vec![STOP, GOON]),
        ]
        .into(),
    }
}

/// Returns the faults of a valid specification after a change.
fn faults(change: impl FnOnce(&mut Spec)) -> Vec<SpecError> {
    let mut spec = valid();
    change(&mut spec);
    Hierarchy::new(spec).err().unwrap_or_default()
}

#[test]
fn a_valid_specification_has_no_faults() {
    assert_eq!(faults(|_| {}), []);
    assert_eq!(Spec::default().validate(), Ok(()));
}

#[test]
fn r3_a_schema_in_two_groups_or_twice_in_one_is_refused() {
    let expected = SpecError::TwoFathers {
        schema: "stop".into(),
        first: "roots".into(),
        second: "motion".into(),
    };
    assert_eq!(faults(|s| s.groups[ROOTS].members.push(STOP)), [expected]);
    let twice = faults(|s| s.groups[MOTION].members.push(GOON));
    assert!(matches!(twice.as_slice(), [SpecError::TwoFathers { .. }]));
}

#[test]
fn a_motor_schema_without_a_group_is_refused() {
    assert_eq!(
        faults(|s| s.groups[MOTION].members.truncate(1)),
        [SpecError::NoGroup {
            schema: "goon".into()
        }]
    );
}

#[test]
fn only_motor_schemas_compete_and_have_children() {
    let expected = SpecError::PerceptiveMember {
        schema: "laser".into(),
        group: "motion".into(),
    };
    assert_eq!(faults(|s| s.groups[MOTION].members.push(LASER)), [expected]);
    let expected = SpecError::PerceptiveFather {
        schema: "laser".into(),
        group: "motion".into(),
    };
    assert_eq!(faults(|s| s.groups[MOTION].father = Some(LASER)), [expected]);
}

#[test]
fn r6_only_perceptive_schemas_can_be_needed() {
    let expected = SpecError::MotorNeeded {
        schema: "laser".into(),
        needs: "goon".into(),
    };
    assert_eq!(faults(|s| s.schemas[LASER].needs.push(GOON)), [expected]);
}

#[test]
fn cycles_of_fathers_and_of_needs_are_reported() {
    let of_fathers = faults(|s| s.groups[ROOTS].father = Some(GOON));
    let path = ["example", "goon", "example"].map(String::from).to_vec();
    assert_eq!(of_fathers, [SpecError::FatherCycle { path }]);
    let of_needs = faults(|s| s.schemas[LASER].needs.push(LASER));
    let path = ["laser", "laser"].map(String::from).to_vec();
    assert_eq!(of_needs, [SpecError::NeedCycle { path }]);
}

#[test]
fn needs_that_join_again_without_a_cycle_are_valid() {
    let diamond = faults(|s| {
        for name in ["walls", "doors", "map"] {
            s.schemas.push(SchemaSpec::new(name, Kind::Perceptive, MS));
        }
        s.schemas[SchemaId(4)].needs = vec![LASER];
        s.schemas[SchemaId(5)].needs = vec![LASER];
        s.schemas[SchemaId(6)].needs = vec![SchemaId(4), SchemaId(5)];
    });
    assert_eq!(diamond, []);
}

#[test]
fn invalid_policies_are_refused() {
    let motion = || "motion".to_owned();
    let with = |policy| faults(|s| s.groups[MOTION].policy = policy);
    assert_eq!(
        with(Policy::round_robin(Duration::ZERO)),
        [SpecError::BadParameter {
            group: motion(),
            key: "turn",
            expected: "a time above 0"
        }]
    );
    for hysteresis in [-0.1, f64::NAN, f64::INFINITY] {
        assert_eq!(
            with(Policy::sticky(Duration::ZERO, hysteresis)),
            [SpecError::BadParameter {
                group: motion(),
                key: "hysteresis",
                expected: "a finite number, 0 or more"
            }]
        );
    }
    assert_eq!(with(Policy::FATHER), []);
    let roots = faults(|s| s.groups[ROOTS].policy = Policy::FATHER);
    assert_eq!(
        roots,
        [SpecError::NoArbitrator {
            group: "roots".into()
        }]
    );
    let not_a_member = faults(|s| s.groups[MOTION].absence = Absence::Fallback(EXAMPLE));
    assert_eq!(
        not_a_member,
        [SpecError::FallbackNotMember {
            group: motion(),
            fallback: "example".into()
        }]
    );
}

#[test]
fn an_invalid_policy_is_refused_at_run_time() {
    let mut h = Hierarchy::new(valid()).expect("valid");
    let refused = h.at(0, &mut Vec::new()).set_policy(ROOTS, Policy::FATHER);
    assert_eq!(
        refused,
        Err(SpecError::NoArbitrator {
            group: "roots".into()
        })
    );
    assert_eq!(h.spec(), &valid());
}

#[test]
fn all_faults_are_reported_at_once_with_a_remedy() {
    let all = faults(|s| {
        s.schemas[SchemaId(3)].name = "stop".into();
        s.schemas[SchemaId(2)].period = 0;
        s.schemas[SchemaId(2)].needs.push(SchemaId(9));
        s.groups[MOTION].members.push(SchemaId(8));
        s.groups.push(GroupSpec::new("empty", None, vec![]));
    });
    let messages: Vec<String> = all.iter().map(ToString::to_string).collect();
    let expected = [
        "two schemas are called `stop`: give each its own name",
        "`stop` has a period of 0: give a time above 0",
        "`stop` names schema number 9, which does not exist: name a listed one",
        "`motion` names schema number 8, which does not exist: name a listed one",
        "the group `empty` has no members: list a motor schema or remove the group",
    ];
    assert_eq!(messages, expected);
}

/// Returns the contract of the group of stop and goon.
fn motion_contract(spec: &Spec) -> GroupContract {
    contract(spec).swap_remove(1)
}

#[test]
fn r17_the_slowest_check_and_the_slowest_first_action_may_be_of_two_schemas() {
    let mut spec = valid();
    spec.schemas[STOP].period = 200 * MS;
    spec.schemas[STOP].budget = 10 * MS;
    spec.schemas[GOON].budget = 20 * MS;
    let motion = motion_contract(&spec);
    assert_eq!((motion.by_check.slowest, motion.total()), (GOON, 235 * MS));
    assert_eq!(
        motion.to_string(),
        "motion: goon takes over within 235 ms = period of stop 200 ms + check by stop 10 ms + patience with the loser 5 ms \
         + check of goon before it acts 20 ms"
    );
}

#[test]
fn r17_the_contract_of_a_triggered_schema_includes_a_turn_under_way() {
    let mut spec = valid();
    for id in [STOP, GOON] {
        spec.schemas[id].budget = 20 * MS;
        spec.schemas[id].triggered = true;
    }
    spec.schemas[GOON].panel = true;
    assert_eq!(
        motion_contract(&spec).to_string(),
        "motion: goon takes over within 145 ms = turn of goon that is under way 20 ms \
         + drawing of the panel of goon and a gesture on it 40 ms + check by goon 20 ms + patience with the loser 5 ms \
         + drawing of the panel of goon and a gesture on it 40 ms \
         + check of goon before it acts 20 ms"
    );
}

#[test]
fn r17_the_contract_includes_a_second_arbitration_and_its_delay_of_the_father() {
    let mut spec = valid();
    spec.groups[MOTION].policy = Policy::FATHER;
    spec.groups[MOTION].budget = 7 * MS;
    assert_eq!(
        motion_contract(&spec).to_string(),
        "motion: stop takes over within 94 ms = period of stop 75 ms + arbitration that is under way 7 ms \
         + arbitration by the father 7 ms + patience with the loser 5 ms\n  \
         motion, by urgency alone: stop takes over within 169 ms = period of stop 75 ms + period of the winner goon 75 ms \
         + arbitration that is under way 7 ms + arbitration by the father 7 ms + patience with the loser 5 ms"
    );
    let roots = &contract(&spec)[0];
    assert_eq!(
        roots.to_string(),
        "roots: example takes over within 108 ms = period of example 75 ms + arbitrations by example 14 ms \
         + patience with the loser 5 ms + arbitrations by example 14 ms"
    );
}

#[test]
fn r17_urgency_alone_waits_for_the_winners_iteration() {
    let mut spec = valid();
    spec.groups[MOTION].policy = Policy::URGENCY;
    spec.schemas[GOON].period = 300 * MS;
    spec.schemas[GOON].triggered = true;
    spec.schemas[GOON].budget = 10 * MS;
    let motion = motion_contract(&spec);
    assert_eq!(
        motion.allowed(),
        (75 + 5 + 10) * MS,
        "the measured latency begins after the wait"
    );
    let by_winner = motion.by_winner.expect("urgency counts");
    assert_eq!(
        (by_winner.slowest, by_winner.total()),
        (STOP, (75 + 300 + 10 + 5) * MS),
        "the winner goon does not take over from itself"
    );
    spec.groups[MOTION].members.truncate(1);
    assert_eq!(motion_contract(&spec).by_winner, None, "no other schema can win");
}

#[test]
fn r17_the_contract_includes_dwell_times_and_turns() {
    let mut spec = valid();
    let sticky = |dwell| Policy::sticky(Duration::from_nanos(dwell), 0.0);
    spec.groups[MOTION].policy = sticky(50 * MS);
    let motion = motion_contract(&spec);
    assert_eq!(motion.by_check.total(), (75 + 50 + 5) * MS);
    let by_winner = |motion: &GroupContract| motion.by_winner.as_ref().map(TakeoverBound::total);
    assert_eq!(by_winner(&motion), Some((75 + 75 + 5) * MS));
    assert_eq!(motion.allowed(), (75 + 5) * MS);
    spec.groups[MOTION].policy = sticky(500 * MS);
    let motion = motion_contract(&spec);
    assert_eq!(
        by_winner(&motion),
        Some((75 + 500 + 5) * MS),
        "the longer of the two"
    );
    spec.groups[MOTION].members.push(EXAMPLE);
    spec.groups[MOTION].policy = Policy::round_robin(Duration::from_millis(100));
    let motion = motion_contract(&spec);
    assert_eq!(
        (motion.total(), motion.by_winner),
        ((75 + 2 * 100 + 5) * MS, None)
    );
}

#[test]
fn r17_a_schema_that_takes_a_whole_period_misses_the_next_deadline() {
    let mut spec = valid();
    for id in [STOP, GOON] {
        spec.schemas[id].budget = 75 * MS;
    }
    assert_eq!(
        motion_contract(&spec).to_string(),
        "motion: stop takes over within 305 ms = 2 periods of stop 150 ms + check by stop 75 ms + patience with the loser 5 ms \
         + check of stop before it acts 75 ms"
    );
}

#[test]
fn r17_the_running_hierarchy_allows_what_the_contract_states() {
    let mut spec = valid();
    for policy in [
        Policy::PRIORITY,
        Policy::FATHER,
        Policy::round_robin(Duration::from_millis(1)),
    ] {
        spec.groups[MOTION].policy = policy;
        spec.schemas[STOP].budget += MS;
        spec.schemas[GOON].panel ^= true;
        let all = contract(&spec);
        let hierarchy = Hierarchy::new(spec.clone()).expect("valid");
        for group in all {
            assert_eq!(hierarchy.allowed(group.group), Some(group.allowed()), "{group}");
        }
    }
}

#[test]
fn r17_the_sum_of_a_contract_does_not_overflow() {
    let mut spec = valid();
    spec.schemas[STOP].period = u64::MAX;
    assert_eq!(motion_contract(&spec).total(), u64::MAX);
}
