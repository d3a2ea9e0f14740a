//! The scenario of one test: the behaviour of each instance, and a log of what the instances did, in order.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use jde_host::Handle;
use jde_records::event::Event;
use jde_schema::Result;
use parking_lot::{Condvar, Mutex};

use super::io::{Call, Io};

/// What an instance does when it is called.
pub(crate) type Behaviour = Box<dyn FnMut(Call, &mut Io<'_>) -> Result + Send>;

/// How an instance draws its panel.
pub(crate) type DrawFn = Arc<dyn Fn(&Io<'_>) + Send + Sync>;

/// The scenario of one test.
#[derive(Default)]
pub(crate) struct Scenario {
    number: u32,
    quiet: bool,
    behaviours: Mutex<HashMap<String, Arc<Mutex<Behaviour>>>>,
    draw_fns: Mutex<HashMap<String, DrawFn>>,
    /// The call that each instance is in, if any.
    inside: Mutex<BTreeMap<String, Call>>,
    log: Mutex<Log>,
    changed: Condvar,
    handle: Mutex<Option<Handle>>,
}

#[derive(Default)]
struct Log {
    /// Counts all entries.
    version: u64,
    lines: Vec<String>,
    events: Vec<Event>,
}

/// How many lines a report shows.
const REPORTED_LINES: usize = 30;

static SCENARIOS: Mutex<Vec<Arc<Scenario>>> = Mutex::new(Vec::new());

impl Scenario {
    /// A new scenario.
    pub(crate) fn new() -> Arc<Self> {
        Self::create(false)
    }

    /// A scenario that records nothing, for long runs.
    pub(crate) fn quiet() -> Arc<Self> {
        Self::create(true)
    }

    fn create(quiet: bool) -> Arc<Self> {
        static NEXT: AtomicU32 = AtomicU32::new(1);
        let scenario = Arc::new(Self {
            number: NEXT.fetch_add(1, Ordering::Relaxed),
            quiet,
            ..Self::default()
        });
        SCENARIOS.lock().push(Arc::clone(&scenario));
        scenario
    }

    /// The scenario with this number. Instances find their scenario by it.
    pub(crate) fn of(number: u32) -> Arc<Self> {
        let scenarios = SCENARIOS.lock();
        let scenario = scenarios.iter().find(|scenario| scenario.number == number);
        Arc::clone(scenario.expect("every schema of the test plugin has the number of a scenario"))
    }

    pub(crate) fn number(&self) -> u32 {
        self.number
    }

    /// Sets what an instance does in its calls.
    pub(crate) fn on_call(
        &self,
        name: &str,
        behaviour: impl FnMut(Call, &mut Io<'_>) -> Result + Send + 'static,
    ) {
        self.behaviours
            .lock()
            .insert(name.to_owned(), Arc::new(Mutex::new(Box::new(behaviour))));
    }

    /// Adds a motor schema that is READY while `ready` is true, and commands `speed` in each iteration.
    pub(crate) fn drives(&self, name: &str, ready: &Arc<std::sync::atomic::AtomicBool>, speed: f64) {
        let ready = Arc::clone(ready);
        self.on_call(name, move |call, io| {
            match call {
                Call::Check => io.ready(ready.load(Ordering::SeqCst)),
                Call::Iterate => {
                    io.command(speed);
                }
                _ => {}
            }
            Ok(())
        });
    }

    /// Sets how an instance draws its panel. A drawing that blocks does not block the behaviour of other calls.
    pub(crate) fn on_draw(&self, name: &str, draw: impl Fn(&Io<'_>) + Send + Sync + 'static) {
        self.draw_fns.lock().insert(name.to_owned(), Arc::new(draw));
    }

    pub(crate) fn draw_fn(&self, name: &str) -> Option<DrawFn> {
        self.draw_fns.lock().get(name).cloned()
    }

    /// Makes waiting threads check their conditions again, after an event that no schema caused.
    pub(crate) fn notify(&self) {
        self.log.lock().version += 1;
        self.changed.notify_all();
    }

    pub(crate) fn behaviour(&self, name: &str) -> Option<Arc<Mutex<Behaviour>>> {
        self.behaviours.lock().get(name).cloned()
    }

    /// Records a line.
    pub(crate) fn record(&self, line: impl FnOnce() -> String) {
        if self.quiet {
            return;
        }
        let mut log = self.log.lock();
        log.lines.push(line());
        log.version += 1;
        drop(log);
        self.changed.notify_all();
    }

    pub(crate) fn record_event(&self, event: &Event) {
        if self.quiet {
            return;
        }
        let mut log = self.log.lock();
        log.events.push(event.clone());
        log.version += 1;
        drop(log);
        self.changed.notify_all();
    }

    /// All lines so far.
    pub(crate) fn lines(&self) -> Vec<String> {
        self.log.lock().lines.clone()
    }

    /// Whether the line was recorded.
    pub(crate) fn has_line(&self, line: &str) -> bool {
        self.log.lock().lines.iter().any(|recorded| recorded == line)
    }

    /// How often the line was recorded.
    pub(crate) fn count(&self, line: &str) -> usize {
        self.log
            .lock()
            .lines
            .iter()
            .filter(|recorded| *recorded == line)
            .count()
    }

    /// The index of the first occurrence of a line.
    #[track_caller]
    pub(crate) fn first(&self, line: &str) -> usize {
        let lines = self.lines();
        let index = lines.iter().position(|recorded| recorded == line);
        index.unwrap_or_else(|| panic!("`{line}` is not in {lines:#?}"))
    }

    /// The index of the last occurrence of a line.
    #[track_caller]
    pub(crate) fn last(&self, line: &str) -> usize {
        let lines = self.lines();
        let index = lines.iter().rposition(|recorded| recorded == line);
        index.unwrap_or_else(|| panic!("`{line}` is not in {lines:#?}"))
    }

    /// All events of the application.
    pub(crate) fn events(&self) -> Vec<Event> {
        self.log.lock().events.clone()
    }

    /// Whether such an event occurred.
    pub(crate) fn has_event(&self, expected: impl Fn(&Event) -> bool) -> bool {
        self.log.lock().events.iter().any(expected)
    }

    /// The number of such events.
    pub(crate) fn count_events(&self, expected: impl Fn(&Event) -> bool) -> usize {
        self.log
            .lock()
            .events
            .iter()
            .filter(|event| expected(event))
            .count()
    }

    pub(crate) fn set_handle(&self, handle: Handle) {
        let before = self.handle.lock().replace(handle);
        assert!(before.is_none(), "a scenario has one application");
    }

    /// The application, for behaviours that inspect it.
    pub(crate) fn handle(&self) -> Option<Handle> {
        self.handle.lock().clone()
    }

    /// Blocks until `done`, which is evaluated again after every entry.
    pub(crate) fn wait_until(&self, mut done: impl FnMut() -> bool) {
        loop {
            let seen = self.log.lock().version;
            if done() {
                return;
            }
            let mut log = self.log.lock();
            self.changed.wait_while(&mut log, |log| log.version == seen);
        }
    }

    /// Runs an instance's call, which [`Self::report`] shows while it runs.
    pub(crate) fn track_call<R>(&self, name: &str, call: Call, run: impl FnOnce() -> R) -> R {
        struct RemoveOnDrop<'a>(&'a Scenario, &'a str);
        impl Drop for RemoveOnDrop<'_> {
            fn drop(&mut self) {
                self.0.inside.lock().remove(self.1);
            }
        }
        self.inside.lock().insert(name.to_owned(), call);
        let _guard = RemoveOnDrop(self, name);
        run()
    }

    /// The current state, for a watchdog: the calls that run, the last lines, and the state of each
    /// schema.
    pub(crate) fn report(&self) -> String {
        let inside = self.inside.lock().clone();
        let lines = self.lines();
        let last = &lines[lines.len().saturating_sub(REPORTED_LINES)..];
        // The snapshot comes last, because it needs the rules' lock, which a hung thread may hold.
        eprintln!("calls that run: {inside:?}\nlast lines: {last:#?}");
        let Some(handle) = self.handle() else {
            return String::from("no application runs");
        };
        let views = handle.snapshot().schemas.into_iter();
        let states = views.map(|view| format!("{} {:?} {:?}", view.name, view.state, view.health));
        format!("schemas: {:#?}", states.collect::<Vec<_>>())
    }

    /// Removes the scenario, so that the values in its behaviours are dropped.
    pub(crate) fn close(&self) {
        SCENARIOS.lock().retain(|scenario| scenario.number != self.number);
        self.behaviours.lock().clear();
        self.draw_fns.lock().clear();
        self.handle.lock().take();
    }
}
