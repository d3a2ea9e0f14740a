//! What a program sees of the schemas, and its actions as an operator.

use std::ffi::c_char;

use jde_abi::raw;
use jde_core::State;
use jde_embed::{Error, Run};
use jde_records::RecordKind;

use crate::boundary::{Failure, call, check_place, give, give_text, text};
use crate::run::nanoseconds;
use crate::{handles, tables};

/// Returns the winner of a group, such as "roots" or "example/base". `JDE_NO_VALUE` if nobody wins.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_winner(
    run: *mut tables::Run,
    group: *const c_char,
    text: *mut *mut c_char,
) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        // SAFETY: the pointers are those of the header's rules.
        unsafe {
            let group = crate::boundary::text("group", group)?;
            let winner = run.winner(group)?;
            give_text(
                text,
                winner.ok_or_else(|| Failure::new(raw::NO_VALUE, "nobody wins"))?,
            )
        }
    })
}

/// Returns the state of a schema: `JDE_SLEPT`, `JDE_CHECKING`, `JDE_READY` or `JDE_WINNER`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_state(run: *mut tables::Run, schema: *const c_char, state: *mut u32) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        // SAFETY: the pointers are those of the header's rules.
        unsafe {
            let number = match run.schema_state(text("schema", schema)?)? {
                State::Slept => raw::SLEPT,
                State::Checking => raw::CHECKING,
                State::Ready => raw::READY,
                State::Winner => raw::WINNER,
            };
            give("state", state, number)
        }
    })
}

/// Returns the state of every schema and group as JSON: `hierarchy` of docs/protocol.md.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_snapshot(run: *mut tables::Run, text: *mut *mut c_char) -> i32 {
    call(|| {
        let snapshot = serde_json::to_string(&handles::run(run)?.snapshot());
        let snapshot = snapshot.map_err(|error| Failure::new(raw::FAILED, error.to_string()))?;
        // SAFETY: a place for a text.
        unsafe { give_text(text, snapshot) }
    })
}

/// Removes the oldest record that the program has not taken, and returns its kind and its JSON, in the form of
/// docs/recordings.md. `JDE_NO_VALUE` if there is none. Of each kind, 100 000 records wait; `dropped` may be null, and gets
/// how many were dropped since the last call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_next_record(
    run: *mut tables::Run,
    kind: *mut u32,
    text: *mut *mut c_char,
    dropped: *mut u64,
) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        check_place("kind", kind)?;
        check_place("text", text)?;
        let next = run.next_record()?;
        let (record, lost) = next.ok_or_else(|| Failure::new(raw::NO_VALUE, "no record waits"))?;
        let number = match record.kind() {
            RecordKind::Decision => tables::RECORD_DECISION,
            RecordKind::State => tables::RECORD_STATE,
            RecordKind::Event => tables::RECORD_EVENT,
        };
        // SAFETY: the pointers are those of the header's rules.
        unsafe {
            give("kind", kind, number)?;
            if !dropped.is_null() {
                dropped.write(lost);
            }
            give_text(text, String::from_utf8_lossy(&record.to_json()))
        }
    })
}

/// Wakes a schema as its father would. As every action of an operator (R14), it lasts until it is released, or until the
/// lease ends. `JDE_REFUSED` with the reason; likewise below.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_play(run: *mut tables::Run, schema: *const c_char) -> i32 {
    // SAFETY: a text of the program.
    unsafe { act(run, schema, Run::play) }
}

/// Puts a schema to sleep until it is released.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_stop(run: *mut tables::Run, schema: *const c_char) -> i32 {
    // SAFETY: a text of the program.
    unsafe { act(run, schema, Run::stop) }
}

/// Makes a schema the winner of its group while it is awake.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_force(run: *mut tables::Run, schema: *const c_char) -> i32 {
    // SAFETY: a text of the program.
    unsafe { act(run, schema, Run::force) }
}

/// Undoes what operators did to a schema, and restores the modulations that they wrote.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_release(run: *mut tables::Run, schema: *const c_char) -> i32 {
    // SAFETY: a text of the program.
    unsafe { act(run, schema, Run::release) }
}

/// Stops all schemas at once, and makes every command neutral, until jde_run_release_all(). No lease ends that.
#[unsafe(no_mangle)]
pub extern "C" fn jde_run_stop_all(run: *mut tables::Run) -> i32 {
    call(|| Ok(handles::run(run)?.stop_all()?))
}

/// Undoes jde_run_stop_all(), whoever stopped everything.
#[unsafe(no_mangle)]
pub extern "C" fn jde_run_release_all(run: *mut tables::Run) -> i32 {
    call(|| Ok(handles::run(run)?.release_all()?))
}

/// Gives all that the program holds as an operator a lease of so many seconds of the application from now on, so that a
/// program that hangs holds nothing any more. Call it again within the lease to renew it. After its end, what was held
/// is undone, and later actions have no lease until this is called again. 0 removes the lease.
#[unsafe(no_mangle)]
pub extern "C" fn jde_run_lease(run: *mut tables::Run, seconds: f64) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        let lease = (seconds != 0.0).then(|| nanoseconds(seconds)).transpose()?;
        run.renew_lease(lease);
        Ok(())
    })
}

/// Changes the world of a simulated robot by the name of its driver, in TOML: "{ remove = 'door' }" (docs/simulator.md).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn jde_run_edit(
    run: *mut tables::Run,
    driver: *const c_char,
    edits: *const c_char,
) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        // SAFETY: texts of the program.
        let (driver, edits) = unsafe { (text("driver", driver)?, text("edits", edits)?) };
        Ok(run.edit(driver, edits)?)
    })
}

unsafe fn act(
    run: *mut tables::Run,
    schema: *const c_char,
    action: impl FnOnce(&Run, &str) -> Result<(), Error>,
) -> i32 {
    call(|| {
        let run = handles::run(run)?;
        // SAFETY: the caller's.
        let schema = unsafe { text("schema", schema) }?;
        Ok(action(&run, schema)?)
    })
}
