//! Runs one instance, one turn at a time: the loop of the paper's figure 2, the same for every executor
//! (R16).
//!
//! A turn does what is due now and returns when the next one is due. It never waits; the executors do.

mod again;
mod death;
mod life;
mod line;
mod panel;
mod swap;
mod time;

use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

use jde_abi::describe::Kind;
use jde_core::{Answer, Check, GroupId, Level, Nanos};

use crate::build::{self, Build};
use crate::engine::Engine;
use crate::inbox::Inbox;
use crate::instance::{self, Beyond, Desk, Instance, Ports};
use crate::panels::Pace;
use crate::running::StartError;
use crate::turn::{Journal, Turn};
pub(crate) use line::Line;
use swap::Trial;

/// An instance and its state between turns.
pub(crate) struct Runner {
    engine: Arc<Engine>,
    number: usize,
    kind: Kind,
    desk: Arc<Desk>,
    life: Life,
    period: Nanos,
    /// One instant of the grid of its deadlines.
    anchor: Nanos,
    /// When its last check was. A change of readiness occurred after that.
    last_check: Nanos,
    /// When it last iterated, plus one. In lockstep it iterates at most once an instant.
    last_iteration: Nanos,
    /// Whether the last cycle and the last drawing were late.
    late: [bool; 2],
    /// The instance ends as soon as it sleeps.
    unloading: bool,
    /// Set while the present build is on trial.
    trial: Option<Trial>,
    /// A build took over in this turn; the result is reported at its end.
    announced: bool,
    /// A build took over in this turn; its next turn follows at once.
    at_once: bool,
    /// When its last turn with a check or an iteration ended.
    last_turn: Nanos,
    /// When its panel was drawn.
    pace: Pace,
    /// Receives the turns, if they are recorded.
    journal: Option<Arc<Journal>>,
    /// The record of the present turn.
    told: Turn,
    beyond: Beyond,
}

/// Which iterations a turn asks permission for.
enum Leave {
    Any,
    /// Like `Any`, and in lockstep also a second one at the same instant: its input arrived after the first.
    Again,
    /// Only the first iteration since the instance became WINNER.
    First,
}

enum Life {
    /// There is no instance: it was not created yet, or it faulted or was unloaded.
    Absent,
    Slept(Instance),
    Awake {
        instance: Instance,
        due: Nanos,
    },
    /// Between two of the others, within a turn.
    Changing,
}

impl Runner {
    pub(crate) fn new(engine: &Arc<Engine>, number: usize, build: Build, ports: Ports) -> Self {
        engine.builds.begin(number, Arc::new(build));
        Self::with(engine, number, ports)
    }

    /// A runner of the build that is in force for the instance.
    fn with(engine: &Arc<Engine>, number: usize, mut ports: Ports) -> Self {
        let about = &engine.application.instances[number];
        let kind = about.schema.kind;
        let panel = instance::panel_of(&engine.builds.of(number).table);
        engine.declare_panel(number, panel.map(|panel| panel.touch.is_some()));
        let journal = engine.journal.clone().filter(|_| kind != Kind::Driver);
        if let Some(journal) = &journal {
            ports.follow(journal);
        }
        Self {
            engine: Arc::clone(engine),
            number,
            kind,
            desk: Arc::new(Desk::new(ports)),
            life: Life::Absent,
            period: about.period_ns,
            anchor: 0,
            last_check: 0,
            last_iteration: 0,
            late: [false; 2],
            unloading: false,
            trial: None,
            announced: false,
            at_once: false,
            last_turn: 0,
            pace: Pace::default(),
            journal,
            told: Turn::of(Turn::CYCLED, number),
            beyond: Beyond::default(),
        }
    }

    /// Creates the instance, unless there is one: before the application starts, so that a failure of the
    /// plugin is known at once, and after its instance was given up or unloaded.
    pub(crate) fn create(&mut self) -> Result<(), String> {
        if !matches!(self.life, Life::Absent) {
            return Ok(());
        }
        let instance = self.instance_of(&self.engine.builds.of(self.number))?;
        self.engine.declare_panel(self.number, instance.panel());
        self.life = Life::Slept(instance);
        self.engine.panels.came(self.number);
        Ok(())
    }

    /// Creates an instance of that build, at this runner's desk.
    fn instance_of(&self, build: &build::Shared) -> Result<Instance, String> {
        self.engine.may_make(self.number)?;
        Instance::create(&self.engine, self.number, build, &self.desk)
    }

