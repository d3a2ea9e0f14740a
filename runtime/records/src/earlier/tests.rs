//! Every event is read from its words alone as another event with the same words.

use jde_panel::{Gesture, Touch};
use proptest::option;
use proptest::prelude::*;

use super::*;
use crate::event::Occurrence;
use crate::reload::Replacement;

fn name() -> impl Strategy<Value = String> {
    "[a-z][a-z0-9_-]{0,8}"
}

/// A name that is no word of a description.
fn schema() -> impl Strategy<Value = String> {
    name().prop_map(|name| format!("s{name}"))
}

fn time() -> impl Strategy<Value = Nanos> {
    0_u64..1 << 45
}

fn process() -> impl Strategy<Value = ResourceUsage> {
    (any::<u16>(), 0_u64..1 << 40).prop_map(|(files, memory)| ResourceUsage {
        files: files.into(),
        memory,
    })
}

fn build() -> impl Strategy<Value = BuildName> {
    ("[0-9]\\.[0-9]", option::of("/[a-z]{1,8}\\.so")).prop_map(|(version, file)| BuildName {
        version,
        file: file.map(PathBuf::from),
    })
}

fn health() -> impl Strategy<Value = Health> {
    prop_oneof![
        Just(Health::Ok),
        Just(Health::Overrun),
        ".{0,20}".prop_map(Health::ArbitrationFailed),
        ".{0,20}".prop_map(Health::Faulted),
    ]
}

fn action() -> impl Strategy<Value = OperatorAction<String>> {
    let touch = |number| Gesture {
        widget: "field".to_owned(),
        touch: if number % 2 == 0 {
            Touch::Pressed
        } else {
            Touch::Toggled(true)
        },
    };
    prop_oneof![
        schema().prop_map(|schema| OperatorAction::Play { schema }),
        schema().prop_map(|schema| OperatorAction::Stop { schema }),
        schema().prop_map(|schema| OperatorAction::Force { schema }),
        schema().prop_map(|schema| OperatorAction::Release { schema }),
        schema().prop_map(|schema| OperatorAction::Unload { schema }),
        schema().prop_map(|schema| OperatorAction::Load { schema }),
        (schema(), build()).prop_map(|(schema, build)| OperatorAction::Reload { schema, build }),
        (schema(), 1_u64..1 << 40).prop_map(|(schema, period)| OperatorAction::Period { schema, period }),
        (schema(), name(), "[a-z0-9. ]{0,9}").prop_map(|(schema, variable, value)| {
            OperatorAction::Modulate {
                schema,
                variable,
                value,
            }
        }),
        (schema(), name(), name()).prop_map(|(schema, export, fault)| OperatorAction::Fail {
            schema,
            export,
            fault
        }),
        (schema(), name()).prop_map(|(schema, export)| OperatorAction::Repair { schema, export }),
        (schema(), 1_u64..9).prop_map(move |(schema, number)| OperatorAction::Touch {
            schema,
            number,
            gesture: touch(number),
        }),
    ]
}

fn losses() -> impl Strategy<Value = Vec<Loss<String>>> {
    let loss = (schema(), name()).prop_map(|(reader, import)| Loss { reader, import });
    prop::collection::vec(loss, 0..3)
}

/// Every event of which a version without data wrote all in its words.
fn events_in_words() -> impl Strategy<Value = What<String>> {
    let of_schemas = prop_oneof![
        (schema(), health()).prop_map(|(schema, health)| What::HealthChanged { schema, health }),
        (schema(), time(), time()).prop_map(|(schema, took, budget)| What::Overrun { schema, took, budget }),
        (schema(), time()).prop_map(|(schema, since)| What::Hung { schema, since }),
        (schema(), time(), any::<u8>(), any::<u32>(), process()).prop_map(
            |(schema, since, abandoned, bytes, process)| What::CallAbandoned {
                schema,
                since,
                abandoned: abandoned.into(),
                retained_bytes: bytes.into(),
                process,
            }
        ),
        (schema(), time(), any::<u8>(), process()).prop_map(|(schema, since, abandoned, process)| {
            What::AbandonedCallReturned {
                schema,
                since,
                abandoned: abandoned.into(),
                process,
            }
        }),
        (schema(), time(), 0.0..100.0, any::<u32>()).prop_map(|(schema, since, distance, reached)| {
            What::Stalled {
                schema,
                since,
                distance,
                reached,
            }
        }),
        (schema(), ".{0,20}").prop_map(|(schema, description)| What::Refused {
            schema,
            description,
            retry: None
        }),
        (schema(), ".{0,20}").prop_map(|(schema, description)| What::Limited { schema, description }),
        (schema(), build(), ".{0,20}").prop_map(|(schema, build, reason)| What::ReloadRolledBack {
            schema,
            build,
            reason
        }),
    ];
    let of_groups = prop_oneof![
        (name(), schema(), time(), 0_u64..1 << 30, 0_u64..1 << 30).prop_map(
            |(group, schema, allowed, more, machine)| What::TookOver {
                group,
                record: 0,
                schema,
                latency: allowed + more,
                allowed,
                machine,
            }
        ),
        (name(), option::of(schema()), option::of(schema()), any::<u8>()).prop_map(
            |(group, first, second, switches)| What::ChatteringStarted {
                group,
                between: [first, second],
                switches: switches.into(),
            }
        ),
        (name(), time(), any::<u64>()).prop_map(|(group, since, switches)| What::ChatteringEnded {
            group,
            since,
            switches
        }),
    ];
    let of_operators = prop_oneof![
        (name(), action(), losses()).prop_map(|(by, action, losses)| What::Operator { by, action, losses }),
        (name(), any::<bool>()).prop_map(|(by, one_step)| What::WentOn { by, one_step }),
    ];
    let others = prop_oneof![
        ".{0,20}".prop_map(|reason| What::StoodStill { reason }),
        "[a-z]{1,8}\\.[a-z]{1,8}".prop_map(|variable| What::Retracted { variable }),
        ".{0,20}".prop_map(|condition| What::Triggered { condition }),
        ".{0,20}".prop_map(|text| What::Ended {
            outcome: Outcome::parse(&text)
        }),
        Just(What::Ended {
            outcome: Outcome::Done
        }),
    ];
    prop_oneof![of_schemas, of_groups, of_operators, others]
}

