//! Applications and tools of one user on one machine, over real sockets.

use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::sync::atomic::Ordering;
use std::sync::mpsc::channel;
use std::time::Duration;

use jde_board::{Access, Declaration};
use jde_link::message::{Action, Network, Request};
use jde_link::{Client, Error, Events, Folders, Link, Rate, Reach};
use jde_records::{RecordKind, RunRecord};
use jde_types::Value as _;
use zenoh::Wait;

use crate::common::{
    TIMEOUT, TestRuntime, TestSubject, declaration, number, raw_session, socket, until, watch, write,
};

fn play(by: &str, schema: &str) -> Request {
    Request {
        by: by.to_owned(),
        action: Action::Play {
            schema: schema.to_owned(),
        },
        lease_ms: None,
    }
}

#[test]
fn an_application_is_found_and_describes_itself() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    assert!(runtime.client().applications().unwrap().is_empty());
    let link = runtime.open("robot", &subject);
    let found = runtime.client().applications().unwrap();
    assert_eq!(found, [link.about().clone()]);
    assert_eq!(
        (found[0].name.as_str(), found[0].pid),
        ("robot", std::process::id())
    );
    assert_eq!(found[0].network, Network::Closed);
    let remote = runtime.remote();
    assert_eq!(remote.about(), link.about());
    assert!(remote.schemas().unwrap().schemas.is_empty());
    let names: Vec<_> = remote
        .variables(false)
        .unwrap()
        .into_iter()
        .map(|v| v.name)
        .collect();
    assert_eq!(names, ["pioneer.bearing", "pioneer.path", "goon.gain"]);
    let status = remote.variables(true).unwrap()[0].status.clone().unwrap();
    assert_eq!((status.sequence, status.age_s), (0, None));
}

#[test]
fn clients_learn_at_once_that_an_application_ended() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    let (sender, received) = channel();
    remote.on_gone(move || sender.send(()).unwrap_or_default());
    assert!(remote.is_alive());
    drop(link);
    received.recv_timeout(TIMEOUT).unwrap();
    assert!(!remote.is_alive());
    assert!(matches!(remote.hierarchy(), Err(Error::Disconnected(name)) if name == "robot"));
    assert!(runtime.client().applications().unwrap().is_empty());
    let remaining = std::fs::read_dir(runtime.folder.path()).unwrap().flatten();
    let remaining: Vec<_> = remaining.map(|file| file.file_name()).collect();
    assert_eq!(remaining, ["lock"], "its files are removed");
}

#[test]
fn the_second_application_of_a_name_gets_a_number_unless_it_requires_the_name() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let first = runtime.open("robot", &subject);
    let second = runtime.open("robot", &subject);
    assert_eq!(first.about().name, "robot");
    assert_eq!(second.about().name, "robot-2");
    let mut settings = runtime.settings("robot");
    settings.require_name = true;
    let error = Link::open(&settings, subject.clone(), &Events::of_records())
        .err()
        .unwrap();
    assert!(
        matches!(error, Error::NameTaken { ref name, .. } if name == "robot"),
        "{error}"
    );
    let client = runtime.client();
    let error = client.application(None).err().unwrap().to_string();
    assert_eq!(error, "several applications run: robot, robot-2; name one");
    assert_eq!(
        client.application(Some("robot-2")).unwrap().about().id,
        second.about().id
    );
    let error = client.application(Some("robt")).err().unwrap().to_string();
    assert_eq!(error, "no application is called `robt`; did you mean `robot`?");
}

