//! The delivered application, whose time stands still.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use jde_app::{Application, Executor};
use jde_host::{Handle, Lockstep, Options, Running};
use jde_loader::Plugins;
use jde_records::event::{Event, Observer, Occurrence, What};
use jde_watchdog::Watchdog;
use parking_lot::Mutex;

use crate::delivered::{self, ROOT, SECOND};

/// The events about time, as text.
#[derive(Clone, Default)]
struct Times(Arc<Mutex<Vec<String>>>);

impl Observer for Times {
    fn on_event(&mut self, event: &Event) {
        let text = match event {
            Event::Other(Occurrence {
                time,
                what: What::StoodStill { reason },
            }) => format!("{time} still: {reason}"),
            Event::Other(Occurrence {
                what: What::WentOn { by, one_step, .. },
                ..
            }) => format!("{by} went on, one step: {one_step}"),
            _ => return,
        };
        self.0.lock().push(text);
    }
}

fn application(plugins: &Plugins, executor: Executor) -> Application {
    let file = Path::new(ROOT).join("apps/safe-navigation.toml");
    let mut application = jde_app::load(&file, &[], plugins).unwrap_or_else(|faults| panic!("{faults}"));
    application.executor = executor;
    application
}

fn options(times: &Times) -> Options {
    Options {
        observers: vec![Box::new(times.clone())],
        may_stand_still: true,
        ..Options::default()
    }
}

fn iterations(handle: &Handle) -> u64 {
    handle
        .snapshot()
        .schemas
        .iter()
        .map(|schema| schema.iterations)
        .sum()
}

fn until(condition: impl Fn() -> bool) {
    while !condition() {
        std::thread::yield_now();
    }
}

#[test]
fn r14_lockstep_stands_still_makes_a_step_and_goes_on_under_the_operators_name() {
    let _watchdog = Watchdog::for_test();
    let (plugins, times) = (delivered::plugins(), Times::default());
    let application = application(&plugins, Executor::Threads);
    let mut lockstep = Lockstep::start(application, &plugins, options(&times)).unwrap();
    lockstep.run_until(2 * SECOND);
    let handle = lockstep.handle();
    handle.stand_still("a reason");
    assert_eq!(lockstep.run_until(5 * SECOND), None);
    assert_eq!(
        (handle.now(), handle.standstill().as_deref()),
        (2 * SECOND, Some("a reason"))
    );
    let next = lockstep.next_instant().expect("something is due");
    let operator = handle.operator("ana");
    operator.step_time().unwrap();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            until(|| handle.now() == next && handle.standstill().is_some());
            operator.continue_time().unwrap();
        });
        assert_eq!(lockstep.wait_while_still(), None);
    });
    assert_eq!(handle.now(), next, "one instant");
    assert!(operator.continue_time().is_err(), "it passes already");
    lockstep.run_until(5 * SECOND);
    assert_eq!(handle.now(), 5 * SECOND);
    let expected = [
        "2000000000 still: a reason",
        "ana went on, one step: true",
        "ana went on, one step: false",
    ];
    assert_eq!(*times.0.lock(), expected);
}

#[test]
fn nothing_becomes_due_in_real_time_while_time_stands_still() {
    let _watchdog = Watchdog::for_test();
    for executor in [Executor::Threads, Executor::Pool] {
        let (plugins, times) = (delivered::plugins(), Times::default());
        let running = Running::start(application(&plugins, executor), &plugins, options(&times)).unwrap();
        let handle = running.handle();
        until(|| handle.now() > SECOND / 5);
        handle.stand_still("a reason");
        let since = Instant::now();
        let passed = |millis| since.elapsed() > Duration::from_millis(millis);
        // Turns that had begun end.
        until(|| passed(50));
        let (now, done) = (handle.now(), iterations(&handle));
        until(|| passed(400));
        assert_eq!((handle.now(), iterations(&handle)), (now, done), "{executor:?}");
        handle.operator("ana").step_time().unwrap();
        assert_eq!(handle.now(), now + 10_000_000);
        handle.operator("ana").continue_time().unwrap();
        until(|| iterations(&handle) > done + 10);
        let limit = now + 10_000_000 + since.elapsed().as_nanos() as u64;
        assert!(handle.now() < limit, "the time that stood still is lost");
    }
}

#[test]
fn time_stands_still_only_where_that_is_permitted() {
    let plugins = delivered::plugins();
    let application = application(&plugins, Executor::Threads);
    let mut lockstep = Lockstep::start(application, &plugins, Options::default()).unwrap();
    lockstep.handle().stand_still("a reason");
    assert_eq!(lockstep.handle().standstill(), None);
    lockstep.run_until(SECOND);
    assert_eq!(lockstep.handle().now(), SECOND);
}
