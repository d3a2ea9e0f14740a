//! Applications and tools of one user on one machine, over real sockets.

use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::sync::atomic::Ordering;
use std::sync::mpsc::channel;
use std::time::Duration;

use jde_link::message::{Action, Network, Request};
use jde_link::{Client, Error, Events, Folders, Link, Rate, Reach};
use jde_records::{RecordKind, RunRecord};
use zenoh::Wait;

use crate::common::{Home, SOON, Stage, number, socket, stranger, until, watch, write};

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
fn an_application_is_found_and_says_what_it_is() {
    let (home, stage) = (Home::new(), Stage::new());
    assert!(home.client().applications().unwrap().is_empty());
    let link = home.open("robot", &stage);
    let found = home.client().applications().unwrap();
    assert_eq!(found, [link.about().clone()]);
    assert_eq!(
        (found[0].name.as_str(), found[0].pid),
        ("robot", std::process::id())
    );
    assert_eq!(found[0].network, Network::Closed);
    let remote = home.remote();
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
fn whoever_leaves_is_gone_at_once_and_says_so() {
    let (home, stage) = (Home::new(), Stage::new());
    let link = home.open("robot", &stage);
    let remote = home.remote();
    let (tell, told) = channel();
    remote.on_gone(move || tell.send(()).unwrap_or_default());
    assert!(remote.is_alive());
    drop(link);
    told.recv_timeout(SOON).unwrap();
    assert!(!remote.is_alive());
    assert!(matches!(remote.hierarchy(), Err(Error::Disconnected(name)) if name == "robot"));
    assert!(home.client().applications().unwrap().is_empty());
    let left = std::fs::read_dir(home.folder.path()).unwrap().flatten();
    let left: Vec<_> = left.map(|file| file.file_name()).collect();
    assert_eq!(left, ["lock"], "nothing of it stays");
}

#[test]
fn the_second_of_a_name_gets_a_number_unless_it_insists() {
    let (home, stage) = (Home::new(), Stage::new());
    let first = home.open("robot", &stage);
    let second = home.open("robot", &stage);
    assert_eq!(first.about().name, "robot");
    assert_eq!(second.about().name, "robot-2");
    let mut settings = home.settings("robot");
    settings.require_name = true;
    let refused = Link::open(&settings, stage.clone(), &Events::of_records())
        .err()
        .unwrap();
    assert!(
        matches!(refused, Error::NameTaken { ref name, .. } if name == "robot"),
        "{refused}"
    );
    let client = home.client();
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
fn a_value_arrives_with_all_that_is_known_of_it() {
    let (home, stage) = (Home::new(), Stage::new());
    let _link = home.open("robot", &stage);
    let remote = home.remote();
    assert!(
        remote.get("pioneer.bearing").unwrap().bytes.is_none(),
        "there is none yet"
    );
    let mut writer = stage.writer("pioneer.bearing");
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
fn values_come_while_somebody_wants_them_and_to_a_late_joiner_at_once() {
    let (home, stage) = (Home::new(), Stage::new());
    let _link = home.open("robot", &stage);
    let remote = home.remote();
    let mut writer = stage.writer("pioneer.bearing");
    write(&mut writer, 1.0, 1);
    let (first, told) = watch(&remote, "pioneer.bearing", Rate::Full);
    assert_eq!(number(&told.recv_timeout(SOON).unwrap()), Some(1.0));
    for value in [2.0, 3.0, 4.0] {
        write(&mut writer, value, 2);
        assert_eq!(number(&told.recv_timeout(SOON).unwrap()), Some(value));
    }
    let other = home.remote();
    let (_late, late) = watch(&other, "pioneer.bearing", Rate::Full);
    assert_eq!(number(&late.recv_timeout(SOON).unwrap()), Some(4.0));
    writer.retract();
    assert!(late.recv_timeout(SOON).unwrap().bytes.is_none());
    assert!(
        told.recv_timeout(SOON).unwrap().bytes.is_none(),
        "what came again was not told again"
    );
    write(&mut writer, 5.0, 3);
    assert_eq!(number(&told.recv_timeout(SOON).unwrap()), Some(5.0));
    let readers = || stage.board.get("pioneer.bearing").unwrap().status(0).readers;
    assert_eq!(readers(), ["link"]);
    drop((first, told, _late, late));
    until("nobody reads what nobody wants", || readers().is_empty());
}

/// A subscriber without a request of its own stands for one whose first message was lost.
#[test]
fn a_value_that_was_lost_on_the_way_arrives_later_although_it_does_not_change() {
    let (home, stage) = (Home::new(), Stage::new());
    let link = home.open("robot", &stage);
    let remote = home.remote();
    for rate in [Rate::Hz(2), Rate::Full] {
        let (_subscription, received) = watch(&remote, "goon.gain", rate);
        assert_eq!(number(&received.recv_timeout(SOON).unwrap()), Some(0.5));
        let session = stranger(&format!("unixsock-stream/{}", socket(&home.folder).display()));
        let key = format!("jde/1/robot/{}/var/goon/gain/{rate}", link.about().id);
        let late = session.declare_subscriber(key).wait().unwrap();
        assert!(late.recv_timeout(SOON).unwrap().is_some(), "at rate {rate}");
    }
}

#[test]
fn a_slow_rate_leaves_values_out_and_ends_with_the_newest() {
    let (home, stage) = (Home::new(), Stage::new());
    let _link = home.open("robot", &stage);
    let remote = home.remote();
    let mut writer = stage.writer("pioneer.bearing");
    let (_watching, told) = watch(&remote, "pioneer.bearing", Rate::Hz(5));
    assert!(told.recv_timeout(SOON).unwrap().bytes.is_none());
    for value in 1..=1000 {
        write(&mut writer, f64::from(value), 2);
    }
    let mut came = 0;
    while let Ok(sample) = told.recv_timeout(SOON) {
        came += 1;
        if sample.sequence == 1000 {
            break;
        }
    }
    assert!((1..1000).contains(&came), "{came}");
}

#[test]
fn events_come_in_order_after_those_that_were_before() {
    let (home, stage) = (Home::new(), Stage::new());
    let events = Events::of_records();
    let _link = Link::open(&home.settings("robot"), stage, &events).unwrap();
    let line = |number: u64| RunRecord::retracted(number * 1_000_000, "pioneer.laser");
    (1..=3).for_each(|number| events.push(line(number)));
    let remote = home.remote();
    let earlier = || {
        let (tell, told) = channel();
        let watching = remote.events(&[RecordKind::Event], 2, move |happened| drop(tell.send(happened)));
        (watching.unwrap(), told)
    };
    // Without subscribers, events are processed within a quarter of a second.
    until("the third is known", || {
        let (_watching, told) = earlier();
        told.try_iter().any(|happened| happened.number == 3)
    });
    let (_watching, told) = earlier();
    events.push(line(4));
    let heard: Vec<_> = (0..3).map(|_| told.recv_timeout(SOON).unwrap()).collect();
    let numbers: Vec<_> = heard
        .iter()
        .map(|happened| (happened.number, happened.missed))
        .collect();
    assert_eq!(numbers, [(2, 0), (3, 0), (4, 0)]);
    assert_eq!(heard[2].record, line(4));
}

#[test]
fn a_snapshot_is_taken_for_those_who_look_and_for_nobody_else() {
    let (home, stage) = (Home::new(), Stage::new());
    let _link = home.open("robot", &stage);
    let remote = home.remote();
    assert_eq!(stage.snapshots.load(Ordering::Relaxed), 0);
    assert_eq!(remote.hierarchy().unwrap().time, 5_000_000_000);
    let (tell, told) = channel();
    let watching = remote
        .watch_hierarchy(move |snapshot| drop(tell.send(snapshot)))
        .unwrap();
    for _ in 0..3 {
        told.recv_timeout(SOON).unwrap();
    }
    drop(watching);
    // A snapshot in progress still arrives.
    while told.recv_timeout(SOON).is_ok() {}
    let taken = stage.snapshots.load(Ordering::Relaxed);
    remote.variables(true).unwrap();
    assert!(stage.snapshots.load(Ordering::Relaxed) <= taken + 1);
}

#[test]
fn a_snapshot_that_follows_an_operation_shows_its_effect() {
    let (home, stage) = (Home::new(), Stage::new());
    let _link = home.open("robot", &stage);
    let remote = home.remote();
    for second in 6..20 {
        remote.hierarchy().unwrap();
        stage.clock.store(second * 1_000_000_000, Ordering::Relaxed);
        remote.operate(&play("ana", "goon")).unwrap();
        assert_eq!(remote.hierarchy().unwrap().time, second * 1_000_000_000);
    }
}

#[test]
fn a_snapshot_taken_before_a_stop_answers_nobody_who_asks_after_it() {
    let (home, stage) = (Home::new(), Stage::new());
    let link = home.open("robot", &stage);
    let session = stranger(&format!("unixsock-stream/{}", socket(&home.folder).display()));
    let root = format!("jde/1/robot/{}", link.about().id);
    let ask = |what: &str| {
        let replies = session.get(format!("{root}/{what}")).wait().unwrap();
        move || {
            let reply = replies.recv_timeout(SOON).unwrap().expect("a reply");
            let sample = reply.into_result().unwrap();
            serde_json::from_slice::<serde_json::Value>(&sample.payload().to_bytes()).unwrap()
        }
    };
    let held = stage.hold_snapshots.lock().unwrap();
    let before = ask("hierarchy");
    until("a snapshot is being taken", || {
        stage.snapshots.load(Ordering::Relaxed) == 1
    });
    stage.clock.store(6_000_000_000, Ordering::Relaxed);
    let stop = Request {
        by: "ana".to_owned(),
        action: Action::StopAll,
        lease_ms: None,
    };
    let reach = Reach::Local(home.folder.clone());
    jde_link::broadcast(&reach, None, &stop, &mut |what| {
        assert!(what.outcome.is_ok(), "{what:?}")
    })
    .unwrap();
    let after = ask("hierarchy");
    // Queries of one session are read in order.
    ask("about")();
    drop(held);
    assert_eq!(before()["time"], 5_000_000_000_u64);
    assert_eq!(after()["time"], 6_000_000_000_u64);
}

#[test]
fn r14_an_operator_acts_by_name_and_hears_why_not() {
    let (home, stage) = (Home::new(), Stage::new());
    let _link = home.open("robot", &stage);
    let remote = home.remote();
    remote.operate(&play("ana@laptop", "goon")).unwrap();
    assert_eq!(stage.acts(), [("ana@laptop".to_owned(), play("", "goon").action)]);
    let error = remote
        .operate(&play("ana@laptop", "nobody"))
        .err()
        .unwrap()
        .to_string();
    assert_eq!(error, "there is no schema `nobody`; did you mean `goon`?");
}

#[test]
fn r14_a_hold_ends_with_whoever_holds() {
    let (home, stage) = (Home::new(), Stage::new());
    let _link = home.open("robot", &stage);
    let remote = home.remote();
    let hold = remote
        .hold(&play("ana", "goon"), Duration::from_millis(300))
        .unwrap();
    assert_eq!(hold.lost(), None);
    drop(hold);
    let let_go = Action::LetGo {
        schema: "goon".to_owned(),
    };
    assert_eq!(stage.acts().last().unwrap().1, let_go);
    // A client that dies: its lease is not renewed.
    let mut request = play("ben", "goon");
    request.lease_ms = Some(100);
    remote.operate(&request).unwrap();
    until("the lease runs out", || {
        stage.acts().last() == Some(&("ben".to_owned(), let_go.clone()))
    });
}

#[test]
fn a_folder_that_others_could_have_made_is_refused() {
    let (home, stage) = (Home::new(), Stage::new());
    let opened = |folder: &Folders| {
        let mut settings = home.settings("robot");
        settings.folder = folder.clone();
        Link::open(&settings, stage.clone(), &Events::of_records()).map(drop)
    };
    let files = tempfile::tempdir().unwrap();
    let open_to_all = files.path().join("open");
    std::fs::create_dir(&open_to_all).unwrap();
    std::fs::set_permissions(&open_to_all, std::fs::Permissions::from_mode(0o755)).unwrap();
    let error = opened(&Folders::at(&open_to_all)).err().unwrap().to_string();
    assert!(error.contains("others may enter it (mode 755)"), "{error}");
    let private = files.path().join("private");
    opened(&Folders::at(&private)).unwrap();
    let link = files.path().join("link");
    symlink(&private, &link).unwrap();
    let error = opened(&Folders::at(&link)).err().unwrap().to_string();
    assert!(error.contains("it is no folder"), "{error}");
    let error = opened(&Folders::at(files.path().join("no/where")))
        .err()
        .unwrap()
        .to_string();
    assert!(error.contains("cannot be used"), "{error}");
    assert!(Client::connect(&Reach::Local(Folders::at(&open_to_all))).is_err());
    let long = files.path().join("x".repeat(120));
    let error = opened(&Folders::at(long)).err().unwrap().to_string();
    assert!(error.contains("nearer to the root"), "{error}");
}
