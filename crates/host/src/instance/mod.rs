//! One instance of a plugin's schema, and its calls: the values they may read, their duration and their
//! results.
//!
//! The owner of an [`Instance`] runs it. Calls never overlap, because each takes it by `&mut`. Only [`Body`]
//! knows whether its functions run in this process or in one of their own.

mod body;
mod call;
mod desk;
mod here;
mod host_table;
mod left;
mod memory;
mod ports;
mod remains;
mod scratch;

use std::ffi::CString;
use std::sync::Arc;

use jde_abi::raw;
use jde_core::{Case, Level, Nanos};
use jde_panel::{Gesture, List};

use crate::build;
use crate::engine::Engine;
use crate::plugin::Functions;
use crate::turn::{self, INPUTS, Turn};
use body::Body;
pub(crate) use call::Call;
use call::Leave;
pub(crate) use desk::Desk;
pub(crate) use here::{Candidate, Given, Here, Question, Verdict, panel_of};
pub(crate) use host_table::text_of;
pub(crate) use left::Left;
pub(crate) use memory::{Remembered, memory_of};
pub(crate) use ports::{Port, Ports, Shown, Wrote};
use scratch::Scratch;

/// An instance that was created, and the desk at which it finds its ports.
pub(crate) struct Instance {
    number: usize,
    name: CString,
    build: build::Shared,
    table: Functions,
    panel: Option<raw::Panel>,
    /// `None` before the creation and after the end.
    body: Option<Body>,
    desk: Arc<Desk>,
    scratch: Scratch,
    engine: Arc<Engine>,
    /// The last call, if turns are recorded.
    called: turn::Call,
    /// The values read since the last release before that call, if turns are recorded.
    inputs: Vec<u32>,
}

/// The parts of a turn that do not fit in [`Turn`].
#[derive(Default)]
pub(crate) struct Beyond {
    /// Its ports beyond [`INPUTS`].
    pub(crate) ports: Vec<u32>,
    /// What it wrote, in a replay.
    pub(crate) wrote: Vec<Wrote>,
}

/// The result of a check.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Answer {
    pub(crate) ready: bool,
    pub(crate) urgency: f64,
    /// Time of the newest value that the check read.
    pub(crate) newest: Nanos,
}

impl Instance {
    /// Creates an instance of `build`, SLEPT. At one desk only one instance is called at a time.
    pub(crate) fn create(
        engine: &Arc<Engine>,
        number: usize,
        build: &build::Shared,
        desk: &Arc<Desk>,
    ) -> Result<Self, String> {
        let table = build.table;
        let name =
            CString::new(engine.application.instances[number].name.replace('\0', "")).unwrap_or_default();
        let mut instance = Self {
            number,
            name,
            build: Arc::clone(build),
            table,
            panel: panel_of(&table),
            body: None,
            desk: Arc::clone(desk),
            scratch: Scratch::default(),
            engine: Arc::clone(engine),
            called: turn::Call::default(),
            inputs: Vec::new(),
        };
        let ((), failure, _) = instance.enter(Leave::All, |body, call| *body = Body::create(call));
        if instance.body.is_none() {
            return Err(failure.unwrap_or_else(|| String::from("its create returned null without a reason")));
        }
        Ok(instance)
    }

    pub(crate) fn awake(&mut self) -> Result<(), String> {
        self.desk.renew();
        self.begin();
        let result = match self.table.awake {
            Some(_) => self.result("awake", Body::awake),
            None => Ok(()),
        };
        self.release();
        result
    }

    /// Evaluates the precondition with the newest values, which stay for the iteration that follows (R8).
    pub(crate) fn check(&mut self) -> Result<Answer, String> {
        self.begin();
        let (mut ready, mut urgency) = (true, 0.0);
        if self.table.check.is_some() {
            self.result("check", |body, call| {
                let status;
                (status, ready, urgency) = body.check(call);
                status
            })?;
        }
        Ok(Answer {
            ready,
            urgency,
            newest: self.desk.newest(),
        })
    }

    pub(crate) fn iterate(&mut self) -> Result<(), String> {
        self.result("iterate", Body::iterate)
    }