    /// Like [`Self::create`], with a complete error.
    pub(crate) fn make(&mut self) -> Result<(), StartError> {
        self.create().map_err(|reason| {
            let application = &self.engine.application;
            let instance = &application.instances[self.number];
            let plugin = &application.plugins[instance.plugin].name;
            StartError::Create {
                schema: instance.name.clone(),
                type_name: format!("{plugin}/{}", instance.schema.name),
                reason,
            }
        })
    }

    /// Does what is due now. Returns when the next turn is due; `None` if only a signal causes one.
    pub(crate) fn turn(&mut self, inbox: Inbox) -> Option<Nanos> {
        let (triggered, promoted, touched) = (inbox.triggered, inbox.promoted, inbox.touched);
        if !inbox.is_empty() {
            self.attend(inbox);
        }
        let mut looked = false;
        if let Life::Awake { due, .. } = self.life {
            let now = self.engine.clock.now();
            self.begin_turn(Turn::of(Turn::CYCLED, self.number));
            looked = if now >= due {
                self.cycle(now, due);
                true
            } else if triggered || promoted && self.engine.is_taking(self.number) {
                // The values behind the choice may be a period old, so it checks again before it acts (R8).
                self.react(now);
                true
            } else {
                false
            };
            self.tell();
            if looked {
                self.draw();
            }
            self.rest();
        }
        if touched {
            self.take_gesture();
        }
        self.end_turn(looked);
        match self.life {
            Life::Awake { due, .. } => Some(due),
            Life::Slept(_) if self.engine.clock.is_real() => self.draw_asleep(),
            Life::Absent | Life::Slept(_) | Life::Changing => None,
        }
    }

    /// Processes the signals, before anything is checked.
    fn attend(&mut self, inbox: Inbox) {
        for (group, ticket, level) in inbox.asked {
            self.arbitrate(group, ticket, &level);
        }
        if inbox.replaced {
            if self.trial.is_some() {
                self.engine
                    .give_up_build(self.number, "a call of it did not return in time");
            }
            self.give_up();
        }
        if inbox.unloaded {
            self.unload();
        }
        // Before it awakes: its first turn occurs at once, whatever its period.
        if inbox.retimed {
            self.retime();
        }
        for awake in inbox.life {
            match awake {
                Some(time) => self.wake_up(time),
                None => self.fall_asleep(),
            }
        }
        if inbox.swapped
            && let Some(swap) = self.engine.builds.has_turn(self.number)
        {
            self.swap(&swap);
        }
    }

    /// Its period, ns.
    pub(crate) fn period(&self) -> Nanos {
        self.period
    }

    /// The means to give up a call of it from another thread.
    pub(crate) fn line(&self) -> Line {
        Line::new(&self.engine, self.number, &self.desk)
    }

    /// Ends the instance for good.
    pub(crate) fn destroy(&mut self) {
        self.fall_asleep();
        self.dismiss();
    }

    /// One period: check, then iterate if it is WINNER.
    fn cycle(&mut self, start: Nanos, due: Nanos) {
        self.at_once = false;
        self.look_and_act(start, Leave::Any);
        let end = self.engine.clock.now();
        self.engine.meters[self.number].cycle(start, end - start);
        let missed = self.goes_on(due, end);
        if self.engine.clock.is_real() {
            self.judge(end - start, missed);
        }
    }

    /// Reacts to a value that cannot wait for the period. A motor schema re-evaluates its precondition (R12),
    /// and iterates only if that made it WINNER. A driver carries out the command.
    fn react(&mut self, now: Nanos) {
        let motor = self.kind == Kind::Motor;
        self.look_and_act(now, if motor { Leave::First } else { Leave::Again });
    }

