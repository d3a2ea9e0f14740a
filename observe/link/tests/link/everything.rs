//! Stopping everything (R14): under a flood of queries, and next to applications that do not reply.

use std::net::TcpListener;
use std::sync::Arc;

use jde_link::message::{Action, Request};
use jde_link::{BroadcastOutcome, Error, Reach, broadcast};
use jde_watchdog::Watchdog;
use parking_lot::Mutex;
use zenoh::Wait;

use crate::common::{TestRuntime, TestSubject};
use crate::network::{free_address, open};
use crate::processes::ChildProcess;

fn stop() -> Request {
    Request {
        by: "ana".to_owned(),
        action: Action::StopAll,
        lease_ms: None,
    }
}

fn network(endpoints: &[&str]) -> Reach {
    Reach::Network {
        endpoints: endpoints.iter().map(|endpoint| (*endpoint).to_owned()).collect(),
        login: None,
        tls: None,
    }
}

/// Stops everything in reach, and returns the outcomes in their order of arrival.
fn stop_all(reach: &Reach, name: Option<&str>) -> Result<Vec<BroadcastOutcome>, Error> {
    let mut outcomes = Vec::new();
    broadcast(reach, name, &stop(), &mut |outcome| outcomes.push(outcome))?;
    Ok(outcomes)
}

fn stop_count(subject: &TestSubject) -> usize {
    let actions = subject.actions();
    actions
        .iter()
        .filter(|(_, action)| *action == Action::StopAll)
        .count()
}

#[test]
fn r14_everything_can_be_stopped_locally_and_over_the_network_during_a_flood_of_queries() {
    let runtime = TestRuntime::new();
    let (_link, subject, endpoint) = open(&runtime, "tcp", |_| {});
    let _flood = ChildProcess::start("queries", &runtime);
    for reach in [network(&[&endpoint]), Reach::Local(runtime.folder.clone())] {
        for _ in 0..3 {
            let before = stop_count(&subject);
            let outcomes = stop_all(&reach, None).unwrap();
            assert!(
                matches!(&*outcomes, [BroadcastOutcome { target, outcome: Ok(_) }] if target == "robot"),
                "{outcomes:?}"
            );
            assert!(
                stop_count(&subject) > before,
                "the stop is carried out before it is reported"
            );
        }
    }
}

/// Starts a peer that admits every client and replies with a function.
fn replying_peer(reply: impl Fn(zenoh::query::Query) + Send + Sync + 'static) -> (String, zenoh::Session) {
    let endpoint = format!("tcp/{}", free_address());
    let mut config = zenoh::Config::default();
    for (key, value) in [
        ("mode", "\"peer\"".to_owned()),
        ("listen/endpoints", format!("[\"{endpoint}\"]")),
        ("scouting/multicast/enabled", "false".to_owned()),
    ] {
        config.insert_json5(key, &value).unwrap();
    }
    let session = zenoh::open(config).wait().unwrap();
    session
        .declare_queryable("jde/**")
        .callback(reply)
        .background()
        .wait()
        .unwrap();
    (endpoint, session)
}

