//! The optional abilities of a type of schema: their tables, and the functions in them. Each function catches
//! panics, like those of `calls`.

#![allow(unsafe_code)]

use core::ffi::{CStr, c_char, c_void};
use core::{ptr, slice};

use jde_abi::{raw, table};

use super::calls::call;
use crate::context::Context;
use crate::inspect::{Inspect, Problems};
use crate::memory::{Memory, Saved, Saving};
use crate::panel::{self, Gesture, Panel};
use crate::schema::Describe;

/// Builds the table of a panel.
pub(super) const fn panel<S: Panel>() -> raw::Panel {
    raw::Panel {
        size: size_of::<raw::Panel>() as u32,
        reserved: 0,
        draw: Some(draw::<S>),
        touch: Some(touch::<S>),
    }
}

/// Builds the table of a memory.
pub(super) const fn state<S: Memory>() -> raw::State {
    raw::State {
        size: size_of::<raw::State>() as u32,
        version: S::VERSION,
        save: Some(save::<S>),
        restore: Some(restore::<S>),
    }
}

/// Builds the table of an inspection.
pub(super) const fn inspection<S: Inspect>() -> raw::Inspect {
    raw::Inspect {
        size: size_of::<raw::Inspect>() as u32,
        reserved: 0,
        inspect: Some(inspect::<S>),
    }
}

/// Returns the table of the panel, the memory, the inspection, the guard or the lists of ports, or null if the type
/// does not have that ability.
///
/// # Safety
/// As for [`raw::Schema::ability`]. For each other function of this module, as for the field of its name.
pub(super) unsafe extern "C" fn ability<S: Describe>(id: *const c_char) -> *const c_void {
    if id.is_null() {
        return ptr::null();
    }
    // SAFETY: the host's text.
    match unsafe { CStr::from_ptr(id) }.to_str() {
        Ok(raw::ABILITY_PANEL) => const { &S::PANEL }
            .as_ref()
            .map_or(ptr::null(), |panel| ptr::from_ref(panel).cast()),
        Ok(raw::ABILITY_STATE) => const { &S::STATE }
            .as_ref()
            .map_or(ptr::null(), |state| ptr::from_ref(state).cast()),
        Ok(raw::ABILITY_GUARD) => const { &S::GUARD }
            .as_ref()
            .map_or(ptr::null(), |guard| ptr::from_ref(guard).cast()),
        Ok(raw::ABILITY_LISTS) => const { &S::LISTS }
            .as_ref()
            .map_or(ptr::null(), |lists| ptr::from_ref(lists).cast()),
        Ok(raw::ABILITY_INSPECT) => const { &S::INSPECT }
            .as_ref()
            .map_or(ptr::null(), |inspect| ptr::from_ref(inspect).cast()),
        _ => ptr::null(),
    }
}

unsafe extern "C" fn inspect<S: Inspect>(
    instance: *mut c_void,
    cx: *mut raw::Context,
    problems: *const raw::Problems,
) -> i32 {
    // SAFETY: the host's table, which lives until this call returns.
    let Ok(list) = (unsafe { table::read(problems) }) else {
        return raw::BAD_ARGUMENT;
    };
    let inspect = |schema: &mut S, cx: &Context<'_>| {
        schema.inspect(cx, &mut Problems::new(&list, cx.ports));
        Ok(())
    };
    // SAFETY: the host's pointers.
    unsafe { call::<S>(instance, cx, inspect) }
}

unsafe extern "C" fn save<S: Memory>(
    instance: *mut c_void,
    cx: *mut raw::Context,
    saver: *const raw::Saver,
) -> i32 {
    // SAFETY: the host's saver, which lives until this call returns.
    let Ok(saver) = (unsafe { table::read(saver) }) else {
        return raw::BAD_ARGUMENT;
    };
    let save = |schema: &mut S, cx: &Context<'_>| {
        let mut saving = Saving::new();
        schema.save(cx, &mut saving);
        let bytes = saving.into_bytes();
        // SAFETY: the host's function and the first argument that it requires, and bytes of that length.
        let status = unsafe { (saver.write)(saver.saving, bytes.as_ptr().cast(), bytes.len() as u64) };
        match status {
            raw::OK => Ok(()),
            _ => Err(format!("it saves {} bytes, more than are kept", bytes.len()).into()),
        }
    };
    // SAFETY: the host's pointers.
    unsafe { call::<S>(instance, cx, save) }
}

unsafe extern "C" fn restore<S: Memory>(
    instance: *mut c_void,
    cx: *mut raw::Context,
    version: u32,
    bytes: *const c_void,
    length: u64,
) -> i32 {
    let bytes = match (bytes.is_null(), usize::try_from(length)) {
        (_, Ok(0)) => &[][..],
        // SAFETY: the host's bytes, which live until this call returns.
        (false, Ok(length)) => unsafe { slice::from_raw_parts(bytes.cast::<u8>(), length) },
        (true, _) | (_, Err(_)) => return raw::BAD_ARGUMENT,
    };
    // SAFETY: the host's pointers.
    unsafe {
        call::<S>(instance, cx, |schema, cx| {
            schema.restore(cx, &mut Saved::new(version, bytes))
        })
    }
}

unsafe extern "C" fn draw<S: Panel>(
    instance: *mut c_void,
    cx: *mut raw::Context,
    pen: *const raw::Pen,
) -> i32 {
    // SAFETY: the host's pen, which lives until this call returns.
    let Ok(pen) = (unsafe { table::read(pen) }) else {
        return raw::BAD_ARGUMENT;
    };
    let mut pen = panel::Pen::of(&pen);
    let draw = |schema: &mut S, cx: &Context<'_>| {
        schema.draw(cx, &mut pen);
        Ok(())
    };
    // SAFETY: the host's pointers.
    unsafe { call::<S>(instance, cx, draw) }
}

unsafe extern "C" fn touch<S: Panel>(
    instance: *mut c_void,
    cx: *mut raw::Context,
    gesture: *const raw::Gesture,
) -> i32 {
    // SAFETY: the host's table, which lives until this call returns.
    let (by, gesture) = match unsafe { jde_panel::read_gesture(gesture) } {
        Ok(Some(known)) => known,
        // A later host reports a kind of gesture that this schema cannot have requested.
        Ok(None) => return raw::OK,
        Err(_) => return raw::BAD_ARGUMENT,
    };
    let gesture = Gesture::new(by, gesture);
    // SAFETY: the host's pointers.
    unsafe { call::<S>(instance, cx, |schema, cx| schema.touched(cx, &gesture)) }
}
