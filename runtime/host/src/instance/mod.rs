//! One instance of a plugin's schema, and its calls: the values they may read, their duration and their
//! results.
//!
//! The owner of an [`Instance`] runs it. Calls never overlap, because each takes it by `&mut`. Only [`Body`]
//! distinguishes whether its functions run in this process, in one of their own, or are those of a mock.

mod abandoned;
mod body;
mod bound_port;
mod call;
mod chunks;
mod command_limits;
mod early;
mod ending;
mod export_faults;
mod guard;
mod guarded_ports;
mod host_table;
mod isolated;
mod measurement;
mod memory;
mod mocked;
mod port_access;
mod ports;
mod retained;
mod scratch;
mod shared_ports;
mod turns;
mod unmoved;
mod view;

use std::ffi::CString;
use std::sync::Arc;

use jde_abi::raw;
use jde_app::RoleId;
use jde_core::{Case, Level, SchemaId};
use jde_loader::instance::{ArbitrationQuery, CandidateChild, InProcessInstance, Verdict, panel_of};
use jde_loader::{Judgement, SchemaFunctions, build};
use jde_panel::{Gesture, List};
use jde_records::turn::{self, INPUTS, Turn};

use crate::engine::Engine;
pub(crate) use abandoned::AbandonedInstance;
use body::Body;
pub(crate) use bound_port::{BoundPort, PortWrite, ShownValue};
pub(crate) use call::CallContext;
use call::Permissions;
pub(crate) use chunks::{AuthorityEnd, Chunks};
pub(crate) use command_limits::CommandLimits;
pub(crate) use ending::{CheckResult, Iterated};
use ending::{call_result, iterated};
pub(crate) use export_faults::ExportFaults;
pub(crate) use guard::{
    CommandInForce, GuardState, Guarding, PortGuard, Refusal, StateCopy, UnjudgedCommand, UnjudgedInForce,
};
pub(crate) use isolated::MAX_INLINE_BYTES;
pub(crate) use measurement::NoValue;
pub(crate) use port_access::PortAccess;
pub(crate) use ports::Ports;
use scratch::Scratch;

/// An instance that was created, with the access to its ports.
pub(crate) struct Instance {
    number: SchemaId,
    name: CString,
    build: build::SharedBuild,
    table: SchemaFunctions,
    panel: Option<raw::Panel>,
    /// `None` before the creation and after the end.
    body: Option<Body>,
    port_access: Arc<PortAccess>,
    scratch: Scratch,
    engine: Arc<Engine>,
    /// The last call, if turns are recorded.
    last_call: turn::Call,
    /// The values read since the last release before that call, if turns are recorded.
    inputs: Vec<u32>,
}

/// The parts of a turn that do not fit in [`Turn`].
#[derive(Default)]
pub(crate) struct TurnOverflow {
    /// Its ports beyond [`INPUTS`].
    pub(crate) ports: Vec<u32>,
    /// Its writes, in a replay.
    pub(crate) writes: Vec<PortWrite>,
}

