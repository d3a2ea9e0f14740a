//! The functions of an instance, in C layout. Each one catches panics and validates what the host passes
//! before it uses it.

#![allow(unsafe_code)]

use core::ffi::{c_char, c_void};
use core::ptr::{self, NonNull};

use jde_abi::{raw, table};

use super::catch::catch;
use crate::context::Context;
use crate::error::{NoValue, Result, message};
use crate::level::{Level, Verdict};
use crate::schema::{Arbitrate, Schema};

/// The target of the host's pointer to an instance.
struct Instance<S> {
    /// The host's table in the layout of this SDK. Functions that an older host does not have are absent.
    host: raw::Host,
    schema: S,
}

/// # Safety
/// As for [`raw::Schema::create`]. For each other function of this module, as for the field of its name.
pub(super) unsafe extern "C" fn create<S: Schema>(
    _: *const raw::Schema,
    host: *const raw::Host,
    raw: *mut raw::Context,
) -> *mut c_void {
    // SAFETY: a host's table starts with its size and version, whose positions never change. The rest is used
    // only if both are right.
    let host = unsafe {
        if host.is_null() || host.cast::<u32>().add(1).read() != raw::ABI_MAJOR {
            return ptr::null_mut();
        }
        table::read(host)
    };
    let Ok(host) = host else {
        return ptr::null_mut();
    };
    let Some(raw) = NonNull::new(raw) else {
        return ptr::null_mut();
    };
    // SAFETY: the new instance is called only through its own table.
    match catch(|| unsafe { S::build() }) {
        Ok(schema) => Box::into_raw(Box::new(Instance { host, schema })).cast(),
        Err(panic) => {
            let ports = const { S::TABLE.ports };
            let cx = Context {
                host: &host,
                raw,
                ports,
            };
            cx.fail(&panic);
            ptr::null_mut()
        }
    }
}

pub(super) unsafe extern "C" fn destroy<S: Schema>(instance: *mut c_void) {
    if instance.is_null() {
        return;
    }
    // SAFETY: the pointer that `create` returned, which the host passes back once.
    let instance = unsafe { Box::from_raw(instance.cast::<Instance<S>>()) };
    // No call remains that could report the message.
    let _ = catch(|| drop(instance));
}

pub(super) unsafe extern "C" fn awake<S: Schema>(instance: *mut c_void, cx: *mut raw::Context) -> i32 {
    // SAFETY: the host's pointers.
    unsafe { call::<S>(instance, cx, S::awake) }
}

pub(super) unsafe extern "C" fn check<S: Schema>(
    instance: *mut c_void,
    cx: *mut raw::Context,
    out: *mut raw::Precondition,
) -> i32 {
    let check = |schema: &mut S, cx: &Context<'_>| {
        let precondition = schema.check(cx)?;
        let urgency = precondition.urgency;
        if !urgency.is_finite() {
            return Err(format!("its check offered an urgency of {urgency}; it must be finite").into());
        }
        let filled = raw::Precondition {
            size: size_of::<raw::Precondition>() as u32,
            ready: u32::from(precondition.ready),
            urgency,
        };
        // SAFETY: the host's pointer to room for the result, which states its size.
        unsafe { table::write(out, &filled) };
        Ok(())
    };
    if out.is_null() {
        return raw::BAD_ARGUMENT;
    }
    // SAFETY: the host's pointers.
    unsafe { call::<S>(instance, cx, check) }
}

pub(super) unsafe extern "C" fn iterate<S: Schema>(instance: *mut c_void, cx: *mut raw::Context) -> i32 {
    // SAFETY: the host's pointers.
    unsafe { call::<S>(instance, cx, S::iterate) }
}

pub(super) unsafe extern "C" fn arbitrate<S: Arbitrate>(
    instance: *mut c_void,
    cx: *mut raw::Context,
    level: *const raw::Level,
    out: *mut raw::Verdict,
) -> i32 {
    if out.is_null() {
        return raw::BAD_ARGUMENT;
    }
    // SAFETY: the host's table, which lives until this call returns.
    let Some(level) = (unsafe { Level::of(level) }) else {
        return raw::BAD_ARGUMENT;
    };
    let arbitrate = |schema: &mut S, cx: &Context<'_>| {
        let verdict = schema.arbitrate(cx, &level)?;
        // SAFETY: the host's pointer to room for the result, which states its size.
        unsafe { table::write(out, &raw_verdict(&verdict)) };
        Ok(())
    };
    // SAFETY: the host's pointers.
    unsafe { call::<S>(instance, cx, arbitrate) }
}

pub(super) unsafe extern "C" fn sleep<S: Schema>(instance: *mut c_void, cx: *mut raw::Context) {
    let sleep = |schema: &mut S, cx: &Context<'_>| {
        schema.sleep(cx);
        Ok(())
    };
    // SAFETY: the host's pointers. `fail` has received any error. The call itself returns nothing.
    let _ = unsafe { call::<S>(instance, cx, sleep) };
}

/// Returns the schema in an instance.
///
/// # Safety
/// `instance` is what `create::<S>` returned, and no call of it runs while the returned reference is in use.
pub(crate) unsafe fn schema_of<'a, S: Schema>(instance: *mut c_void) -> &'a S {
    // SAFETY: the caller's.
    unsafe { &(*instance.cast::<Instance<S>>()).schema }
}

/// Calls a function of an instance, and reports an error or a panic to the host with its message.
///
/// # Safety
/// `instance` is what `create` returned, and no other call of it runs. `cx` is the context of the present
/// call.
pub(super) unsafe fn call<S: Schema>(
    instance: *mut c_void,
    cx: *mut raw::Context,
    function: impl FnOnce(&mut S, &Context<'_>) -> Result,
) -> i32 {
    let Some(raw) = NonNull::new(cx) else {
        return raw::BAD_ARGUMENT;
    };
    // SAFETY: the caller's; null is checked.
    let Some(instance) = (unsafe { instance.cast::<Instance<S>>().as_mut() }) else {
        return raw::BAD_ARGUMENT;
    };
    let cx = Context {
        host: &instance.host,
        raw,
        ports: const { S::TABLE.ports },
    };
    let schema = &mut instance.schema;
    match catch(|| function(schema, &cx).map_err(|error| (message(&error), error.is::<NoValue>()))) {
        Ok(Ok(())) => raw::OK,
        Ok(Err((message, lacks_value))) => {
            cx.fail(&message);
            if lacks_value { raw::NO_VALUE } else { raw::FAILED }
        }
        Err(panic) => {
            cx.fail(&panic);
            raw::PANICKED
        }
    }
}

/// Converts a reason to C layout. One that is too long is cut at a character boundary.
pub(super) fn text(reason: &str) -> [c_char; 128] {
    let mut text = [0; 128];
    let cut = reason.floor_char_boundary(text.len() - 1);
    let bytes = reason[..cut].bytes().take_while(|&byte| byte != 0);
    for (place, byte) in text.iter_mut().zip(bytes) {
        *place = c_char::from_ne_bytes([byte]);
    }
    text
}

fn raw_verdict(verdict: &Verdict) -> raw::Verdict {
    raw::Verdict {
        size: size_of::<raw::Verdict>() as u32,
        child: verdict
            .child
            .and_then(|child| i32::try_from(child).ok())
            .unwrap_or(-1),
        reason: text(&verdict.reason),
    }
}
