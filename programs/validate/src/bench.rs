//! The host that a plugin sees during a check. It takes down each promise that a request breaks.

#![allow(unsafe_code)]

use std::ffi::{CString, c_char, c_void};
use std::mem::offset_of;
use std::ptr::null;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::ThreadId;

use jde_abi::describe::{Role, Schema};
use jde_abi::raw::{self, Context, Host};
use jde_abi::table::{self, text_of};
use jde_board::finite::Finite;
use jde_loader::AlignedBytes;
use jde_loader::instance::PluginContext;

use crate::malformed::malformed;
use crate::measurement::value_of;

/// The time that passes between two calls, ns.
const STEP: u64 = 50_000_000;

/// The circumstances of a life.
#[derive(Clone, Copy)]
pub(crate) struct Circumstances {
    /// Imports have values.
    pub(crate) has_values: bool,
    /// Optional ports and children are bound.
    pub(crate) is_bound: bool,
    /// Commands, wakes and the like are accepted.
    pub(crate) has_authority: bool,
    /// The host is of the oldest minor version.
    pub(crate) is_old: bool,
}

/// One instance's host; a [`Context`] points to it.
pub(crate) struct Bench<'s> {
    schema: &'s Schema,
    circumstances: Circumstances,
    owner: ThreadId,
    name: CString,
    application: u64,
    now: u64,
    call: Option<&'static str>,
    /// A request came outside of a call, or from another thread.
    is_misused: AtomicBool,
    /// A value for each port.
    values: Vec<AlignedBytes>,
    is_loaned: Vec<bool>,
    is_awake: Vec<bool>,
    /// The reason that the plugin stated in this call.
    pub(crate) failure: Option<String>,
    /// The names of checks, and how a request broke their promise.
    pub(crate) breaches: Vec<(&'static str, String)>,
    /// Every publication, with its port and time.
    pub(crate) publications: Vec<(u32, u64, Vec<u8>)>,
}

impl<'s> Bench<'s> {
    pub(crate) fn new(schema: &'s Schema, circumstances: Circumstances, application: u64) -> Self {
        let value = |port: &jde_abi::describe::Port| match &port.role {
            Role::Modulation { default, .. } => AlignedBytes::new(default),
            Role::Command { neutral, .. } => AlignedBytes::new(neutral),
            _ => value_of(&port.value_type),
        };
        Self {
            schema,
            circumstances,
            owner: std::thread::current().id(),
            name: CString::from(c"validated"),
            application,
            now: STEP,
            call: None,
            is_misused: AtomicBool::new(false),
            values: schema.ports.iter().map(value).collect(),
            is_loaned: vec![false; schema.ports.len()],
            is_awake: vec![false; schema.children.len()],
            failure: None,
            breaches: Vec::new(),
            publications: Vec::new(),
        }
    }

