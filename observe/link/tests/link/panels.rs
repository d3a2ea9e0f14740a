//! Panels over the link: they are drawn while clients watch, are the same for all clients, and receive the
//! gestures of clients with permission.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use jde_link::message::{Action, Request, SchemaInfo, Schemas};
use jde_link::{Access, Link, OnDrawn, PanelSample, PanelViewer, Rate, Remote, Subscription};
use jde_panel::PanelFrame;
use jde_panel::{Button, Gesture, Item, List, Touch};
use parking_lot::Mutex;
use zenoh::Wait;

use crate::common::{TIMEOUT, TestRuntime, TestSubject, raw_session, socket, until};
use crate::network;
use crate::processes::ChildProcess;

/// The panel of the schema `goon`, drawn by a test.
#[derive(Default)]
pub(crate) struct TestPanel {
    /// Whether the schema has a panel.
    exists: AtomicBool,
    sequence: AtomicU64,
    next: AtomicU64,
    newest: Mutex<Option<Arc<PanelFrame>>>,
    viewers: Mutex<Vec<(u64, f64, OnDrawn)>>,
}

struct TestViewer {
    panel: Arc<TestPanel>,
    number: u64,
}

impl TestPanel {
    /// The schemas; `goon` has a panel once `exists` is set.
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
        if !self.exists.load(Ordering::Relaxed) {
            return Schemas::default();
        }
        Schemas {
            schemas: vec![schema("goon", true), schema("vff", false)],
            groups: Vec::new(),
        }
    }

    pub(crate) fn view(panel: &Arc<Self>, rate: f64, on_drawn: OnDrawn) -> Box<dyn PanelViewer> {
        let number = panel.next.fetch_add(1, Ordering::Relaxed);
        panel.viewers.lock().push((number, rate, on_drawn));
        let panel = Arc::clone(panel);
        Box::new(TestViewer { panel, number })
    }

    /// Draws a new frame and returns its sequence number.
    pub(crate) fn draw(&self, list: Result<List, &str>) -> u64 {
        let sequence = self.sequence.fetch_add(1, Ordering::Relaxed) + 1;
        *self.newest.lock() = Some(Arc::new(PanelFrame {
            sequence,
            time: 3_000_000_000,
            took: Duration::ZERO,
            failed: 0,
            list: list.map_err(str::to_owned),
        }));
        for (_, _, on_drawn) in &*self.viewers.lock() {
            on_drawn();
        }
        sequence
    }

    /// The rate that each viewer requests.
    fn rates(&self) -> Vec<f64> {
        let viewers = self.viewers.lock();
        let mut rates: Vec<_> = viewers.iter().map(|(_, rate, _)| *rate).collect();
        rates.sort_by(f64::total_cmp);
        rates
    }
}

impl PanelViewer for TestViewer {
    fn newest(&self) -> Option<Arc<PanelFrame>> {
        self.panel.newest.lock().clone()
    }
}

impl Drop for TestViewer {
    fn drop(&mut self) {
        let mut viewers = self.panel.viewers.lock();
        viewers.retain(|(number, ..)| *number != self.number);
    }
}

