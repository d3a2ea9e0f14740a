//! One instance of a plugin's schema, and the only place where a plugin's functions are called.
//!
//! Whoever holds an [`Instance`] runs it: calls never overlap because each takes it by `&mut`.

#![allow(unsafe_code)]

mod desk;
mod host_table;
mod left;
mod memory;
mod ports;
mod remains;
mod scratch;

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::null_mut;
use std::sync::Arc;

use jde_abi::raw;
use jde_core::{Case, Level, Nanos};
use jde_panel::{Gesture, List};

use crate::build;
use crate::engine::Engine;
use crate::turn::{self, Turn};
pub(crate) use desk::Desk;
use host_table::{Call, HOST, Leave};
pub(crate) use left::Left;
pub(crate) use memory::{Remembered, memory_of};
pub(crate) use ports::{Port, Ports, Shown};
use scratch::Scratch;

/// An instance that was made, and the desk at which it finds its ports.
pub(crate) struct Instance {
    number: usize,
    name: CString,
    build: build::Shared,
    table: &'static raw::Schema,
    panel: Option<&'static raw::Panel>,
    this: *mut c_void,
    desk: Arc<Desk>,
    scratch: Scratch,
    engine: Arc<Engine>,
    /// The last call, for those who want to know.
    called: turn::Call,
    /// What it has looked at since the last release before it, likewise.
    inputs: Vec<u32>,
}

// SAFETY: the ABI lets calls of one instance come from different threads one after another, and `&mut self` keeps them apart.
unsafe impl Send for Instance {}

/// The answer to a check.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Answer {
    pub(crate) ready: bool,
    pub(crate) urgency: f64,
    /// When the newest value that the check looked at came to be.
    pub(crate) newest: Nanos,
}

