//! Injects faults and ends them. A refused action is not a failure of the campaign, because actions occur at
//! random times.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use jde_abi::describe::Kind;
use jde_board::value::Value;
use jde_core::{Id, SchemaId, State};
use jde_host::reload::ReloadOptions;
use jde_host::{Handle, OperatorHandle};
use jde_loader::LoadedPlugin;
use jde_records::snapshot::{Hold, HoldKind};
use rustix::process::{Pid, Signal as Posix, kill_process};

use crate::application::TestApplication;
use crate::observer::Tamper;
use crate::plan::{Act, Meanwhile, Operation, PlannedFault, Signal};

/// The operator's name.
const OPERATOR_NAME: &str = "faults";
/// Pause between two actions of a competing operator: the repetition rate of a key that is held down.
const ACTION_PAUSE: Duration = Duration::from_millis(1);
/// Probation of a build, ns: some faults occur during it, some after it.
const BUILD_PROBATION: u64 = 200_000_000;

/// An injected fault.
pub(super) struct ActiveFault {
    /// The index of its schema.
    pub(super) schema: SchemaId,
    /// The number of misdeeds that the schema had reported before.
    misdeed_count: u64,
    process: Option<Pid>,
    done: bool,
    competitors: Option<CompetingThreads>,
    /// The schema was awake although it was stopped.
    woke: Arc<AtomicBool>,
}

impl ActiveFault {
    /// What the fault itself found to be wrong.
    pub(super) fn violation(&self) -> Option<String> {
        let woke = self.woke.load(Ordering::Relaxed);
        woke.then(|| String::from("R14: a lease ended, and a schema that another operator stops was awake"))
    }
}

/// Two operators that act concurrently until this is dropped.
struct CompetingThreads {
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

/// What an operator does again and again.
type Deed = Box<dyn FnMut(&OperatorHandle) -> Result<(), String> + Send>;

impl CompetingThreads {
    fn start(handle: &Handle, deeds: [Deed; 2]) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let spawn = |(name, mut deed): (&'static str, Deed)| {
            let (operator, stop) = (handle.operator(name), Arc::clone(&stop));
            std::thread::spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    // An action is refused if it changes nothing.
                    drop(deed(&operator));
                    std::thread::sleep(ACTION_PAUSE);
                }
            })
        };
        let threads = ["ana", "ben"].into_iter().zip(deeds).map(spawn).collect();
        Self { stop, threads }
    }

    /// They stop and release everything.
    fn contest(handle: &Handle) -> Self {
        let deeds: [Deed; 2] = [
            Box::new(OperatorHandle::stop_all),
            Box::new(OperatorHandle::release_all),
        ];
        Self::start(handle, deeds)
    }

    /// They act on a schema under leases that they end at once. `woke` is set if it is awake although it is stopped, or
    /// if a `tamper` says so.
    fn lease(handle: &Handle, schema: SchemaId, woke: &Arc<AtomicBool>, tamper: Option<Tamper>) -> Self {
        let appears_awake = tamper == Some(Tamper::Lease);
        let deed = |actions: [Operation; 3]| -> Deed {
            let (handle, woke) = (handle.clone(), Arc::clone(woke));
            let (mut turn, mut slept) = (0, false);
            Box::new(move |operator| {
                let leased = operator.under_lease();
                operate(&leased, schema, actions[turn % actions.len()]);
                turn += 1;
                let view = &handle.snapshot().schemas[schema.index()];
                let is_lasting = |hold: &Hold| hold.kind == HoldKind::Stopped && !hold.leased;
                // A winner may first end its iteration.
                slept = view.holds().any(is_lasting) && (slept || view.state == State::Slept);
                if slept && (appears_awake || view.state != State::Slept) {
                    woke.store(true, Ordering::Relaxed);
                }
                leased.release_own(schema)
            })
        };
        let deeds = [
            deed([Operation::Stop, Operation::Force, Operation::Play]),
            deed([Operation::Play, Operation::Stop, Operation::Unload]),
        ];
        Self::start(handle, deeds)
    }
}

