//! The host's side of the ABI: the functions a plugin calls back, each within a call of its instance.
//!
//! No panic leaves through them: it would end the process. One that arises is the host's own, and ends the application.
//!
//! A call that was given up is refused whatever shows it something or changes anything. Its name, its seed and the time it is
//! still told: it may wait for the last, and plugins do not expect the others to be missing.

use std::ffi::{CStr, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use jde_abi::raw::{self, Context, Host};
use jde_core::{Nanos, Policy};

use super::desk::Desk;
use super::ports::{PortError, Ports, View};
use super::{Scratch, state_number};
use crate::build::{Build, Way};
use crate::engine::Engine;

/// What a [`Context`] really is.
pub(super) struct Call<'a> {
    pub(super) engine: &'a Arc<Engine>,
    pub(super) number: usize,
    pub(super) name: &'a CStr,
    pub(super) build: &'a Build,
    pub(super) desk: &'a Desk,
    pub(super) scratch: &'a mut Scratch,
    pub(super) failure: Option<String>,
    /// What it was told when it first asked for the time.
    pub(super) told: Option<Nanos>,
    pub(super) leave: Leave,
}

/// What a call may change.
pub(super) enum Leave {
    /// Whatever its authority allows.
    All,
    /// Its exports: it is put to sleep or woken up without losing its place.
    Exports,
    /// Nothing; and the first thing that it tried.
    Nothing(Option<String>),
}

impl Call<'_> {
    /// Whether this call may not act on others.
    fn refuses(&mut self, what: impl FnOnce(&Self) -> String) -> bool {
        match self.leave {
            Leave::All => false,
            Leave::Exports => true,
            Leave::Nothing(_) => self.refuses_all(what),
        }
    }

    /// Whether this call may not even write its exports.
    fn refuses_all(&mut self, what: impl FnOnce(&Self) -> String) -> bool {
        if let Leave::Nothing(None) = self.leave {
            let what = what(self);
            self.leave = Leave::Nothing(Some(what));
        }
        matches!(self.leave, Leave::Nothing(_))
    }

    /// Whether it may not write that port of the application.
    fn refuses_port(&mut self, port: usize) -> bool {
        let what = |call: &Self| format!("write `{}`", call.port_name(port));
        match self.desk.ports(|ports| ports.is_wish(port)) {
            None => true,
            Some(true) => self.refuses(what),
            Some(false) => self.refuses_all(what),
        }
    }

    fn port_name(&self, port: usize) -> &str {
        let ports = &self.engine.application.instances[self.number].schema.ports;
        ports.get(port).map_or("a port", |port| &port.name)
    }

    /// The role of the application that the build means.
    fn role(&self, role: u32) -> Result<usize, i32> {
        self.build
            .role(role)
            .ok_or(raw::BAD_ARGUMENT)?
            .ok_or(raw::UNBOUND)
    }

    /// What comes of writing what nobody can see.
    fn unheard(&self) -> i32 {
        self.desk.ports(|_| raw::OK).unwrap_or(raw::REFUSED)
    }

    /// Asks the rules for something about a child; refused if the call was given up. It cannot be until that is done.
    fn ask(&self, child: u32, body: impl FnOnce(usize) -> i32) -> i32 {
        let asked = self.desk.ports(|_| match self.role(child) {
            Ok(role) => body(role),
            Err(status) => status,
        });
        asked.unwrap_or(raw::REFUSED)
    }
}

/// What a port shows.
fn view<'a>(build: &'a Build, ports: &'a mut Ports, port: u32, now: Nanos) -> Result<View<'a>, PortError> {
    match build.way(port) {
        Some(Way::Bound(port)) => ports.read(*port, now),
        Some(Way::Unbound) => Err(PortError::Unbound),
        Some(Way::Fixed { value, neutral }) => Ok(View {
            bytes: value.bytes(),
            time: if *neutral { now } else { 0 },
            sequence: 0,
            writer: u32::MAX,
            neutral: *neutral,
        }),
        Some(Way::Unheard(_)) | None => Err(PortError::WrongPort),
    }
}

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
    retract,
    real_time,
};