    /// Evaluates the precondition of a motor schema, and iterates if the rules permit.
    fn look_and_act(&mut self, now: Nanos, leave: Leave) {
        let Life::Awake { instance, .. } = &mut self.life else {
            return;
        };
        let checked = if self.kind == Kind::Motor {
            let result = instance.check();
            self.told.looked = instance.called(&mut self.told, &mut self.beyond);
            let Some(check) = self.found(now, result) else {
                return;
            };
            Some(check)
        } else {
            None
        };
        let again_this_instant = self.last_iteration == now + 1 && !self.engine.clock.is_real();
        let asks = matches!(leave, Leave::Again) || !again_this_instant;
        let first = matches!(leave, Leave::First);
        let (may, begun) = match checked {
            Some(check) if asks => {
                let (checked, begun) = self.engine.checked_and_begin(self.number, check, first);
                self.told.checked = checked;
                begun
            }
            Some(check) => {
                self.told.checked = self.engine.checked(self.number, check);
                return;
            }
            None if asks => self.engine.begin(self.number),
            None => return,
        };
        self.told.begun = begun;
        self.told.way = match leave {
            Leave::Any | Leave::Again => Turn::ANY,
            Leave::First => Turn::FIRST,
        };
        if may {
            self.last_iteration = now + 1;
            let result = self.iterate();
            self.iterated(result);
        }
    }

    /// Converts the result of a check for the rules. Returns `None` after a failure, which is then reported
    /// already.
    fn found(&mut self, now: Nanos, result: Result<instance::Answer, String>) -> Option<Check> {
        match result {
            Ok(answer) => {
                // The situation arose with the newest value read, but not before the last check, which saw
                // the earlier situation.
                let cause = answer.newest.clamp(self.last_check.min(now), now);
                self.last_check = now;
                Some(Check {
                    ready: answer.ready,
                    urgency: answer.urgency,
                    cause,
                })
            }
            Err(reason) => {
                self.fault(reason);
                None
            }
        }
    }

    fn iterate(&mut self) -> Result<(), String> {
        let Life::Awake { instance, .. } = &mut self.life else {
            return Ok(());
        };
        let start = self.engine.clock.now();
        let result = instance.iterate();
        self.told.acted = instance.called(&mut self.told, &mut self.beyond);
        let took = self.engine.clock.now().saturating_sub(start);
        self.engine.meters[self.number].iterated(took);
        result
    }

    /// Reports the end of an iteration to the rules.
    fn iterated(&mut self, result: Result<(), String>) {
        match result {
            Ok(()) => self.engine.meters[self.number].started.store(true, Relaxed),
            Err(reason) => self.fault(reason),
        }
        self.told.ended = self.engine.end(self.number);
    }

    /// Records the turn that is over, if there was one.
    fn tell(&mut self) {
        if let Some(journal) = &self.journal {
            let turn = std::mem::replace(&mut self.told, Turn::of(Turn::CYCLED, self.number));
            if !turn.is_empty() {
                journal.tell_all(&turn, &self.beyond.ports);
            }
            self.beyond.ports.clear();
        }
    }

    /// Starts the record of a turn.
    fn begin_turn(&mut self, turn: Turn) {
        if self.journal.is_some() {
            self.told = turn;
            self.beyond.ports.clear();
        }
    }

    /// Releases the values read, so that the next turn sees the newest.
    fn rest(&mut self) {
        if let Life::Awake { instance, .. } = &mut self.life {
            instance.rest();
        }
    }

    fn arbitrate(&mut self, group: GroupId, ticket: u64, level: &Level) {
        self.told = Turn {
            detail: u64::from(group.0),
            ticket,
            ..Turn::of(Turn::ARBITRATED, self.number)
        };
        self.engine.meters[self.number].take_up(ticket, self.engine.clock.now());
        let answer = self.answer(level);
        let failed = match &answer {
            Answer::Failed { reason } => Some(reason.clone()),
            Answer::Chose { .. } => None,
        };
        self.told.checked = self.engine.answered(group, ticket, answer);
        self.tell();
        if let Some(reason) = failed
            && !self.go_back(&reason)
        {
            self.survive(&reason);
        }
    }

    /// Calls the father's own arbitration.
    fn answer(&mut self, level: &Level) -> Answer {
        let (Life::Slept(instance) | Life::Awake { instance, .. }) = &mut self.life else {
            return Answer::Failed {
                reason: "the father is not there".into(),
            };
        };
        let answer = instance.arbitrate(level);
        self.told.looked = instance.called(&mut self.told, &mut self.beyond);
        let (role, reason) = match answer {
            Ok(answer) => answer,
            Err(reason) => return Answer::Failed { reason },
        };
        let children = &self.engine.application.instances[self.number].children;
        let child = role
            .and_then(|role| children[role])
            .map(|child| jde_core::SchemaId(child as u32));
        match (role, child) {
            (Some(role), None) => Answer::Failed {
                reason: format!("chose the unbound child {role}"),
            },
            _ => Answer::Chose { child, reason },
        }
    }
}
