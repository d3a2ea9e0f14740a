//! The host's table in a child: requests of the plugin go to the host, except those that the state of the
//! current call can serve.
//!
//! A panic in this module is a defect of the host. It aborts the child, and the host reports that.

#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::null;

use jde_abi::raw::{self, Context, Host};
use jde_abi::table::{self, text_of};
use jde_loader::instance::PluginContext;

use super::authority::AuthorityFlag;
use super::memory::IsolatedPort;
use super::messages::{Call, Changes, ChildState, Done, FromChild, Outcome, Reply, ToChild};
use super::timers::machine_time;
use super::wire::Wire;

/// The name of the extension of [`raw::Host`] by which a debugger in a child holds a call: a [`Hold`].
pub const HOLD: &CStr = c"jde.hold";

/// Holds the present call, or lets it go on. Nothing is late while a call is held, and its process has the terminal.
#[repr(C)]
pub struct Hold {
    /// The function. Returns when the terminal is free.
    pub hold: unsafe extern "C" fn(context: *mut Context, held: bool),
}

static HOLD_TABLE: Hold = Hold { hold };

/// The state of a child, to which a [`Context`] points.
pub(crate) struct Session {
    pub(crate) wire: Wire,
    pub(crate) name: CString,
    pub(crate) application: u64,
    pub(crate) seed: u64,
    pub(crate) real_time: bool,
    pub(crate) ports: Vec<IsolatedPort>,
    /// Without it, the host is asked about every command.
    pub(crate) authority: Option<AuthorityFlag>,
    pub(crate) call: CallState,
}

/// The state of the current call.
#[derive(Default)]
pub(crate) struct CallState {
    /// The application's time when the call was sent, and the machine's.
    now: u64,
    machine: u64,
    /// Seconds of the application in a second of the machine; 0 if calls take no time.
    speed: f64,
    /// The release of the ports in which the call runs.
    release: u64,
    changes: Changes,
    /// The ports whose early values were read, a bit each.
    read_early: u128,
    /// The result of the plugin's first query of the time.
    reported_time: Option<u64>,
}

/// The table given to the instance of a child.
pub(crate) static HOST: Host = Host {
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

impl CallState {
    /// Returns the state at the start of a call.
    pub(crate) fn of(call: &Call) -> Self {
        Self {
            now: call.now,
            machine: call.machine,
            speed: call.speed,
            release: call.release,
            changes: call.changes,
            read_early: 0,
            reported_time: None,
        }
    }

    /// Returns the state during an inspection, which may change nothing.
    pub(crate) fn inspection() -> Self {
        Self {
            changes: Changes::Nothing,
            ..Self::default()
        }
    }

    /// Returns the application's time.
    pub(crate) fn now(&self) -> u64 {
        let passed = machine_time().saturating_sub(self.machine);
        self.now + (passed as f64 * self.speed) as u64
    }
}

impl Session {
    /// Ends the call.
    pub(crate) fn finish_call(&mut self, status: i32, outcome: Outcome) -> std::io::Result<()> {
        self.ports.iter_mut().for_each(IsolatedPort::end_call);
        self.wire.send(&FromChild::Done(Done {
            status,
            read_early: self.call.read_early,
            first_time: self.call.reported_time,
            outcome,
        }))
    }

    /// Returns the context for the functions of an instance that was created with [`HOST`].
    pub(crate) fn context(&mut self) -> PluginContext<'_> {
        // SAFETY: the functions of `HOST` expect a session behind their context.
        unsafe { PluginContext::new(self) }
    }

    /// Sends a message that needs no reply.
    pub(crate) fn notify(&mut self, message: &FromChild<'_>) {
        if self.wire.send(message).is_err() {
            kill_self();
        }
    }

    fn read(&mut self, number: u32) -> Result<raw::Sample, i32> {
        let release = self.call.release;
        let port = self.ports.get_mut(number as usize).ok_or(raw::BAD_ARGUMENT)?;
        if let Some((shown, is_first)) = port.show(release) {
            if is_first {
                self.call.read_early |= 1_u128.unbounded_shl(number);
            }
            return shown;
        }
        let Reply::Input(input) = request(&mut self.wire, &FromChild::Read { port: number }) else {
            kill_self();
        };
        port.store(release, input).unwrap_or_else(|| kill_self())
    }

    fn loan(&mut self, number: u32) -> Result<*mut u8, i32> {
        let port = self.ports.get_mut(number as usize).ok_or(raw::BAD_ARGUMENT)?;
        // In a call that may change nothing, the host refuses the loan and records the attempt.
        if self.call.changes != Changes::Nothing
            && let Some(buffer) = port.loan()
        {
            return Ok(buffer);
        }
        let Reply::Loan(place) = request(&mut self.wire, &FromChild::Loan { port: number }) else {
            kill_self();
        };
        Ok(port.loan_from(place?).unwrap_or_else(|| kill_self()))
    }

    fn publish(&mut self, number: u32, time: u64) -> i32 {
        let Some(port) = self.ports.get_mut(number as usize) else {
            return raw::BAD_ARGUMENT;
        };
        let has_authority = || self.authority.as_ref().is_some_and(AuthorityFlag::is_set);
        let unanswered = self.call.changes == Changes::All && port.is_accepted(has_authority);
        let publish = FromChild::Publish {
            port: number,
            time: if time == 0 { self.call.now() } else { time },
            value: port.take_loan(),
            unanswered,
        };
        change(&mut self.wire, &publish, unanswered)
    }

    fn retract(&mut self, number: u32) -> i32 {
        let port = self.ports.get(number as usize);
        let unanswered = self.call.changes == Changes::All && port.is_some_and(IsolatedPort::is_export);
        let retract = FromChild::Retract {
            port: number,
            unanswered,
        };
        change(&mut self.wire, &retract, unanswered)
    }
}