#[test]
fn a_value_arrives_with_its_attachment() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let _link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    assert!(
        remote.get("pioneer.bearing").unwrap().bytes.is_none(),
        "no value was written yet"
    );
    let mut writer = subject.writer("pioneer.bearing");
    write(&mut writer, 1.5, 4_000_000_000);
    let sample = remote.get("pioneer.bearing").unwrap();
    assert_eq!(number(&sample), Some(1.5));
    assert_eq!(
        (sample.sequence, sample.time, sample.age),
        (1, 4_000_000_000, 1_000_000_000)
    );
    assert_eq!(
        (sample.writer.as_str(), sample.valid_until),
        ("pioneer", u64::MAX)
    );
    assert_eq!(number(&remote.get("goon.gain").unwrap()), Some(0.5));
    writer.retract();
    assert!(remote.get("pioneer.bearing").unwrap().bytes.is_none());
    let error = remote.get("pioneer.baering").err().unwrap().to_string();
    assert_eq!(
        error,
        "`robot` has no variable `pioneer.baering`; did you mean `pioneer.bearing`?"
    );
}

#[test]
fn r7_r19_a_command_or_a_value_whose_validity_is_over_is_none() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let validity = 1_000_000_000;
    for (name, access) in [
        ("sonar", Access::Export { validity }),
        ("speed", Access::Command { validity }),
    ] {
        let declared = Declaration {
            access,
            ..declaration("robot", name, f64::describe())
        };
        subject.board.declare(declared).unwrap();
    }
    let _link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    for name in ["robot.sonar", "robot.speed"] {
        subject.clock.store(5_000_000_000, Ordering::Relaxed);
        subject.board.get(name).unwrap().grant(0);
        write(&mut subject.writer(name), 0.4, 4_500_000_000);
        let sample = remote.get(name).unwrap();
        assert_eq!(
            (number(&sample), sample.valid_until),
            (Some(0.4), 5_500_000_000),
            "{name}"
        );
        let watched = [Rate::Hz(20), Rate::Full].map(|rate| watch(&remote, name, rate));
        for (_, received) in &watched {
            assert_eq!(number(&received.recv_timeout(TIMEOUT).unwrap()), Some(0.4));
        }
        subject.clock.store(6_000_000_000, Ordering::Relaxed);
        // An export at full rate is told by its host, which this subject is not.
        let is_told = [true, name == "robot.speed"];
        for ((_, received), _) in watched.iter().zip(is_told).filter(|(_, is_told)| *is_told) {
            assert!(received.recv_timeout(TIMEOUT).unwrap().bytes.is_none(), "{name}");
        }
        let sample = remote.get(name).unwrap();
        assert!(sample.bytes.is_none(), "{name}");
        let variables = remote.variables(true).unwrap();
        let variable = variables.iter().find(|variable| variable.name == name).unwrap();
        assert!(variable.status.as_ref().unwrap().retracted, "{name}");
    }
}

#[test]
fn values_arrive_while_a_client_subscribes_and_at_once_at_a_late_subscriber() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let _link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    let mut writer = subject.writer("pioneer.bearing");
    write(&mut writer, 1.0, 1);
    let (first, received) = watch(&remote, "pioneer.bearing", Rate::Full);
    assert_eq!(number(&received.recv_timeout(TIMEOUT).unwrap()), Some(1.0));
    for value in [2.0, 3.0, 4.0] {
        write(&mut writer, value, 2);
        assert_eq!(number(&received.recv_timeout(TIMEOUT).unwrap()), Some(value));
    }
    let other = runtime.remote();
    let (late_subscription, late) = watch(&other, "pioneer.bearing", Rate::Full);
    assert_eq!(number(&late.recv_timeout(TIMEOUT).unwrap()), Some(4.0));
    writer.retract();
    assert!(late.recv_timeout(TIMEOUT).unwrap().bytes.is_none());
    assert!(
        received.recv_timeout(TIMEOUT).unwrap().bytes.is_none(),
        "a value that is sent again is not reported again"
    );
    write(&mut writer, 5.0, 3);
    assert_eq!(number(&received.recv_timeout(TIMEOUT).unwrap()), Some(5.0));
    let readers = || subject.board.get("pioneer.bearing").unwrap().status(0).readers;
    assert_eq!(readers(), ["link"]);
    drop((first, received, late_subscription, late));
    until("the link closes its reader", || readers().is_empty());
}

