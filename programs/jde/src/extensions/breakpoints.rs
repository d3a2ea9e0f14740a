//! Breakpoints: conditions at which the time of a run stands still. They are evaluated where their values are
//! published, so that time stops at the moment itself; only simulated applications have them.

use std::io::{self, BufRead, Write};
use std::sync::Arc;
use std::thread;

use jde_board::Watch;
use jde_conditions::{Condition, Names, Triggers};
use jde_core::Nanos;
use jde_host::{Handle, StartHook, StartHookError};
use jde_loader::Plugins;
use jde_records::event::{Event, Observer};
use jde_session::run::{Extension, PreparedExtension, RecordingSummary, RunContext, terminal_operator};
use jde_terminal::{self as terminal, FAINT, TITLE};
use parking_lot::Mutex;

use super::record::condition_failure;

/// The conditions, as text.
pub(crate) struct Breakpoints {
    /// At least one.
    pub(crate) conditions: Vec<String>,
    /// Whether the terminal's lines ask what to do; otherwise the oscilloscope does.
    pub(crate) asks: bool,
}

/// The breakpoints of one run.
struct RunBreakpoints {
    state: Arc<Mutex<BreakpointState>>,
    watches: Arc<Mutex<Vec<Watch>>>,
    asks: bool,
}

struct BreakpointState {
    triggers: Triggers,
    /// Known once the application is about to start.
    handle: Option<Handle>,
}

impl Extension for Breakpoints {
    fn prepare(
        &self,
        context: &RunContext<'_>,
    ) -> Result<Option<Box<dyn PreparedExtension>>, StartHookError> {
        let names = Names::of(context.application);
        let conditions = self.conditions.iter().map(|text| Condition::new(text, &names));
        let conditions = conditions.collect::<Result<_, _>>().map_err(condition_failure)?;
        let state = BreakpointState {
            triggers: Triggers::new(names, conditions),
            handle: None,
        };
        Ok(Some(Box::new(RunBreakpoints {
            state: Arc::new(Mutex::new(state)),
            watches: Arc::default(),
            asks: self.asks,
        })))
    }
}

impl PreparedExtension for RunBreakpoints {
    fn observer(&self) -> Box<dyn Observer> {
        Box::new(BreakpointObserver(Arc::clone(&self.state)))
    }

    fn may_stand_still(&self) -> bool {
        true
    }

    fn before_start(&self, _: &Arc<Plugins>) -> StartHook {
        let (state, watches, asks) = (Arc::clone(&self.state), Arc::clone(&self.watches), self.asks);
        Box::new(move |handle| {
            state.lock().handle = Some(handle.clone());
            // Each publication is an instant for conditions on the time alone.
            for variable in handle.board().list() {
                let state = Arc::clone(&state);
                let name = variable.describe().full_name();
                let is_read = state.lock().triggers.variables().contains(name.as_str());
                let reader = is_read.then(|| Mutex::new(variable.reader("breakpoint")));
                let watch = variable.watch(move || match &reader {
                    Some(reader) => {
                        let mut reader = reader.lock();
                        let mut state = state.lock();
                        let now = state.handle.as_ref().map_or(0, Handle::now);
                        let bytes = reader.latch_newest(now).map(|latched| latched.bytes);
                        state.take_value(&name, bytes);
                    }
                    None => state.lock().advance(),
                });
                watches.lock().push(watch);
            }
            let asking = Arc::clone(&state);
            if asks {
                let handle = handle.clone();
                thread::Builder::new()
                    .name(String::from("breakpoints"))
                    .spawn(move || {
                        ask(&handle);
                        // Nobody is left to let time pass again.
                        asking.lock().handle = None;
                        // It may pass already.
                        let _ = terminal_operator(&handle).continue_time();
                    })?;
            }
            Ok(())
        })
    }

    fn finish(&self) -> Option<RecordingSummary> {
        self.watches.lock().clear();
        self.state.lock().handle = None;
        None
    }
}

/// Takes the events of a run.
struct BreakpointObserver(Arc<Mutex<BreakpointState>>);

impl Observer for BreakpointObserver {
    fn on_event(&mut self, event: &Event) {
        let mut fired = Vec::new();
        let mut state = self.0.lock();
        state.triggers.process_event(event, &mut fired);
        state.stop(fired.first());
    }
}

impl BreakpointState {
    fn take_value(&mut self, variable: &str, bytes: Option<&[u8]>) {
        let Some(now) = self.handle.as_ref().map(Handle::now) else {
            return;
        };
        let mut fired = Vec::new();
        match bytes {
            Some(bytes) => self.triggers.process_value(now, variable, bytes, &mut fired),
            None => self.triggers.process_retraction(now, variable, &mut fired),
        }
        self.stop(fired.first());
        self.advance();
    }

    fn advance(&mut self) {
        if let Some(handle) = &self.handle {
            let mut fired = Vec::new();
            self.triggers.advance(handle.now(), &mut fired);
            self.stop(fired.first());
        }
    }

    /// Lets time stand still at the first condition that became true.
    fn stop(&self, fired: Option<&jde_conditions::Firing>) {
        if let (Some(handle), Some(firing)) = (&self.handle, fired) {
            handle.stand_still(&firing.text);
        }
    }
}

/// How often to look for the end of a step. A longer one is a call that takes seconds; then its prompt is missing.
const MAX_LOOKS: usize = 250;

/// The keys, for a line of the terminal.
const KEYS: &str = "c continues, n makes a step, q quits";

/// Says where time stands still, and does what is typed, until standard input ends; then the application goes
/// on without breakpoints.
fn ask(handle: &Handle) {
    let operator = terminal_operator(handle);
    let mut lines = io::stdin().lock().lines();
    let mut reported = None;
    while handle.outcome().is_none() {
        let Some(reason) = handle.standstill() else {
            thread::sleep(super::BREAKPOINT_INTERVAL);
            continue;
        };
        let now = handle.now();
        if reported != Some(now) {
            reported = Some(now);
            let mut output = terminal::err();
            let seconds = now as f64 / 1e9;
            let _ = writeln!(
                output,
                "{TITLE}stands still at {seconds:.3} s{TITLE:#}: {reason} {FAINT}({KEYS}){FAINT:#}"
            );
            let _ = output.flush();
        }
        match lines.next() {
            Some(Ok(line)) => match line.trim() {
                // A tool may have let time pass meanwhile.
                "c" => drop(operator.continue_time()),
                "n" => {
                    let _ = operator.step_time();
                    wait_for_step(handle, now);
                }
                "q" => handle.stop(),
                _ => reported = None,
            },
            Some(Err(_)) | None => return,
        }
    }
}

/// Waits until a step has been made: the executor of lockstep makes it on its own thread.
fn wait_for_step(handle: &Handle, before: Nanos) {
    for _ in 0..MAX_LOOKS {
        if handle.now() != before || handle.outcome().is_some() {
            return;
        }
        thread::sleep(super::BREAKPOINT_INTERVAL);
    }
}
