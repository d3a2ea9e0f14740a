//! The host that a plugin sees during a check. It takes down each promise that a request breaks.

#![allow(unsafe_code)]

use std::ffi::{CStr, CString};
use std::mem::offset_of;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::ThreadId;

use jde_abi::describe::{Role, Schema};
use jde_abi::finite::Finite;
use jde_abi::host::{self, Host};
use jde_abi::raw::{self, Context};
use jde_loader::AlignedBytes;
use jde_loader::instance::PluginContext;

use crate::malformed::malformed;
use crate::measurement::value_of;

/// The time that passes between two calls, ns.
const CALL_INTERVAL: u64 = 50_000_000;

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
            now: CALL_INTERVAL,
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
    pub(crate) fn table(&self) -> &'static raw::Host {
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
        self.now += CALL_INTERVAL;
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

    fn output(&mut self, number: u32, verb: &str) -> Result<usize, i32> {
        let Some(port) = self.schema.ports.get(number as usize) else {
            self.breach("ports", format!("it {verb} port {number}, and has no such port"));
            return Err(raw::BAD_ARGUMENT);
        };
        match port.role {
            Role::Import | Role::Modulation { .. } | Role::Command { .. } => {
                self.breach(
                    "ports",
                    format!("it {verb} `{}`, which it can only read", port.name),
                );
                Err(raw::BAD_ARGUMENT)
            }
            Role::Export { .. } => Ok(number as usize),
            Role::Actuator | Role::ChildModulation { .. } if self.is_unbound(port.has(raw::OPTIONAL)) => {
                Err(raw::UNBOUND)
            }
            Role::Actuator | Role::ChildModulation { .. } => Ok(number as usize),
        }
    }

    fn publish_loan(&mut self, number: u32, time: u64) -> Result<(), i32> {
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

    fn retract_export(&mut self, number: u32) -> Result<(), i32> {
        let place = self.output(number, "retracts")?;
        let port = &self.schema.ports[place];
        if !matches!(port.role, Role::Export { .. }) {
            self.breach(
                "ports",
                format!("it retracts `{}`, which is not an export", port.name),
            );
            return Err(raw::BAD_ARGUMENT);
        }
        self.change(&format!("retracts `{}`", port.name), true);
        self.publications.push((number, 0, Vec::new()));
        Ok(())
    }

    /// Returns the place of a child, for a request that needs authority if it is a `change`.
    fn role(&mut self, number: u32, change: Option<&str>) -> Result<usize, i32> {
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

/// Refuses requests outside of a call and from another thread.
impl Host for Bench<'_> {
    const NOT_RUN: i32 = raw::REFUSED;

    unsafe fn request<R>(context: *mut Context, not_run: R, run: impl FnOnce(&mut Self) -> R) -> R {
        let bench = context.cast::<Self>();
        if bench.is_null() {
            return not_run;
        }
        // SAFETY: the bench that [`Bench::call`] lent still exists; these fields do not change while a call runs.
        let is_allowed = unsafe { (*bench).owner == std::thread::current().id() && (*bench).call.is_some() };
        if !is_allowed {
            // SAFETY: as above, and the field is atomic.
            unsafe { (*bench).is_misused.store(true, Ordering::Release) };
            return not_run;
        }
        // SAFETY: in the call, on its thread, nothing else uses the bench.
        run(unsafe { &mut *bench })
    }

    fn read(&mut self, number: u32) -> Result<raw::Sample, i32> {
        let Some(port) = self.schema.ports.get(number as usize) else {
            self.breach("ports", format!("it reads port {number}, and has no such port"));
            return Err(raw::BAD_ARGUMENT);
        };
        let is_import = match port.role {
            Role::Import => true,
            Role::Modulation { .. } | Role::Command { .. } => false,
            Role::Export { .. } | Role::Actuator | Role::ChildModulation { .. } => {
                self.breach(
                    "ports",
                    format!("it reads `{}`, which it can only write", port.name),
                );
                return Err(raw::BAD_ARGUMENT);
            }
        };
        if self.is_unbound(port.has(raw::OPTIONAL)) && is_import {
            return Err(raw::UNBOUND);
        }
        if is_import && !self.circumstances.has_values {
            return Err(raw::NO_VALUE);
        }
        let bytes = self.values[number as usize].bytes();
        Ok(raw::Sample {
            data: bytes.as_ptr().cast(),
            bytes: bytes.len() as u64,
            time_ns: self.now - CALL_INTERVAL,
            sequence: u64::from(is_import),
            writer: u32::MAX,
            flags: match port.role {
                Role::Modulation { .. } => raw::SAMPLE_DEFAULT,
                Role::Command { .. } => raw::SAMPLE_NEUTRAL,
                _ => 0,
            },
        })
    }

    fn loan(&mut self, number: u32) -> Result<*mut u8, i32> {
        let port = self.output(number, "loans memory for")?;
        if !std::mem::replace(&mut self.is_loaned[port], true) {
            self.values[port].bytes_mut().fill(0);
        }
        Ok(self.values[port].bytes_mut().as_mut_ptr())
    }

    fn publish(&mut self, port: u32, time: u64) -> i32 {
        status(self.publish_loan(port, time))
    }

    fn retract(&mut self, port: u32) -> i32 {
        status(self.retract_export(port))
    }

    fn wake(&mut self, child: u32) -> i32 {
        let role = self.role(child, Some("wakes"));
        status(role.map(|role| self.is_awake[role] = true))
    }

    fn sleep(&mut self, child: u32) -> i32 {
        let role = self.role(child, Some("puts to sleep"));
        status(role.map(|role| self.is_awake[role] = false))
    }

    fn child(&mut self, child: u32) -> Result<(u32, bool), i32> {
        let role = self.role(child, None)?;
        Ok((
            if self.is_awake[role] {
                raw::READY
            } else {
                raw::SLEPT
            },
            false,
        ))
    }

    fn set_policy(&mut self, child: u32, _: u32, _: u64, _: f64) -> i32 {
        status(self.role(child, Some("changes the policy of")).map(drop))
    }

    fn now(&mut self) -> u64 {
        self.now
    }

    /// Time is never real, so no driver opens a device.
    fn real_time(&mut self) -> bool {
        false
    }

    fn seed(&mut self) -> u64 {
        7
    }

    fn application(&mut self) -> u64 {
        self.application
    }

    fn name(&mut self) -> &CStr {
        &self.name
    }

    fn log(&mut self, _: u32, _: &str) {}

    fn fail(&mut self, reason: String) {
        self.failure = Some(reason);
    }
}

fn status(result: Result<(), i32>) -> i32 {
    result.err().unwrap_or(raw::OK)
}

static HOST: raw::Host = CURRENT;

/// A host of minor version 0, which ends before `retract`.
static OLD_HOST: raw::Host = raw::Host {
    size: offset_of!(raw::Host, retract) as u32,
    abi_minor: 0,
    retract: None,
    real_time: None,
    ..CURRENT
};

const CURRENT: raw::Host = host::table::<Bench<'_>>();