/// A subscriber without a request of its own stands for one whose first message was lost.
#[test]
fn a_value_that_was_lost_on_the_way_arrives_later_although_it_does_not_change() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    for rate in [Rate::Hz(2), Rate::Full] {
        let (_subscription, received) = watch(&remote, "goon.gain", rate);
        assert_eq!(number(&received.recv_timeout(TIMEOUT).unwrap()), Some(0.5));
        let session = raw_session(&format!("unixsock-stream/{}", socket(&runtime.folder).display()));
        let key = format!("jde/1/robot/{}/var/goon/gain/{rate}", link.about().id);
        let late = session.declare_subscriber(key).wait().unwrap();
        assert!(late.recv_timeout(TIMEOUT).unwrap().is_some(), "at rate {rate}");
    }
}

#[test]
fn a_slow_rate_skips_values_and_ends_with_the_newest() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let _link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    let mut writer = subject.writer("pioneer.bearing");
    let (_subscription, received) = watch(&remote, "pioneer.bearing", Rate::Hz(5));
    assert!(received.recv_timeout(TIMEOUT).unwrap().bytes.is_none());
    for value in 1..=1000 {
        write(&mut writer, f64::from(value), 2);
    }
    let mut count = 0;
    while let Ok(sample) = received.recv_timeout(TIMEOUT) {
        count += 1;
        if sample.sequence == 1000 {
            break;
        }
    }
    assert!((1..1000).contains(&count), "{count}");
}

#[test]
fn past_events_arrive_before_new_ones_in_order() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let events = Events::of_records();
    let _link = Link::open(&runtime.settings("robot"), subject, &events).unwrap();
    let record = |number: u64| RunRecord::retracted(number * 1_000_000, "pioneer.laser");
    (1..=3).for_each(|number| events.push(record(number)));
    let remote = runtime.remote();
    let subscribe = || {
        let (sender, received) = channel();
        let subscription = remote.events(&[RecordKind::Event], 2, move |event| drop(sender.send(event)));
        (subscription.unwrap(), received)
    };
    // Without subscribers, events are processed within a quarter of a second.
    until("the third event is stored", || {
        let (_subscription, received) = subscribe();
        received.try_iter().any(|event| event.number == 3)
    });
    let (_subscription, received) = subscribe();
    events.push(record(4));
    let events: Vec<_> = (0..3).map(|_| received.recv_timeout(TIMEOUT).unwrap()).collect();
    let numbers: Vec<_> = events.iter().map(|event| (event.number, event.missed)).collect();
    assert_eq!(numbers, [(2, 0), (3, 0), (4, 0)]);
    assert_eq!(events[2].record, record(4));
}

#[test]
fn snapshots_are_taken_only_on_request() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let _link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    assert_eq!(subject.snapshots.load(Ordering::Relaxed), 0);
    assert_eq!(remote.hierarchy().unwrap().time, 5_000_000_000);
    let (sender, received) = channel();
    let subscription = remote
        .watch_hierarchy(move |snapshot| drop(sender.send(snapshot)))
        .unwrap();
    for _ in 0..3 {
        received.recv_timeout(TIMEOUT).unwrap();
    }
    drop(subscription);
    // A snapshot in progress still arrives.
    while received.recv_timeout(TIMEOUT).is_ok() {}
    let taken = subject.snapshots.load(Ordering::Relaxed);
    remote.variables(true).unwrap();
    assert!(subject.snapshots.load(Ordering::Relaxed) <= taken + 1);
}

#[test]
fn a_snapshot_that_follows_an_operation_shows_its_effect() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let _link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    for second in 6..20 {
        remote.hierarchy().unwrap();
        subject.clock.store(second * 1_000_000_000, Ordering::Relaxed);
        remote.operate(&play("ana", "goon")).unwrap();
        assert_eq!(remote.hierarchy().unwrap().time, second * 1_000_000_000);
    }
}

