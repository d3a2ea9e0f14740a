//! The table of a guard, and its function, which catches panics like those of `calls`.

#![allow(unsafe_code)]

use core::ffi::{CStr, c_char, c_void};
use core::time::Duration;

use jde_abi::{raw, table};
use jde_types::Value;

use super::catch::catch;
use crate::guard::Guard;

/// Builds the table of a guard.
pub(super) const fn guard<S: Guard>() -> raw::Guard {
    assert!(
        S::TABLE.kind == raw::PERCEPTIVE,
        "only a perceptive schema can be a guard"
    );
    raw::Guard {
        size: size_of::<raw::Guard>() as u32,
        state: state::<S>(),
        command: S::Command::TYPE,
        judge: Some(judge::<S>),
    }
}

/// Returns the number of the export of that name and type.
const fn state<S: Guard>() -> u32 {
    let mut number = 0;
    while number < S::TABLE.port_count {
        // SAFETY: the table has that many ports, whose texts and types are constants.
        let (kind, name, value_type) = unsafe {
            let port = &*S::TABLE.ports.add(number as usize);
            (port.kind, port.name, (*port.value_type).name)
        };
        if kind == raw::EXPORT && is_same(bytes(name), S::STATE_EXPORT.as_bytes()) {
            let is_state = is_same(bytes(value_type), bytes(S::State::TYPE.name));
            assert!(
                is_state,
                "the export `STATE_EXPORT` has another type than `State`"
            );
            return number;
        }
        number += 1;
    }
    panic!("`STATE_EXPORT` names no export of the schema")
}

pub(super) const fn bytes<'a>(text: *const c_char) -> &'a [u8] {
    // SAFETY: a text of a constant table.
    unsafe { CStr::from_ptr(text) }.to_bytes()
}

pub(super) const fn is_same(a: &[u8], b: &[u8]) -> bool {
    let mut same = a.len() == b.len();
    let mut place = 0;
    while same && place < a.len() {
        same = a[place] == b[place];
        place += 1;
    }
    same
}

/// # Safety
/// As for [`raw::Guard::judge`].
unsafe extern "C" fn judge<S: Guard>(
    state: *const c_void,
    age_ns: u64,
    command: *const c_void,
    out: *mut raw::Judgement,
) -> i32 {
    if out.is_null() {
        return raw::BAD_ARGUMENT;
    }
    // SAFETY: the host's values of these types, readable for the length of the call.
    let (Some(state), Some(command)) = (unsafe {
        (
            state.cast::<S::State>().as_ref(),
            command.cast::<S::Command>().as_ref(),
        )
    }) else {
        return raw::BAD_ARGUMENT;
    };
    // SAFETY: the host's pointer to room for the result, which states its size.
    let lent = unsafe { table::read(out) };
    let age = Duration::from_nanos(age_ns);
    let judged = catch(|| {
        let refused = S::judge(state, age, command).err()?;
        let limited = S::limit(state, age, command).filter(|limited| S::judge(state, age, limited).is_ok());
        Some((refused, limited))
    });
    let (status, reason, limited) = match judged {
        Ok(None) => (raw::OK, None, None),
        Ok(Some((reason, limited))) => (raw::OK, Some(reason), limited),
        Err(panic) => (raw::PANICKED, Some(panic), None),
    };
    let mut judgement = raw::Judgement {
        accepted: u32::from(reason.is_none()),
        reason: super::calls::text(reason.as_deref().unwrap_or_default()),
        ..raw::Judgement::REFUSED
    };
    if let (Some(limited), Ok(lent)) = (limited, lent) {
        judgement.command = lent.command;
        // SAFETY: the room that the host lends for a command, or null if it is of before minor version 8.
        if let Some(room) = unsafe { lent.command.cast::<S::Command>().as_mut() } {
            *room = limited;
            judgement.accepted = raw::LIMITED;
        }
    }
    // SAFETY: as above.
    unsafe { table::write(out, &judgement) };
    status
}