    /// The table for the instance.
    pub(crate) fn table(&self) -> &'static Host {
        if self.circumstances.is_old {
            &OLD_HOST
        } else {
            &HOST
        }
    }

    /// Runs a call. Returns what it returns, and the reason that it stated.
    pub(crate) fn call<R>(
        &mut self,
        name: &'static str,
        call: impl FnOnce(PluginContext<'_>) -> R,
    ) -> (R, Option<String>) {
        self.call = Some(name);
        self.failure = None;
        // SAFETY: the functions of `HOST` and `OLD_HOST` expect a `Bench` behind their context.
        let result = call(unsafe { PluginContext::new(self) });
        self.call = None;
        self.now += STEP;
        self.is_loaned.fill(false);
        if self.is_misused.load(Ordering::Acquire) {
            self.breach(
                "calls",
                "it asked something of its host outside of a call, or in another thread",
            );
        }
        (result, self.failure.take())
    }

    pub(crate) fn now(&self) -> u64 {
        self.now
    }

    /// Whether an iteration may begin: an operator may force one without a true precondition, but only values make that
    /// worth while.
    pub(crate) fn may_iterate(&self, is_ready: bool) -> bool {
        is_ready || self.circumstances.has_values
    }

    /// Whether a request came outside of a call, or from another thread.
    pub(crate) fn is_misused(&self) -> bool {
        self.is_misused.load(Ordering::Acquire)
    }

    fn breach(&mut self, check: &'static str, words: impl Into<String>) {
        self.breaches.push((check, words.into()));
    }

    /// Takes down a change in a call that may change nothing.
    fn change(&mut self, what: &str, is_export: bool) {
        let call = self.call.unwrap_or_default();
        let check = match call {
            "check" if !is_export => "checks",
            "draw" => "drawing",
            "save" | "restore" => "state",
            "inspect" => "inspects",
            _ => return,
        };
        self.breach(check, format!("in `{call}` it {what}"));
    }

    fn is_unbound(&self, optional: bool) -> bool {
        optional && !self.circumstances.is_bound
    }

    fn read(&mut self, number: u32) -> Result<raw::Sample, i32> {
        let Some(port) = self.schema.ports.get(number as usize) else {
            self.breach("ports", format!("it reads port {number}, and has no such port"));
            return Err(raw::BAD_ARGUMENT);
        };
        let is_import = match port.role {
            Role::Import { .. } => true,
            Role::Modulation { .. } | Role::Command { .. } => false,
            Role::Export { .. } | Role::Actuator | Role::ChildModulation { .. } => {
                self.breach(
                    "ports",
                    format!("it reads `{}`, which it can only write", port.name),
                );
                return Err(raw::BAD_ARGUMENT);
            }
        };
        if self.is_unbound(port.optional) && is_import {
            return Err(raw::UNBOUND);
        }
        if is_import && !self.circumstances.has_values {
            return Err(raw::NO_VALUE);
        }
        let bytes = self.values[number as usize].bytes();
        Ok(raw::Sample {
            data: bytes.as_ptr().cast(),
            bytes: bytes.len() as u64,
            time_ns: self.now - STEP,
            sequence: u64::from(is_import),
            writer: u32::MAX,
            flags: match port.role {
                Role::Modulation { .. } => raw::SAMPLE_DEFAULT,
                Role::Command { .. } => raw::SAMPLE_NEUTRAL,
                _ => 0,
            },
        })
    }

    fn output(&mut self, number: u32, verb: &str) -> Result<usize, i32> {
        let Some(port) = self.schema.ports.get(number as usize) else {
            self.breach("ports", format!("it {verb} port {number}, and has no such port"));
            return Err(raw::BAD_ARGUMENT);
        };
        match port.role {
            Role::Import { .. } | Role::Modulation { .. } | Role::Command { .. } => {
                self.breach(
                    "ports",
                    format!("it {verb} `{}`, which it can only read", port.name),
                );
                Err(raw::BAD_ARGUMENT)
            }
            Role::Export { .. } => Ok(number as usize),
            Role::Actuator | Role::ChildModulation { .. } if self.is_unbound(port.optional) => {
                Err(raw::UNBOUND)
            }
            Role::Actuator | Role::ChildModulation { .. } => Ok(number as usize),
        }
    }

    fn loan(&mut self, number: u32) -> Result<*mut u8, i32> {
        let port = self.output(number, "loans memory for")?;
        if !std::mem::replace(&mut self.is_loaned[port], true) {
            self.values[port].bytes_mut().fill(0);
        }
        Ok(self.values[port].bytes_mut().as_mut_ptr())
    }

    fn publish(&mut self, number: u32, time: u64) -> Result<(), i32> {
        let place = self.output(number, "publishes")?;
        let port = &self.schema.ports[place];
        if !std::mem::take(&mut self.is_loaned[place]) {
            self.breach(
                "loans",
                format!("it publishes `{}` and has no memory loaned for it", port.name),
            );
            return Err(raw::BAD_ARGUMENT);
        }
        if time > self.now {
            let ahead = (time - self.now) as f64 / 1e9;
            self.breach(
                "times",
                format!("it publishes `{}` as measured in {ahead} s", port.name),
            );
        }
        let bytes = self.values[place].bytes().to_vec();
        if let Some(wrong) = malformed(&port.value_type, &bytes) {
            self.breach("values", format!("it publishes `{}` with {wrong}", port.name));
        }
        let is_export = matches!(port.role, Role::Export { .. });
        self.change(&format!("publishes `{}`", port.name), is_export);
        if !is_export {
            if let Some(field) = Finite::new(&port.value_type).first_not_finite(&bytes) {
                let field = format!("it writes `{}` with a `{field}` that is not finite", port.name);
                self.breach("values", field);
                return Err(raw::NOT_FINITE);
            }
            if !self.circumstances.has_authority {
                return Err(raw::REFUSED);
            }
        }
        self.publications.push((number, time, bytes));
        Ok(())
    }

    fn retract(&mut self, number: u32) -> Result<(), i32> {
        let place = self.output(number, "retracts")?;
        let port = &self.schema.ports[place];
        if !matches!(port.role, Role::Export { .. }) {
            self.breach(
                "ports",
                format!("it retracts `{}`, which is no export", port.name),
            );
            return Err(raw::BAD_ARGUMENT);
        }
        self.change(&format!("retracts `{}`", port.name), true);
        self.publications.push((number, 0, Vec::new()));
        Ok(())
    }

    /// Returns the place of a child, for a request that needs authority if it is a `change`.
    fn child(&mut self, number: u32, change: Option<&str>) -> Result<usize, i32> {
        let Some(child) = self.schema.children.get(number as usize) else {
            if self.schema.children.last().is_some_and(|child| child.many) {
                // It does not know how many the application names.
                return Err(raw::BAD_ARGUMENT);
            }
            self.breach("ports", format!("it names child {number}, and has no such child"));
            return Err(raw::BAD_ARGUMENT);
        };
        if let Some(change) = change {
            self.change(&format!("{change} `{}`", child.name), false);
        }
        if self.is_unbound(child.optional) {
            Err(raw::UNBOUND)
        } else if change.is_some() && !self.circumstances.has_authority {
            Err(raw::REFUSED)
        } else {
            Ok(number as usize)
        }
    }
}

