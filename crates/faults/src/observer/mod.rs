//! Observes an application from outside and reports violated rules. It does not rely on the observed code's
//! own reports: states and authority are rebuilt from effects, commands are read from the board, motion is
//! read from the simulated robot's ground truth, and turns are counted.

mod commands;
mod history;
mod motion;
mod rhythm;
mod rules;
mod tamper;
mod values;

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use jde_board::Watch;
use jde_core::{Health, Nanos};
use jde_host::event::Event;
use jde_host::turn::{Call, OnTurn, Turn};
use jde_host::{BeforeStart, Handle, Options};

use crate::case::Clock;
use commands::Commands;
use history::History;
use motion::Motion;
use rhythm::Rhythm;
use rules::Rules;
pub use tamper::Tamper;

/// Most reported violations: later ones follow from the first.
const MOST_TOLD: usize = 8;

/// Most faults after which a restart follows soon: the back-off of 20 ms doubles with each.
const SOON: u64 = 5;

/// Sign of a call that did not return: the host gave it up.
pub const LEFT_BEHIND: &str = "left behind";
/// Sign of a call that returned after all.
pub const CAME_BACK: &str = "came back";
/// Sign of a call that was abandoned when the application ended.
pub const LEFT_AT_THE_END: &str = "left at the end";

/// The observer's state, shared by all its callbacks.
pub(crate) struct Known {
    pub(crate) clock: Clock,
    pub(crate) tamper: Option<Tamper>,
    pub(crate) names: Vec<String>,
    pub(crate) history: History,
    pub(crate) rhythm: Rhythm,
    pub(crate) signs: Vec<Sign>,
    /// Schemas that faulted and were not restarted.
    faulted: BTreeSet<usize>,
    broken: Vec<String>,
    /// The application is ending or has ended.
    over: bool,
}

/// A consequence of a fault.
#[derive(Clone, Debug)]
pub struct Sign {
    /// Its time.
    pub time: Nanos,
    /// The schema's index.
    pub schema: usize,
    /// The consequence: "faulted", "hung".
    pub what: &'static str,
}

/// The observer of one application.
pub struct Observer {
    known: Arc<Mutex<Known>>,
    commands: Arc<Mutex<Commands>>,
    motion: Motion,
    watches: Arc<Mutex<Vec<Watch>>>,
}

impl Observer {
    /// An observer for an application that has not started.
    #[must_use]
    pub fn new(clock: Clock, tamper: Option<Tamper>) -> Self {
        let known = Known {
            clock,
            tamper,
            names: Vec::new(),
            history: History::default(),
            rhythm: Rhythm::new(clock),
            signs: Vec::new(),
            faulted: BTreeSet::new(),
            broken: Vec::new(),
            over: false,
        };
        Self {
            known: Arc::new(Mutex::new(known)),
            commands: Arc::default(),
            motion: Motion::default(),
            watches: Arc::default(),
        }
    }

    /// Connects the observer to an application that is started with these options.
    pub fn watch(&self, options: &mut Options) {
        options.witness = Some(Box::new(Rules::new(Arc::clone(&self.known))));
        let known = Arc::clone(&self.known);
        options
            .observers
            .push(Box::new(move |event: &Event| lock(&known).hear(event)));
        let known = Arc::clone(&self.known);
        let turns: OnTurn = Arc::new(move |turn: &Turn| {
            if turn.kind == Turn::CYCLED {
                // A perceptive schema checks nothing.
                let checked = turn.looked != Call::default();
                let call = if checked { turn.looked } else { turn.acted };
                lock(&known).had_turn(turn.schema as usize, call.time);
            }
        });
        options.on_turn = Some(turns);
        let (known, commands, watches) = (
            Arc::clone(&self.known),
            Arc::clone(&self.commands),
            Arc::clone(&self.watches),
        );
        let before: BeforeStart = Box::new(move |handle: &Handle| {
            let application = handle.application();
            let mut seen = lock(&known);
            seen.names = application
                .instances
                .iter()
                .map(|instance| instance.name.clone())
                .collect();
            seen.rhythm.begin(application);
            let tamper = seen.tamper;
            drop(seen);
            let mut kept = lock(&watches);
            kept.extend(Commands::watch(&commands, handle, tamper));
            kept.extend(rhythm::watch_drivers(&known, handle));
            Ok(())
        });
        options.before_start = Some(before);
    }

    /// A schema is about to have a fault: from now on it may miss turns.
    pub fn excuse(&self, schema: usize) {
        lock(&self.known).rhythm.excuse(schema);
    }

