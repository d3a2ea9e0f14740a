//! The stage of one test: the part of each instance, and a log of what they did, in order.

use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use jde_host::Handle;
use jde_records::event::Event;
use jde_schema::{Context, Pen, Result};

use super::easel::{Brush, Easel};
use super::io::{Call, Io};

/// What an instance does when it is called.
pub(crate) type Part = Box<dyn FnMut(Call, &mut Io<'_>) -> Result + Send>;

/// The stage of one test.
#[derive(Default)]
pub(crate) struct Stage {
    number: u32,
    quiet: bool,
    parts: Mutex<HashMap<String, Arc<Mutex<Part>>>>,
    brushes: Mutex<HashMap<String, Brush>>,
    /// The call that each instance is in, if any.
    inside: Mutex<BTreeMap<String, Call>>,
    log: Mutex<Log>,
    news: Condvar,
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
const LAST: usize = 30;

static STAGES: Mutex<Vec<Arc<Stage>>> = Mutex::new(Vec::new());

impl Stage {
    /// A new stage.
    pub(crate) fn new() -> Arc<Self> {
        Self::made(false)
    }

    /// A stage that records nothing, for long runs.
    pub(crate) fn quiet() -> Arc<Self> {
        Self::made(true)
    }

    fn made(quiet: bool) -> Arc<Self> {
        static NEXT: AtomicU32 = AtomicU32::new(1);
        let stage = Arc::new(Self {
            number: NEXT.fetch_add(1, Ordering::Relaxed),
            quiet,
            ..Self::default()
        });
        lock(&STAGES).push(Arc::clone(&stage));
        stage
    }

    /// The stage of that number. Instances find theirs by it.
    pub(crate) fn of(number: u32) -> Arc<Self> {
        let stages = lock(&STAGES);
        let stage = stages.iter().find(|stage| stage.number == number);
        Arc::clone(stage.expect("schemas of the test plugin say on which stage they are"))
    }

    pub(crate) fn number(&self) -> u32 {
        self.number
    }

    /// Sets the part of an instance.
    pub(crate) fn play(&self, name: &str, part: impl FnMut(Call, &mut Io<'_>) -> Result + Send + 'static) {
        lock(&self.parts).insert(name.to_owned(), Arc::new(Mutex::new(Box::new(part))));
    }

    /// Adds a motor schema that is READY while `ready` is true, and commands `speed` in each iteration.
    pub(crate) fn drives(&self, name: &str, ready: &Arc<std::sync::atomic::AtomicBool>, speed: f64) {
        let ready = Arc::clone(ready);
        self.play(name, move |call, io| {
            match call {
                Call::Check => io.ready(ready.load(Ordering::SeqCst)),
                Call::Iterate => {
                    io.command(speed);
                }
                Call::Awake | Call::Sleep | Call::Arbitrate | Call::Drop => {}
            }
            Ok(())
        });
    }

    /// Sets how an easel draws its panel.
    pub(crate) fn paints(
        &self,
        name: &str,
        brush: impl Fn(&Easel, &Context, &mut Pen) + Send + Sync + 'static,
    ) {
        lock(&self.brushes).insert(name.to_owned(), Arc::new(brush));
    }

    pub(crate) fn brush(&self, name: &str) -> Option<Brush> {
        lock(&self.brushes).get(name).cloned()
    }

    /// Makes waiting threads check their conditions again, after an event that no schema caused.
    pub(crate) fn stir(&self) {
        lock(&self.log).version += 1;
        self.news.notify_all();
    }

    pub(crate) fn part(&self, name: &str) -> Option<Arc<Mutex<Part>>> {
        lock(&self.parts).get(name).cloned()
    }

    /// Records a line.
    pub(crate) fn note(&self, line: impl FnOnce() -> String) {
        if self.quiet {
            return;
        }
        let mut log = lock(&self.log);
        log.lines.push(line());
        log.version += 1;
        drop(log);
        self.news.notify_all();
    }

    pub(crate) fn hear(&self, event: &Event) {
        if self.quiet {
            return;
        }
        let mut log = lock(&self.log);
        log.events.push(event.clone());
        log.version += 1;
        drop(log);
        self.news.notify_all();
    }

    /// All lines so far.
    pub(crate) fn lines(&self) -> Vec<String> {
        lock(&self.log).lines.clone()
    }

    /// Whether the line was recorded.
    pub(crate) fn did(&self, line: &str) -> bool {
        lock(&self.log).lines.iter().any(|done| done == line)
    }

    /// How often the line was recorded.
    pub(crate) fn count(&self, line: &str) -> usize {
        lock(&self.log).lines.iter().filter(|done| *done == line).count()
    }

    /// The index of the first occurrence of a line.
    #[track_caller]
    pub(crate) fn first(&self, line: &str) -> usize {
        let lines = self.lines();
        let place = lines.iter().position(|done| done == line);
        place.unwrap_or_else(|| panic!("`{line}` is not in {lines:#?}"))
    }

    /// The index of the last occurrence of a line.
    #[track_caller]
    pub(crate) fn last(&self, line: &str) -> usize {
        let lines = self.lines();
        let place = lines.iter().rposition(|done| done == line);
        place.unwrap_or_else(|| panic!("`{line}` is not in {lines:#?}"))
    }

    /// All events of the application.
    pub(crate) fn events(&self) -> Vec<Event> {
        lock(&self.log).events.clone()
    }

    /// Whether such an event occurred.
    pub(crate) fn told(&self, wanted: impl Fn(&Event) -> bool) -> bool {
        lock(&self.log).events.iter().any(wanted)
    }

    /// The number of such events.
    pub(crate) fn count_events(&self, wanted: impl Fn(&Event) -> bool) -> usize {
        lock(&self.log)
            .events
            .iter()
            .filter(|event| wanted(event))
            .count()
    }

    pub(crate) fn opened(&self, handle: Handle) {
        let before = lock(&self.handle).replace(handle);
        assert!(before.is_none(), "one application a stage");
    }

    /// The application, for parts that inspect it.
    pub(crate) fn handle(&self) -> Option<Handle> {
        lock(&self.handle).clone()
    }

    /// Blocks until `done`, which is evaluated again after every entry.
    pub(crate) fn wait_until(&self, mut done: impl FnMut() -> bool) {
        loop {
            let seen = lock(&self.log).version;
            if done() {
                return;
            }
            let log = lock(&self.log);
            drop(
                self.news
                    .wait_while(log, |log| log.version == seen)
                    .unwrap_or_else(PoisonError::into_inner),
            );
        }
    }

    /// Runs an instance's call, which [`Self::report`] shows while it runs.
    pub(crate) fn within<R>(&self, name: &str, call: Call, run: impl FnOnce() -> R) -> R {
        struct Leaves<'a>(&'a Stage, &'a str);
        impl Drop for Leaves<'_> {
            fn drop(&mut self) {
                lock(&self.0.inside).remove(self.1);
            }
        }
        lock(&self.inside).insert(name.to_owned(), call);
        let _leaves = Leaves(self, name);
        run()
    }

    /// The present situation, for a watchdog: the calls that run, the last lines, and the state of each
    /// schema.
    pub(crate) fn report(&self) -> String {
        let inside = lock(&self.inside).clone();
        let lines = self.lines();
        let last = &lines[lines.len().saturating_sub(LAST)..];
        // The snapshot comes last, because it needs the rules' lock, which a hung thread may hold.
        eprintln!("calls that run: {inside:?}\nwhat was done last: {last:#?}");
        let Some(handle) = self.handle() else {
            return String::from("nothing runs");
        };
        let views = handle.snapshot().schemas.into_iter();
        let states = views.map(|view| format!("{} {:?} {:?}", view.name, view.state, view.health));
        format!("schemas: {:#?}", states.collect::<Vec<_>>())
    }

    /// Removes the stage, so that the values in its parts are dropped.
    pub(crate) fn close(&self) {
        lock(&STAGES).retain(|stage| stage.number != self.number);
        lock(&self.parts).clear();
        lock(&self.brushes).clear();
        lock(&self.handle).take();
    }
}

/// Locks also after a panic: a test that fails under a lock must not hide its reason behind another panic.
pub(crate) fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