/// An application with a panel.
pub(crate) fn subject_with_panel() -> Arc<TestSubject> {
    let subject = TestSubject::new();
    subject.panel.exists.store(true, Ordering::Relaxed);
    subject
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

fn watch_panel(remote: &Remote, rate: Rate) -> (Subscription, Receiver<PanelSample>) {
    let (sender, received) = channel();
    let subscription = remote
        .watch_panel("goon", rate, move |panel| drop(sender.send(panel)))
        .unwrap();
    (subscription, received)
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
fn a_panel_is_drawn_while_clients_watch_and_is_the_same_for_all() {
    let (runtime, subject) = (TestRuntime::new(), subject_with_panel());
    let _link = runtime.open("robot", &subject);
    assert!(subject.panel.rates().is_empty(), "no client watches");
    let (first_client, second_client) = (runtime.remote(), runtime.remote());
    let (subscription, received) = watch_panel(&first_client, Rate::Full);
    let (slow_subscription, received_slowly) = watch_panel(&second_client, Rate::Hz(2));
    until("both clients watch", || subject.panel.rates() == [2.0, 30.0]);
    let number = subject.panel.draw(Ok(list(1)));
    for received in [&received, &received_slowly] {
        let panel = received.recv_timeout(TIMEOUT).unwrap();
        assert_eq!((panel.list, panel.sequence), (Ok(list(1)), number));
        assert_eq!((panel.time, panel.age), (3_000_000_000, 2_000_000_000));
    }
    for value in 2..=50 {
        let number = subject.panel.draw(Ok(list(value)));
        // Each drawing is sent before the next is drawn, so all arrive in order.
        let panel = received.recv_timeout(TIMEOUT).unwrap();
        assert_eq!((panel.list, panel.sequence), (Ok(list(value)), number));
    }
    drop(subscription);
    until("one client watches", || subject.panel.rates() == [2.0]);
    drop(slow_subscription);
    until("no client watches", || subject.panel.rates().is_empty());
}

#[test]
fn a_low_rate_skips_drawings_and_ends_with_the_newest() {
    let (runtime, subject) = (TestRuntime::new(), subject_with_panel());
    let _link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    let start = Instant::now();
    let (_subscription, received) = watch_panel(&remote, Rate::Hz(10));
    until("the client watches", || !subject.panel.rates().is_empty());
    let mut count = 0;
    let mut last = 0;
    for value in 1..=200 {
        last = subject.panel.draw(Ok(list(value)));
        count += received.try_iter().count();
    }
    loop {
        let panel = received.recv_timeout(TIMEOUT).unwrap();
        count += 1;
        if panel.sequence == last {
            break;
        }
    }
    let limit = start.elapsed().as_secs_f64() * 10.0 + 2.0;
    assert!(count as f64 <= limit, "{count} in {:?}", start.elapsed());
}

#[test]
fn a_late_client_receives_the_newest_drawing_at_once_and_others_not_twice() {
    let (runtime, subject) = (TestRuntime::new(), subject_with_panel());
    let _link = runtime.open("robot", &subject);
    let (first, second) = (runtime.remote(), runtime.remote());
    let (_subscription, received) = watch_panel(&first, Rate::Hz(5));
    until("the client watches", || !subject.panel.rates().is_empty());
    subject.panel.draw(Ok(list(1)));
    assert_eq!(received.recv_timeout(TIMEOUT).unwrap().list, Ok(list(1)));
    let (_late_subscription, received_late) = watch_panel(&second, Rate::Hz(5));
    assert_eq!(received_late.recv_timeout(TIMEOUT).unwrap().list, Ok(list(1)));
    subject.panel.draw(Ok(list(2)));
    assert_eq!(received.recv_timeout(TIMEOUT).unwrap().list, Ok(list(2)));
}

#[test]
fn a_panel_that_cannot_be_shown_is_replaced_by_the_reason() {
    let (runtime, subject) = (TestRuntime::new(), subject_with_panel());
    let _link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    let (_subscription, received) = watch_panel(&remote, Rate::Full);
    until("the client watches", || !subject.panel.rates().is_empty());
    subject.panel.draw(Err("it panicked: no laser"));
    let panel = received.recv_timeout(TIMEOUT).unwrap();
    assert_eq!(panel.list, Err("it panicked: no laser".to_owned()));
    let mut invalid = list(1);
    invalid.items.push(Item::Value {
        label: "load".to_owned(),
        value: f64::INFINITY,
        unit: String::new(),
    });
    subject.panel.draw(Ok(invalid));
    let reason = received.recv_timeout(TIMEOUT).unwrap().list.unwrap_err();
    assert!(reason.contains("load") && reason.contains("inf"), "{reason}");
    for (schema, part) in [("vff", "has no panel"), ("gon", "did you mean `goon`?")] {
        let refused = remote.watch_panel(schema, Rate::Full, |_| {});
        let error = refused.err().unwrap().to_string();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn r14_a_gesture_carries_the_name_of_its_operator() {
    let (runtime, subject) = (TestRuntime::new(), subject_with_panel());
    let _link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    remote.touch("ana@laptop", "goon", click()).unwrap();
    let touched = Action::Touch {
        schema: "goon".to_owned(),
        gesture: click(),
    };
    assert_eq!(subject.actions(), [("ana@laptop".to_owned(), touched.clone())]);
    let leased = Request {
        by: "ana@laptop".to_owned(),
        action: touched,
        lease_ms: Some(1000),
    };
    let error = remote.operate(&leased).err().unwrap().to_string();
    assert!(error.contains("no lease"), "{error}");
    assert_eq!(subject.actions().len(), 1);
}

#[test]
fn operators_can_act_during_a_local_flood_of_gestures() {
    let (runtime, subject) = (TestRuntime::new(), subject_with_panel());
    let link = runtime.open("robot", &subject);
    let flood = raw_session(&format!("unixsock-stream/{}", socket(&runtime.folder).display()));
    check_stop_during_flood(&flood, &link, &subject);
    let remote = runtime.remote();
    for _ in 0..50 {
        remote.operate(&stop()).unwrap();
    }
}

#[test]
fn r14_operators_can_act_during_a_flood_of_gestures_over_the_network() {
    let runtime = TestRuntime::new();
    let (link, subject, endpoint) =
        network::open(&runtime, "tcp", |settings| settings.access = Access::Operate);
    check_stop_during_flood(&raw_session(&endpoint), &link, &subject);
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

/// Sends more gestures than the queue permits, and then a stop through the same session.
fn check_stop_during_flood(flood: &zenoh::Session, link: &Link, subject: &Arc<TestSubject>) {
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
    let guard = subject.gesture_lock.lock();
    // More than the queue permits; the first is not finished before the stop is requested.
    let open = Arc::new(());
    for _ in 0..400 {
        let open = Arc::clone(&open);
        let get = flood.get(key.as_str()).payload(request.clone());
        get.callback(move |_| drop(Arc::clone(&open))).wait().unwrap();
    }
    until("most requests are refused", || Arc::strong_count(&open) < 100);
    let stop = stop();
    let (sender, received) = channel();
    let get = flood
        .get(key.as_str())
        .payload(serde_json::to_vec(&stop).unwrap());
    get.callback(move |reply| sender.send(reply.into_result().is_ok()).unwrap())
        .wait()
        .unwrap();
    // Later queries of lower priority are answered later.
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
        actions.contains(&("ana".to_owned(), stop.action.clone()))
            && actions.iter().any(|(by, _)| by == "eva")
    });
}

#[test]
fn a_killed_viewer_is_removed_and_the_others_still_receive() {
    let (runtime, subject) = (TestRuntime::new(), subject_with_panel());
    let _link = runtime.open("robot", &subject);
    let remote = runtime.remote();
    let (_subscription, received) = watch_panel(&remote, Rate::Full);
    until("the client watches", || subject.panel.rates() == [30.0]);
    let viewer = ChildProcess::start("viewer", &runtime);
    until("both clients watch", || subject.panel.rates() == [5.0, 30.0]);
    drop(viewer);
    until("the killed viewer no longer watches", || {
        subject.panel.rates() == [30.0]
    });
    subject.panel.draw(Ok(list(1)));
    assert_eq!(received.recv_timeout(TIMEOUT).unwrap().list, Ok(list(1)));
}

#[test]
fn invalid_panel_tokens_are_ignored() {
    let (runtime, subject) = (TestRuntime::new(), subject_with_panel());
    let link = runtime.open("robot", &subject);
    let root = format!("jde/1/robot/{}", link.about().id);
    let raw_session = raw_session(&format!("unixsock-stream/{}", socket(&runtime.folder).display()));
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
            raw_session
                .liveliness()
                .declare_token(format!("{root}/{token}"))
                .wait()
                .unwrap()
        })
        .collect();
    let remote = runtime.remote();
    let (_subscription, received) = watch_panel(&remote, Rate::Full);
    until("the client watches", || !subject.panel.rates().is_empty());
    subject.panel.draw(Ok(list(1)));
    received.recv_timeout(TIMEOUT).unwrap();
    assert_eq!(subject.panel.rates(), [30.0]);
}
