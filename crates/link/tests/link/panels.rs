//! Panels over the link: drawn while clients watch, the same for all of them, and touched by clients with
//! permission.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use jde_link::message::{Action, Request, SchemaInfo, Schemas};
use jde_link::{Access, Link, OnDrawn, PanelSample, PanelViewer, Rate, Remote, Subscription};
use jde_panel::PanelFrame;
use jde_panel::{Button, Gesture, Item, List, Touch};
use zenoh::Wait;

use crate::common::{Home, SOON, Stage, socket, stranger, until};
use crate::network;
use crate::processes::Actor;

/// The panel of the schema `goon`, drawn by a test.
#[derive(Default)]
pub(crate) struct Easel {
    /// Whether the schema has a panel.
    is_there: AtomicBool,
    sequence: AtomicU64,
    next: AtomicU64,
    newest: Mutex<Option<Arc<PanelFrame>>>,
    lookers: Mutex<Vec<(u64, f64, OnDrawn)>>,
}

struct Look {
    easel: Arc<Easel>,
    number: u64,
}

impl Easel {
    /// The schemas; `goon` has a panel once `is_there` is set.
    pub(crate) fn schemas(&self) -> Schemas {
        let schema = |name: &str, panel| SchemaInfo {
            name: name.to_owned(),
            type_name: "test/test".to_owned(),
            kind: "motor".to_owned(),
            doc: String::new(),
            father: None,
            group: None,
            period_s: 0.1,
            budget_s: 0.1,
            children: Vec::new(),
            ports: Vec::new(),
            panel,
        };
        if !self.is_there.load(Ordering::Relaxed) {
            return Schemas::default();
        }
        Schemas {
            schemas: vec![schema("goon", true), schema("vff", false)],
            groups: Vec::new(),
        }
    }

    pub(crate) fn look(easel: &Arc<Self>, rate: f64, news: OnDrawn) -> Box<dyn PanelViewer> {
        let number = easel.next.fetch_add(1, Ordering::Relaxed);
        easel.lookers.lock().unwrap().push((number, rate, news));
        let easel = Arc::clone(easel);
        Box::new(Look { easel, number })
    }

    /// Draws anew; returns the sequence number.
    pub(crate) fn draw(&self, list: Result<List, &str>) -> u64 {
        let sequence = self.sequence.fetch_add(1, Ordering::Relaxed) + 1;
        *self.newest.lock().unwrap() = Some(Arc::new(PanelFrame {
            sequence,
            time: 3_000_000_000,
            took: Duration::ZERO,
            failed: 0,
            list: list.map_err(str::to_owned),
        }));
        for (_, _, news) in &*self.lookers.lock().unwrap() {
            news();
        }
        sequence
    }

    /// The rate that each viewer requests.
    fn rates(&self) -> Vec<f64> {
        let lookers = self.lookers.lock().unwrap();
        let mut rates: Vec<_> = lookers.iter().map(|(_, rate, _)| *rate).collect();
        rates.sort_by(f64::total_cmp);
        rates
    }
}

impl PanelViewer for Look {
    fn newest(&self) -> Option<Arc<PanelFrame>> {
        self.easel.newest.lock().unwrap().clone()
    }
}

impl Drop for Look {
    fn drop(&mut self) {
        let mut lookers = self.easel.lookers.lock().unwrap();
        lookers.retain(|(number, ..)| *number != self.number);
    }
}

/// An application with a panel.
pub(crate) fn stage() -> Arc<Stage> {
    let stage = Stage::new();
    stage.easel.is_there.store(true, Ordering::Relaxed);
    stage
}

/// A distinct list for each value.
pub(crate) fn list(value: u64) -> List {
    List {
        time: 3_000_000_000,
        items: vec![Item::Value {
            label: "number".to_owned(),
            value: value as f64,
            unit: String::new(),
        }],
    }
}

fn look(remote: &Remote, rate: Rate) -> (Subscription, Receiver<PanelSample>) {
    let (tell, told) = channel();
    let watching = remote
        .watch_panel("goon", rate, move |panel| drop(tell.send(panel)))
        .unwrap();
    (watching, told)
}

fn click() -> Gesture {
    Gesture {
        widget: "field".to_owned(),
        touch: Touch::Clicked {
            at: [1.2, 3.4, 0.0],
            button: Button::Primary,
        },
    }
}

