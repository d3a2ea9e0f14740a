//! How time passes, and how a run ends.

use std::ffi::c_char;

use jde_abi::raw;
use jde_core::Nanos;
use jde_embed::{Run, Stop};

use crate::boundary::{Failure, call, give, give_text, text};
use crate::{handles, tables};

/// The longest time of a run, s.
const LONGEST_RUN: f64 = 9e9;

/// Runs the next instant in lockstep: everything that is due then. `JDE_ENDED` if the application has ended;
/// `JDE_NOT_REACHED` if nothing is due any more. Blocks while the schemas compute.
#[unsafe(no_mangle)]
pub extern "C" fn jde_run_step(run: *mut tables::Run) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        match run.step(None)? {
            true => Ok(()),
            false if run.outcome().is_some() => Err(ended(&run)),
            false => Err(Failure::new(tables::NOT_REACHED, "nothing is due any more")),
        }
    })
}

/// Lets time pass in lockstep, or waits in real time, until a time, s; `INFINITY` for no end. `JDE_ENDED` if the
/// application ends before. Blocks meanwhile; several threads may wait.
#[unsafe(no_mangle)]
pub extern "C" fn jde_run_until(run: *mut tables::Run, time: f64) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        match run.until(end(time)?, None, || true)? {
            Stop::Time | Stop::Condition => Ok(()),
            Stop::End => Err(ended(&run)),
        }
    })
}

/// The same until a condition is true, as `jde run --break` takes it: "vff.won and clearance < 0.2". In lockstep it is
/// looked at after each instant, in real time a hundred times a second and after each change of a state.
/// `JDE_NOT_REACHED` if the time comes first.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_until_condition(
    run: *mut tables::Run,
    condition: *const c_char,
    time: f64,
) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        // SAFETY: a text of the program.
        let condition = unsafe { text("condition", condition) }?;
        match run.until(end(time)?, Some(condition), || true)? {
            Stop::Condition => Ok(()),
            Stop::Time => Err(Failure::new(
                tables::NOT_REACHED,
                format!("`{condition}` has not become true"),
            )),
            Stop::End => Err(ended(&run)),
        }
    })
}

/// Returns the time, s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_time(run: *mut tables::Run, time: *mut f64) -> i32 {
    call(|| {
        let now = handles::run(run)?.handle().now();
        // SAFETY: a place for a number.
        unsafe { give("time", time, now as f64 / 1e9) }
    })
}

/// Returns how the application ended: "done" or "failed" for its mission, "time up", "stopped", or "broken: " with the
/// reason. `JDE_NO_VALUE` while it runs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_outcome(run: *mut tables::Run, text: *mut *mut c_char) -> i32 {
    call(|| match handles::run(run)?.outcome() {
        // SAFETY: a place for a text.
        Some(outcome) => unsafe { give_text(text, outcome) },
        None => Err(Failure::new(raw::NO_VALUE, "the application runs")),
    })
}

/// Ends the application and brings it to rest: actuators first, then all schemas in order. Blocks until it is at rest,
/// at most a second for each schema that does not return; threads that wait for the run return `JDE_ENDED`. Variables
/// and records can still be read.
#[unsafe(no_mangle)]
pub extern "C" fn jde_run_end(run: *mut tables::Run) -> i32 {
    call(|| {
        handles::run(run)?.end();
        Ok(())
    })
}

/// Ends the application as jde_run_end() does, and closes the handle.
#[unsafe(no_mangle)]
pub extern "C" fn jde_run_close(run: *mut tables::Run) -> i32 {
    call(|| {
        let ending = handles::run(run)?;
        handles::close(run);
        ending.end();
        Ok(())
    })
}

/// Converts a time of the program, s, to ns.
pub(crate) fn nanoseconds(seconds: f64) -> Result<Nanos, Failure> {
    if (0.0..LONGEST_RUN).contains(&seconds) {
        Ok((seconds * 1e9).round() as Nanos)
    } else {
        let text = format!("{seconds} s is not a time of a run: give 0 to {LONGEST_RUN:e}");
        Err(Failure::new(raw::BAD_ARGUMENT, text))
    }
}

fn end(time: f64) -> Result<Option<Nanos>, Failure> {
    (time != f64::INFINITY).then(|| nanoseconds(time)).transpose()
}

fn ended(run: &Run) -> Failure {
    let outcome = run.outcome().unwrap_or_default();
    Failure::new(tables::ENDED, format!("the application has ended: {outcome}"))
}