/// Runs `body` with the call behind `context`.
///
/// # Safety
/// `context` is the one given to the present call of an instance, on this thread.
unsafe fn within<R>(context: *mut Context, broken: R, body: impl FnOnce(&mut Call<'_>) -> R) -> R {
    // SAFETY: by the contract of `Host`, the context is the one `Instance::call` made, and nothing else uses it meanwhile.
    let call = unsafe { &mut *context.cast::<Call<'_>>() };
    catch_unwind(AssertUnwindSafe(|| body(call))).unwrap_or_else(|_| {
        call.engine.panicked();
        broken
    })
}

fn status(error: &PortError) -> i32 {
    match error {
        PortError::Unbound => raw::UNBOUND,
        PortError::NoValue => raw::NO_VALUE,
        PortError::WrongPort | PortError::NothingLoaned => raw::BAD_ARGUMENT,
        PortError::Refused {
            why: jde_board::Refused::NotFinite,
            ..
        } => raw::NOT_FINITE,
        PortError::Refused { .. } => raw::REFUSED,
    }
}

unsafe extern "C" fn read(context: *mut Context, port: u32, out: *mut raw::Sample) -> i32 {
    // SAFETY: the plugin gives the context of this call and room for a sample.
    unsafe {
        within(context, raw::FAILED, |call| {
            let now = call.engine.clock.now();
            let shown = call.desk.ports(|ports| match view(call.build, ports, port, now) {
                Err(error) => status(&error),
                Ok(view) => {
                    let fresh = if view.sequence == 0 {
                        raw::SAMPLE_DEFAULT
                    } else {
                        0
                    };
                    out.write(raw::Sample {
                        data: view.bytes.as_ptr().cast::<c_void>(),
                        bytes: view.bytes.len() as u64,
                        time_ns: view.time,
                        sequence: view.sequence,
                        writer: view.writer,
                        flags: if view.neutral { raw::SAMPLE_NEUTRAL } else { fresh },
                    });
                    raw::OK
                }
            });
            shown.unwrap_or(raw::REFUSED)
        })
    }
}

unsafe extern "C" fn loan(context: *mut Context, port: u32, out: *mut *mut c_void) -> i32 {
    // SAFETY: the plugin gives the context of this call and room for a pointer.
    unsafe {
        within(context, raw::FAILED, |call| {
            if let Some(Way::Bound(port)) = call.build.way(port) {
                // Who may not command is told so when it publishes, as ever.
                if call.refuses_all(|call| format!("write `{}`", call.port_name(*port))) {
                    return raw::REFUSED;
                }
            }
            let lent = call.desk.ports(|ports| {
                let room = match call.build.way(port) {
                    Some(Way::Bound(port)) => ports.loan(*port),
                    Some(Way::Unbound) => Err(PortError::Unbound),
                    Some(Way::Unheard(bytes)) => Ok(call.scratch.room(port, *bytes)),
                    Some(Way::Fixed { .. }) | None => Err(PortError::WrongPort),
                };
                match room {
                    Err(error) => status(&error),
                    Ok(bytes) => {
                        out.write(bytes.as_mut_ptr().cast::<c_void>());
                        raw::OK
                    }
                }
            });
            lent.unwrap_or(raw::REFUSED)
        })
    }
}

unsafe extern "C" fn publish(context: *mut Context, port: u32, time_ns: u64) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe {
        within(context, raw::FAILED, |call| {
            let port = match call.build.way(port) {
                Some(Way::Bound(port)) => *port,
                Some(Way::Unbound) => return raw::UNBOUND,
                Some(Way::Unheard(_)) if call.scratch.has(port) => return call.unheard(),
                Some(Way::Unheard(_) | Way::Fixed { .. }) | None => return raw::BAD_ARGUMENT,
            };
            if call.refuses_port(port) {
                return raw::REFUSED;
            }
            let now = call.engine.clock.now();
            let time = if time_ns == 0 { now } else { time_ns };
            let period = call.engine.meters[call.number].period.load(Ordering::Relaxed);
            match call.desk.ports(|ports| ports.publish(port, time, now, period)) {
                None => raw::REFUSED,
                Some(Ok(())) => raw::OK,
                Some(Err(error)) => {
                    if let PortError::Refused { why, first } = &error {
                        call.engine.write_refused(call.number, port, why, *first);
                    }
                    status(&error)
                }
            }
        })
    }
}

unsafe extern "C" fn wake(context: *mut Context, child: u32) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe {
        within(context, raw::FAILED, |call| {
            if call.refuses(|_| String::from("wake a child")) {
                return raw::REFUSED;
            }
            call.ask(child, |role| call.engine.child_wakes(call.number, role, true))
        })
    }
}