#[test]
fn a_panel_is_drawn_while_somebody_looks_and_all_see_the_same() {
    let (home, stage) = (Home::new(), stage());
    let _link = home.open("robot", &stage);
    assert!(stage.easel.rates().is_empty(), "nobody looks");
    let (one, other) = (home.remote(), home.remote());
    let (watching, told) = look(&one, Rate::Full);
    let (slow, told_slowly) = look(&other, Rate::Hz(2));
    until("both look", || stage.easel.rates() == [2.0, 30.0]);
    let number = stage.easel.draw(Ok(list(1)));
    for told in [&told, &told_slowly] {
        let panel = told.recv_timeout(SOON).unwrap();
        assert_eq!((panel.list, panel.sequence), (Ok(list(1)), number));
        assert_eq!((panel.time, panel.age), (3_000_000_000, 2_000_000_000));
    }
    for value in 2..=50 {
        let number = stage.easel.draw(Ok(list(value)));
        // Each drawing is sent before the next is drawn, so all arrive in order.
        let panel = told.recv_timeout(SOON).unwrap();
        assert_eq!((panel.list, panel.sequence), (Ok(list(value)), number));
    }
    drop(watching);
    until("one looks", || stage.easel.rates() == [2.0]);
    drop(slow);
    until("nobody looks", || stage.easel.rates().is_empty());
}

#[test]
fn whoever_wants_less_gets_less_and_the_newest_in_the_end() {
    let (home, stage) = (Home::new(), stage());
    let _link = home.open("robot", &stage);
    let remote = home.remote();
    let start = Instant::now();
    let (_watching, told) = look(&remote, Rate::Hz(10));
    until("it looks", || !stage.easel.rates().is_empty());
    let mut seen = 0;
    let mut last = 0;
    for value in 1..=200 {
        last = stage.easel.draw(Ok(list(value)));
        seen += told.try_iter().count();
    }
    loop {
        let panel = told.recv_timeout(SOON).unwrap();
        seen += 1;
        if panel.sequence == last {
            break;
        }
    }
    let most = start.elapsed().as_secs_f64() * 10.0 + 2.0;
    assert!(seen as f64 <= most, "{seen} in {:?}", start.elapsed());
}

#[test]
fn a_late_comer_gets_the_newest_at_once_and_nobody_gets_it_twice() {
    let (home, stage) = (Home::new(), stage());
    let _link = home.open("robot", &stage);
    let (first, second) = (home.remote(), home.remote());
    let (_watching, told) = look(&first, Rate::Hz(5));
    until("it looks", || !stage.easel.rates().is_empty());
    stage.easel.draw(Ok(list(1)));
    assert_eq!(told.recv_timeout(SOON).unwrap().list, Ok(list(1)));
    let (_late, told_late) = look(&second, Rate::Hz(5));
    assert_eq!(told_late.recv_timeout(SOON).unwrap().list, Ok(list(1)));
    stage.easel.draw(Ok(list(2)));
    assert_eq!(told.recv_timeout(SOON).unwrap().list, Ok(list(2)));
}

