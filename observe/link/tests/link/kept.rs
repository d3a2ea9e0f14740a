//! Peers of earlier versions: each file of `tests/kept` has the answers and the requests of one version, which nobody edits
//! (docs/releases.md).

use std::sync::mpsc::channel;
use std::time::Duration;

use jde_link::Client;
use jde_records::{RecordKind, RunRecord};
use serde_json::Value;
use zenoh::Wait;

use crate::common::{TIMEOUT, TestRuntime, raw_session};
use crate::network::{free_address, open, reach};

/// Returns the file of each version.
fn versions() -> Vec<Value> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/kept");
    let files = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let read = |file| serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    let found: Vec<Value> = files.map(read).collect();
    assert!(!found.is_empty());
    found
}

/// A peer that listens and has the answers of a version.
fn serve(endpoint: &str, kept: &Value) -> Vec<Box<dyn std::any::Any>> {
    let mut config = zenoh::Config::default();
    for (key, value) in [
        ("mode", "\"peer\"".to_owned()),
        ("listen/endpoints", format!("[\"{endpoint}\"]")),
        ("scouting/multicast/enabled", "false".to_owned()),
    ] {
        config.insert_json5(key, &value).unwrap();
    }
    let session = zenoh::open(config).wait().unwrap();
    let (name, id) = (
        kept["about"]["name"].as_str().unwrap(),
        kept["about"]["id"].as_str().unwrap(),
    );
    let root = format!("jde/1/{name}/{id}");
    let token = session
        .liveliness()
        .declare_token(format!("{root}/alive"))
        .wait()
        .unwrap();
    let mut served: Vec<Box<dyn std::any::Any>> = vec![Box::new(token)];
    for (path, answer) in kept
        .as_object()
        .unwrap()
        .iter()
        .filter(|(path, _)| *path != "requests")
    {
        let (key, answer) = (format!("{root}/{path}"), answer.to_string());
        let reply_key = key.clone();
        let queryable = session
            .declare_queryable(key)
            .callback(move |query| {
                query
                    .reply(reply_key.clone(), answer.clone())
                    .wait()
                    .unwrap_or_default()
            })
            .wait();
        served.push(Box::new(queryable.unwrap()));
    }
    served.push(Box::new(session));
    served
}

#[test]
fn a_client_reads_the_answers_of_an_earlier_version() {
    for kept in versions() {
        let endpoint = format!("tcp/{}", free_address());
        let _served = serve(&endpoint, &kept);
        let client = Client::connect(&reach(&endpoint, None, None)).unwrap();
        let remote = client.application(None).unwrap();
        assert_eq!(remote.about().version, kept["about"]["version"]);
        let schemas = remote.schemas().unwrap();
        assert_eq!(
            schemas.schemas.len(),
            kept["schemas"]["schemas"].as_array().unwrap().len()
        );
        let variables = remote.variables(false).unwrap();
        assert_eq!(variables.len(), kept["variables"].as_array().unwrap().len());
        for variable in variables {
            variable.value_type().unwrap();
        }
        let snapshot = remote.hierarchy().unwrap();
        assert_eq!(snapshot.schemas.len(), schemas.schemas.len());
        for kind in RecordKind::ALL {
            let (sender, received) = channel();
            let subscription = remote.events(&[kind], 100, move |event| {
                sender.send(event.record).unwrap_or_default()
            });
            drop(subscription.unwrap());
            let records: Vec<RunRecord> = received.iter().collect();
            let key = match kind {
                RecordKind::Decision => "events/decisions",
                RecordKind::State => "events/states",
                RecordKind::Event => "events/events",
            };
            assert_eq!(records.len(), kept[key].as_array().unwrap().len(), "{key}");
        }
    }
}

#[test]
fn an_application_carries_out_the_requests_of_an_earlier_version() {
    for kept in versions() {
        let runtime = TestRuntime::new();
        let (link, subject, endpoint) = open(&runtime, "tcp", |_| {});
        let client = raw_session(&endpoint);
        let requests = kept["requests"].as_array().unwrap();
        for request in requests {
            let (sender, received) = channel();
            client
                .get(format!("jde/1/robot/{}/operate", link.about().id))
                .payload(request.to_string())
                .timeout(Duration::from_secs(20))
                .callback(move |reply| sender.send(reply.into_result().is_ok()).unwrap_or_default())
                .wait()
                .unwrap();
            assert!(received.recv_timeout(TIMEOUT).unwrap(), "{request}");
        }
        assert_eq!(subject.actions().len(), requests.len());
    }
}