    /// Draws the panel from the values read since the last release. `None` if there is no panel.
    pub(crate) fn draw(&mut self) -> Option<Result<List, String>> {
        self.panel?;
        let ((status, list), failure, leave) = self.call_as(Leave::Nothing(None), Body::draw);
        Some(match leave {
            Leave::Nothing(Some(what)) => Err(format!("it tried to {what} while its panel was drawn")),
            Leave::Nothing(None) | Leave::All | Leave::Exports => outcome("draw", status, failure).and(list),
        })
    }

    /// Delivers a gesture on the panel.
    pub(crate) fn touch(&mut self, by: &str, gesture: &Gesture) -> Result<(), String> {
        if self.panel.is_none_or(|panel| panel.touch.is_none()) {
            return Ok(());
        }
        self.begin();
        let result = self.result("touch", |body, call| body.touch(call, by, gesture));
        self.release();
        result
    }

    /// Calls the father's own arbitration. Returns the role it chose, or `None`, and the reason.
    pub(crate) fn arbitrate(&mut self, level: &Level) -> Result<(Option<usize>, String), String> {
        if self.table.arbitrate.is_none() {
            return Err(String::from("it has no arbitration of its own"));
        }
        self.begin();
        let question = self.question(level);
        let mut verdict = Verdict::default();
        let answer = self.result("arbitrate", |body, call| {
            let status;
            (status, verdict) = body.arbitrate(call, &question);
            status
        });
        self.release();
        answer?;
        let Verdict { child, reason } = verdict;
        let Some(role) = child else {
            return Ok((None, reason));
        };
        match self.build.role(role) {
            Some(Some(role)) => Ok((Some(role), reason)),
            Some(None) => Err(format!("chose child {role}, whose role nobody has")),
            None => Err(format!("named child {role}, and it has {}", self.build.roles())),
        }
    }

    pub(crate) fn sleep(&mut self) -> Result<(), String> {
        self.begin();
        let (_, failure) = match self.table.sleep {
            Some(_) => self.call(Body::sleep),
            None => ((), None),
        };
        self.release();
        failure.map_or(Ok(()), Err)
    }

    /// Whether its process is dead.
    pub(crate) fn is_dead(&self) -> bool {
        self.body.as_ref().is_some_and(Body::is_dead)
    }

    /// Whether the rules must be informed of a failure: not once they know that its process died.
    pub(crate) fn is_to_tell(&self) -> bool {
        self.body.as_ref().is_none_or(Body::is_to_tell)
    }

    /// Returns the last call. Copies what it read and wrote to `turn`, and what does not fit there to
    /// `beyond`. All are empty unless turns are recorded.
    pub(crate) fn called(&self, turn: &mut Turn, beyond: &mut Beyond) -> turn::Call {
        let told = turn.inputs.resize(self.inputs.len().min(INPUTS));
        let (first, rest) = self.inputs.split_at(told.len());
        told.copy_from_slice(first);
        beyond.ports.clear();
        beyond.ports.extend_from_slice(rest);
        if self.engine.clock.is_past() {
            let wrote = self.desk.ports(Ports::take_wrote);
            beyond.wrote.extend(wrote.into_iter().flatten());
        }
        self.called
    }

    /// Releases the values read. Called after the turn, so that the panel shows what the iteration saw.
    pub(crate) fn rest(&mut self) {
        self.release();
    }

    /// Starts a turn: the record of earlier calls is cleared.
    fn begin(&mut self) {
        self.release();
        self.inputs.fill(Turn::UNSEEN);
        if self.engine.clock.is_past() {
            self.desk.ports(Ports::take_wrote);
        }
    }

    fn release(&mut self) {
        self.desk.release();
    }

    /// Ends it. This is a call like any other: it may hang and be given up.
    fn end(&mut self) {
        self.release();
        match self.body.take() {
            None => {}
            Some(Body::Here(here)) => self.end_here(here),
            // Its process can be ended whatever it does.
            Some(Body::Apart(apart)) => apart.destroy(&self.engine, self.number),
        }
    }

    fn end_here(&self, here: Here) {
        if self.desk.is_closed() {
            // An earlier call was given up, and this is the rest of its instance.
            return drop(here);
        }
        let start = self.engine.clock.now();
        self.desk.enter(start);
        let meter = &self.engine.meters[self.number];
        meter.enter(start);
        drop(here);
        if self.desk.leave(|_| ()) {
            meter.leave();
        } else if !std::thread::panicking() {
            Left::new(self.number, start, None, &self.desk).leave();
        }
    }