#[test]
fn a_query_after_a_stop_is_not_answered_with_an_earlier_snapshot() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let link = runtime.open("robot", &subject);
    let session = raw_session(&format!("unixsock-stream/{}", socket(&runtime.folder).display()));
    let root = format!("jde/1/robot/{}", link.about().id);
    let query = |path: &str| {
        let replies = session.get(format!("{root}/{path}")).wait().unwrap();
        move || {
            let reply = replies.recv_timeout(TIMEOUT).unwrap().expect("a reply");
            let sample = reply.into_result().unwrap();
            serde_json::from_slice::<serde_json::Value>(&sample.payload().to_bytes()).unwrap()
        }
    };
    let guard = subject.snapshot_lock.lock();
    let before = query("hierarchy");
    until("a snapshot is being taken", || {
        subject.snapshots.load(Ordering::Relaxed) == 1
    });
    subject.clock.store(6_000_000_000, Ordering::Relaxed);
    let stop = Request {
        by: "ana".to_owned(),
        action: Action::StopAll,
        lease_ms: None,
    };
    let reach = Reach::Local(runtime.folder.clone());
    jde_link::broadcast(&reach, None, &stop, &mut |outcome| {
        assert!(outcome.outcome.is_ok(), "{outcome:?}")
    })
    .unwrap();
    let after = query("hierarchy");
    // Queries of one session are read in order.
    query("about")();
    drop(guard);
    assert_eq!(before()["time"], 5_000_000_000_u64);
    assert_eq!(after()["time"], 6_000_000_000_u64);
}

#[test]
fn r14_an_action_carries_its_operator_and_a_refusal_its_reason() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let _link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    remote.operate(&play("ana@laptop", "goon")).unwrap();
    assert_eq!(
        subject.actions(),
        [("ana@laptop".to_owned(), play("", "goon").action)]
    );
    let error = remote
        .operate(&play("ana@laptop", "unknown"))
        .err()
        .unwrap()
        .to_string();
    assert_eq!(error, "there is no schema `unknown`; did you mean `goon`?");
}

#[test]
fn r14_a_hold_ends_with_its_client() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let _link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    let hold = remote
        .hold(&play("ana", "goon"), Duration::from_millis(300))
        .unwrap();
    assert_eq!(hold.lost(), None);
    drop(hold);
    let let_go = Action::LetGo {
        schema: "goon".to_owned(),
    };
    assert_eq!(subject.actions().last().unwrap().1, let_go);
    // The lease of a client that dies is not renewed.
    let mut request = play("ben", "goon");
    request.lease_ms = Some(100);
    remote.operate(&request).unwrap();
    until("the lease expires", || {
        subject.actions().last() == Some(&("ben".to_owned(), let_go.clone()))
    });
}

#[test]
fn a_folder_that_others_could_have_created_is_refused() {
    let (runtime, subject) = (TestRuntime::new(), TestSubject::new());
    let open = |folder: &Folders| {
        let mut settings = runtime.settings("robot");
        settings.folder = folder.clone();
        Link::open(&settings, subject.clone(), &Events::of_records()).map(drop)
    };
    let files = tempfile::tempdir().unwrap();
    let open_to_all = files.path().join("open");
    std::fs::create_dir(&open_to_all).unwrap();
    std::fs::set_permissions(&open_to_all, std::fs::Permissions::from_mode(0o755)).unwrap();
    let error = open(&Folders::at(&open_to_all)).err().unwrap().to_string();
    assert!(error.contains("others may enter it (mode 755)"), "{error}");
    let private = files.path().join("private");
    open(&Folders::at(&private)).unwrap();
    let link = files.path().join("link");
    symlink(&private, &link).unwrap();
    let error = open(&Folders::at(&link)).err().unwrap().to_string();
    assert!(error.contains("it is not a folder"), "{error}");
    let error = open(&Folders::at(files.path().join("no/where")))
        .err()
        .unwrap()
        .to_string();
    assert!(error.contains("cannot be used"), "{error}");
    assert!(Client::connect(&Reach::Local(Folders::at(&open_to_all))).is_err());
    let long = files.path().join("x".repeat(120));
    let error = open(&Folders::at(long)).err().unwrap().to_string();
    assert!(error.contains("a shorter path"), "{error}");
}
