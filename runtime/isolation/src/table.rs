//! The host's table in a child: requests of the plugin go to the host, except those that the state of the
//! current call can serve.
//!
//! A panic in this module is a defect of the host. It aborts the child, and the host reports that.

#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_void};
use std::ptr::null;

use jde_abi::host::{self, Host};
use jde_abi::raw::{self, Context};
use jde_loader::instance::PluginContext;

use super::authority::AuthorityFlag;
use super::memory::IsolatedPort;
use super::messages::{Call, Changes, Done, FromChild, Reply, Returned, ToChild};
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
pub(crate) struct ChildSession {
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
pub(crate) static HOST: raw::Host = host::table::<ChildSession>();

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

impl ChildSession {
    /// Ends the call.
    pub(crate) fn finish_call(&mut self, status: i32, outcome: Returned) -> std::io::Result<()> {
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

impl Host for ChildSession {
    unsafe fn request<R>(context: *mut Context, _: R, run: impl FnOnce(&mut Self) -> R) -> R {
        // SAFETY: by the contract of `Host` the context is that of `ChildSession::context`, and nothing else uses it
        // meanwhile.
        run(unsafe { &mut *context.cast::<Self>() })
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

    fn wake(&mut self, child: u32) -> i32 {
        status(&mut self.wire, &FromChild::Wake { child })
    }

    fn sleep(&mut self, child: u32) -> i32 {
        status(&mut self.wire, &FromChild::PutToSleep { child })
    }

    fn child(&mut self, child: u32) -> Result<(u32, bool), i32> {
        let Reply::Child(child) = request(&mut self.wire, &FromChild::Child { child }) else {
            kill_self();
        };
        child
    }

    fn set_policy(&mut self, child: u32, policy: u32, dwell_ns: u64, hysteresis: f64) -> i32 {
        let message = FromChild::SetPolicy {
            child,
            policy,
            dwell_ns,
            hysteresis,
        };
        status(&mut self.wire, &message)
    }

    fn now(&mut self) -> u64 {
        let now = self.call.now();
        self.call.reported_time.get_or_insert(now);
        now
    }

    fn real_time(&mut self) -> bool {
        self.real_time
    }

    fn seed(&mut self) -> u64 {
        self.seed
    }

    fn application(&mut self) -> u64 {
        self.application
    }

    fn name(&mut self) -> &CStr {
        &self.name
    }

    fn log(&mut self, level: u32, text: &str) {
        self.notify(&FromChild::Log { level, text });
    }

    fn fail(&mut self, reason: String) {
        self.notify(&FromChild::Fail(&reason));
    }

    fn extension(&mut self, id: &CStr) -> *const c_void {
        match id == HOLD {
            true => (&raw const HOLD_TABLE).cast(),
            false => null(),
        }
    }
}

unsafe extern "C" fn hold(context: *mut Context, held: bool) {
    // SAFETY: the plugin gives the context of this call.
    unsafe {
        ChildSession::request(context, (), |session| {
            let _ = status(&mut session.wire, &FromChild::Hold(held));
        })
    };
}