#[test]
fn what_cannot_be_shown_comes_as_the_reason() {
    let (home, stage) = (Home::new(), stage());
    let _link = home.open("robot", &stage);
    let remote = home.remote();
    let (_watching, told) = look(&remote, Rate::Full);
    until("it looks", || !stage.easel.rates().is_empty());
    stage.easel.draw(Err("it panicked: no laser"));
    let panel = told.recv_timeout(SOON).unwrap();
    assert_eq!(panel.list, Err("it panicked: no laser".to_owned()));
    let mut broken = list(1);
    broken.items.push(Item::Value {
        label: "load".to_owned(),
        value: f64::INFINITY,
        unit: String::new(),
    });
    stage.easel.draw(Ok(broken));
    let reason = told.recv_timeout(SOON).unwrap().list.unwrap_err();
    assert!(reason.contains("load") && reason.contains("inf"), "{reason}");
    for (schema, part) in [("vff", "has no panel"), ("gon", "did you mean `goon`?")] {
        let refused = remote.watch_panel(schema, Rate::Full, |_| {});
        let error = refused.err().unwrap().to_string();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn r14_gestures_are_handed_in_as_the_doings_of_whoever_did_them() {
    let (home, stage) = (Home::new(), stage());
    let _link = home.open("robot", &stage);
    let remote = home.remote();
    remote.touch("ana@laptop", "goon", click()).unwrap();
    let touched = Action::Touch {
        schema: "goon".to_owned(),
        gesture: click(),
    };
    assert_eq!(stage.acts(), [("ana@laptop".to_owned(), touched.clone())]);
    let leased = Request {
        by: "ana@laptop".to_owned(),
        action: touched,
        lease_ms: Some(1000),
    };
    let error = remote.operate(&leased).err().unwrap().to_string();
    assert!(error.contains("no lease"), "{error}");
    assert_eq!(stage.acts().len(), 1);
}

#[test]
fn whoever_floods_with_gestures_keeps_no_operator_from_acting() {
    let (home, stage) = (Home::new(), stage());
    let link = home.open("robot", &stage);
    let flood = stranger(&format!("unixsock-stream/{}", socket(&home.folder).display()));
    keeps_no_operator_from_acting(&flood, &link, &stage);
    let remote = home.remote();
    for _ in 0..50 {
        remote.operate(&stop()).unwrap();
    }
}

#[test]
fn r14_whoever_floods_across_the_network_keeps_no_operator_from_acting() {
    let home = Home::new();
    let (link, stage, endpoint) = network::open(&home, "tcp", |settings| settings.access = Access::Operate);
    keeps_no_operator_from_acting(&stranger(&endpoint), &link, &stage);
}

fn stop() -> Request {
    Request {
        by: "ana".to_owned(),
        action: Action::Stop {
            schema: "goon".to_owned(),
        },
        lease_ms: None,
    }
}

/// Sends more gestures than the queue permits and then a stop, through one door.
fn keeps_no_operator_from_acting(flood: &zenoh::Session, link: &Link, stage: &Arc<Stage>) {
    let key = format!("jde/1/robot/{}/operate", link.about().id);
    let request = Request {
        by: "eva".to_owned(),
        action: Action::Touch {
            schema: "goon".to_owned(),
            gesture: click(),
        },
        lease_ms: None,
    };
    let request = serde_json::to_vec(&request).unwrap();
    let held = stage.hold.lock().unwrap();
    // More than the queue permits; the first is not finished before the stop is requested.
    let open = Arc::new(());
    for _ in 0..400 {
        let open = Arc::clone(&open);
        let get = flood.get(key.as_str()).payload(request.clone());
        get.callback(move |_| drop(Arc::clone(&open))).wait().unwrap();
    }
    until("most are refused", || Arc::strong_count(&open) < 100);
    let stop = stop();
    let (tell, told) = channel();
    let get = flood
        .get(key.as_str())
        .payload(serde_json::to_vec(&stop).unwrap());
    get.callback(move |reply| tell.send(reply.into_result().is_ok()).unwrap())
        .wait()
        .unwrap();
    // Later and less urgent queries are answered later.
    let about = flood.get(key.replace("operate", "about")).wait().unwrap();
    assert!(about.recv_timeout(SOON).unwrap().is_some());
    drop(held);
    assert_eq!(told.recv_timeout(SOON), Ok(true), "the stop was carried out");
    until("both are done", || {
        let acts = stage.acts();
        acts.contains(&("ana".to_owned(), stop.action.clone())) && acts.iter().any(|(by, _)| by == "eva")
    });
}

#[test]
fn a_viewer_that_is_killed_looks_no_longer_and_the_others_still_see() {
    let (home, stage) = (Home::new(), stage());
    let _link = home.open("robot", &stage);
    let remote = home.remote();
    let (_watching, told) = look(&remote, Rate::Full);
    until("it looks", || stage.easel.rates() == [30.0]);
    let viewer = Actor::start("viewer", &home);
    until("both look", || stage.easel.rates() == [5.0, 30.0]);
    drop(viewer);
    until("its look ends", || stage.easel.rates() == [30.0]);
    stage.easel.draw(Ok(list(1)));
    assert_eq!(told.recv_timeout(SOON).unwrap().list, Ok(list(1)));
}

#[test]
fn a_look_at_what_is_nowhere_is_none() {
    let (home, stage) = (Home::new(), stage());
    let link = home.open("robot", &stage);
    let root = format!("jde/1/robot/{}", link.about().id);
    let stranger = stranger(&format!("unixsock-stream/{}", socket(&home.folder).display()));
    let tokens = [
        "look",
        "look/vff/5hz/x",
        "look/goon/7hz/x",
        "look/nobody/full/x",
        "look/goon/5hz/x/y",
    ];
    let _tokens: Vec<_> = tokens
        .iter()
        .map(|token| {
            stranger
                .liveliness()
                .declare_token(format!("{root}/{token}"))
                .wait()
                .unwrap()
        })
        .collect();
    let remote = home.remote();
    let (_watching, told) = look(&remote, Rate::Full);
    until("it looks", || !stage.easel.rates().is_empty());
    stage.easel.draw(Ok(list(1)));
    told.recv_timeout(SOON).unwrap();
    assert_eq!(stage.easel.rates(), [30.0]);
}