/// Runs a request in the call behind `context`; refuses it outside of a call and from another thread.
///
/// # Safety
/// `context` is null, or one that [`Bench::call`] lent and whose bench still exists.
unsafe fn request<R>(context: *mut Context, refused: R, body: impl FnOnce(&mut Bench<'_>) -> R) -> R {
    let bench = context.cast::<Bench<'_>>();
    if bench.is_null() {
        return refused;
    }
    // SAFETY: the bench exists; these fields do not change while a call runs.
    let is_allowed = unsafe { (*bench).owner == std::thread::current().id() && (*bench).call.is_some() };
    if !is_allowed {
        // SAFETY: as above, and the field is atomic.
        unsafe { (*bench).is_misused.store(true, Ordering::Release) };
        return refused;
    }
    // SAFETY: in the call, on its thread, nothing else uses the bench.
    body(unsafe { &mut *bench })
}

fn status(result: Result<(), i32>) -> i32 {
    result.err().unwrap_or(raw::OK)
}

unsafe extern "C" fn read(context: *mut Context, port: u32, out: *mut raw::Sample) -> i32 {
    // SAFETY: the plugin gives a context and room for a sample.
    unsafe {
        request(context, raw::REFUSED, |bench| {
            status(bench.read(port).map(|sample| out.write(sample)))
        })
    }
}

unsafe extern "C" fn loan(context: *mut Context, port: u32, out: *mut *mut c_void) -> i32 {
    // SAFETY: the plugin gives a context and room for a pointer.
    unsafe {
        request(context, raw::REFUSED, |bench| {
            status(bench.loan(port).map(|buffer| out.write(buffer.cast())))
        })
    }
}

unsafe extern "C" fn publish(context: *mut Context, port: u32, time: u64) -> i32 {
    // SAFETY: the plugin gives a context.
    unsafe { request(context, raw::REFUSED, |bench| status(bench.publish(port, time))) }
}

unsafe extern "C" fn retract(context: *mut Context, port: u32) -> i32 {
    // SAFETY: the plugin gives a context.
    unsafe { request(context, raw::REFUSED, |bench| status(bench.retract(port))) }
}

unsafe extern "C" fn wake(context: *mut Context, child: u32) -> i32 {
    // SAFETY: the plugin gives a context.
    unsafe {
        request(context, raw::REFUSED, |bench| {
            status(
                bench
                    .child(child, Some("wakes"))
                    .map(|child| bench.is_awake[child] = true),
            )
        })
    }
}

unsafe extern "C" fn sleep(context: *mut Context, child: u32) -> i32 {
    // SAFETY: the plugin gives a context.
    unsafe {
        request(context, raw::REFUSED, |bench| {
            let place = bench.child(child, Some("puts to sleep"));
            status(place.map(|child| bench.is_awake[child] = false))
        })
    }
}

unsafe extern "C" fn child(context: *mut Context, child: u32, out: *mut raw::ChildStatus) -> i32 {
    // SAFETY: the plugin gives a context and room for a status.
    unsafe {
        request(context, raw::REFUSED, |bench| {
            let place = bench.child(child, None);
            status(place.map(|child| {
                let state = if bench.is_awake[child] {
                    raw::READY
                } else {
                    raw::SLEPT
                };
                let status = raw::ChildStatus {
                    size: size_of::<raw::ChildStatus>() as u32,
                    state,
                    faulted: 0,
                    reserved: 0,
                };
                table::write(out, &status);
            }))
        })
    }
}

unsafe extern "C" fn set_policy(context: *mut Context, child: u32, _: u32, _: u64, _: f64) -> i32 {
    // SAFETY: the plugin gives a context.
    unsafe {
        request(context, raw::REFUSED, |bench| {
            status(bench.child(child, Some("changes the policy of")).map(drop))
        })
    }
}

unsafe extern "C" fn now(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives a context.
    unsafe { request(context, 0, |bench| bench.now) }
}

unsafe extern "C" fn seed(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives a context.
    unsafe { request(context, 0, |_| 7) }
}

unsafe extern "C" fn application(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives a context.
    unsafe { request(context, 0, |bench| bench.application) }
}

unsafe extern "C" fn name(context: *mut Context) -> *const c_char {
    // SAFETY: the plugin gives a context; the name lives as long as the bench.
    unsafe { request(context, c"".as_ptr(), |bench| bench.name.as_ptr()) }
}

unsafe extern "C" fn log(context: *mut Context, _: u32, text: *const c_char, length: u64) {
    // SAFETY: the plugin gives a context and a text of that length.
    unsafe { request(context, (), |_| drop(text_of(text, length))) };
}

unsafe extern "C" fn fail(context: *mut Context, text: *const c_char, length: u64) {
    // SAFETY: the plugin gives a context and a text of that length.
    unsafe { request(context, (), |bench| bench.failure = Some(text_of(text, length))) };
}

unsafe extern "C" fn extension(_: *mut Context, _: *const c_char) -> *const c_void {
    null()
}

/// Time is never real, so no driver opens a device.
unsafe extern "C" fn real_time(_: *mut Context) -> u32 {
    0
}

static HOST: Host = CURRENT;

/// A host of minor version 0, which ends before `retract`.
static OLD_HOST: Host = Host {
    size: offset_of!(Host, retract) as u32,
    abi_minor: 0,
    retract: None,
    real_time: None,
    ..CURRENT
};

const CURRENT: Host = Host {
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
