//! Clients watch the panel of a running schema and send gestures to it. They receive its drawings, the
//! gestures take effect, and the schema is not disturbed otherwise.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use jde_app::Application;
use jde_host::{Handle, Lockstep, Options, Running};
use jde_link::{Events, Link, Rate, SubjectInfo};
use jde_loader::{Plugins, SearchPath};
use jde_panel::{Button, Item, List, Touch};
use jde_schema::prelude::*;
use jde_watchdog::Watchdog;
use parking_lot::Mutex;

use crate::common::{TestRuntime, until};
use crate::processes::ChildProcess;

/// Counts and draws the count.
#[derive(Describe)]
#[schema(motor, period = "10ms")]
struct Painter {
    /// The count.
    #[export]
    count: Export<u64>,
    counted: u64,
    target: Option<[f64; 3]>,
}

impl Schema for Painter {
    fn iterate(&mut self, cx: &Context) -> Result {
        self.counted += 1;
        self.count.write(cx, self.counted);
        Ok(())
    }
}

impl Panel for Painter {
    fn draw(&self, _: &Context, pen: &mut Pen) {
        pen.value("counted", self.counted as f64, "");
        if let Some([x, y, _]) = self.target {
            pen.text(format!("target {x}, {y}"));
        }
        pen.canvas("field").wants_clicks().show(|plane| {
            plane.disc([0.0, 0.0], 0.3);
        });
    }

    fn touched(&mut self, _: &Context, gesture: &Gesture) -> Result {
        if gesture.widget == "field"
            && let Touch::Clicked { at, .. } = gesture.touch
        {
            self.target = Some(at);
        }
        Ok(())
    }
}

static PAINTERS: jde_abi::raw::Plugin = jde_schema::plugin!("painters", "Panels of a test.", [Painter]);

fn application() -> (Plugins, Application) {
    let mut plugins = Plugins::new(SearchPath::default());
    plugins.link(&PAINTERS).unwrap();
    // The schema has the name that the child process `viewer` watches.
    let text = "name = \"painters\"\nroots = [\"goon\"]\n[schemas.goon]\ntype = \"painters/painter\"\n";
    let application = jde_app::parse(text, Path::new("painters.toml"), &[], &plugins).unwrap();
    (plugins, application)
}

/// The options of a run with a link, and the link once the run has started.
fn linked(runtime: &TestRuntime, application: &Application) -> (Options, Arc<Mutex<Option<Link>>>) {
    let events = Events::of(application);
    let info = SubjectInfo::new(application, 1.0);
    let settings = runtime.settings("robot");
    let link = Arc::new(Mutex::new(None));
    let opened = Arc::clone(&link);
    let observer = events.observer();
    let options = Options {
        observers: vec![observer],
        start_hook: Some(Box::new(move |handle: &Handle| {
            let subject = Arc::new(jde_link_host::Running::new(handle.clone(), info));
            *opened.lock() = Some(Link::open(&settings, subject, &events)?);
            Ok(())
        })),
        ..Options::default()
    };
    (options, link)
}

fn click(widget: &str) -> jde_panel::Gesture {
    jde_panel::Gesture {
        widget: widget.to_owned(),
        touch: Touch::Clicked {
            at: [1.5, -2.0, 0.0],
            button: Button::Primary,
        },
    }
}

fn counted(list: &List) -> f64 {
    let value = list.items.iter().find_map(|item| match item {
        Item::Value { label, value, .. } if label == "counted" => Some(*value),
        _ => None,
    });
    value.unwrap()
}

