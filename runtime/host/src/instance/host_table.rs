//! What a plugin may request of the host, each within a call of its instance.
//!
//! No panic unwinds out of a request, because it would end the process. A panic in one is the host's own, and ends the
//! application.

#![allow(unsafe_code)]

use std::convert::identity;
use std::ffi::{CStr, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null;
use std::sync::atomic::Ordering;

use jde_abi::host::{self, Host};
use jde_abi::raw::{self, Context, Sample};
use jde_core::{Nanos, Policy};
use jde_loader::build::PortMapping;

use super::call::{CallContext, status};
use super::state_number;
use super::turns::TURNS;

/// The table given to every instance.
pub(super) static HOST: raw::Host = host::table::<CallContext<'_>>();

/// Ports and roles have the numbers of the build.
impl Host for CallContext<'_> {
    unsafe fn request<R>(context: *mut Context, not_run: R, run: impl FnOnce(&mut Self) -> R) -> R {
        // SAFETY: by the contract of `Host`, the context is the one that `Instance::call_optional` made, and
        // nothing else uses it during the call.
        let call = unsafe { &mut *context.cast::<Self>() };
        catch_unwind(AssertUnwindSafe(|| run(call))).unwrap_or_else(|_| {
            call.engine.report_panic();
            not_run
        })
    }

    fn read(&mut self, port: u32) -> Result<Sample, i32> {
        self.show(port, |view| view.sample())
    }

    fn loan(&mut self, port: u32) -> Result<*mut u8, i32> {
        self.lend(port, <[u8]>::as_mut_ptr)
    }

    fn publish(&mut self, port: u32, time: Nanos) -> i32 {
        let port = match self.build.mapping(port) {
            Some(PortMapping::Bound(port)) => *port,
            Some(PortMapping::Unbound) => return raw::UNBOUND,
            Some(PortMapping::Discarded(_)) if self.scratch.is_loaned(port) => {
                return self.discarded_status();
            }
            Some(PortMapping::Discarded(_) | PortMapping::Fixed { .. }) | None => return raw::BAD_ARGUMENT,
        };
        if self.refuses_port(port) {
            return raw::REFUSED;
        }
        let now = self.engine.clock.now();
        let time = if time == 0 { now } else { time };
        let period = self.engine.metrics[self.number].period.load(Ordering::Relaxed);
        let least = self.engine.application.instances[self.number].command_validity_ns(period);
        let unusual = self.port_access.with_ports(|ports| {
            let published = ports.publish(port, time, now, least);
            let is_usual = published.is_ok() && !ports.is_limited;
            (!is_usual).then(|| (published, ports.take_exceeded(port)))
        });
        match unusual {
            Some(None) => raw::OK,
            None => raw::REFUSED,
            Some(Some((published, exceeded))) => {
                self.finish_publication(port, published, exceeded, [time, now, least])
            }
        }
    }

    fn retract(&mut self, port: u32) -> i32 {
        let port = match self.build.mapping(port) {
            Some(PortMapping::Bound(port)) => *port,
            Some(PortMapping::Discarded(_)) => return self.discarded_status(),
            Some(PortMapping::Unbound | PortMapping::Fixed { .. }) | None => return raw::BAD_ARGUMENT,
        };
        if self.refuses_all(|call| format!("take `{}` back", call.port_name(port))) {
            return raw::REFUSED;
        }
        match self.port_access.with_ports(|ports| ports.retract(port)) {
            None => raw::REFUSED,
            Some(Ok(())) => raw::OK,
            Some(Err(error)) => status(&error),
        }
    }

    fn wake(&mut self, child: u32) -> i32 {
        if self.refuses(|_| String::from("wake a child")) {
            return raw::REFUSED;
        }
        let asked = self.with_child(child, |role| self.engine.request_child(self.number, role, true));
        asked.unwrap_or_else(identity)
    }

    fn sleep(&mut self, child: u32) -> i32 {
        if self.refuses(|_| String::from("put a child to sleep")) {
            return raw::REFUSED;
        }
        let asked = self.with_child(child, |role| self.engine.request_child(self.number, role, false));
        asked.unwrap_or_else(identity)
    }

    fn child(&mut self, child: u32) -> Result<(u32, bool), i32> {
        let (state, is_faulted) =
            self.with_child(child, |role| self.engine.child_status(self.number, role))??;
        Ok((state_number(state), is_faulted))
    }

    fn set_policy(&mut self, child: u32, policy: u32, dwell: Nanos, hysteresis: f64) -> i32 {
        let Some(policy) = Policy::from_code(policy, dwell, hysteresis) else {
            return raw::BAD_ARGUMENT;
        };
        if self.refuses(|_| String::from("change a policy")) {
            return raw::REFUSED;
        }
        let asked = self.with_child(child, |role| self.engine.set_policy(self.number, role, policy));
        asked.unwrap_or_else(identity)
    }

    fn now(&mut self) -> Nanos {
        let now = self.engine.clock.now();
        self.first_time.get_or_insert(now);
        now
    }

    fn real_time(&mut self) -> bool {
        self.engine.clock.has_wall_clock_speed()
    }

    fn seed(&mut self) -> u64 {
        self.engine.seed_of(self.number)
    }

    fn application(&mut self) -> u64 {
        self.engine.id
    }

    fn name(&mut self) -> &CStr {
        self.name
    }

    fn log(&mut self, level: u32, text: &str) {
        // Messages of a call that was given up are discarded.
        if !self.port_access.is_closed() {
            self.engine.log(self.number, level, text);
        }
    }

    fn fail(&mut self, reason: String) {
        self.failure = Some(reason);
    }

    fn extension(&mut self, id: &CStr) -> *const c_void {
        let is_turns = id.to_bytes() == raw::EXTENSION_TURNS.as_bytes();
        match is_turns && self.real_time() {
            true => (&raw const TURNS).cast(),
            false => null(),
        }
    }
}
