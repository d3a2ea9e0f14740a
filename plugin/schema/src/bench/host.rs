//! The bench's host. It keeps the contract of the ABI as the real host does, and never panics.

#![allow(unsafe_code)]

use core::ffi::CStr;
use core::time::Duration;

use jde_abi::describe::Role;
use jde_abi::host::{self, Host};
use jde_abi::raw::{self, Context, Sample};
use jde_core::Policy;

use super::state::BenchState;
use crate::child::State;
use crate::context::Severity;

pub(super) static HOST: raw::Host = host::table::<BenchState>();

impl Host for BenchState {
    unsafe fn request<R>(context: *mut Context, _: R, run: impl FnOnce(&mut Self) -> R) -> R {
        // SAFETY: the bench's own context of the present call, to which no other reference exists.
        run(unsafe { &mut *context.cast() })
    }

    fn read(&mut self, port: u32) -> Result<Sample, i32> {
        let port = self.ports.get(port as usize).ok_or(raw::BAD_ARGUMENT)?;
        let validity = match port.port.role {
            Role::Import | Role::Modulation { .. } => Duration::MAX,
            Role::Command { validity_ns, .. } => Duration::from_nanos(validity_ns),
            Role::Export { .. } | Role::Actuator | Role::ChildModulation { .. } => {
                return Err(raw::BAD_ARGUMENT);
            }
        };
        if !port.bound {
            return Err(raw::UNBOUND);
        }
        let newest = port
            .newest
            .as_ref()
            .filter(|(_, time)| self.now <= time.saturating_add(validity));
        let (bytes, time, flags) = match (newest, &port.initial) {
            (Some((bytes, time)), _) => (bytes, *time, 0),
            (None, Some(initial)) if validity == Duration::MAX => {
                (initial, Duration::ZERO, raw::SAMPLE_DEFAULT)
            }
            (None, Some(initial)) => (initial, Duration::ZERO, raw::SAMPLE_NEUTRAL),
            (None, None) => return Err(raw::NO_VALUE),
        };
        Ok(Sample {
            data: bytes.as_ptr().cast(),
            bytes: bytes.as_slice().len() as u64,
            time_ns: time.as_nanos() as u64,
            sequence: port.sequence,
            writer: 0,
            flags,
        })
    }

    fn loan(&mut self, port: u32) -> Result<*mut u8, i32> {
        self.refuse("write")?;
        let port = self.ports.get_mut(port as usize).ok_or(raw::BAD_ARGUMENT)?;
        match port.port.role {
            Role::Export { .. } | Role::Actuator | Role::ChildModulation { .. } => {}
            Role::Import | Role::Modulation { .. } | Role::Command { .. } => {
                return Err(raw::BAD_ARGUMENT);
            }
        }
        if !port.bound {
            return Err(raw::UNBOUND);
        }
        port.loaned = true;
        Ok(port.loan.as_mut_ptr())
    }

    fn publish(&mut self, port: u32, time_ns: u64) -> i32 {
        let refused = self.refuse("write");
        status(refused.and_then(|()| self.publish_loan(port as usize, time_ns)))
    }

    fn retract(&mut self, port: u32) -> i32 {
        let refused = self.refuse("take a value back");
        status(refused.and_then(|()| self.retract_export(port as usize)))
    }

    fn wake(&mut self, child: u32) -> i32 {
        status(self.child_to_change(child, "wake a child").map(|child| {
            if child.state == State::Slept {
                child.state = if child.motor {
                    State::Checking
                } else {
                    State::Winner
                };
            }
        }))
    }

    fn sleep(&mut self, child: u32) -> i32 {
        status(self.child_to_change(child, "put a child to sleep").map(|child| {
            child.state = State::Slept;
            child.precondition = false.into();
        }))
    }

    fn child(&mut self, child: u32) -> Result<(u32, bool), i32> {
        let child = self.bound_child(child)?;
        Ok((child.state.code(), child.faulted))
    }

    fn set_policy(&mut self, child: u32, policy: u32, dwell_ns: u64, hysteresis: f64) -> i32 {
        let policy = Policy::from_code(policy, dwell_ns, hysteresis);
        status(self.child_to_change(child, "change a policy").and_then(|child| {
            if !child.motor || policy.is_none() {
                return Err(raw::BAD_ARGUMENT);
            }
            child.policy = policy;
            Ok(())
        }))
    }

    fn now(&mut self) -> u64 {
        self.now.as_nanos() as u64
    }

    fn real_time(&mut self) -> bool {
        self.real_time
    }

    fn seed(&mut self) -> u64 {
        1
    }

    fn application(&mut self) -> u64 {
        1
    }

    fn name(&mut self) -> &CStr {
        c"bench"
    }

    fn log(&mut self, level: u32, text: &str) {
        let severity = match level {
            raw::TRACE => Severity::Trace,
            raw::DEBUG => Severity::Debug,
            raw::INFO => Severity::Info,
            raw::WARN => Severity::Warn,
            _ => Severity::Error,
        };
        self.log.push((severity, text.to_owned()));
    }

    fn fail(&mut self, reason: String) {
        self.reason = Some(reason);
    }
}

fn status(result: Result<(), i32>) -> i32 {
    result.err().unwrap_or(raw::OK)
}