impl Instance {
    /// Creates an instance of `build`, SLEPT. Instances that share `port_access` are called one at a time.
    pub(crate) fn create(
        engine: &Arc<Engine>,
        number: SchemaId,
        build: &build::SharedBuild,
        port_access: &Arc<PortAccess>,
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
            port_access: Arc::clone(port_access),
            scratch: Scratch::default(),
            engine: Arc::clone(engine),
            last_call: turn::Call::default(),
            inputs: Vec::new(),
        };
        let ((), failure, _) =
            instance.call_optional(Permissions::All, |body, call| *body = Body::create(call));
        if instance.body.is_none() {
            return Err(failure.unwrap_or_default());
        }
        if instance.is_mocked() {
            instance.panel = None;
        }
        Ok(instance)
    }

    pub(crate) fn awake(&mut self) -> Result<(), String> {
        self.port_access.relatch();
        self.begin_turn();
        let result = match self.table.awake {
            Some(_) => self.call_checked("awake", Body::awake),
            None => {
                self.call_nothing();
                Ok(())
            }
        };
        self.release();
        result
    }

    /// Evaluates the precondition with the newest values, which stay for the iteration that follows (R8).
    pub(crate) fn check(&mut self) -> Result<CheckResult, String> {
        self.begin_turn();
        let (mut ready, mut urgency) = (true, 0.0);
        if self.table.check.is_some() || self.is_mocked() {
            let ((status, is_ready, offered), failure) = self.call(Body::check);
            (ready, urgency) = (is_ready && status != raw::NO_VALUE, offered);
            iterated("check", status, failure)?;
        } else {
            self.call_nothing();
        }
        Ok(CheckResult {
            ready,
            urgency,
            newest: self.port_access.newest(),
        })
    }

    pub(crate) fn iterate(&mut self) -> Result<Iterated, String> {
        let (status, failure) = self.call(|body, call| {
            let status = body.iterate(call);
            call.end_iteration(status);
            status
        });
        iterated("iterate", status, failure)
    }

    /// Whether a check and its iteration can be one call.
    pub(crate) fn has_combined_call(&self) -> bool {
        self.table.check.is_some() && self.body.as_ref().is_some_and(Body::is_isolated)
    }

    /// Evaluates the precondition as [`Self::check`] does and, if it is true, iterates in the same call. Returns
    /// whether it iterated, and the check's result with that of the iteration, or the error of either. A process that
    /// died in the call counts as one that iterated: what it had published took effect.
    pub(crate) fn check_and_iterate(&mut self) -> (bool, Result<(CheckResult, Iterated), String>) {
        self.begin_turn();
        let ((status, ready, urgency), failure) = self.call(|body, call| {
            let (status, ready, urgency) = body.check_and_iterate(call);
            if ready {
                call.end_iteration(status);
            }
            (status, ready, urgency)
        });
        let called = iterated(if ready { "iterate" } else { "check" }, status, failure);
        let newest = self.port_access.newest();
        let result = called.map(|iterated| {
            let check = CheckResult {
                ready,
                urgency,
                newest,
            };
            (check, iterated)
        });
        (ready || self.is_dead(), result)
    }

    /// Draws the panel from the values read since the last release. Returns `None` if there is no panel.
    pub(crate) fn draw(&mut self) -> Option<Result<List, String>> {
        self.panel?;
        let ((status, list), failure, permissions) = self.call_with(Permissions::ReadOnly(None), Body::draw);
        Some(match permissions {
            Permissions::ReadOnly(Some(action)) => {
                Err(format!("it tried to {action} while its panel was drawn"))
            }
            Permissions::ReadOnly(None) | Permissions::All | Permissions::ExportsOnly => {
                call_result("draw", status, failure).and(list)
            }
        })
    }

    /// Delivers a gesture on the panel.
    pub(crate) fn touch(&mut self, by: &str, gesture: &Gesture) -> Result<(), String> {
        if self.panel.is_none_or(|panel| panel.touch.is_none()) {
            return Ok(());
        }
        self.begin_turn();
        let result = self.call_checked("touch", |body, call| body.touch(call, by, gesture));
        self.release();
        result
    }

    /// Calls the father's own arbitration. Returns the role it chose, or `None`, and the reason.
    pub(crate) fn arbitrate(&mut self, level: &Level) -> Result<(Option<RoleId>, String), String> {
        if self.table.arbitrate.is_none() {
            return Err(String::from("it has no arbitration of its own"));
        }
        self.begin_turn();
        let query = self.arbitration_query(level);
        let mut verdict = Verdict::default();
        let result = self.call_checked("arbitrate", |body, call| {
            let status;
            (status, verdict) = body.arbitrate(call, &query);
            status
        });
        self.release();
        result?;
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
        self.begin_turn();
        let (_, failure) = match self.table.sleep {
            Some(_) => self.call(Body::sleep),
            None => {
                self.call_nothing();
                ((), None)
            }
        };
        self.release();
        failure.map_or(Ok(()), Err)
    }

    /// Judges the commands in force by a new state, if it is a guard. It is a call of it: one that does not return is
    /// a hang.
    pub(crate) fn judge_in_force(&mut self) -> Vec<(CommandInForce, Judgement)> {
        let (engine, number) = (Arc::clone(&self.engine), self.number);
        let now = engine.clock.now();
        let unjudged = self.port_access.with_ports(|ports| ports.commands_in_force(now));
        match unjudged.flatten() {
            Some(unjudged) if !unjudged.commands.is_empty() => {
                let judge =
                    |_: &mut Body, _: &mut CallContext<'_>| engine.judge_in_force(number, unjudged, now);
                self.call_with(Permissions::ReadOnly(None), judge).0
            }
            Some(_) | None => Vec::new(),
        }
    }

    fn is_mocked(&self) -> bool {
        matches!(self.body, Some(Body::Mocked(_)))
    }

    /// Whether its process is dead.
    pub(crate) fn is_dead(&self) -> bool {
        self.body.as_ref().is_some_and(Body::is_dead)
    }

    /// Whether the rules must be informed of a failure; false after they were informed of the death of its
    /// process.
    pub(crate) fn claim_failure_report(&self) -> bool {
        self.body.as_ref().is_none_or(Body::claim_failure_report)
    }

    /// Returns the last call. Copies its reads and writes to `turn`, and those that do not fit to
    /// `overflow`. All are empty unless turns are recorded or repeated.
    pub(crate) fn copy_last_call(&self, turn: &mut Turn, overflow: &mut TurnOverflow) -> turn::Call {
        let inputs = turn.inputs.resize(self.inputs.len().min(INPUTS));
        let (first, rest) = self.inputs.split_at(inputs.len());
        inputs.copy_from_slice(first);
        overflow.ports.clear();
        overflow.ports.extend_from_slice(rest);
        if self.engine.clock.is_replayed() {
            let writes = self.port_access.with_ports(Ports::take_writes);
            overflow.writes.extend(writes.into_iter().flatten());
        }
        self.last_call
    }

    /// Releases the values read. Called after the turn, so that the panel shows the values of the iteration.
    pub(crate) fn release_values(&mut self) {
        self.release();
    }

    /// Starts a turn: the record of earlier calls is cleared.
    fn begin_turn(&mut self) {
        self.release();
        self.inputs.fill(Turn::UNUSED);
        if self.engine.clock.is_replayed() {
            self.port_access.with_ports(Ports::take_writes);
        }
    }

    #[inline]
    fn release(&mut self) {
        self.port_access.release();
    }

    /// Ends the instance. Like any other call, this one may hang and be given up.
    fn end(&mut self) {
        self.release();
        match self.body.take() {
            None | Some(Body::Mocked(_)) => {}
            Some(Body::InProcess(instance)) => self.end_in_process(instance),
            // Its process can be ended in every state.
            Some(Body::Isolated(instance)) => instance.destroy(&self.engine, self.number),
        }
    }

    fn end_in_process(&self, instance: InProcessInstance) {
        if self.port_access.is_closed() {
            // An earlier call was given up, and this is the rest of its instance.
            return drop(instance);
        }
        let start = self.engine.clock.now();
        self.port_access.begin_call(start);
        let meter = &self.engine.metrics[self.number];
        meter.begin_call(start);
        drop(instance);
        if self.port_access.end_call(|_| ()) {
            meter.end_call();
        } else if !std::thread::panicking() {
            AbandonedInstance::new(self.number, start, None, &self.port_access).unwind();
        }
    }

    /// Converts the level for the father: children have the roles of his build.
    fn arbitration_query(&self, level: &Level) -> ArbitrationQuery {
        let roles = &self.engine.application.instances[self.number].children;
        let role = |id: SchemaId| {
            let role = roles.find(|child| *child == Some(id))?;
            Some(self.build.own_role(role)? as u32)
        };
        let candidates = level.candidates.iter().filter_map(|candidate| {
            Some(CandidateChild {
                child: role(candidate.id)?,
                state: state_number(candidate.state),
                ready: candidate.ready,
                urgency: candidate.urgency,
            })
        });
        let group = &self.engine.application.groups[level.group].name;
        ArbitrationQuery {
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

    fn call_checked(
        &mut self,
        what: &str,
        call: impl FnOnce(&mut Body, &mut CallContext<'_>) -> i32,
    ) -> Result<(), String> {
        let (status, failure) = self.call(call);
        call_result(what, status, failure)
    }

    /// Runs a call with a context of its own. Also returns the reason that the plugin set, if any.
    fn call<R>(&mut self, call: impl FnOnce(&mut Body, &mut CallContext<'_>) -> R) -> (R, Option<String>) {
        let (result, failure, _) = self.call_with(Permissions::All, call);
        (result, failure)
    }

    /// Takes the place of a call of a function that the schema does not have: a record of the turn states when it
    /// was.
    fn call_nothing(&mut self) {
        self.call_optional(Permissions::ReadOnly(None), |_, _| ());
    }

    /// Like [`Self::call`], with fewer permissions. Also returns the permissions, which contain the
    /// first attempt to exceed them.
    fn call_with<R>(
        &mut self,
        permissions: Permissions,
        call: impl FnOnce(&mut Body, &mut CallContext<'_>) -> R,
    ) -> (R, Option<String>, Permissions) {
        self.call_optional(permissions, |body, context| call(expect_body(body), context))
    }

    /// Like [`Self::call_with`], for a call that may create the instance. Does not return if the call was
    /// given up, so that the caller cannot use its result: the thread unwinds to where [`AbandonedInstance`]
    /// is handled.
    fn call_optional<R>(
        &mut self,
        permissions: Permissions,
        call: impl FnOnce(&mut Option<Body>, &mut CallContext<'_>) -> R,
    ) -> (R, Option<String>, Permissions) {
        let engine = &self.engine;
        let meter = &engine.metrics[self.number];
        let mut context = CallContext {
            engine,
            number: self.number,
            name: &self.name,
            build: &self.build,
            port_access: &self.port_access,
            scratch: &mut self.scratch,
            failure: None,
            first_time: None,
            permissions,
        };
        let start = engine.clock.now();
        let after = context.port_access.begin_call(start);
        meter.begin_call(start);
        let result = call(&mut self.body, &mut context);
        let failure = context.failure.take();
        let first_time = context.first_time;
        let permissions = context.permissions;
        let returned = self.port_access.end_call(|ports| {
            ports.discard_loans();
            if let (Some(after), Some(log)) = (after, ports.read_log()) {
                let (after, time) = log.last.unwrap_or((after, start));
                let clock = first_time.unwrap_or(start);
                self.last_call = turn::Call { after, time, clock };
                self.inputs.clone_from(&log.inputs);
            }
        });
        if !returned {
            AbandonedInstance::new(self.number, start, self.body.take(), &self.port_access).unwind();
        }
        meter.end_call();
        self.scratch.discard();
        (result, failure, permissions)
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        self.end();
    }
}

fn expect_body(body: &mut Option<Body>) -> &mut Body {
    body.as_mut()
        .expect("the body is taken only when the instance ends")
}

fn state_number(state: jde_core::State) -> u32 {
    match state {
        jde_core::State::Slept => raw::SLEPT,
        jde_core::State::Checking => raw::CHECKING,
        jde_core::State::Ready => raw::READY,
        jde_core::State::Winner => raw::WINNER,
    }
}
