//! The host's side of the ABI: the functions that a plugin calls back, each within a call of its instance.
//!
//! No panic unwinds out of them, because it would end the process. A panic in them is the host's own, and
//! ends the application.

#![allow(unsafe_code)]

use std::ffi::{CStr, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null;

use jde_abi::raw::{self, Context, Host};
use jde_abi::table::{self, text_of};

use super::call::CallContext;
use super::turns::TURNS;

/// The table given to every instance.
pub(super) static HOST: Host = Host {
    size: size_of::<Host>() as u32,
    abi_major: raw::ABI_MAJOR,
    abi_minor: raw::ABI_MINOR,
    reserved: 0,
    read,
    loan,
    publish,
    wake,
    sleep,
    child,
    set_policy,
    now,
    seed,
    application,
    name,
    log,
    fail,
    extension,
    retract: Some(retract),
    real_time: Some(real_time),
};

/// Runs `body` with the call behind `context`.
///
/// # Safety
/// `context` is the one given to the current call of an instance, on this thread.
pub(super) unsafe fn in_call<R>(
    context: *mut Context,
    on_panic: R,
    body: impl FnOnce(&mut CallContext<'_>) -> R,
) -> R {
    // SAFETY: by the contract of `Host`, the context is the one that `Instance::call_optional` made, and
    // nothing else uses it during the call.
    let call = unsafe { &mut *context.cast::<CallContext<'_>>() };
    catch_unwind(AssertUnwindSafe(|| body(call))).unwrap_or_else(|_| {
        call.engine.report_panic();
        on_panic
    })
}

unsafe extern "C" fn read(context: *mut Context, port: u32, out: *mut raw::Sample) -> i32 {
    // SAFETY: the plugin gives the context of this call and room for a sample.
    unsafe {
        in_call(context, raw::FAILED, |call| {
            let shown = call.read(port, |view| out.write(view.sample()));
            shown.map_or_else(|status| status, |()| raw::OK)
        })
    }
}

unsafe extern "C" fn loan(context: *mut Context, port: u32, out: *mut *mut c_void) -> i32 {
    // SAFETY: the plugin gives the context of this call and room for a pointer.
    unsafe {
        in_call(context, raw::FAILED, |call| {
            let loaned = call.loan(port, |buffer| out.write(buffer.as_mut_ptr().cast::<c_void>()));
            loaned.map_or_else(|status| status, |()| raw::OK)
        })
    }
}

unsafe extern "C" fn publish(context: *mut Context, port: u32, time_ns: u64) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { in_call(context, raw::FAILED, |call| call.publish(port, time_ns)) }
}

unsafe extern "C" fn wake(context: *mut Context, child: u32) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { in_call(context, raw::FAILED, |call| call.wake(child)) }
}

unsafe extern "C" fn sleep(context: *mut Context, child: u32) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { in_call(context, raw::FAILED, |call| call.sleep(child)) }
}

unsafe extern "C" fn child(context: *mut Context, child: u32, out: *mut raw::ChildStatus) -> i32 {
    // SAFETY: the plugin gives the context of this call and room for a status.
    unsafe {
        in_call(context, raw::FAILED, |call| match call.child(child) {
            Err(status) => status,
            Ok(status) => {
                table::write(out, &status);
                raw::OK
            }
        })
    }
}

unsafe extern "C" fn set_policy(
    context: *mut Context,
    child: u32,
    policy: u32,
    dwell_ns: u64,
    hysteresis: f64,
) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe {
        in_call(context, raw::FAILED, |call| {
            call.set_policy(child, policy, dwell_ns, hysteresis)
        })
    }
}

unsafe extern "C" fn now(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { in_call(context, 0, |call| call.now()) }
}

unsafe extern "C" fn seed(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { in_call(context, 0, |call| call.engine.seed_of(call.number)) }
}

unsafe extern "C" fn application(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { in_call(context, 0, |call| call.engine.id) }
}

unsafe extern "C" fn name(context: *mut Context) -> *const c_char {
    // SAFETY: the plugin gives the context of this call.
    unsafe { in_call(context, null(), |call| call.name.as_ptr()) }
}

unsafe extern "C" fn log(context: *mut Context, level: u32, text: *const c_char, length: u64) {
    // SAFETY: the plugin gives the context of this call and a text of that length.
    unsafe {
        in_call(context, (), |call| {
            let text = text_of(text, length);
            call.log(level, &text);
        });
    }
}

unsafe extern "C" fn fail(context: *mut Context, text: *const c_char, length: u64) {
    // SAFETY: the plugin gives the context of this call and a text of that length.
    unsafe { in_call(context, (), |call| call.failure = Some(text_of(text, length))) }
}

unsafe extern "C" fn extension(context: *mut Context, id: *const c_char) -> *const c_void {
    // SAFETY: the plugin gives a text with a NUL at its end, and the context of this call.
    unsafe {
        let is_turns = CStr::from_ptr(id).to_bytes() == raw::EXTENSION_TURNS.as_bytes();
        match is_turns && real_time(context) == 1 {
            true => (&raw const TURNS).cast(),
            false => null(),
        }
    }
}

unsafe extern "C" fn retract(context: *mut Context, port: u32) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { in_call(context, raw::FAILED, |call| call.retract(port)) }
}

unsafe extern "C" fn real_time(context: *mut Context) -> u32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe {
        in_call(context, 0, |call| {
            u32::from(call.engine.clock.has_wall_clock_speed())
        })
    }
}