impl Drop for CompetingThreads {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            // A panic shows by the missing actions of this operator.
            drop(thread.join());
        }
    }
}

/// Selects the schema for a fault: usually one that is about to make the call in question. A driver without an
/// iteration is not selected: its failure would end the application.
pub(super) fn victim(
    fault: &PlannedFault,
    application: &TestApplication,
    handle: &Handle,
) -> Option<SchemaId> {
    let snapshot = handle.snapshot();
    let names = application.victims(fault.target, fault.kind.needs_process());
    let suitable: Vec<SchemaId> = names
        .iter()
        .filter_map(|name| handle.application().instance(name))
        .filter(|id| {
            let schema = &snapshot.schemas[id.index()];
            schema.kind != Kind::Driver || schema.iterations > 0
        })
        .collect();
    let call = match &fault.act {
        Act::SetTrouble { place, .. } | Act::Reload { place, .. } => *place,
        Act::Signal(_)
        | Act::Operate(_)
        | Act::FailExport(..)
        | Act::Contest
        | Act::Leases
        | Act::DuringReload { .. } => "check",
    };
    let is_about_to = |id: &&SchemaId| {
        let schema = &snapshot.schemas[id.index()];
        match call {
            "iterate" => schema.state == State::Winner,
            "awake" => schema.state == State::Slept,
            "arbitrate" => {
                let mut groups = snapshot.groups.iter();
                schema.state == State::Winner && groups.any(|group| group.father == Some(id.index()))
            }
            _ => schema.state != State::Slept,
        }
    };
    let about_to_call: Vec<SchemaId> = suitable.iter().filter(is_about_to).copied().collect();
    let candidates = if about_to_call.is_empty() || fault.any {
        &suitable
    } else {
        &about_to_call
    };
    let count = candidates.len() as u64;
    (count > 0).then(|| candidates[(fault.choice % count) as usize])
}

pub(super) fn begin(
    fault: &PlannedFault,
    schema: SchemaId,
    handle: &Handle,
    builds: &[LoadedPlugin],
    tamper: Option<Tamper>,
) -> ActiveFault {
    let operator = handle.operator(OPERATOR_NAME);
    let mut active = ActiveFault {
        schema,
        misdeed_count: misdeed_count(schema, handle),
        process: None,
        done: false,
        competitors: None,
        woke: Arc::default(),
    };
    match &fault.act {
        Act::SetTrouble { trouble, place: call } => set_trouble(&operator, schema, trouble, call),
        Act::Reload {
            trouble,
            place: call,
            build,
        } => {
            set_trouble(&operator, schema, trouble, call);
            reload(&operator, schema, &builds[*build]);
        }
        Act::Signal(signal) => {
            let process = handle.snapshot().schemas[schema.index()].process;
            active.process = process.and_then(|number| Pid::from_raw(number.cast_signed()));
            let posix = match signal {
                Signal::Kill => Posix::KILL,
                Signal::Stop => Posix::STOP,
            };
            active.done = active
                .process
                .is_some_and(|process| kill_process(process, posix).is_ok());
        }
        Act::Operate(operation) => active.done = operate(&operator, schema, *operation),
        Act::Contest => {
            active.done = operator.stop_all().is_ok();
            active.competitors = Some(CompetingThreads::contest(handle));
        }
        Act::FailExport(export, failure) => {
            active.done = operator.fail_export(schema, export, *failure).is_ok();
        }
        Act::Leases => {
            active.done = operator.hold_asleep(schema).is_ok();
            active.competitors = Some(CompetingThreads::lease(handle, schema, &active.woke, tamper));
        }
        Act::DuringReload { build, meanwhile } => {
            active.done = reload(&operator, schema, &builds[*build]);
            match meanwhile {
                Meanwhile::Operate(operation) => active.done |= operate(&operator, schema, *operation),
                Meanwhile::Reload => drop(reload(&operator, schema, &builds[(build + 1) % builds.len()])),
                Meanwhile::Panic => set_trouble(&operator, schema, "panic", "check"),
            }
        }
    }
    active
}