#[test]
fn r10_a_gesture_changes_the_panel_and_is_recorded_with_its_operator() {
    let runtime = TestRuntime::new();
    let (plugins, application) = application();
    let (options, link) = linked(&runtime, &application);
    let running = Running::start(application, &plugins, options).unwrap();
    let remote = runtime.remote();
    let schemas = remote.schemas().unwrap().schemas;
    assert!(schemas.iter().all(|schema| schema.panel && schema.name == "goon"));
    let latest = Arc::new(Mutex::new(List::default()));
    let newest = Arc::clone(&latest);
    let _subscription = remote
        .watch_panel("goon", Rate::Full, move |panel| {
            *newest.lock() = panel.list.unwrap();
        })
        .unwrap();
    until("the schema counts", || {
        latest.lock().items.len() == 2 && counted(&latest.lock()) > 3.0
    });
    remote.touch("ana@laptop", "goon", click("field")).unwrap();
    let shows_target = |list: &List| {
        let mut items = list.items.iter();
        items.any(|item| matches!(item, Item::Text { text, .. } if text == "target 1.5, -2"))
    };
    until("the panel shows its target", || shows_target(&latest.lock()));
    let received = Arc::new(Mutex::new(String::new()));
    let log = Arc::clone(&received);
    let _events = remote
        .events(&[jde_records::RecordKind::Event], 100, move |event| {
            if let jde_records::RunRecord::Other(record) = event.record {
                log.lock()
                    .push_str(&format!("{:?} {}\n", record.what.by(), record.text()));
            }
        })
        .unwrap();
    until("R14: an event names the operator", || {
        let received = received.lock();
        received
            .lines()
            .any(|line| line.contains("ana@laptop") && line.contains("field"))
    });
    let health = running.handle().snapshot().schemas[0].health.clone();
    assert_eq!(health, jde_core::Health::Ok);
    drop(link.lock().take());
    drop(running);
}

/// Runs until a tenth of a second of virtual time, and records the schema's state.
fn trace(lockstep: &mut Lockstep, tenth: u64, trace: &mut Vec<(u64, u64)>) {
    lockstep.run_until(tenth * 100_000_000);
    let handle = lockstep.handle();
    let count = handle.board().find("goon.count").unwrap();
    let iterations = handle.snapshot().schemas[0].iterations;
    trace.push((count.newest(), iterations));
}

#[test]
fn r16_a_schema_does_the_same_while_clients_watch_flood_and_die() {
    let _watchdog = Watchdog::for_test();
    let runtime = TestRuntime::new();
    let (plugins, watched) = application();
    let (options, link) = linked(&runtime, &watched);
    let mut lockstep = Lockstep::start(watched, &plugins, options).unwrap();
    let (seen, touched, finished) = (
        Arc::new(AtomicU64::new(0)),
        Arc::new(AtomicU64::new(0)),
        Arc::new(AtomicBool::new(false)),
    );
    let (lists, accepted, stop) = (Arc::clone(&seen), Arc::clone(&touched), Arc::clone(&finished));
    let folder = runtime.folder.clone();
    let client_thread = std::thread::spawn(move || {
        let client = jde_link::Client::connect(&jde_link::Reach::Local(folder)).unwrap();
        let remote = client.application(None).unwrap();
        let _subscription = remote.watch_panel("goon", Rate::Full, move |panel| {
            lists.fetch_add(u64::from(panel.list.is_ok()), Ordering::Relaxed);
        });
        while !stop.load(Ordering::Relaxed) {
            // Excess gestures are refused.
            let accepted_now = remote.touch("eva", "goon", click("field")).is_ok();
            accepted.fetch_add(u64::from(accepted_now), Ordering::Relaxed);
        }
    });
    let mut disturbed = Vec::new();
    let mut tenth = 0;
    let mut viewers_killed = 0;
    while viewers_killed < 2 || seen.load(Ordering::Relaxed) < 20 || touched.load(Ordering::Relaxed) == 0 {
        if viewers_killed < 2 {
            let viewer = ChildProcess::start("viewer", &runtime);
            tenth += 1;
            trace(&mut lockstep, tenth, &mut disturbed);
            drop(viewer);
            viewers_killed += 1;
        }
        tenth += 1;
        trace(&mut lockstep, tenth, &mut disturbed);
    }
    finished.store(true, Ordering::Relaxed);
    client_thread.join().unwrap();
    drop(link.lock().take());
    drop(lockstep);

    let (plugins, unwatched) = application();
    let mut lockstep = Lockstep::start(unwatched, &plugins, Options::default()).unwrap();
    let mut undisturbed = Vec::new();
    for tenth in 1..=tenth {
        trace(&mut lockstep, tenth, &mut undisturbed);
    }
    assert_eq!(disturbed, undisturbed);
    assert!(undisturbed.last().unwrap().1 >= 10, "the schema iterates");
}
