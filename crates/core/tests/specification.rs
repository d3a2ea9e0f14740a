//! What is wrong with a specification is said before the start, all at once; and the contract's arithmetic.
//!
//! It refuses to start anything.

use jde_core::{
    Absence, GroupId, GroupSpec, Hierarchy, Kind, Policy, SchemaId, SchemaSpec, Spec, SpecError, contract,
};

const MS: u64 = 1_000_000;
const LASER: SchemaId = SchemaId(0);
const EXAMPLE: SchemaId = SchemaId(1);
const STOP: SchemaId = SchemaId(2);
const GOON: SchemaId = SchemaId(3);

fn sound() -> Spec {
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
        ],
        groups: vec![
            GroupSpec::new("roots", None, vec![EXAMPLE]),
            GroupSpec::new("motion", Some(EXAMPLE), vec![STOP, GOON]),
        ],
    }
}

/// The faults of a sound specification after a change.
fn faults(change: impl FnOnce(&mut Spec)) -> Vec<SpecError> {
    let mut spec = sound();
    change(&mut spec);
    Hierarchy::new(spec).err().unwrap_or_default()
}

#[test]
fn a_sound_specification_has_no_faults() {
    assert_eq!(faults(|_| {}), []);
    assert_eq!(Spec::default().validate(), Ok(()));
}

#[test]
fn r3_a_schema_with_two_places_is_refused() {
    let expected = SpecError::TwoFathers {
        schema: "stop".into(),
        first: "roots".into(),
        second: "motion".into(),
    };
    assert_eq!(faults(|s| s.groups[0].members.push(STOP)), [expected]);
    let twice = faults(|s| s.groups[1].members.push(GOON));
    assert!(matches!(twice.as_slice(), [SpecError::TwoFathers { .. }]));
}

#[test]
fn a_motor_schema_without_a_group_is_refused() {
    assert_eq!(
        faults(|s| s.groups[1].members.truncate(1)),
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
    assert_eq!(faults(|s| s.groups[1].members.push(LASER)), [expected]);
    let expected = SpecError::PerceptiveFather {
        schema: "laser".into(),
        group: "motion".into(),
    };
    assert_eq!(faults(|s| s.groups[1].father = Some(LASER)), [expected]);
}

#[test]
fn r6_only_perceptive_schemas_can_be_needed() {
    let expected = SpecError::MotorNeeded {
        schema: "laser".into(),
        needs: "goon".into(),
    };
    assert_eq!(faults(|s| s.schemas[0].needs.push(GOON)), [expected]);
}

#[test]
fn circles_of_fathers_and_of_needs_are_shown() {
    let of_fathers = faults(|s| s.groups[0].father = Some(GOON));
    let path = ["example", "goon", "example"].map(String::from).to_vec();
    assert_eq!(of_fathers, [SpecError::FatherCycle { path }]);
    let of_needs = faults(|s| s.schemas[0].needs.push(LASER));
    let path = ["laser", "laser"].map(String::from).to_vec();
    assert_eq!(of_needs, [SpecError::NeedCycle { path }]);
}

#[test]
fn needs_that_meet_again_without_a_circle_are_sound() {
    let diamond = faults(|s| {
        for name in ["walls", "doors", "map"] {
            s.schemas.push(SchemaSpec::new(name, Kind::Perceptive, MS));
        }
        s.schemas[4].needs = vec![LASER];
        s.schemas[5].needs = vec![LASER];
        s.schemas[6].needs = vec![SchemaId(4), SchemaId(5)];
    });
    assert_eq!(diamond, []);
}

#[test]
fn policies_that_cannot_work_are_refused() {
    let motion = || "motion".to_owned();
    let with = |policy| faults(|s| s.groups[1].policy = policy);
    assert_eq!(
        with(Policy::RoundRobin { turn: 0 }),
        [SpecError::ZeroTurn { group: motion() }]
    );
    for hysteresis in [-0.1, f64::NAN, f64::INFINITY] {
        assert_eq!(
            with(Policy::Sticky { dwell: 0, hysteresis }),
            [SpecError::BadHysteresis { group: motion() }]
        );
    }
    assert_eq!(with(Policy::Father), []);
    let roots = faults(|s| s.groups[0].policy = Policy::Father);
    assert_eq!(
        roots,
        [SpecError::NobodyToAsk {
            group: "roots".into()
        }]
    );
    let stranger = faults(|s| s.groups[1].absence = Absence::Fallback(EXAMPLE));
    assert_eq!(
        stranger,
        [SpecError::FallbackNotMember {
            group: motion(),
            fallback: "example".into()
        }]
    );
}

#[test]
fn a_policy_that_cannot_work_is_refused_while_running_too() {
    let mut h = Hierarchy::new(sound()).expect("sound");
    let refused = h.set_policy(0, GroupId(0), Policy::Father, &mut Vec::new());
    assert_eq!(
        refused,
        Err(SpecError::NobodyToAsk {
            group: "roots".into()
        })
    );
    assert_eq!(h.spec(), &sound());
}

#[test]
fn all_faults_are_reported_at_once_and_each_says_what_to_do() {
    let all = faults(|s| {
        s.schemas[3].name = "stop".into();
        s.schemas[2].period = 0;
        s.schemas[2].needs.push(SchemaId(9));
        s.groups[1].members.push(SchemaId(8));
        s.groups.push(GroupSpec::new("empty", None, vec![]));
    });
    let told: Vec<String> = all.iter().map(ToString::to_string).collect();
    let expected = [
        "two schemas are called `stop`: give each its own name",
        "`stop` has a period of 0: give a time above 0",
        "`stop` names schema number 9, which does not exist: name a listed one",
        "`motion` names schema number 8, which does not exist: name a listed one",
        "the group `empty` has no members: list a motor schema or remove the group",
    ];
    assert_eq!(told, expected);
}

#[test]
fn r17_the_contract_is_that_of_the_slowest_member() {
    let mut spec = sound();
    spec.schemas[STOP.index()].period = 200 * MS;
    spec.schemas[STOP.index()].budget = 10 * MS;
    spec.schemas[GOON.index()].budget = 20 * MS;
    let motion = &contract(&spec)[1];
    assert_eq!((motion.slowest, motion.total()), (STOP, 215 * MS));
    spec.schemas[STOP.index()].triggered = true;
    let motion = &contract(&spec)[1];
    assert_eq!((motion.slowest, motion.total()), (GOON, 100 * MS));
    spec.groups[1].policy = Policy::Father;
    spec.groups[1].budget = 7 * MS;
    assert_eq!(contract(&spec)[1].total(), 107 * MS);
}

#[test]
fn r17_a_panel_takes_as_long_as_an_iteration_may() {
    let mut spec = sound();
    spec.schemas[GOON.index()].budget = 20 * MS;
    spec.schemas[GOON.index()].panel = true;
    let motion = &contract(&spec)[1];
    assert_eq!((motion.slowest, motion.total()), (GOON, 120 * MS));
    assert_eq!(
        motion.to_string(),
        "motion: goon takes over within 120 ms = period of goon 75 ms + longest iteration of goon 20 ms \
         + drawing of its panel 20 ms + patience with the loser 5 ms"
    );
}

#[test]
fn r17_a_contract_beyond_all_time_does_not_overflow() {
    let mut spec = sound();
    spec.schemas[STOP.index()].period = u64::MAX;
    assert_eq!(contract(&spec)[1].total(), u64::MAX);
}
