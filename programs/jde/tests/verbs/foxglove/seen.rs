//! What a client sees, sets and calls, and what it learns of the end.

use std::collections::BTreeSet;

use jde_log::{Recording, record};
use jde_records::{RecordKind, RunRecord};
use jde_ros::cdr;
use jde_types::Value as _;
use serde_json::{Value, json};

use super::{Arrival, enter};
use crate::attached::Sandbox;
use crate::page::{PageRun, read_token, safe_navigation};
use crate::support::pair;

#[test]
fn a_client_sees_the_channels_of_a_recording() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &pair(), &["--web"]);
    let (mut client, info) = enter(&run, &run.token);
    let file = sandbox.folder().join("drive.mcap");
    sandbox.run_ok(&["record", file.to_str().expect("a path"), "--for", "1s"]);
    let recording = Recording::open(&file).expect("a recording");
    let recorded: BTreeSet<Vec<String>> = recording
        .channels()
        .map(|channel| {
            let definition = String::from_utf8(channel.definition.to_vec()).expect("text");
            let names = [
                &channel.topic,
                &channel.encoding,
                &channel.type_name,
                &channel.definition_encoding,
            ];
            names.into_iter().cloned().chain([definition]).collect()
        })
        .collect();
    let text = |channel: &Value, key: &str| channel[key].as_str().expect("a text").to_owned();
    let seen: BTreeSet<Vec<String>> = client
        .channels
        .iter()
        .filter(|channel| channel["topic"] != "/jde/log")
        .map(|channel| {
            ["topic", "encoding", "schemaName", "schemaEncoding", "schema"]
                .map(|key| text(channel, key))
                .to_vec()
        })
        .collect();
    assert_eq!(seen, recorded);
    let id = sandbox.json(&["apps"])[0]["id"].clone();
    assert_eq!(
        (&info["sessionId"], &info["supportedEncodings"]),
        (&id, &json!(["json"]))
    );
    // Values, decisions and lines, with times of the application's clock from its start.
    client.subscribe(0, "/talker/count");
    let (first, data) = client.message(0);
    let bytes = cdr::decode(&u64::describe(), &data).expect("a number");
    let count = u64::from_bytes(&bytes).expect("a number");
    let (second, data) = client.message(0);
    let bytes = cdr::decode(&u64::describe(), &data).expect("a number");
    assert!(u64::from_bytes(&bytes).expect("a number") > count && second > first);
    client.subscribe(1, "/jde/decisions");
    let (_, data) = client.message(1);
    let decision = record::decode(RecordKind::Decision, &data).expect("a decision");
    assert!(matches!(decision, RunRecord::Decision(decision) if decision.group == "roots"));
    client.subscribe(2, "/jde/log");
    let (_, data) = client.message(2);
    assert!(String::from_utf8_lossy(&data).contains("listener"));
    client.say(&json!({ "op": "unsubscribe", "subscriptionIds": [0, 1, 2] }));
    let times: Vec<u64> = std::iter::from_fn(|| match client.read() {
        Arrival::Time(time) => Some(Some(time)),
        Arrival::Text(_) | Arrival::Message { .. } | Arrival::Response(_) => Some(None),
        Arrival::Close => None,
    })
    .flatten()
    .take(5)
    .collect();
    assert!(times.is_sorted() && times[0] > first, "{times:?}");
}

#[test]
fn r14_rights_are_those_of_the_token() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &safe_navigation(), &["--web"]);
    let (_, welcome) = run.enter(&run.token);
    let (mut looks, info) = enter(&run, &read_token(&welcome));
    assert!(!info["capabilities"].to_string().contains("services") && looks.services.is_empty());
    let before = looks.parameters(&["goon.fast"]);
    looks.set("goon.fast", &json!(0.1));
    assert!(looks.refused().contains("only looks"));
    assert_eq!(looks.values("set"), before);
    let refusal = looks.call(0, "{}").expect_err("it looks only");
    assert!(refusal.contains("only looks"), "{refusal}");
    assert!(!sandbox.motors_awake().is_empty());

    let (mut client, _) = enter(&run, &run.token);
    let all = client.parameters(&[]);
    assert!(
        all.as_array().is_some_and(|all| all.contains(&before[0])),
        "{all}"
    );
    looks.say(&json!({ "op": "subscribeParameterUpdates", "parameterNames": ["goon.fast"] }));
    // It is known to have been taken once the next request is answered.
    looks.parameters(&[]);
    client.set("goon.fast", &json!(0.1));
    let set = json!([{ "name": "goon.fast", "value": 0.1, "type": "float64" }]);
    assert_eq!(client.values("set"), set);
    assert_eq!(looks.next("parameterValues")["parameters"], set);
    assert_eq!(client.parameters(&["goon.fast", "none.such"]), set);
    for (name, value) in [
        ("goon.fast", json!(-1)),
        ("goon.fast", json!("quick")),
        ("goon.fast", json!(null)),
        ("goon.period", json!(-1)),
        ("none.such", json!(1)),
    ] {
        client.set(name, &value);
        let words = client.refused();
        assert!(words.contains(name), "{words}");
        let in_force = client.values("set");
        assert!(name != "goon.fast" || in_force == set, "{in_force}");
    }
    client.set("goon.period", &json!(0.2));
    assert_eq!(client.values("set")[0]["value"], 0.2);
    sandbox.run_ok(&["set", "goon.fast", "0.15"]);
    assert_eq!(looks.next("parameterValues")["parameters"][0]["value"], 0.15);

    for (service, payload, words) in [
        ("/jde/stop", "{}", "schema"),
        ("/jde/stop", r#"{"schema": "nobody"}"#, "nobody"),
        ("/jde/play", "[]", "schema"),
    ] {
        let refusal = client.call_named(service, payload).expect_err("it is refused");
        assert!(refusal.contains(words), "{refusal}");
    }
    assert!(client.call(99, "{}").is_err());
    assert_eq!(
        client.call_named("/jde/stop_all", "").expect("it may")["success"],
        true
    );
    assert_eq!(sandbox.motors_awake(), [""; 0]);
    let (mut page, _) = run.enter(&run.token);
    page.until(|state| state["stopped"]["by"] == "ana@127.0.0.1");
    assert_eq!(
        client.call_named("/jde/release_all", "{}").expect("it may")["success"],
        true
    );
    page.until(|state| state["stopped"].is_null());
}

#[test]
fn clients_learn_of_the_end() {
    let sandbox = Sandbox::new();
    let run = PageRun::start(&sandbox, &pair(), &["--web", "--for", "8s"]);
    let (mut client, _) = enter(&run, &run.token);
    assert_eq!(client.next("unadvertise")["channelIds"][0], 0);
    let status = client.next("status");
    assert!(
        status["message"]
            .as_str()
            .is_some_and(|words| words.contains("ended")),
        "{status}"
    );
    assert!(matches!(client.read(), Arrival::Close));
}