    /// A fault of the schema has ended: from `again` on it must have turns.
    pub fn recovers(&self, schema: usize, again: Nanos) {
        lock(&self.known).rhythm.recovers(schema, again);
    }

    /// Reports schemas that were not restarted long after their faults ended.
    pub fn judge_recovery(&self, handle: &Handle) {
        // Taken first: the rules' witness waits for the observer's lock, so its holder must not wait for the
        // rules.
        let schemas = handle.snapshot().schemas;
        let mut known = lock(&self.known);
        for (place, schema) in schemas.iter().enumerate() {
            let faulted = matches!(schema.health, Health::Faulted(_));
            // After many faults, the back-off is long.
            let waits = schema.faults > SOON || schema.left > 0;
            if faulted && !waits && known.rhythm.is_to_have_turns(place, handle.now()) {
                known.tell(format!(
                    "recovery: `{}` was not restarted after its fault",
                    schema.name
                ));
            }
        }
    }

    /// Judges all that occurred until now; in lockstep, between two instants.
    pub fn judge(&mut self, handle: &Handle) {
        let now = handle.now();
        let mut known = lock(&self.known);
        lock(&self.commands).judge(&mut known, now);
        self.motion.judge(&mut known, &lock(&self.commands), handle, now);
        known.judge_rhythm(now);
        if known.clock == Clock::Lockstep {
            known.judge_values(handle, now);
        }
    }

    /// The application is about to end. From now on nothing is judged.
    pub fn is_over(&self) {
        lock(&self.known).over = true;
        lock(&self.watches).clear();
        lock(&self.commands).close();
    }

    /// Judges what can be judged only at the end. `bare` is the share of turns that a thread beside the
    /// application lost although it only waited for its turns.
    pub fn conclude(&self, bare: f64) {
        lock(&self.known).conclude_rhythm(bare);
    }

    /// The violations found so far.
    #[must_use]
    pub fn broken(&self) -> Vec<String> {
        lock(&self.known).broken.clone()
    }

    /// The consequences of faults so far.
    #[must_use]
    pub fn signs(&self) -> Vec<Sign> {
        lock(&self.known).signs.clone()
    }

    /// The least share of its turns that a bystander had.
    #[must_use]
    pub fn least_kept(&self) -> Option<f64> {
        lock(&self.known).rhythm.least_kept()
    }
}

impl Known {
    pub(crate) fn tell(&mut self, broken: String) {
        if self.broken.len() < MOST_TOLD {
            self.broken.push(broken);
        }
    }

    pub(crate) fn name(&self, schema: usize) -> &str {
        self.names.get(schema).map_or("?", String::as_str)
    }

    pub(crate) fn tampers(&mut self, with: Tamper) -> bool {
        // Once: the observer must find a single violation.
        self.tamper.take_if(|tamper| *tamper == with).is_some()
    }

    fn hear(&mut self, event: &Event) {
        if let Event::Health { schema, health, .. } = event {
            if matches!(health, Health::Faulted(_)) {
                self.faulted.insert(*schema);
            } else {
                self.faulted.remove(schema);
            }
        }
        let (time, schema, what) = match event {
            Event::Changed {
                time,
                schema,
                from,
                to,
            } => {
                self.changed(*time, *schema, *from, *to);
                return;
            }
            Event::Health {
                time,
                schema,
                health: Health::Faulted(_),
            } => (*time, *schema, "faulted"),
            Event::Health {
                time,
                schema,
                health: Health::ArbitrationFailed(_),
            } => (*time, *schema, "arbitration failed"),
            Event::Hung { time, schema, .. } if self.over => (*time, *schema, LEFT_AT_THE_END),
            Event::Hung { time, schema, .. } => (*time, *schema, "hung"),
            Event::LeftBehind { time, schema, .. } => (*time, *schema, LEFT_BEHIND),
            Event::CameBack { time, schema, .. } => (*time, *schema, CAME_BACK),
            Event::Refused { time, schema, .. } => (*time, *schema, "refused"),
            Event::Overrun { time, schema, .. } => (*time, *schema, "overran"),
            Event::Reloaded { time, schema, .. } => (*time, *schema, "reloaded"),
            Event::ReloadUndone { time, schema, .. } => (*time, *schema, "went back"),
            Event::Operator { time, action, .. } => (*time, action.schema(), "operated"),
            Event::Health { .. }
            | Event::Decided(_)
            | Event::Took { .. }
            | Event::Late { .. }
            | Event::Chatters { .. }
            | Event::Calmed { .. }
            | Event::Stalled { .. }
            | Event::Ended { .. } => return,
        };
        self.signs.push(Sign { time, schema, what });
    }
}

pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
