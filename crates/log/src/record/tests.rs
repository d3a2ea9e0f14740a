//! Messages are compared with bytes computed by hand, and decoded by their definitions. Random records survive both directions, and damaged messages
//! are refused.

use jde_panel::{Button, Gesture, Touch};
use jde_records::{CandidateRecord, Decision, EventRecord, GestureRecord, StateRecord};
use jde_ros::interface::Interfaces;
use proptest::option;
use proptest::prelude::*;
use serde_json::json;

use super::*;

fn message(record: &RunRecord) -> Vec<u8> {
    let mut message = vec![0xff; 3];
    encode(record.clone(), &mut message);
    message
}

#[test]
fn a_change_of_state_is_its_time_and_three_texts() {
    let record = RunRecord::State(StateRecord {
        time_s: 2.5,
        schema: "goon".to_owned(),
        from: "ready".to_owned(),
        to: "winner".to_owned(),
    });
    let expected = [
        &[0, 1, 0, 0][..],
        &[2, 0, 0, 0],
        &500_000_000_u32.to_le_bytes(),
        &[5, 0, 0, 0],
        b"goon\0",
        // 17 bytes of the body so far: three to the next multiple of four.
        &[0; 3],
        &[6, 0, 0, 0],
        b"ready\0",
        &[0; 2],
        &[7, 0, 0, 0],
        b"winner\0",
    ];
    assert_eq!(message(&record), expected.concat());
    assert_eq!(decode(RecordKind::State, &expected.concat()), Ok(record));
}

/// Decodes a message by its definition only.
fn by_definition(kind: RecordKind, message: &[u8]) -> serde_json::Value {
    let (name, text) = schema(kind);
    let mut interfaces = Interfaces::default();
    // Messages come after those that contain them.
    for section in text.rsplit("=\nMSG: ") {
        let inner = section.split_once('\n').filter(|_| !text.starts_with(section));
        let (name, fields) = match inner {
            Some((title, fields)) => (title.replace('/', "/msg/"), fields),
            None => (name.to_owned(), section),
        };
        let fields: Vec<_> = fields.lines().filter(|line| !line.starts_with("==")).collect();
        interfaces
            .message(&name, &fields.join("\n"))
            .expect("it defines messages");
    }
    interfaces.decode(name, message).expect("it is one")
}

#[test]
fn a_message_has_the_fields_of_its_definition() {
    let decision = Decision {
        number: 7,
        time_s: 1.5,
        group: "roots".to_owned(),
        case: "collision".to_owned(),
        candidates: vec![CandidateRecord {
            name: "goon".to_owned(),
            state: "ready".to_owned(),
            ready: true,
            urgency: Some(0.25),
        }],
        before: None,
        choice: Some("goon".to_owned()),
        decider: "father".to_owned(),
        reason: "r".to_owned(),
        cause: "c".to_owned(),
        changed: true,
        takeover_us: Some(2500.0),
    };
    let json = by_definition(RecordKind::Decision, &message(&RunRecord::Decision(decision)));
    let expected = json!({
        "stamp": { "sec": 1, "nanosec": 500_000_000 }, "number": 7, "group": "roots", "case_name": "collision",
        "candidates": [{ "name": "goon", "state": "ready", "ready": true, "urgency": 0.25 }],
        "before": "", "choice": "goon", "decider": "father", "reason": "r", "cause": "c",
        "changed": true, "takeover": 0.0025,
    });
    assert_eq!(json, expected);
    let touch = Touch::Dragged {
        from: [1.0, 2.0, 3.0],
        to: [4.0, 5.0, 6.0],
        button: Button::Middle,
        ended: true,
    };
    let event = EventRecord {
        kind: "operator".to_owned(),
        schema: Some("goon".to_owned()),
        by: Some("ana".to_owned()),
        text: "t".to_owned(),
        touched: Some(GestureRecord {
            number: 9,
            gesture: Gesture {
                widget: "field".to_owned(),
                touch,
            },
        }),
        time_s: 0.0,
    };
    let json = by_definition(RecordKind::Event, &message(&RunRecord::Event(event)));
    let expected = json!({
        "stamp": { "sec": 0, "nanosec": 0 }, "kind": "operator", "schema": "goon", "by": "ana", "text": "t",
        "gesture": {
            "number": 9, "widget": "field", "touch": "dragged", "active": true, "value": 0.0, "option": 0,
            "position": [4.0, 5.0, 6.0], "origin": [1.0, 2.0, 3.0], "button": "middle", "key": "",
        },
    });
    assert_eq!(json, expected);
}