/// Ends the fault; returns whether it is known to have taken effect.
pub(super) fn end(fault: &PlannedFault, handle: &Handle, active: &mut ActiveFault) -> bool {
    let schema = active.schema;
    let operator = handle.operator(OPERATOR_NAME);
    match &fault.act {
        Act::SetTrouble { .. } | Act::Reload { .. } if fault.stays => {}
        Act::SetTrouble { place: "end", .. } => {
            // Otherwise the instance would not end before the application does.
            drop(operator.unload(schema));
            set_trouble(&operator, schema, "", "iterate");
            drop(operator.load(schema));
        }
        Act::SetTrouble { .. } | Act::Reload { .. } => set_trouble(&operator, schema, "", "iterate"),
        Act::Signal(Signal::Kill) => {}
        Act::Signal(Signal::Stop) => {
            // The host may have killed it since. Only the same process is continued.
            let same = handle.snapshot().schemas[schema.index()]
                .process
                .and_then(|number| Pid::from_raw(number.cast_signed()));
            if let Some(process) = active.process.filter(|process| Some(*process) == same) {
                let _ = kill_process(process, Posix::CONT);
            }
        }
        Act::Operate(_) | Act::DuringReload { .. } if fault.stays => {}
        Act::FailExport(export, _) => drop(operator.repair_export(schema, export)),
        Act::Leases => {
            active.competitors = None;
            drop(operator.release(schema));
        }
        Act::Contest => {
            // Whatever the last action was, everything is released.
            active.competitors = None;
            drop(operator.release_all());
        }
        Act::DuringReload {
            meanwhile: Meanwhile::Panic | Meanwhile::Reload,
            ..
        } => set_trouble(&operator, schema, "", "iterate"),
        Act::Operate(operation)
        | Act::DuringReload {
            meanwhile: Meanwhile::Operate(operation),
            ..
        } => release(&operator, schema, *operation),
    }
    active.done || misdeed_count(schema, handle) > active.misdeed_count
}

/// Starts a replacement by another build; returns whether it was accepted. It is refused while another one
/// waits.
fn reload(operator: &OperatorHandle, schema: SchemaId, build: &LoadedPlugin) -> bool {
    let options = ReloadOptions {
        probation: BUILD_PROBATION,
        fresh: false,
    };
    operator.replace(schema, build, options).is_ok()
}

fn operate(operator: &OperatorHandle, schema: SchemaId, operation: Operation) -> bool {
    let result = match operation {
        Operation::Stop => operator.hold_asleep(schema),
        Operation::Force => operator.force(schema),
        Operation::Play => operator.play(schema),
        Operation::Retime(period) => operator.set_period(schema, period),
        Operation::Unload => operator.unload(schema),
        Operation::StopAll => operator.stop_all(),
    };
    result.is_ok()
}

fn release(operator: &OperatorHandle, schema: SchemaId, operation: Operation) {
    let result = match operation {
        Operation::StopAll => operator.release_all(),
        Operation::Stop | Operation::Force | Operation::Play | Operation::Retime(_) | Operation::Unload => {
            operator.release(schema)
        }
    };
    // Another operator may have released it before.
    drop(result);
}

fn set_trouble(operator: &OperatorHandle, schema: SchemaId, trouble: &str, call: &str) {
    for (name, value) in [("place", call), ("trouble", trouble)] {
        // The modulation exists and accepts the value. An error would show as a fault without effect.
        let _ = operator.modulate(schema, name, &Value::Text(value.to_owned()));
    }
}

/// The number of misdeeds that the schema has reported, including retracted ones.
fn misdeed_count(schema: SchemaId, handle: &Handle) -> u64 {
    let name = &handle.application().instances[schema].name;
    let variable = handle.board().find(&format!("{name}.misdeeds"));
    variable.map_or(0, |variable| variable.newest())
}
