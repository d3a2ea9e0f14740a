//! Doing what has a fault happen, and taking it back. What is refused is no fault of the campaign: it comes at odd times.

use jde_board::value::Value;
use jde_host::plugin::Loaded;
use jde_host::reload::How;
use jde_host::{Handle, Operating};
use rustix::process::{Pid, Signal as Posix, kill_process};

use crate::plan::{Act, Fault, Operation, Signal};

/// Who acts.
const BY: &str = "faults";
/// How long a build is on trial: some faults come after it, some before.
const TRIAL: u64 = 200_000_000;

/// What is under way.
pub(super) struct Under {
    /// Misdeeds that the schema had told of before.
    misdeeds: u64,
    process: Option<Pid>,
    done: bool,
}

pub(super) fn begin(fault: &Fault, place: usize, handle: &Handle, builds: &[Loaded]) -> Under {
    let operator = handle.operator(BY);
    let mut under = Under {
        misdeeds: misdeeds(fault, handle),
        process: None,
        done: false,
    };
    match &fault.act {
        Act::Tell { trouble, place: call } => tell(&operator, place, trouble, call),
        Act::Reload {
            trouble,
            place: call,
            build,
        } => {
            tell(&operator, place, trouble, call);
            let how = How {
                probation: TRIAL,
                fresh: false,
            };
            // Refused if another waits for its turn already.
            let _ = operator.replace(place, &builds[*build], how);
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
        Act::Operate(operation) => {
            let asked = match operation {
                Operation::Stop => operator.hold_asleep(place),
                Operation::Force => operator.force(place),
                Operation::Play => operator.play(place),
                Operation::Retime(period) => operator.set_period(place, *period),
                Operation::Unload => operator.unload(place),
                Operation::StopAll => operator.stop_all(),
            };
            under.done = asked.is_ok();
        }
    }
    under
}

/// Takes it back; answers whether it is known to have taken effect.
pub(super) fn end(fault: &Fault, place: usize, handle: &Handle, under: Under) -> bool {
    let operator = handle.operator(BY);
    match &fault.act {
        Act::Tell { .. } | Act::Reload { .. } => tell(&operator, place, "", "iterate"),
        Act::Signal(Signal::Kill) => {}
        Act::Signal(Signal::Stop) => {
            // It may have been killed for it long ago; only while it is the same process is it woken.
            let same = handle.snapshot().schemas[place]
                .process
                .and_then(|number| Pid::from_raw(number.cast_signed()));
            if let Some(process) = under.process.filter(|process| Some(*process) == same) {
                let _ = kill_process(process, Posix::CONT);
            }
        }
        Act::Operate(Operation::StopAll) => drop(operator.release_all()),
        Act::Operate(_) => drop(operator.release(place)),
    }
    under.done || misdeeds(fault, handle) > under.misdeeds
}

fn tell(operator: &Operating, place: usize, trouble: &str, call: &str) {
    for (name, word) in [("place", call), ("trouble", trouble)] {
        // The modulation is there, and the word fits: what could be wrong shows as a fault that never takes effect.
        let _ = operator.modulate(place, name, &Value::Text(word.to_owned()));
    }
}

/// How often it has told of a misdeed, also if that was taken back since.
fn misdeeds(fault: &Fault, handle: &Handle) -> u64 {
    let told = handle.board().find(&format!("{}.misdeeds", fault.schema));
    told.map_or(0, |told| told.newest())
}