#[test]
fn a_gesture_of_an_unknown_kind_leaves_its_event() {
    let event = |touch: &str| EventRecord {
        text: "pressed `go`".to_owned(),
        touched: (touch == "pressed").then(|| GestureRecord {
            number: 1,
            gesture: Gesture {
                widget: "go".to_owned(),
                touch: Touch::Pressed,
            },
        }),
        ..EventRecord::default()
    };
    let known = message(&RunRecord::Event(event("pressed")));
    let at = known
        .windows(7)
        .rposition(|part| part == b"pressed")
        .expect("it is named");
    let unknown = [&known[..at], b"stroked", &known[at + 7..]].concat();
    assert_eq!(
        decode(RecordKind::Event, &unknown),
        Ok(RunRecord::Event(event("stroked")))
    );
}

#[test]
fn a_list_that_is_longer_than_its_message_is_refused() {
    let record = RunRecord::Decision(Decision::default());
    let mut long = message(&record);
    // After the header, the time, the number and two empty texts: 4 + 8 + 8 + 5 + 3 + 5 + 3.
    long[36..40].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(matches!(
        decode(RecordKind::Decision, &long),
        Err(Error::Truncated(_) | Error::Text(_))
    ));
}

fn text() -> impl Strategy<Value = String> {
    "[^\0]{0,12}"
}

fn name() -> impl Strategy<Value = Option<String>> {
    option::of("[a-z/]{1,8}")
}

/// Whole nanoseconds, s.
fn time_s() -> impl Strategy<Value = f64> {
    (0_u64..1 << 50).prop_map(|ns| ns as f64 / 1e9)
}

fn candidate() -> impl Strategy<Value = CandidateRecord> {
    (text(), text(), any::<bool>(), option::of(-1e300..1e300)).prop_map(|(name, state, ready, urgency)| {
        CandidateRecord {
            name,
            state,
            ready,
            urgency,
        }
    })
}

fn decision() -> impl Strategy<Value = Decision> {
    let times = (time_s(), option::of(0_u64..1 << 40));
    let texts = (text(), text(), text(), text(), text());
    let candidates = prop::collection::vec(candidate(), 0..5);
    let rest = (any::<u64>(), name(), name(), any::<bool>());
    (times, texts, candidates, rest).prop_map(
        |((time_s, takeover), (group, case, decider, reason, cause), candidates, rest)| {
            let (number, before, choice, changed) = rest;
            Decision {
                number,
                time_s,
                group,
                case,
                candidates,
                before,
                choice,
                decider,
                reason,
                cause,
                changed,
                takeover_us: takeover.map(|ns| ns as f64 / 1e3),
            }
        },
    )
}

fn touch() -> impl Strategy<Value = Touch> {
    let place = || prop::array::uniform3(-1e9..1e9);
    let button = || prop::sample::select(vec![Button::Primary, Button::Secondary, Button::Middle]);
    prop_oneof![
        Just(Touch::Pressed),
        any::<bool>().prop_map(Touch::Toggled),
        (-1e9..1e9).prop_map(Touch::Moved),
        any::<u32>().prop_map(Touch::Chose),
        (place(), button()).prop_map(|(at, button)| Touch::Clicked { at, button }),
        (place(), place(), button(), any::<bool>()).prop_map(|(from, to, button, ended)| Touch::Dragged {
            from,
            to,
            button,
            ended
        }),
        (text(), any::<bool>()).prop_map(|(key, down)| Touch::Key { key, down }),
    ]
}

fn event() -> impl Strategy<Value = EventRecord> {
    let gesture = (1..u64::MAX, text(), touch()).prop_map(|(number, widget, touch)| GestureRecord {
        number,
        gesture: Gesture { widget, touch },
    });
    (time_s(), text(), name(), name(), text(), option::of(gesture)).prop_map(
        |(time_s, kind, schema, by, text, touched)| EventRecord {
            time_s,
            kind,
            schema,
            by,
            text,
            touched,
        },
    )
}

fn record() -> impl Strategy<Value = RunRecord> {
    let state = (time_s(), text(), text(), text()).prop_map(|(time_s, schema, from, to)| StateRecord {
        time_s,
        schema,
        from,
        to,
    });
    prop_oneof![
        decision().prop_map(RunRecord::Decision),
        state.prop_map(RunRecord::State),
        event().prop_map(RunRecord::Event),
    ]
}

proptest! {
    #[test]
    fn nothing_of_a_record_is_lost(record in record()) {
        prop_assert_eq!(decode(record.kind(), &message(&record)), Ok(record));
    }

    #[test]
    fn random_bytes_do_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let message = [&[0, 1, 0, 0], &*bytes].concat();
        for kind in RecordKind::ALL {
            let _ = decode(kind, &message);
            let _ = decode(kind, &bytes);
        }
    }

    #[test]
    fn a_damaged_message_does_not_panic(
        record in record(),
        at: prop::sample::Index,
        put: u32,
        end: prop::sample::Index,
    ) {
        let mut message = message(&record);
        let at = at.index(message.len() - 4);
        message[at..at + 4].copy_from_slice(&put.to_le_bytes());
        let _ = decode(record.kind(), &message);
        message.truncate(end.index(message.len()));
        let _ = decode(record.kind(), &message);
    }
}
