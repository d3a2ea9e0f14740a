//! Stopping everything while other applications and the same one have other requests (R14).

use std::net::TcpListener;
use std::sync::{Arc, Mutex};

use jde_link::message::{Action, Request};
use jde_link::{BroadcastOutcome, Error, Reach, broadcast};
use jde_watchdog::Watchdog;
use zenoh::Wait;

use crate::common::{Home, Stage};
use crate::network::{free, open};
use crate::processes::Actor;

fn stop() -> Request {
    Request {
        by: "ana".to_owned(),
        action: Action::StopAll,
        lease_ms: None,
    }
}

fn at(endpoints: &[&str]) -> Reach {
    Reach::Network {
        endpoints: endpoints.iter().map(|endpoint| (*endpoint).to_owned()).collect(),
        login: None,
        tls: None,
    }
}

/// Stops everything in reach, and returns the outcomes in their order of arrival.
fn stopped(reach: &Reach, name: Option<&str>) -> Result<Vec<BroadcastOutcome>, Error> {
    let mut heard = Vec::new();
    broadcast(reach, name, &stop(), &mut |what| heard.push(what))?;
    Ok(heard)
}

fn stops(stage: &Stage) -> usize {
    let acts = stage.acts();
    acts.iter()
        .filter(|(_, action)| *action == Action::StopAll)
        .count()
}

#[test]
fn r14_a_flood_of_questions_keeps_nobody_from_stopping_everything_from_anywhere() {
    let home = Home::new();
    let (_link, stage, endpoint) = open(&home, "tcp", |_| {});
    let _flood = Actor::start("asks", &home);
    for reach in [at(&[&endpoint]), Reach::Local(home.folder.clone())] {
        for _ in 0..3 {
            let before = stops(&stage);
            let heard = stopped(&reach, None).unwrap();
            assert!(
                matches!(&*heard, [BroadcastOutcome { target, outcome: Ok(_) }] if target == "robot"),
                "{heard:?}"
            );
            assert!(stops(&stage) > before, "it was done before it was told");
        }
    }
}

/// A peer that admits everybody and answers with a function.
fn answering(answer: impl Fn(zenoh::query::Query) + Send + Sync + 'static) -> (String, zenoh::Session) {
    let endpoint = format!("tcp/{}", free());
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
        .callback(answer)
        .background()
        .wait()
        .unwrap();
    (endpoint, session)
}

#[test]
fn r14_one_that_does_not_answer_delays_nobody_and_is_named() {
    let home = Home::new();
    let (_link, stage, live) = open(&home, "tcp", |_| {});
    let silent = TcpListener::bind("127.0.0.1:0").unwrap();
    let silent = format!("tcp/{}", silent.local_addr().unwrap());
    let off = format!("tcp/{}", free());
    let kept = Arc::new(Mutex::new(Vec::new()));
    let keeps = Arc::clone(&kept);
    let (holding, holds) = answering(move |query| keeps.lock().unwrap().push(query));
    let (endless, talks) = answering(|query| {
        for number in 0..5000 {
            let key = format!("jde/1/ghost/{number}/operate");
            let _ = query.reply(key, "nonsense").wait();
        }
    });
    let heard = stopped(&at(&[&silent, &off, &holding, &endless, &live]), None).unwrap();
    assert_eq!(stops(&stage), 1);
    let place = |who: &str| heard.iter().position(|heard| heard.target == who);
    let done = place("robot").unwrap();
    assert!(heard[done].outcome.is_ok(), "{heard:?}");
    for dead in [&silent, &off, &holding] {
        let named = place(dead).unwrap_or_else(|| panic!("{dead} is not named: {heard:?}"));
        assert!(heard[named].outcome.is_err(), "{heard:?}");
        assert!(dead == &off || named > done, "it was not waited for: {heard:?}");
    }
    let ghosts = heard.iter().filter(|heard| heard.target == "ghost");
    let mut ghosts = ghosts.map(|ghost| ghost.outcome.is_err());
    assert!(
        ghosts.next().is_some() && ghosts.all(|wrong| wrong),
        "nonsense is no answer"
    );
    // Only the named application is stopped, wherever it is.
    let other = Home::new();
    let (link, second, there) = open(&other, "tcp", |settings| settings.name = "robot2".to_owned());
    let both = at(&[&live, &there]);
    assert_eq!(stopped(&both, Some("robot2")).unwrap().len(), 1);
    assert_eq!((stops(&stage), stops(&second)), (1, 1));
    let id = format!("@{}", &link.about().id[..6]);
    assert_eq!(stopped(&both, Some(&id)).unwrap().len(), 1);
    assert_eq!((stops(&stage), stops(&second)), (1, 2));
    drop((holds, talks));
    let nobody = stopped(&both, Some("robot3")).unwrap_err();
    assert!(matches!(nobody, Error::NotFound { .. }), "{nobody}");
}

#[test]
fn r14_of_several_at_an_endpoint_one_that_does_not_answer_is_told_as_well() {
    let _watchdog = Watchdog::for_test();
    let kept = Arc::new(Mutex::new(Vec::new()));
    let keeps = Arc::clone(&kept);
    let (endpoint, _both) = answering(move |query| {
        let done = r#"{"ok": true, "roots": ["goon"]}"#;
        query.reply("jde/1/quick/1/operate", done).wait().unwrap();
        // While the query is open, another application may still answer.
        keeps.lock().unwrap().push(query);
    });
    let heard = stopped(&at(&[&endpoint]), None).unwrap();
    assert!(
        matches!(
            &*heard,
            [
                BroadcastOutcome { target: quick, outcome: Ok(_) },
                BroadcastOutcome { target, outcome: Err(Error::Timeout { .. }) },
            ] if quick == "quick" && *target == endpoint
        ),
        "{heard:?}"
    );
}

#[test]
fn r14_what_may_only_look_is_told_so_and_what_is_not_there_is_said() {
    let home = Home::new();
    let nothing = stopped(&Reach::Local(home.folder.clone()), None).unwrap_err();
    assert!(matches!(nothing, Error::NoApplication(_)), "{nothing}");
    let (_link, stage, endpoint) = open(&home, "tcp", |settings| settings.access = jde_link::Access::Read);
    let heard = stopped(&at(&[&endpoint]), None).unwrap();
    assert_eq!(heard[0].target, endpoint);
    let error = heard[0].outcome.as_ref().unwrap_err().to_string();
    assert!(error.contains("may only look"), "{error}");
    assert_eq!(stops(&stage), 0);
    let unknown = stopped(&Reach::Local(home.folder.clone()), Some("robto")).unwrap_err();
    assert!(matches!(unknown, Error::UnknownApplication { .. }), "{unknown}");
}
