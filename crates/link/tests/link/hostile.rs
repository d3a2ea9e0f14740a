//! Clients that send nonsense or floods, or do not read.

use std::io::Write as _;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::channel;

use jde_link::Rate;
use jde_link::message::{Action, Request};
use proptest::prelude::*;
use zenoh::Wait;

use crate::common::{Home, SOON, Stage, number, socket, stranger, until, watch, write};
use crate::processes::Actor;

#[test]
fn no_bytes_upset_an_application() {
    let (home, stage) = (Home::new(), Stage::new());
    let link = home.open("robot", &stage);
    let root = format!("jde/1/robot/{}", link.about().id);
    let stranger = stranger(&format!("unixsock-stream/{}", socket(&home.folder).display()));
    let bytes = proptest::collection::vec(any::<u8>(), 0..200);
    let below = "(operate|about|variables|hierarchy|events/states|var/pioneer/bearing|want/a/b/c|[a-z*]{1,4}/[a-z*]{1,4})";
    let parameters = "(last=-1|last=99999999999999999999|status|status=;last|[ -~]{0,20})";
    let mut runner = proptest::test_runner::TestRunner::default();
    runner
        .run(&(bytes, below, parameters), |(bytes, below, parameters)| {
            // An invalid key is refused before it is sent.
            let selector = format!("{root}/{below}?{parameters}");
            if let Ok(get) = zenoh::query::Selector::try_from(selector) {
                let (tell, told) = std::sync::mpsc::channel::<()>();
                stranger
                    .get(get)
                    .payload(bytes.clone())
                    .attachment(bytes)
                    .callback(move |_| {
                        let _ = &tell;
                    })
                    .wait()
                    .unwrap();
                // The channel closes when all answers have arrived.
                while told.recv().is_ok() {}
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
        stranger.liveliness().declare_token(token).wait().unwrap()
    })
    .collect();
    assert_eq!(home.remote().schemas().unwrap().schemas.len(), 0);
    assert_eq!(stage.acts(), []);
    drop(tokens);
}

#[test]
fn bytes_that_are_not_even_zenoh_upset_nobody() {
    let (home, stage) = (Home::new(), Stage::new());
    let _link = home.open("robot", &stage);
    let path = socket(&home.folder);
    for noise in [
        &b"GET / HTTP/1.1\r\n\r\n"[..],
        &[0xff; 100_000],
        &[0, 0, 0, 0],
        b"",
    ] {
        let mut socket = UnixStream::connect(&path).unwrap();
        // The socket may be closed meanwhile.
        let _ = socket.write_all(noise);
    }
    assert_eq!(home.remote().about().name, "robot");
}

#[test]
fn a_flood_keeps_nobody_else_from_being_served() {
    let (home, stage) = (Home::new(), Stage::new());
    let _link = home.open("robot", &stage);
    let remote = home.remote();
    let mut writer = stage.writer("pioneer.bearing");
    let (_watching, told) = watch(&remote, "pioneer.bearing", Rate::Full);
    assert!(told.recv_timeout(SOON).unwrap().bytes.is_none());
    let flood = Actor::start("flood", &home);
    until("it floods", || !stage.acts().is_empty());
    for value in 1..=200 {
        write(&mut writer, f64::from(value), 1);
        // Some values are skipped, but the newest arrives.
        while number(&told.recv_timeout(SOON).unwrap()) != Some(f64::from(value)) {}
    }
    until("somebody new gets in", || {
        home.client()
            .application(None)
            .is_ok_and(|late| late.schemas().is_ok())
    });
    assert!(remote.is_alive());
    drop(flood);
    remote.schemas().unwrap();
}

#[test]
fn r14_a_flood_of_acts_keeps_nobody_from_stopping_everything() {
    let (home, stage) = (Home::new(), Stage::new());
    let link = home.open("robot", &stage);
    let flood = stranger(&format!("unixsock-stream/{}", socket(&home.folder).display()));
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
    let held = stage.hold.lock().unwrap();
    // More than the allowed rate and the queue permit; the first is not finished before the stop is
    // requested.
    let open = Arc::new(());
    for _ in 0..400 {
        let open = Arc::clone(&open);
        let get = flood.get(key.as_str()).payload(play.clone());
        get.callback(move |_| drop(Arc::clone(&open))).wait().unwrap();
    }
    until("most are refused", || Arc::strong_count(&open) < 100);
    let (tell, told) = channel();
    let get = flood.get(key.as_str()).payload(request("ana", Action::StopAll));
    get.callback(move |reply| tell.send(reply.into_result().is_ok()).unwrap())
        .wait()
        .unwrap();
    // Later queries are answered later.
    let about = flood.get(key.replace("operate", "about")).wait().unwrap();
    assert!(about.recv_timeout(SOON).unwrap().is_some());
    drop(held);
    assert_eq!(told.recv_timeout(SOON), Ok(true), "the stop was carried out");
    until("both are done", || {
        let acts = stage.acts();
        acts.contains(&("ana".to_owned(), Action::StopAll)) && acts.iter().any(|(by, _)| by == "eva")
    });
}

#[test]
fn what_is_nowhere_is_looked_for_once_however_many_want_it() {
    let (home, stage) = (Home::new(), Stage::new());
    let link = home.open("robot", &stage);
    let root = format!("jde/1/robot/{}", link.about().id);
    let stranger = stranger(&format!("unixsock-stream/{}", socket(&home.folder).display()));
    let _tokens: Vec<_> = (0..100)
        .map(|number| {
            let token = format!("{root}/want/nobody/v{number}/full/x");
            stranger.liveliness().declare_token(token).wait().unwrap()
        })
        .collect();
    let remote = home.remote();
    let mut writer = stage.writer("pioneer.bearing");
    write(&mut writer, 1.0, 1);
    // Its value arrives after the earlier tokens were processed.
    let (_watching, told) = watch(&remote, "pioneer.bearing", Rate::Full);
    assert_eq!(number(&told.recv_timeout(SOON).unwrap()), Some(1.0));
    let before = stage.looked.load(Ordering::Relaxed);
    for _ in 0..10 {
        let (_again, told) = watch(&remote, "pioneer.bearing", Rate::Full);
        assert_eq!(number(&told.recv_timeout(SOON).unwrap()), Some(1.0));
    }
    let looks = stage.looked.load(Ordering::Relaxed) - before;
    assert!(looks < 100, "{looks} looks at the board for ten more who watch");
}