impl Instance {
    /// Makes an instance of `build`, SLEPT. At one desk only one instance is called at a time.
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
            panel: panel_of(table),
            this: null_mut(),
            desk: Arc::clone(desk),
            scratch: Scratch::default(),
            engine: Arc::clone(engine),
            called: turn::Call::default(),
            inputs: Vec::new(),
        };
        let create = table.create.expect("read::plugin refuses schemas without create");
        let made = |this: &mut *mut c_void, context| {
            // SAFETY: the table was checked; the context lives for the call.
            *this = unsafe { create(table, &raw const HOST, context) };
        };
        let ((), failure, _) = instance.enter(Leave::All, made);
        if instance.this.is_null() {
            // The drop of an instance without `this` calls nothing.
            return Err(failure.unwrap_or_else(|| String::from("its create returned null without a reason")));
        }
        Ok(instance)
    }

    pub(crate) fn awake(&mut self) -> Result<(), String> {
        self.release();
        let result = match self.table.awake {
            // SAFETY: `this` came from this table's create; the context lives for the call.
            Some(awake) => self.result("awake", |this, context| unsafe { awake(this, context) }),
            None => Ok(()),
        };
        self.release();
        result
    }

    /// Evaluates the precondition over fresh values, which stay for the iteration that follows (R8).
    pub(crate) fn check(&mut self) -> Result<Answer, String> {
        self.release();
        let mut out = raw::Precondition {
            size: size_of::<raw::Precondition>() as u32,
            ready: 1,
            urgency: 0.0,
        };
        if let Some(check) = self.table.check {
            // SAFETY: as in `awake`; `out` lives for the call.
            self.result("check", |this, context| unsafe {
                check(this, context, &raw mut out)
            })?;
        }
        Ok(Answer {
            ready: out.ready != 0,
            urgency: out.urgency,
            newest: self.desk.ports(|ports| ports.newest()).unwrap_or_default(),
        })
    }

    pub(crate) fn iterate(&mut self) -> Result<(), String> {
        let iterate = self
            .table
            .iterate
            .expect("read::plugin refuses schemas without iterate");
        // SAFETY: as in `awake`.
        self.result("iterate", |this, context| unsafe { iterate(this, context) })
    }

    /// Draws its panel, over the values that it has looked at since the last release. Nothing if it has none.
    pub(crate) fn draw(&mut self) -> Option<Result<List, String>> {
        let draw = self.panel?.draw?;
        let time = self.engine.clock.now();
        let (done, list) = jde_panel::lend_pen(time, |pen| {
            // SAFETY: as in `awake`; the pen lives for the call.
            let (status, failure, wrote) = self.call_as(Leave::Nothing(None), |this, context| unsafe {
                draw(this, context, pen)
            });
            match wrote {
                Leave::Nothing(Some(what)) => Err(format!("it tried to {what} while its panel was drawn")),
                Leave::Nothing(None) | Leave::All | Leave::Exports => outcome("draw", status, failure),
            }
        });
        Some(done.and_then(|()| list.map_err(|broken| broken.to_string())))
    }

    /// Hands in what somebody did to its panel.
    pub(crate) fn touch(&mut self, by: &str, gesture: &Gesture) -> Result<(), String> {
        let Some(touch) = self.panel.and_then(|panel| panel.touch) else {
            return Ok(());
        };
        self.release();
        let result = jde_panel::lend_gesture(by, gesture, |gesture| {
            // SAFETY: as in `awake`; the gesture lives for the call.
            self.result("touch", |this, context| unsafe { touch(this, context, gesture) })
        });
        self.release();
        result
    }

    /// Asks the father's own function; answers with a role, or nobody, and the reason.
    pub(crate) fn arbitrate(&mut self, level: &Level) -> Result<(Option<usize>, String), String> {
        let Some(arbitrate) = self.table.arbitrate else {
            return Err(String::from("it has no arbitration of its own"));
        };
        self.release();
        let engine = Arc::clone(&self.engine);
        let roles = &engine.application.instances[self.number].children;
        let build = Arc::clone(&self.build);
        let role = |id: jde_core::SchemaId| {
            let role = roles.iter().position(|child| *child == Some(id.index()))?;
            build.own_role(role)
        };
        let candidates: Vec<raw::Candidate> = level
            .candidates
            .iter()
            .filter_map(|candidate| {
                Some(raw::Candidate {
                    size: size_of::<raw::Candidate>() as u32,
                    child: role(candidate.id)? as u32,
                    state: state_number(candidate.state),
                    ready: u32::from(candidate.ready),
                    urgency: candidate.urgency,
                })
            })
            .collect();
        let group = &engine.application.groups[level.group.index()].name;
        let group = CString::new(group.rsplit('/').next().unwrap_or(group)).unwrap_or_default();
        let level = raw::Level {
            size: size_of::<raw::Level>() as u32,
            case: match level.case {
                Case::Collision => raw::COLLISION,
                Case::Absence => raw::ABSENCE,
                Case::Alone | Case::Forced => raw::ALONE,
            },
            group: group.as_ptr(),
            candidates: candidates.as_ptr(),
            candidate_count: candidates.len() as u32,
            winner: level.winner.and_then(role).map_or(-1, |role| role as i32),
        };
        let mut verdict = raw::Verdict {
            size: size_of::<raw::Verdict>() as u32,
            child: -1,
            reason: [0; 128],
        };
        // SAFETY: as in `awake`; level and verdict live for the call.
        let answer = self.result("arbitrate", |this, context| unsafe {
            arbitrate(this, context, &raw const level, &raw mut verdict)
        });
        self.release();
        answer?;
        let reason = text_within(&verdict.reason);
        let Ok(role) = u32::try_from(verdict.child) else {
            return Ok((None, reason));
        };
        match build.role(role) {
            Some(Some(role)) => Ok((Some(role), reason)),
            Some(None) => Err(format!("chose child {role}, whose role nobody has")),
            None => Err(format!("named child {role}, and it has {}", build.roles())),
        }
    }

    pub(crate) fn sleep(&mut self) -> Result<(), String> {
        self.release();
        let (_, failure) = match self.table.sleep {
            // SAFETY: as in `awake`.
            Some(sleep) => self.call(|this, context| unsafe { sleep(this, context) }),
            None => ((), None),
        };
        self.release();
        failure.map_or(Ok(()), Err)
    }

    /// The last call; and what it looked at is told to `turn`. Nothing if nobody wants to know.
    pub(crate) fn called(&self, turn: &mut Turn) -> turn::Call {
        let told = turn.inputs.resize(self.inputs.len());
        told.copy_from_slice(&self.inputs[..told.len()]);
        self.called
    }

    /// Lets go of the values it looked at: after its turn, so that its panel shows what its iteration saw.
    pub(crate) fn rest(&mut self) {
        self.release();
    }

    fn release(&mut self) {
        self.desk.ports(Ports::release);
    }

    fn end(&mut self) {
        self.release();
        let this = std::mem::replace(&mut self.this, null_mut());
        if let (false, Some(destroy)) = (this.is_null(), self.table.destroy) {
            // SAFETY: `this` came from this table's create and is given back once, since it was taken out.
            unsafe { destroy(this) };
        }
    }

    fn result(
        &mut self,
        what: &str,
        call: impl FnOnce(*mut c_void, *mut raw::Context) -> i32,
    ) -> Result<(), String> {
        let (status, failure) = self.call(call);
        outcome(what, status, failure)
    }

    /// One call, with a context that lives just as long; also gives the reason that the plugin left, if it did.
    fn call<R>(&mut self, call: impl FnOnce(*mut c_void, *mut raw::Context) -> R) -> (R, Option<String>) {
        let (result, failure, _) = self.call_as(Leave::All, call);
        (result, failure)
    }

    /// The same with less leave; and what it tried against that.
    fn call_as<R>(
        &mut self,
        leave: Leave,
        call: impl FnOnce(*mut c_void, *mut raw::Context) -> R,
    ) -> (R, Option<String>, Leave) {
        self.enter(leave, |this, context| call(*this, context))
    }

    /// The same for a call that may make the instance. Does not return if the call was given up: then nothing that would follow
    /// from it may, and the thread goes back to where [`Left`] is looked after.
    fn enter<R>(
        &mut self,
        leave: Leave,
        call: impl FnOnce(&mut *mut c_void, *mut raw::Context) -> R,
    ) -> (R, Option<String>, Leave) {
        let engine = Arc::clone(&self.engine);
        let meter = &engine.meters[self.number];
        let mut context = Call {
            engine: &engine,
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
        let after = context.desk.enter(start, Ports::enter).flatten();
        meter.enter(start);
        let result = call(&mut self.this, (&raw mut context).cast::<raw::Context>());
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
        if returned.is_none() {
            let this = std::mem::replace(&mut self.this, null_mut());
            Left::new(self.number, start, &self.build, this, &self.desk).leave();
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

/// The panel of a type of schema, if it has one; that it can be drawn was looked at when its plugin was loaded.
pub(crate) fn panel_of(table: &'static raw::Schema) -> Option<&'static raw::Panel> {
    let ability = table.ability?;
    let id = CString::new(raw::ABILITY_PANEL).expect("an id holds no NUL");
    // SAFETY: the table was checked, and the id is a text; what a plugin gives for it is null or such a table, and lives as long
    // as the process.
    unsafe { ability(id.as_ptr()).cast::<raw::Panel>().as_ref() }
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

/// The text before the first NUL, or all of it if there is none.
fn text_within(text: &[c_char]) -> String {
    let bytes: Vec<u8> = text.iter().map(|c| *c as u8).chain([0]).collect();
    CStr::from_bytes_until_nul(&bytes)
        .map(|text| text.to_string_lossy().into_owned())
        .unwrap_or_default()
}