/// Stores what comes with the next call for a port.
pub(crate) fn store_early(
    ports: &mut [IsolatedPort],
    port: u32,
    store: impl FnOnce(&mut IsolatedPort) -> Option<()>,
) {
    let port = ports.get_mut(port as usize);
    port.and_then(store).unwrap_or_else(|| kill_self());
}

/// Sends a request, and returns the host's reply.
fn request<'a>(wire: &'a mut Wire, message: &FromChild<'_>) -> Reply<'a> {
    match wire.send(message).and_then(|()| wire.receive()) {
        Ok(ToChild::Reply(reply)) => reply,
        Ok(ToChild::Early { .. } | ToChild::EarlyLoan { .. } | ToChild::Call(_) | ToChild::Destroy)
        | Err(_) => kill_self(),
    }
}

/// Sends a request, and returns the status that the host replies.
fn status(wire: &mut Wire, message: &FromChild<'_>) -> i32 {
    match request(wire, message) {
        Reply::Status(status) => status,
        Reply::Input(_) | Reply::Loan(_) | Reply::Child(_) => kill_self(),
    }
}

/// Sends a change to the host, and waits for its reply unless the host accepts the change for certain.
fn change(wire: &mut Wire, message: &FromChild<'_>, unanswered: bool) -> i32 {
    if !unanswered {
        return status(wire, message);
    }
    if wire.send(message).is_err() {
        kill_self();
    }
    raw::OK
}

/// Ends the process because the connection to the host broke during a call. It sends itself a signal, because
/// exit handlers would run code of the plugin, which is inside a call.
fn kill_self() -> ! {
    use rustix::process::{Signal, getpid, kill_process};
    let _ = kill_process(getpid(), Signal::KILL);
    std::process::abort()
}

/// Returns the session behind a context.
///
/// # Safety
/// `context` is the one given to the current call of the instance, on this thread.
unsafe fn session<'a>(context: *mut Context) -> &'a mut Session {
    // SAFETY: by the contract of `Host` the context is that of `Session::context`, and nothing else uses it
    // meanwhile.
    unsafe { &mut *context.cast::<Session>() }
}

unsafe extern "C" fn read(context: *mut Context, port: u32, out: *mut raw::Sample) -> i32 {
    // SAFETY: the plugin gives the context of this call and room for a sample.
    unsafe {
        match session(context).read(port) {
            Err(status) => status,
            Ok(sample) => {
                out.write(sample);
                raw::OK
            }
        }
    }
}

