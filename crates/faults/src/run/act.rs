//! Injects faults and ends them. A refused action is no failure of the campaign, since it occurs at random
//! times.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use jde_board::value::Value;
use jde_core::State;
use jde_host::reload::ReloadOptions;
use jde_host::{Handle, OperatorHandle};
use jde_loader::LoadedPlugin;
use rustix::process::{Pid, Signal as Posix, kill_process};

use crate::application::TestApplication;
use crate::plan::{Act, Fault, Meanwhile, Operation, Signal};

/// The operator's name.
const OPERATOR_NAME: &str = "faults";
/// Pause between two orders of a rival, as fast as a key held down.
const PACE: Duration = Duration::from_millis(1);
/// Probation of a build, ns: some faults occur after it, some before.
const TRIAL: u64 = 200_000_000;

/// An injected fault.
pub(super) struct ActiveFault {
    /// The index of its schema.
    pub(super) schema: usize,
    /// The number of misdeeds that the schema had reported before.
    misdeeds: u64,
    process: Option<Pid>,
    done: bool,
    competitors: Option<CompetingThreads>,
}

/// Two operators that stop and release everything, each as fast as the answers arrive, until dropped.
struct CompetingThreads {
    over: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl CompetingThreads {
    fn start(handle: &Handle) -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let stops = |by: &'static str, act: fn(&OperatorHandle) -> Result<(), String>| {
            let (operator, over) = (handle.operator(by), Arc::clone(&over));
            std::thread::spawn(move || {
                while !over.load(Ordering::Relaxed) {
                    // An order is refused if the other rival has already done the same.
                    drop(act(&operator));
                    std::thread::sleep(PACE);
                }
            })
        };
        let threads = vec![
            stops("ana", OperatorHandle::stop_all),
            stops("ben", OperatorHandle::release_all),
        ];
        Self { over, threads }
    }
}

impl Drop for CompetingThreads {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            // A panic becomes visible by the rival's missing actions.
            drop(thread.join());
        }
    }
}

/// Selects the schema for a fault: usually one that is about to make the call in question.
pub(super) fn victim(fault: &Fault, stage: &TestApplication, handle: &Handle) -> Option<usize> {
    let snapshot = handle.snapshot();
    let fit = stage.victims(fault.target, fault.kind.needs_process());
    let fit: Vec<usize> = fit
        .iter()
        .filter_map(|name| handle.application().instance(name))
        .collect();
    let call = match &fault.act {
        Act::SetTrouble { place, .. } | Act::Reload { place, .. } => *place,
        Act::Signal(_) | Act::Operate(_) | Act::Contest | Act::DuringReload { .. } => "check",
    };
    let is_about_to = |place: &&usize| {
        let schema = &snapshot.schemas[**place];
        match call {
            "iterate" => schema.state == State::Winner,
            "awake" => schema.state == State::Slept,
            "arbitrate" => {
                let mut groups = snapshot.groups.iter();
                schema.state == State::Winner && groups.any(|group| group.father == Some(**place))
            }
            _ => schema.state != State::Slept,
        }
    };
    let about: Vec<usize> = fit.iter().filter(is_about_to).copied().collect();
    let among = if about.is_empty() || fault.any {
        &fit
    } else {
        &about
    };
    let count = among.len() as u64;
    (count > 0).then(|| among[(fault.choice % count) as usize])
}

pub(super) fn begin(fault: &Fault, place: usize, handle: &Handle, builds: &[LoadedPlugin]) -> ActiveFault {
    let operator = handle.operator(OPERATOR_NAME);
    let mut under = ActiveFault {
        schema: place,
        misdeeds: misdeeds(place, handle),
        process: None,
        done: false,
        competitors: None,
    };
    match &fault.act {
        Act::SetTrouble { trouble, place: call } => set_trouble(&operator, place, trouble, call),
        Act::Reload {
            trouble,
            place: call,
            build,
        } => {
            set_trouble(&operator, place, trouble, call);
            reload(&operator, place, &builds[*build]);
        }
        Act::Signal(signal) => {
            let process = handle.snapshot().schemas[place].process;
            under.process = process.and_then(|number| Pid::from_raw(number.cast_signed()));
            let sent = match signal {
                Signal::Kill => Posix::KILL,
                Signal::Stop => Posix::STOP,
            };
            under.done = under
                .process
                .is_some_and(|process| kill_process(process, sent).is_ok());
        }
        Act::Operate(operation) => under.done = operate(&operator, place, *operation),
        Act::Contest => {
            under.done = operator.stop_all().is_ok();
            under.competitors = Some(CompetingThreads::start(handle));
        }
        Act::DuringReload { build, meanwhile } => {
            under.done = reload(&operator, place, &builds[*build]);
            match meanwhile {
                Meanwhile::Operate(operation) => under.done |= operate(&operator, place, *operation),
                Meanwhile::Reload => drop(reload(&operator, place, &builds[(build + 1) % builds.len()])),
                Meanwhile::Panic => set_trouble(&operator, place, "panic", "check"),
            }
        }
    }
    under
}