#[test]
fn r14_an_endpoint_that_does_not_reply_is_reported_and_delays_no_other() {
    let runtime = TestRuntime::new();
    let (_link, subject, live) = open(&runtime, "tcp", |_| {});
    let silent = TcpListener::bind("127.0.0.1:0").unwrap();
    let silent = format!("tcp/{}", silent.local_addr().unwrap());
    let off = format!("tcp/{}", free_address());
    let open_queries = Arc::new(Mutex::new(Vec::new()));
    let held = Arc::clone(&open_queries);
    let (holding, holding_session) = replying_peer(move |query| held.lock().push(query));
    let (endless, endless_session) = replying_peer(|query| {
        for number in 0..5000 {
            let key = format!("jde/1/ghost/{number}/operate");
            let _ = query.reply(key, "nonsense").wait();
        }
    });
    let outcomes = stop_all(&network(&[&silent, &off, &holding, &endless, &live]), None).unwrap();
    assert_eq!(stop_count(&subject), 1);
    let position = |target: &str| outcomes.iter().position(|outcome| outcome.target == target);
    let done = position("robot").unwrap();
    assert!(outcomes[done].outcome.is_ok(), "{outcomes:?}");
    for target in [&silent, &off, &holding] {
        let reported = position(target).unwrap_or_else(|| panic!("{target} is not reported: {outcomes:?}"));
        assert!(outcomes[reported].outcome.is_err(), "{outcomes:?}");
        assert!(
            target == &off || reported > done,
            "it delayed the others: {outcomes:?}"
        );
    }
    let ghosts = outcomes.iter().filter(|outcome| outcome.target == "ghost");
    let mut ghosts = ghosts.map(|ghost| ghost.outcome.is_err());
    assert!(
        ghosts.next().is_some() && ghosts.all(|is_error| is_error),
        "nonsense is not accepted as a reply"
    );
    // Only the named application is stopped, wherever it is.
    let other = TestRuntime::new();
    let (link, second, second_endpoint) = open(&other, "tcp", |settings| settings.name = "robot2".to_owned());
    let both = network(&[&live, &second_endpoint]);
    assert_eq!(stop_all(&both, Some("robot2")).unwrap().len(), 1);
    assert_eq!((stop_count(&subject), stop_count(&second)), (1, 1));
    let id = format!("@{}", &link.about().id[..6]);
    assert_eq!(stop_all(&both, Some(&id)).unwrap().len(), 1);
    assert_eq!((stop_count(&subject), stop_count(&second)), (1, 2));
    drop((holding_session, endless_session));
    let not_found = stop_all(&both, Some("robot3")).unwrap_err();
    assert!(matches!(not_found, Error::NotFound { .. }), "{not_found}");
}

#[test]
fn r14_of_several_applications_at_an_endpoint_one_that_does_not_reply_is_reported() {
    let _watchdog = Watchdog::for_test();
    let open_queries = Arc::new(Mutex::new(Vec::new()));
    let held = Arc::clone(&open_queries);
    let (endpoint, _session) = replying_peer(move |query| {
        let done = r#"{"ok": true, "roots": ["goon"]}"#;
        query.reply("jde/1/quick/1/operate", done).wait().unwrap();
        // While the query is open, another application may still reply.
        held.lock().push(query);
    });
    let outcomes = stop_all(&network(&[&endpoint]), None).unwrap();
    assert!(
        matches!(
            &*outcomes,
            [
                BroadcastOutcome { target: quick, outcome: Ok(_) },
                BroadcastOutcome { target, outcome: Err(Error::Timeout { .. }) },
            ] if quick == "quick" && *target == endpoint
        ),
        "{outcomes:?}"
    );
}

#[test]
fn r14_stopping_reports_missing_permission_and_missing_applications() {
    let runtime = TestRuntime::new();
    let no_application = stop_all(&Reach::Local(runtime.folder.clone()), None).unwrap_err();
    assert!(
        matches!(no_application, Error::NoApplication(_)),
        "{no_application}"
    );
    let (_link, subject, endpoint) = open(&runtime, "tcp", |settings| {
        settings.access = jde_link::Access::Read
    });
    let outcomes = stop_all(&network(&[&endpoint]), None).unwrap();
    assert_eq!(outcomes[0].target, endpoint);
    let error = outcomes[0].outcome.as_ref().unwrap_err().to_string();
    assert!(error.contains("may only read"), "{error}");
    assert_eq!(stop_count(&subject), 0);
    let unknown = stop_all(&Reach::Local(runtime.folder.clone()), Some("robto")).unwrap_err();
    assert!(matches!(unknown, Error::UnknownApplication { .. }), "{unknown}");
}