unsafe extern "C" fn loan(context: *mut Context, port: u32, out: *mut *mut c_void) -> i32 {
    // SAFETY: the plugin gives the context of this call and room for a pointer.
    unsafe {
        match session(context).loan(port) {
            Err(status) => status,
            Ok(buffer) => {
                out.write(buffer.cast());
                raw::OK
            }
        }
    }
}

unsafe extern "C" fn publish(context: *mut Context, port: u32, time_ns: u64) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { session(context) }.publish(port, time_ns)
}

unsafe extern "C" fn retract(context: *mut Context, port: u32) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { session(context) }.retract(port)
}

unsafe extern "C" fn wake(context: *mut Context, child: u32) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    let wire = unsafe { &mut session(context).wire };
    status(wire, &FromChild::Wake { child })
}

unsafe extern "C" fn sleep(context: *mut Context, child: u32) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    let wire = unsafe { &mut session(context).wire };
    status(wire, &FromChild::PutToSleep { child })
}

unsafe extern "C" fn child(context: *mut Context, child: u32, out: *mut raw::ChildStatus) -> i32 {
    // SAFETY: the plugin gives the context of this call.
    let wire = unsafe { &mut session(context).wire };
    let Reply::Child(child) = request(wire, &FromChild::Child { child }) else {
        kill_self();
    };
    match child {
        Err(status) => status,
        Ok(ChildState { state, faulted }) => {
            let status = raw::ChildStatus {
                size: size_of::<raw::ChildStatus>() as u32,
                state,
                faulted,
                reserved: 0,
            };
            // SAFETY: the plugin gives room for a status.
            unsafe { table::write(out, &status) };
            raw::OK
        }
    }
}

unsafe extern "C" fn set_policy(
    context: *mut Context,
    child: u32,
    policy: u32,
    dwell_ns: u64,
    hysteresis: f64,
) -> i32 {
    let message = FromChild::SetPolicy {
        child,
        policy,
        dwell_ns,
        hysteresis,
    };
    // SAFETY: the plugin gives the context of this call.
    status(unsafe { &mut session(context).wire }, &message)
}

unsafe extern "C" fn now(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives the context of this call.
    let call = unsafe { &mut session(context).call };
    let now = call.now();
    call.reported_time.get_or_insert(now);
    now
}

unsafe extern "C" fn seed(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { session(context) }.seed
}

unsafe extern "C" fn application(context: *mut Context) -> u64 {
    // SAFETY: the plugin gives the context of this call.
    unsafe { session(context) }.application
}

unsafe extern "C" fn name(context: *mut Context) -> *const c_char {
    // SAFETY: the plugin gives the context of this call.
    unsafe { session(context) }.name.as_ptr()
}

unsafe extern "C" fn log(context: *mut Context, level: u32, text: *const c_char, length: u64) {
    // SAFETY: the plugin gives the context of this call and a text of that length.
    let (session, text) = unsafe { (session(context), text_of(text, length)) };
    session.notify(&FromChild::Log { level, text: &text });
}

unsafe extern "C" fn fail(context: *mut Context, text: *const c_char, length: u64) {
    // SAFETY: the plugin gives the context of this call and a text of that length.
    let (session, text) = unsafe { (session(context), text_of(text, length)) };
    session.notify(&FromChild::Fail(&text));
}

unsafe extern "C" fn extension(_: *mut Context, name: *const c_char) -> *const c_void {
    // SAFETY: the plugin gives a text with a null at its end.
    match unsafe { CStr::from_ptr(name) } == HOLD {
        true => (&raw const HOLD_TABLE).cast(),
        false => null(),
    }
}

unsafe extern "C" fn hold(context: *mut Context, held: bool) {
    // SAFETY: the plugin gives the context of this call.
    status(unsafe { &mut session(context).wire }, &FromChild::Hold(held));
}

unsafe extern "C" fn real_time(context: *mut Context) -> u32 {
    // SAFETY: the plugin gives the context of this call.
    u32::from(unsafe { session(context) }.real_time)
}
