//! Readers of messages: what they refuse, and that nothing makes them panic.

use jde_records::snapshot::SchemaView;
use proptest::prelude::*;
use serde_json::{Value, json};

use super::*;
use crate::folder::runtime_folder::tests::about as example;
use crate::message::GroupInfo;

const ID: &str = "0123456789abcdef";

type Reader = fn(&[u8]) -> Result<(), Refused>;

/// A message of each kind that makes sense, and its reader.
fn messages() -> Vec<(Value, Reader)> {
    let schema = SchemaInfo {
        name: "goon".to_owned(),
        kind: "motor".to_owned(),
        group: Some("roots".to_owned()),
        ..SchemaInfo::default()
    };
    let group = GroupInfo {
        name: "roots".to_owned(),
        father: None,
        members: vec!["goon".to_owned()],
        policy: "priority".to_owned(),
    };
    let variable = VariableInfo {
        name: "goon.fast".to_owned(),
        owner: "goon".to_owned(),
        variable: "fast".to_owned(),
        access: "modulation".to_owned(),
        ..VariableInfo::default()
    };
    let view = SchemaView {
        name: "goon".to_owned(),
        group: Some(0),
        ..SchemaView::default()
    };
    let mut snapshot = Snapshot {
        schemas: vec![view],
        ..Snapshot::default()
    };
    snapshot.groups.push(jde_records::snapshot::GroupView {
        name: "roots".to_owned(),
        members: vec![0],
        winner: Some(0),
        ..Default::default()
    });
    let schemas = Schemas {
        schemas: vec![schema],
        groups: vec![group],
    };
    let state = json!({ "time_s": 1.0, "schema": "goon", "from": "slept", "to": "ready" });
    vec![
        (json!(example("robot", ID)), |bytes| about(bytes).map(drop)),
        (json!(schemas), |bytes| super::schemas(bytes).map(drop)),
        (json!([variable]), |bytes| variables(bytes).map(drop)),
        (json!(snapshot), |bytes| super::snapshot(bytes).map(drop)),
        (state.clone(), |bytes| record(RecordKind::State, bytes).map(drop)),
        (json!([{ "number": 1, "line": state }]), |bytes| {
            records(RecordKind::State, bytes).map(drop)
        }),
        (json!({ "ok": true }), |bytes| operate_reply(bytes).map(drop)),
        (
            json!({ "by": "ana", "action": "stop", "schema": "goon" }),
            |bytes| request(bytes).map(drop),
        ),
    ]
}

/// Changes one value of a message: `pick` chooses it and what it becomes.
fn spoil(message: &mut Value, pick: &mut u64) {
    let children: Vec<&mut Value> = match message {
        Value::Array(values) => values.iter_mut().collect(),
        Value::Object(fields) => fields.values_mut().collect(),
        _ => Vec::new(),
    };
    let count = children.len() as u64 + 1;
    let chosen = *pick % count;
    *pick /= count;
    match children.into_iter().nth(chosen as usize) {
        Some(child) => spoil(child, pick),
        None => {
            let values = [
                json!(null),
                json!(-1),
                json!(u64::MAX),
                json!(1e300),
                json!("\u{1b}[31m\n"),
                json!(""),
                json!("x".repeat(5000)),
                json!(vec![0; 300]),
                json!({}),
                json!(99),
            ];
            *message = values[(*pick % values.len() as u64) as usize].clone();
        }
    }
}

fn nonsense(refused: Result<impl std::fmt::Debug, Refused>) -> String {
    match refused {
        Err(Refused::Nonsense(reason)) => reason,
        other => panic!("{other:?}"),
    }
}

fn bytes(message: impl serde::Serialize) -> Vec<u8> {
    serde_json::to_vec(&message).unwrap()
}

#[test]
fn messages_that_make_sense_are_read() {
    for (message, read) in messages() {
        assert_eq!(read(&bytes(&message)), Ok(()), "{message}");
    }
}

#[test]
fn schemas_that_are_not_there_are_named() {
    let (message, _) = messages().swap_remove(1);
    let changed = |pointer: &str, value: Value| {
        let mut message = message.clone();
        *message.pointer_mut(pointer).unwrap() = value;
        nonsense(schemas(&bytes(message)))
    };
    assert_eq!(
        changed("/schemas/0/father", json!("nobody")),
        "schema 0 has father `nobody`, and it has no such schema"
    );
    assert!(changed("/schemas/0/father", json!("goon")).contains("fathers above it"));
    assert!(changed("/groups/0/members/0", json!("x")).contains("no such schema"));
    assert!(changed("/schemas/0/kind", json!("robot")).contains("has an unknown kind"));
    assert!(changed("/schemas/0/period_s", json!(-1)).contains("period"));
}

#[test]
fn a_variable_has_the_name_of_its_owner_unless_it_has_none() {
    let (message, _) = messages().swap_remove(2);
    let read = |name: &str, owner: &str| {
        let mut message = message.clone();
        message[0]["name"] = json!(name);
        message[0]["owner"] = json!(owner);
        variables(&bytes(message)).map(drop)
    };
    assert_eq!(read("fast", ""), Ok(()));
    assert_eq!(read("robot2:goon.fast", "robot2:goon"), Ok(()));
    for (name, owner) in [("goon.fast", ""), ("fast", "goon"), (".fast", "")] {
        assert!(nonsense(read(name, owner)).contains("does not begin with its owner"));
    }
}

#[test]
fn an_application_with_the_name_of_another_is_refused() {
    let of = |name: &str, id: &str| about(&bytes(example(name, id)));
    assert!(of("robot", ID).is_ok());
    assert!(nonsense(of("robot\u{202e}", ID)).contains("name"));
    assert!(nonsense(of("robot", "x")).contains("id"));
    let message = bytes(example("robot", ID));
    assert!(about_at(&format!("jde/1/robot/{ID}/about"), &message).is_ok());
    let reason = nonsense(about_at(&format!("jde/1/robot7/{ID}/about"), &message));
    assert_eq!(
        reason,
        "it answers as `robot`, but its key names another application"
    );
}

#[test]
fn a_message_that_would_take_much_memory_is_not_read() {
    let long = vec![b' '; MAX_MESSAGE + 1];
    assert!(nonsense(snapshot(&long)).contains("bytes"));
    let deep = "[".repeat(100_000);
    for (_, read) in messages() {
        assert!(read(deep.as_bytes()).is_err());
    }
    let request = format!(
        r#"{{"by": "ana", "action": "modulate", "schema": "a", "variable": "b", "value": {}1{}}}"#,
        "[".repeat(100_000),
        "]".repeat(100_000)
    );
    assert!(super::request(request.as_bytes()).is_err());
}

proptest! {
    #[test]
    fn readers_survive_any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        for (_, read) in messages() {
            let _ = read(&bytes);
        }
    }

    #[test]
    fn readers_survive_messages_with_any_value_spoilt(picks in any::<[u64; 3]>()) {
        for (mut message, read) in messages() {
            for mut pick in picks {
                spoil(&mut message, &mut pick);
                let _ = read(&bytes(&message));
            }
        }
    }
}