/// Ends the fault; returns whether it is known to have taken effect.
pub(super) fn end(fault: &Fault, handle: &Handle, under: &mut ActiveFault) -> bool {
    let place = under.schema;
    let operator = handle.operator(OPERATOR_NAME);
    match &fault.act {
        Act::SetTrouble { .. } | Act::Reload { .. } if fault.stays => {}
        Act::SetTrouble { place: "end", .. } => {
            // Otherwise the instance would not end before the application does.
            drop(operator.unload(place));
            set_trouble(&operator, place, "", "iterate");
            drop(operator.load(place));
        }
        Act::SetTrouble { .. } | Act::Reload { .. } => set_trouble(&operator, place, "", "iterate"),
        Act::Signal(Signal::Kill) => {}
        Act::Signal(Signal::Stop) => {
            // The host may have killed it since. Only the same process is continued.
            let same = handle.snapshot().schemas[place]
                .process
                .and_then(|number| Pid::from_raw(number.cast_signed()));
            if let Some(process) = under.process.filter(|process| Some(*process) == same) {
                let _ = kill_process(process, Posix::CONT);
            }
        }
        Act::Operate(_) | Act::DuringReload { .. } if fault.stays => {}
        Act::Contest => {
            // Whichever order was last, everything is released.
            under.competitors = None;
            drop(operator.release_all());
        }
        Act::DuringReload {
            meanwhile: Meanwhile::Panic | Meanwhile::Reload,
            ..
        } => set_trouble(&operator, place, "", "iterate"),
        Act::Operate(operation)
        | Act::DuringReload {
            meanwhile: Meanwhile::Operate(operation),
            ..
        } => let_go(&operator, place, *operation),
    }
    under.done || misdeeds(place, handle) > under.misdeeds
}

/// Starts a replacement by another build; returns whether it was accepted. It is refused while another one
/// waits.
fn reload(operator: &OperatorHandle, place: usize, build: &LoadedPlugin) -> bool {
    let how = ReloadOptions {
        probation: TRIAL,
        fresh: false,
    };
    operator.replace(place, build, how).is_ok()
}

fn operate(operator: &OperatorHandle, place: usize, operation: Operation) -> bool {
    let asked = match operation {
        Operation::Stop => operator.hold_asleep(place),
        Operation::Force => operator.force(place),
        Operation::Play => operator.play(place),
        Operation::Retime(period) => operator.set_period(place, period),
        Operation::Unload => operator.unload(place),
        Operation::StopAll => operator.stop_all(),
    };
    asked.is_ok()
}

fn let_go(operator: &OperatorHandle, place: usize, operation: Operation) {
    let done = match operation {
        Operation::StopAll => operator.release_all(),
        Operation::Stop | Operation::Force | Operation::Play | Operation::Retime(_) | Operation::Unload => {
            operator.release(place)
        }
    };
    // Another operator may have released it before.
    drop(done);
}

fn set_trouble(operator: &OperatorHandle, place: usize, trouble: &str, call: &str) {
    for (name, word) in [("place", call), ("trouble", trouble)] {
        // The modulation exists and accepts the word. An error would show as a fault without effect.
        let _ = operator.modulate(place, name, &Value::Text(word.to_owned()));
    }
}

/// The number of misdeeds that the schema has reported, including retracted ones.
fn misdeeds(place: usize, handle: &Handle) -> u64 {
    let name = &handle.application().instances[place].name;
    let told = handle.board().find(&format!("{name}.misdeeds"));
    told.map_or(0, |told| told.newest())
}