unsafe extern "C" fn sleep(context: *mut Context, child: u32) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe {
        within(context, raw::FAILED, |call| {
            if call.refuses(|_| String::from("put a child to sleep")) {
                return raw::REFUSED;
            }
            call.ask(child, |role| call.engine.child_wakes(call.number, role, false))
        })
    }
}

unsafe extern "C" fn child(context: *mut Context, child: u32, out: *mut raw::ChildStatus) -> i32 {
    // SAFETY: the plugin gives the context of this call and room for a status.
    unsafe {
        within(context, raw::FAILED, |call| {
            call.ask(child, |role| match call.engine.child(call.number, role) {
                Err(status) => status,
                Ok((state, faulted)) => {
                    out.write(raw::ChildStatus {
                        size: size_of::<raw::ChildStatus>() as u32,
                        state: state_number(state),
                        faulted: u32::from(faulted),
                        reserved: 0,
                    });
                    raw::OK
                }
            })
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
    let policy = match policy {
        raw::POLICY_PRIORITY => Policy::Priority,
        raw::POLICY_URGENCY => Policy::HighestUrgency,
        raw::POLICY_STICKY if hysteresis.is_finite() && hysteresis >= 0.0 => Policy::Sticky {
            dwell: dwell_ns,
            hysteresis,
        },
        raw::POLICY_ROUND_ROBIN if dwell_ns > 0 => Policy::RoundRobin { turn: dwell_ns },
        raw::POLICY_FATHER => Policy::Father,
        _ => return raw::BAD_ARGUMENT,
    };
    // SAFETY: the plugin gives the context of this call.
    unsafe {
        within(context, raw::FAILED, |call| {
            if call.refuses(|_| String::from("change a policy")) {
                return raw::REFUSED;
            }
            call.ask(child, |role| call.engine.set_policy(call.number, role, policy))
        })
    }
}

unsafe extern "C" fn now(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives the context of this call.
    unsafe {
        within(context, 0, |call| {
            let now = call.engine.clock.now();
            call.told.get_or_insert(now);
            now
        })
    }
}

unsafe extern "C" fn seed(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { within(context, 0, |call| call.engine.seed_of(call.number)) }
}

unsafe extern "C" fn application(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { within(context, 0, |call| call.engine.id) }
}

unsafe extern "C" fn name(context: *mut Context) -> *const c_char {
    // SAFETY: the plugin gives the context of this call.
    unsafe { within(context, null(), |call| call.name.as_ptr()) }
}

unsafe extern "C" fn log(context: *mut Context, level: u32, text: *const c_char, length: u64) {
    // SAFETY: the plugin gives the context of this call and a text of that length.
    unsafe {
        within(context, (), |call| {
            // Whoever was given up speaks for nobody.
            if !call.desk.is_closed() {
                let text = text_of(text, length);
                call.engine.log(call.number, level, &text);
            }
        });
    }
}

unsafe extern "C" fn fail(context: *mut Context, text: *const c_char, length: u64) {
    // SAFETY: the plugin gives the context of this call and a text of that length.
    unsafe { within(context, (), |call| call.failure = Some(text_of(text, length))) }
}

unsafe extern "C" fn extension(_: *mut Context, _: *const c_char) -> *const c_void {
    null()
}

unsafe extern "C" fn retract(context: *mut Context, port: u32) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe {
        within(context, raw::FAILED, |call| {
            let port = match call.build.way(port) {
                Some(Way::Bound(port)) => *port,
                Some(Way::Unheard(_)) => return call.unheard(),
                Some(Way::Unbound | Way::Fixed { .. }) | None => return raw::BAD_ARGUMENT,
            };
            if call.refuses_all(|call| format!("take `{}` back", call.port_name(port))) {
                return raw::REFUSED;
            }
            match call.desk.ports(|ports| ports.retract(port)) {
                None => raw::REFUSED,
                Some(Ok(())) => raw::OK,
                Some(Err(error)) => status(&error),
            }
        })
    }
}

unsafe extern "C" fn real_time(context: *mut Context) -> u32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { within(context, 0, |call| u32::from(call.engine.clock.is_everybodys())) }
}

/// Longest text believed of a plugin.
const LONGEST: u64 = 64 << 10;

unsafe fn text_of(text: *const c_char, length: u64) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: the caller vouches for the length.
    let bytes = unsafe { std::slice::from_raw_parts(text.cast::<u8>(), length.min(LONGEST) as usize) };
    String::from_utf8_lossy(bytes).into_owned()
}
