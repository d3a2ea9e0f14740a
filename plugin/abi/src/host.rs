//! The table of a host, made from the methods of what is behind its contexts. Each host has a state of a call of its own;
//! the functions in C layout exist once, here.

#![allow(unsafe_code)]

use core::ffi::{CStr, c_char, c_void};
use core::ptr;

use crate::raw::{self, ChildStatus, Context, Sample};
use crate::table::{self, text_of};

/// What a host offers in a call of an instance. Each method has the meaning of the field of [`raw::Host`] with its name, and
/// its statuses are those of [`raw`].
#[allow(missing_docs, reason = "the fields of `raw::Host` describe the methods")]
pub trait Host: Sized {
    /// The status of a request that was not run.
    const NOT_RUN: i32 = raw::FAILED;

    /// Runs a request of the call behind `context`, or returns `not_run`. Does not unwind.
    ///
    /// # Safety
    /// A plugin gave `context` to a function of [`table()`].
    unsafe fn request<R>(context: *mut Context, not_run: R, run: impl FnOnce(&mut Self) -> R) -> R;

    fn read(&mut self, port: u32) -> Result<Sample, i32>;
    fn loan(&mut self, port: u32) -> Result<*mut u8, i32>;
    fn publish(&mut self, port: u32, time_ns: u64) -> i32;
    fn retract(&mut self, port: u32) -> i32;
    fn wake(&mut self, child: u32) -> i32;
    fn sleep(&mut self, child: u32) -> i32;
    /// Returns the number of the child's state, and whether it is Faulted.
    fn child(&mut self, child: u32) -> Result<(u32, bool), i32>;
    fn set_policy(&mut self, child: u32, policy: u32, dwell_ns: u64, hysteresis: f64) -> i32;
    fn now(&mut self) -> u64;
    fn real_time(&mut self) -> bool;
    fn seed(&mut self) -> u64;
    fn application(&mut self) -> u64;
    fn name(&mut self) -> &CStr;
    fn log(&mut self, level: u32, text: &str);
    fn fail(&mut self, reason: String);
    fn extension(&mut self, _id: &CStr) -> *const c_void {
        ptr::null()
    }
}

/// Returns the table of a host that gives contexts with an `H` behind them. Lifetimes of `H` do not matter: its methods are
/// the same for all.
#[must_use]
pub const fn table<H: Host>() -> raw::Host {
    raw::Host {
        size: size_of::<raw::Host>() as u32,
        abi_major: raw::ABI_MAJOR,
        abi_minor: raw::ABI_MINOR,
        reserved: 0,
        read: read::<H>,
        loan: loan::<H>,
        publish: publish::<H>,
        wake: wake::<H>,
        sleep: sleep::<H>,
        child: child::<H>,
        set_policy: set_policy::<H>,
        now: now::<H>,
        seed: seed::<H>,
        application: application::<H>,
        name: name::<H>,
        log: log::<H>,
        fail: fail::<H>,
        extension: extension::<H>,
        retract: Some(retract::<H>),
        real_time: Some(real_time::<H>),
    }
}

/// Passes a result to `write`, and returns its status.
fn answer<T>(result: Result<T, i32>, write: impl FnOnce(T)) -> i32 {
    result.map_or_else(
        |status| status,
        |value| {
            write(value);
            raw::OK
        },
    )
}

/// # Safety
/// As for [`raw::Host::read`]. The same holds for each function below and the field of its name.
unsafe extern "C" fn read<H: Host>(context: *mut Context, port: u32, out: *mut Sample) -> i32 {
    if out.is_null() {
        return raw::BAD_ARGUMENT;
    }
    // SAFETY: the plugin gives the context of this call and room for a sample.
    unsafe {
        H::request(context, H::NOT_RUN, |host| {
            answer(host.read(port), |sample| out.write(sample))
        })
    }
}

unsafe extern "C" fn loan<H: Host>(context: *mut Context, port: u32, out: *mut *mut c_void) -> i32 {
    if out.is_null() {
        return raw::BAD_ARGUMENT;
    }
    // SAFETY: the plugin gives the context of this call and room for a pointer.
    unsafe {
        H::request(context, H::NOT_RUN, |host| {
            answer(host.loan(port), |buffer| out.write(buffer.cast()))
        })
    }
}

unsafe extern "C" fn publish<H: Host>(context: *mut Context, port: u32, time_ns: u64) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { H::request(context, H::NOT_RUN, |host| host.publish(port, time_ns)) }
}

unsafe extern "C" fn retract<H: Host>(context: *mut Context, port: u32) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { H::request(context, H::NOT_RUN, |host| host.retract(port)) }
}

unsafe extern "C" fn wake<H: Host>(context: *mut Context, child: u32) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { H::request(context, H::NOT_RUN, |host| host.wake(child)) }
}

unsafe extern "C" fn sleep<H: Host>(context: *mut Context, child: u32) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { H::request(context, H::NOT_RUN, |host| host.sleep(child)) }
}

unsafe extern "C" fn child<H: Host>(context: *mut Context, child: u32, out: *mut ChildStatus) -> i32 {
    if out.is_null() {
        return raw::BAD_ARGUMENT;
    }
    // SAFETY: the plugin gives the context of this call and room for a status, which states its size.
    unsafe {
        H::request(context, H::NOT_RUN, |host| {
            answer(host.child(child), |(state, faulted)| {
                let status = ChildStatus {
                    size: size_of::<ChildStatus>() as u32,
                    state,
                    faulted: u32::from(faulted),
                    reserved: 0,
                };
                table::write(out, &status);
            })
        })
    }
}

unsafe extern "C" fn set_policy<H: Host>(
    context: *mut Context,
    child: u32,
    policy: u32,
    dwell_ns: u64,
    hysteresis: f64,
) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe {
        H::request(context, H::NOT_RUN, |host| {
            host.set_policy(child, policy, dwell_ns, hysteresis)
        })
    }
}

unsafe extern "C" fn now<H: Host>(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { H::request(context, 0, H::now) }
}

unsafe extern "C" fn real_time<H: Host>(context: *mut Context) -> u32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { H::request(context, 0, |host| u32::from(host.real_time())) }
}

unsafe extern "C" fn seed<H: Host>(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { H::request(context, 0, H::seed) }
}

unsafe extern "C" fn application<H: Host>(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { H::request(context, 0, H::application) }
}

unsafe extern "C" fn name<H: Host>(context: *mut Context) -> *const c_char {
    // SAFETY: the plugin gives the context of this call.
    unsafe { H::request(context, c"".as_ptr(), |host| host.name().as_ptr()) }
}

unsafe extern "C" fn log<H: Host>(context: *mut Context, level: u32, text: *const c_char, length: u64) {
    // SAFETY: the plugin gives the context of this call and a text of that length.
    unsafe { H::request(context, (), |host| host.log(level, &text_of(text, length))) };
}

unsafe extern "C" fn fail<H: Host>(context: *mut Context, text: *const c_char, length: u64) {
    // SAFETY: the plugin gives the context of this call and a text of that length.
    unsafe { H::request(context, (), |host| host.fail(text_of(text, length))) };
}

unsafe extern "C" fn extension<H: Host>(context: *mut Context, id: *const c_char) -> *const c_void {
    // SAFETY: the plugin gives the context of this call and a text that ends with a NUL.
    unsafe { H::request(context, ptr::null(), |host| host.extension(CStr::from_ptr(id))) }
}