    /// The level as the father sees it, by the roles of his build.
    fn question(&self, level: &Level) -> Question {
        let roles = &self.engine.application.instances[self.number].children;
        let role = |id: jde_core::SchemaId| {
            let role = roles.iter().position(|child| *child == Some(id.index()))?;
            Some(self.build.own_role(role)? as u32)
        };
        let candidates = level.candidates.iter().filter_map(|candidate| {
            Some(Candidate {
                child: role(candidate.id)?,
                state: state_number(candidate.state),
                ready: candidate.ready,
                urgency: candidate.urgency,
            })
        });
        let group = &self.engine.application.groups[level.group.index()].name;
        Question {
            case: match level.case {
                Case::Collision => raw::COLLISION,
                Case::Absence => raw::ABSENCE,
                Case::Alone | Case::Forced => raw::ALONE,
            },
            group: group.rsplit('/').next().unwrap_or(group).to_owned(),
            candidates: candidates.collect(),
            winner: level.winner.and_then(role),
        }
    }

    fn result(
        &mut self,
        what: &str,
        call: impl FnOnce(&mut Body, &mut Call<'_>) -> i32,
    ) -> Result<(), String> {
        let (status, failure) = self.call(call);
        outcome(what, status, failure)
    }

    /// Calls with a context that lives as long as the call. Also returns the reason that the plugin set, if
    /// any.
    fn call<R>(&mut self, call: impl FnOnce(&mut Body, &mut Call<'_>) -> R) -> (R, Option<String>) {
        let (result, failure, _) = self.call_as(Leave::All, call);
        (result, failure)
    }

    /// Like [`Self::call`], with fewer permissions. Also returns what the call tried against them.
    fn call_as<R>(
        &mut self,
        leave: Leave,
        call: impl FnOnce(&mut Body, &mut Call<'_>) -> R,
    ) -> (R, Option<String>, Leave) {
        self.enter(leave, |body, context| call(body_of(body), context))
    }

    /// Like [`Self::call_as`], for a call that may create the instance. Does not return if the call was given
    /// up, so that nothing that depends on it happens: the thread unwinds to where [`Left`] is handled.
    fn enter<R>(
        &mut self,
        leave: Leave,
        call: impl FnOnce(&mut Option<Body>, &mut Call<'_>) -> R,
    ) -> (R, Option<String>, Leave) {
        let engine = &self.engine;
        let meter = &engine.meters[self.number];
        let mut context = Call {
            engine,
            number: self.number,
            name: &self.name,
            build: &self.build,
            desk: &self.desk,
            scratch: &mut self.scratch,
            failure: None,
            told: None,
            leave,
        };
        let start = engine.clock.now();
        let after = context.desk.enter(start);
        meter.enter(start);
        let result = call(&mut self.body, &mut context);
        let failure = context.failure.take();
        let told = context.told;
        let leave = context.leave;
        let returned = self.desk.leave(|ports| {
            ports.discard_loans();
            if let (Some(after), Some(looks)) = (after, ports.looks()) {
                let (after, time) = looks.last.unwrap_or((after, start));
                let clock = told.unwrap_or(start);
                self.called = turn::Call { after, time, clock };
                self.inputs.clone_from(&looks.inputs);
            }
        });
        if !returned {
            Left::new(self.number, start, self.body.take(), &self.desk).leave();
        }
        meter.leave();
        self.scratch.discard();
        (result, failure, leave)
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        self.end();
    }
}

fn body_of(body: &mut Option<Body>) -> &mut Body {
    body.as_mut()
        .expect("only the end takes the body, and the instance with it")
}

fn outcome(what: &str, status: i32, failure: Option<String>) -> Result<(), String> {
    match (status, failure) {
        (raw::OK, _) => Ok(()),
        (raw::PANICKED, reason) => Err(format!(
            "panicked in {what}: {}",
            reason.as_deref().unwrap_or("no message")
        )),
        (_, Some(reason)) => Err(reason),
        (status, None) => Err(format!("{what} returned error {status} without a reason")),
    }
}

fn state_number(state: jde_core::State) -> u32 {
    match state {
        jde_core::State::Slept => raw::SLEPT,
        jde_core::State::Checking => raw::CHECKING,
        jde_core::State::Ready => raw::READY,
        jde_core::State::Winner => raw::WINNER,
    }
}
