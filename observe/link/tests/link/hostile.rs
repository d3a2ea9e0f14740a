//! Clients that send invalid data or floods, or do not read.

use std::io::Write as _;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::channel;

use jde_link::Rate;
use jde_link::message::{Action, Request};
use proptest::prelude::*;
use zenoh::Wait;

use crate::checks;
use crate::common::{TIMEOUT, TestRuntime, TestSubject, number, raw_session, socket, until, watch, write};
use crate::processes::ChildProcess;

#[test]
fn an_application_survives_arbitrary_bytes() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let link = runtime.open("robot", &subject);
    let root = format!("jde/1/robot/{}", link.about().id);
    let raw_session = raw_session(&format!("unixsock-stream/{}", socket(&runtime.folder).display()));
    let bytes = proptest::collection::vec(any::<u8>(), 0..200);
    let key = "(operate|about|variables|hierarchy|events/states|var/pioneer/bearing|want/a/b/c|[a-z*]{1,4}/[a-z*]{1,4})";
    let parameters = "(last=-1|last=99999999999999999999|status|status=;last|[ -~]{0,20})";
    let mut runner = proptest::test_runner::TestRunner::default();
    runner
        .run(&(bytes, key, parameters), |(bytes, key, parameters)| {
            // An invalid key is refused before it is sent.
            let selector = format!("{root}/{key}?{parameters}");
            if let Ok(get) = zenoh::query::Selector::try_from(selector) {
                let (sender, received) = std::sync::mpsc::channel::<()>();
                raw_session
                    .get(get)
                    .payload(bytes.clone())
                    .attachment(bytes)
                    .callback(move |_| {
                        let _ = &sender;
                    })
                    .wait()
                    .unwrap();
                // The channel closes when all replies have arrived.
                while received.recv().is_ok() {}
            }
            Ok(())
        })
        .unwrap();
    let tokens: Vec<_> = [
        "want",
        "want/a",
        "want/a/b/c/d/e/f",
        "want/pioneer/bearing/7hz/x",
        "alive",
    ]
    .iter()
    .map(|token| {
        let token = format!("{root}/{token}");
        raw_session.liveliness().declare_token(token).wait().unwrap()
    })
    .collect();
    assert_eq!(runtime.remote().schemas().unwrap().schemas.len(), 0);
    assert_eq!(subject.actions(), []);
    drop(tokens);
}

proptest! {
    #[test]
    fn readers_of_messages_survive_any_json(
        json in "(\\[|\\]|\\{|\\}|\"schemas\":|\"groups\":|\"father\":|\"time_s\":|\"line\":|\"number\":|\"name\":|\"x\"|,|1e999|-1|99|null|true){0,60}",
    ) {
        checks::messages(json.as_bytes());
    }
}

#[test]
fn an_application_survives_bytes_that_are_not_zenoh_messages() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let _link = runtime.open("robot", &subject);
    let path = socket(&runtime.folder);
    for bytes in [
        &b"GET / HTTP/1.1\r\n\r\n"[..],
        &[0xff; 100_000],
        &[0, 0, 0, 0],
        b"",
    ] {
        let mut socket = UnixStream::connect(&path).unwrap();
        // The socket may be closed meanwhile.
        let _ = socket.write_all(bytes);
    }
    assert_eq!(runtime.remote().about().name, "robot");
}

#[test]
fn other_clients_are_served_during_a_flood() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let _link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    let mut writer = subject.writer("pioneer.bearing");
    let (_subscription, received) = watch(&remote, "pioneer.bearing", Rate::Full);
    assert!(received.recv_timeout(TIMEOUT).unwrap().bytes.is_none());
    let flood = ChildProcess::start("flood", &runtime);
    until("the flood begins", || !subject.actions().is_empty());
    for value in 1..=200 {
        write(&mut writer, f64::from(value), 1);
        // Some values are skipped, but the newest arrives.
        while number(&received.recv_timeout(TIMEOUT).unwrap()) != Some(f64::from(value)) {}
    }
    until("a new client connects", || {
        runtime
            .client()
            .application(None)
            .is_ok_and(|late_client| late_client.schemas().is_ok())
    });
    assert!(remote.is_alive());
    drop(flood);
    remote.schemas().unwrap();
}

#[test]
fn r14_everything_can_be_stopped_during_a_flood_of_actions() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let link = runtime.open("robot", &subject);
    let flood = raw_session(&format!("unixsock-stream/{}", socket(&runtime.folder).display()));
    let key = format!("jde/1/robot/{}/operate", link.about().id);
    let request = |by: &str, action: Action| {
        let by = by.to_owned();
        let request = Request {
            by,
            action,
            lease_ms: None,
        };
        serde_json::to_vec(&request).unwrap()
    };
    let play = request(
        "eva",
        Action::Play {
            schema: "goon".to_owned(),
        },
    );
    let guard = subject.gesture_lock.lock();
    // More than the allowed rate and the queue permit; the first is not finished before the stop is
    // requested.
    let open = Arc::new(());
    for _ in 0..400 {
        let open = Arc::clone(&open);
        let get = flood.get(key.as_str()).payload(play.clone());
        get.callback(move |_| drop(Arc::clone(&open))).wait().unwrap();
    }
    until("most requests are refused", || Arc::strong_count(&open) < 100);
    let (sender, received) = channel();
    let get = flood.get(key.as_str()).payload(request("ana", Action::StopAll));
    get.callback(move |reply| sender.send(reply.into_result().is_ok()).unwrap())
        .wait()
        .unwrap();
    // Queries are answered in order.
    let about = flood.get(key.replace("operate", "about")).wait().unwrap();
    assert!(about.recv_timeout(TIMEOUT).unwrap().is_some());
    drop(guard);
    assert_eq!(
        received.recv_timeout(TIMEOUT),
        Ok(true),
        "the stop was carried out"
    );
    until("both actions are carried out", || {
        let actions = subject.actions();
        actions.contains(&("ana".to_owned(), Action::StopAll)) && actions.iter().any(|(by, _)| by == "eva")
    });
}

#[test]
fn an_unknown_variable_is_searched_only_once_per_token() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let link = runtime.open("robot", &subject);
    let root = format!("jde/1/robot/{}", link.about().id);
    let raw_session = raw_session(&format!("unixsock-stream/{}", socket(&runtime.folder).display()));
    let _tokens: Vec<_> = (0..100)
        .map(|number| {
            let token = format!("{root}/want/nobody/v{number}/full/x");
            raw_session.liveliness().declare_token(token).wait().unwrap()
        })
        .collect();
    let remote = runtime.remote();
    let mut writer = subject.writer("pioneer.bearing");
    write(&mut writer, 1.0, 1);
    // A value arrives after the earlier tokens were processed.
    let (_subscription, received) = watch(&remote, "pioneer.bearing", Rate::Full);
    assert_eq!(number(&received.recv_timeout(TIMEOUT).unwrap()), Some(1.0));
    let before = subject.board_accesses.load(Ordering::Relaxed);
    for _ in 0..10 {
        let (_again, received) = watch(&remote, "pioneer.bearing", Rate::Full);
        assert_eq!(number(&received.recv_timeout(TIMEOUT).unwrap()), Some(1.0));
    }
    let accesses = subject.board_accesses.load(Ordering::Relaxed) - before;
    assert!(
        accesses < 100,
        "{accesses} accesses to the board for ten more subscriptions"
    );
}
