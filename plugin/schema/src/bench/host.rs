//! The functions of the bench's host. They keep the contract of the ABI as the real host does, and never
//! panic.

#![allow(unsafe_code)]

use core::ffi::{c_char, c_void};
use core::ptr;
use core::time::Duration;

use jde_abi::describe::Role;
use jde_abi::raw;
use jde_abi::table::{self, text_of};
use jde_core::Policy;

use super::state::BenchState;
use crate::child::State;
use crate::context::Severity;

pub(super) static HOST: raw::Host = raw::Host {
    size: size_of::<raw::Host>() as u32,
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

/// # Safety
/// `cx` is the bench's own context of the present call, and no other reference to it exists. The same applies
/// to all functions here.
unsafe fn state<'a>(cx: *mut raw::Context) -> &'a mut BenchState {
    // SAFETY: the caller's.
    unsafe { &mut *cx.cast() }
}

unsafe extern "C" fn read(cx: *mut raw::Context, port: u32, out: *mut raw::Sample) -> i32 {
    // SAFETY: the schema's pointers, by the contract of the ABI.
    unsafe {
        let place = state(cx);
        let Some(port) = place.ports.get(port as usize).filter(|_| !out.is_null()) else {
            return raw::BAD_ARGUMENT;
        };
        let validity = match port.port.role {
            Role::Import { .. } | Role::Modulation { .. } => Duration::MAX,
            Role::Command { validity_ns, .. } => Duration::from_nanos(validity_ns),
            Role::Export { .. } | Role::Actuator | Role::ChildModulation { .. } => return raw::BAD_ARGUMENT,
        };
        if !port.bound {
            return raw::UNBOUND;
        }
        let newest = port
            .newest
            .as_ref()
            .filter(|(_, time)| place.now <= time.saturating_add(validity));
        let (bytes, time, flags) = match (newest, &port.initial) {
            (Some((bytes, time)), _) => (bytes, *time, 0),
            (None, Some(initial)) if validity == Duration::MAX => {
                (initial, Duration::ZERO, raw::SAMPLE_DEFAULT)
            }
            (None, Some(initial)) => (initial, Duration::ZERO, raw::SAMPLE_NEUTRAL),
            (None, None) => return raw::NO_VALUE,
        };
        out.write(raw::Sample {
            data: bytes.as_ptr().cast(),
            bytes: bytes.as_slice().len() as u64,
            time_ns: time.as_nanos() as u64,
            sequence: port.sequence,
            writer: 0,
            flags,
        });
        raw::OK
    }
}

unsafe extern "C" fn loan(cx: *mut raw::Context, port: u32, out: *mut *mut c_void) -> i32 {
    // SAFETY: the bench's own context.
    if unsafe { state(cx) }.refuses("write") {
        return raw::REFUSED;
    }
    // SAFETY: the schema's pointers, by the contract of the ABI.
    unsafe {
        let Some(port) = state(cx).ports.get_mut(port as usize).filter(|_| !out.is_null()) else {
            return raw::BAD_ARGUMENT;
        };
        match port.port.role {
            Role::Export { .. } | Role::Actuator | Role::ChildModulation { .. } => {}
            Role::Import { .. } | Role::Modulation { .. } | Role::Command { .. } => return raw::BAD_ARGUMENT,
        }
        if !port.bound {
            return raw::UNBOUND;
        }
        port.loaned = true;
        out.write(port.loan.as_mut_ptr().cast());
        raw::OK
    }
}

unsafe extern "C" fn publish(cx: *mut raw::Context, port: u32, time_ns: u64) -> i32 {
    // SAFETY: the bench's own context.
    if unsafe { state(cx) }.refuses("write") {
        return raw::REFUSED;
    }
    // SAFETY: the bench's own context.
    unsafe { state(cx) }.publish(port as usize, time_ns)
}

unsafe extern "C" fn wake(cx: *mut raw::Context, child: u32) -> i32 {
    // SAFETY: the bench's own context.
    if unsafe { state(cx) }.refuses("wake a child") {
        return raw::REFUSED;
    }
    // SAFETY: the bench's own context.
    let place = unsafe { state(cx) };
    let authority = place.authority;
    let child = match place.bound_child(child) {
        Ok(child) => child,
        Err(code) => return code,
    };
    if !authority {
        return raw::REFUSED;
    }
    if child.state == State::Slept {
        child.state = if child.motor {
            State::Checking
        } else {
            State::Winner
        };
    }
    raw::OK
}

unsafe extern "C" fn sleep(cx: *mut raw::Context, child: u32) -> i32 {
    // SAFETY: the bench's own context.
    if unsafe { state(cx) }.refuses("put a child to sleep") {
        return raw::REFUSED;
    }
    // SAFETY: the bench's own context.
    let place = unsafe { state(cx) };
    let authority = place.authority;
    let child = match place.bound_child(child) {
        Ok(child) => child,
        Err(code) => return code,
    };
    if !authority {
        return raw::REFUSED;
    }
    child.state = State::Slept;
    child.precondition = false.into();
    raw::OK
}

unsafe extern "C" fn child(cx: *mut raw::Context, child: u32, out: *mut raw::ChildStatus) -> i32 {
    // SAFETY: the schema's pointers, by the contract of the ABI.
    unsafe {
        if out.is_null() {
            return raw::BAD_ARGUMENT;
        }
        let child = match state(cx).bound_child(child) {
            Ok(child) => child,
            Err(code) => return code,
        };
        let status = raw::ChildStatus {
            size: size_of::<raw::ChildStatus>() as u32,
            state: child.state.code(),
            faulted: u32::from(child.faulted),
            reserved: 0,
        };
        table::write(out, &status);
        raw::OK
    }
}

unsafe extern "C" fn set_policy(
    cx: *mut raw::Context,
    child: u32,
    policy: u32,
    dwell_ns: u64,
    hysteresis: f64,
) -> i32 {
    // SAFETY: the bench's own context.
    if unsafe { state(cx) }.refuses("change a policy") {
        return raw::REFUSED;
    }
    // SAFETY: the bench's own context.
    let place = unsafe { state(cx) };
    let authority = place.authority;
    let child = match place.bound_child(child) {
        Ok(child) if child.motor => child,
        Ok(_) => return raw::BAD_ARGUMENT,
        Err(code) => return code,
    };
    let Some(policy) = Policy::from_code(policy, dwell_ns, hysteresis) else {
        return raw::BAD_ARGUMENT;
    };
    if !authority {
        return raw::REFUSED;
    }
    child.policy = Some(policy);
    raw::OK
}

unsafe extern "C" fn now(cx: *mut raw::Context) -> u64 {
    // SAFETY: the bench's own context.
    unsafe { state(cx) }.now.as_nanos() as u64
}

unsafe extern "C" fn seed(_: *mut raw::Context) -> u64 {
    1
}

unsafe extern "C" fn application(_: *mut raw::Context) -> u64 {
    1
}

unsafe extern "C" fn name(_: *mut raw::Context) -> *const c_char {
    c"bench".as_ptr()
}

unsafe extern "C" fn log(cx: *mut raw::Context, level: u32, text: *const c_char, length: u64) {
    let severity = match level {
        raw::TRACE => Severity::Trace,
        raw::DEBUG => Severity::Debug,
        raw::INFO => Severity::Info,
        raw::WARN => Severity::Warn,
        _ => Severity::Error,
    };
    // SAFETY: the bench's own context, and the schema's text.
    unsafe { state(cx).log.push((severity, text_of(text, length))) };
}

unsafe extern "C" fn fail(cx: *mut raw::Context, text: *const c_char, length: u64) {
    // SAFETY: the bench's own context, and the schema's text.
    unsafe { state(cx).reason = Some(text_of(text, length)) };
}

unsafe extern "C" fn extension(_: *mut raw::Context, _: *const c_char) -> *const c_void {
    ptr::null()
}

unsafe extern "C" fn retract(cx: *mut raw::Context, port: u32) -> i32 {
    // SAFETY: the bench's own context.
    if unsafe { state(cx) }.refuses("take a value back") {
        return raw::REFUSED;
    }
    // SAFETY: the bench's own context.
    unsafe { state(cx) }.retract(port as usize)
}

unsafe extern "C" fn real_time(cx: *mut raw::Context) -> u32 {
    // SAFETY: the bench's own context.
    u32::from(unsafe { state(cx) }.real_time)
}