fn without_data(event: &Occurrence<String>) -> Occurrence<String> {
    let message = EventMessage {
        data: None,
        ..EventMessage::from(event)
    };
    message.try_into().expect("it has a time")
}

proptest! {
    #[test]
    fn an_event_is_read_from_its_words(what in events_in_words(), time in time()) {
        let event = what.at(time);
        let read = without_data(&event);
        prop_assert!(!matches!(read.what, What::Unknown { .. }), "{}", event);
        prop_assert_eq!(std::mem::discriminant(&read.what), std::mem::discriminant(&event.what), "{}", event);
        prop_assert_eq!(read.what.kind(), event.what.kind());
        prop_assert_eq!(read.what.schema(), event.what.schema());
        prop_assert_eq!(read.what.by(), event.what.by());
        prop_assert_eq!(read.what.gesture(), event.what.gesture());
        // Of a time that was told in tenths of a second, the last digit may differ.
        if !matches!(event.what, What::Stalled { .. } | What::ChatteringEnded { .. }) {
            prop_assert_eq!(read.text(), event.text());
        }
    }

    #[test]
    fn with_its_data_nothing_of_an_event_is_lost(what in events_in_words(), time in time()) {
        let event = what.at(time);
        let json = serde_json::to_vec(&event).expect("it is JSON");
        let read: Occurrence<String> = serde_json::from_slice(&json).expect("it is an event");
        prop_assert_eq!(read, event);
    }

    #[test]
    fn any_words_are_read(kind in "[a-z-]{0,12}", text in ".{0,40}", schema in option::of(name()), by in option::of(name())) {
        let message = EventMessage { kind: kind.clone(), text: text.clone(), schema, by, ..EventMessage::default() };
        let read = Occurrence::try_from(message).expect("it has a time");
        if matches!(read.what, What::Unknown { .. }) {
            prop_assert_eq!((read.what.kind(), read.text()), (&*kind, text));
        }
    }
}

#[test]
fn an_event_of_a_later_version_keeps_its_words() {
    let message = EventMessage {
        kind: "melted".to_owned(),
        schema: Some("goon".to_owned()),
        text: "it melted".to_owned(),
        data: Some(serde_json::json!({ "melted": { "schema": "goon" } })),
        ..EventMessage::default()
    };
    let event = Occurrence::try_from(message).expect("it has a time");
    assert_eq!(event.to_string(), "goon melted: it melted");
    let passed_on = EventMessage::from(&event);
    assert_eq!(
        passed_on.data,
        Some(serde_json::json!({ "melted": { "schema": "goon" } }))
    );
    let json = serde_json::to_vec(&event).expect("it is JSON");
    let again: Occurrence<String> = serde_json::from_slice(&json).expect("it is an event");
    assert_eq!(again, event);
}

#[test]
fn how_a_build_took_over_was_told_in_part_and_stays_words() {
    let takeover = Replacement {
        build: BuildName::default(),
        carried: None,
        gap: Some(3_000_000),
        took: 1,
        probation: 2,
        notes: Vec::new(),
    };
    let schema = "goon".to_owned();
    let event = What::Reloaded { schema, takeover }.at(7);
    let read = without_data(&event);
    assert!(matches!(read.what, What::Unknown { .. }));
    assert_eq!(read.to_string(), event.to_string());
}

#[test]
fn each_place_of_a_pattern_is_as_short_as_possible() {
    assert_eq!(words("a {} b", "a x b y b"), Some(["x b y"]));
    assert_eq!(words("{} of {}", "x of y of z"), Some(["x", "y of z"]));
    assert_eq!(words("a {} b", "a x"), None::<[&str; 1]>);
    assert_eq!(words("a {}", "b"), None::<[&str; 1]>);
    assert_eq!(words("aa{}aa", "aaa"), None::<[&str; 1]>);
}
