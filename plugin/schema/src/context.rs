//! The context of one call: what a schema can request from the host. None of its methods blocks.

#![allow(unsafe_code)]

use core::ffi::{CStr, c_void};
use core::fmt;
use core::ptr::{self, NonNull};
use core::time::Duration;

use jde_abi::raw;
use jde_types::Value;

use crate::error::Result;
use crate::input::Sample;
use crate::output::Outcome;
use crate::slot::Slot;

/// The context of the present call of an instance. It cannot outlive the call or leave its thread.
pub struct Context<'call> {
    pub(crate) host: &'call raw::Host,
    pub(crate) raw: NonNull<raw::Context>,
    /// The ports of the type whose instance is called.
    pub(crate) ports: *const raw::Port,
}

/// The severity of a log message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// For the developer of this schema; may occur in every iteration.
    Trace,
    /// For the developer of this schema.
    Debug,
    /// For the operator of the application.
    Info,
    /// A problem after which the schema continues.
    Warn,
    /// A failure.
    Error,
}

impl Context<'_> {
    /// Returns the time since the application's start. In lockstep it is constant during a call.
    #[must_use]
    pub fn now(&self) -> Duration {
        // SAFETY: the context is that of the present call.
        Duration::from_nanos(unsafe { (self.host.now)(self.raw.as_ptr()) })
    }

    /// Checks that the application runs in real time. A schema that speaks to a device or to another program calls it in
    /// `awake`.
    ///
    /// # Errors
    /// In lockstep, in a replay, or if the application runs at another speed than real time or may stand still: a device
    /// cannot follow.
    pub fn require_real_time(&self) -> Result<()> {
        let Some(real_time) = self.host.real_time else {
            return Err(self.unbound_message("whether time is real").into());
        };
        // SAFETY: the context is that of the present call.
        if unsafe { real_time(self.raw.as_ptr()) } == 1 {
            return Ok(());
        }
        Err(
            "it speaks to a device, which can be neither hurried nor halted: run without --lockstep, --speed and --break, \
             and in no replay (--record FILE --when CONDITION records what leads to a moment)"
                .into(),
        )
    }

    /// Returns a seed for random generators. It depends only on the application's seed and the instance's
    /// name.
    #[must_use]
    pub fn seed(&self) -> u64 {
        // SAFETY: the context is that of the present call.
        unsafe { (self.host.seed)(self.raw.as_ptr()) }
    }

    /// Returns a number that identifies the running application within this process: all its instances share
    /// it.
    #[must_use]
    pub fn application(&self) -> u64 {
        // SAFETY: the context is that of the present call.
        unsafe { (self.host.application)(self.raw.as_ptr()) }
    }

    /// Returns the instance's name in the application.
    #[must_use]
    pub fn name(&self) -> &str {
        // SAFETY: the context is that of the present call; the name lives as long as the instance.
        unsafe {
            let name = (self.host.name)(self.raw.as_ptr());
            if name.is_null() {
                return "";
            }
            CStr::from_ptr(name).to_str().unwrap_or_default()
        }
    }

    /// Writes a log message. The macros [`info!`](crate::info) and the like are shorter.
    pub fn log(&self, severity: Severity, text: fmt::Arguments<'_>) {
        let text = text.to_string();
        let level = match severity {
            Severity::Trace => raw::TRACE,
            Severity::Debug => raw::DEBUG,
            Severity::Info => raw::INFO,
            Severity::Warn => raw::WARN,
            Severity::Error => raw::ERROR,
        };
        // SAFETY: the context is that of the present call; the text lives until it returns.
        unsafe { (self.host.log)(self.raw.as_ptr(), level, text.as_ptr().cast(), text.len() as u64) }
    }

    /// States the reason for the error that this call is about to return.
    pub(crate) fn fail(&self, text: &str) {
        // SAFETY: the context is that of the present call; the text lives until it returns.
        unsafe { (self.host.fail)(self.raw.as_ptr(), text.as_ptr().cast(), text.len() as u64) }
    }

    /// Returns the value of an input, if it has one. `Err` if the application left the input unbound.
    pub(crate) fn read<T: Value>(&self, slot: &Slot) -> Result<Option<Sample<'_, T>>, Unbound> {
        let Some(sample) = self.sample(slot, size_of::<T>(), align_of::<T>())? else {
            return Ok(None);
        };
        // SAFETY: as many bytes as a `T` has, aligned for it and unchanged until this call returns, which
        // `self` cannot outlive. Every pattern of them is a valid `T`.
        let value = unsafe { &*sample.data.cast::<T>() };
        Ok(Some(Sample::new(value, &sample)))
    }

    /// Returns the value of an input of that many bytes, if it has one. `Err` if the application left the input
    /// unbound.
    pub(crate) fn read_bytes(&self, slot: &Slot, bytes: usize) -> Result<Option<Sample<'_, [u8]>>, Unbound> {
        let Some(sample) = self.sample(slot, bytes, 1)? else {
            return Ok(None);
        };
        // SAFETY: that many bytes, unchanged until this call returns, which `self` cannot outlive.
        let value = unsafe { core::slice::from_raw_parts(sample.data.cast::<u8>(), bytes) };
        Ok(Some(Sample::new(value, &sample)))
    }

    /// Returns the host's sample of an input with values of that size and alignment, if it has one.
    #[inline(always)]
    fn sample(&self, slot: &Slot, bytes: usize, align: usize) -> Result<Option<raw::Sample>, Unbound> {
        let (port, name) = (slot.number(self.ports), slot.name);
        let mut sample = raw::Sample {
            data: ptr::null(),
            bytes: 0,
            time_ns: 0,
            sequence: 0,
            writer: 0,
            flags: 0,
        };
        // SAFETY: the context is that of the present call.
        match unsafe { (self.host.read)(self.raw.as_ptr(), port, &raw mut sample) } {
            raw::OK => {}
            raw::NO_VALUE => return Ok(None),
            raw::UNBOUND => return Err(Unbound),
            code => broken(name, "read", code),
        }
        let data = sample.data;
        assert!(
            sample.bytes == bytes as u64 && !data.is_null() && data.addr().is_multiple_of(align),
            "the host gave `{name}` {} bytes at {data:p}, and its type has {bytes} bytes aligned to {align}",
            sample.bytes,
        );
        Ok(Some(sample))
    }

    /// Returns a buffer for the next value of an output, or `None` if the application left the output
    /// unbound.
    ///
    /// # Safety
    /// The slot's type is `T`.
    pub(crate) unsafe fn loan<T: Value>(&self, slot: &Slot) -> Option<NonNull<T>> {
        let room = self.room(slot)?.cast::<T>();
        assert!(
            room.is_aligned(),
            "the host gave `{}` room at {room:p}, which is not aligned",
            slot.name
        );
        Some(room)
    }

    /// Returns a buffer for the next value of an output whose type has that many bytes, or `None` if the application
    /// left the output unbound.
    pub(crate) fn loan_bytes(&self, slot: &Slot, bytes: usize) -> Option<NonNull<[u8]>> {
        Some(NonNull::slice_from_raw_parts(self.room(slot)?.cast(), bytes))
    }

    #[inline(always)]
    fn room(&self, slot: &Slot) -> Option<NonNull<c_void>> {
        let (port, name) = (slot.number(self.ports), slot.name);
        let mut room = ptr::null_mut();
        // SAFETY: the context is that of the present call.
        match unsafe { (self.host.loan)(self.raw.as_ptr(), port, &raw mut room) } {
            raw::OK => {}
            raw::UNBOUND => return None,
            code => broken(name, "loan", code),
        }
        match NonNull::new(room) {
            Some(room) => Some(room),
            None => panic!("the host gave `{name}` no room"),
        }
    }

    /// Publishes the loaned value as measured at `time`, or now.
    pub(crate) fn publish(&self, slot: &Slot, time: Option<Duration>) -> Outcome {
        let (port, name) = (slot.number_loaned(), slot.name);
        // In the ABI, 0 means now, so a time of 0 becomes 1 ns.
        let time = time.map_or(0, |time| {
            u64::try_from(time.as_nanos()).unwrap_or(u64::MAX).max(1)
        });
        // SAFETY: the context is that of the present call.
        let code = unsafe { (self.host.publish)(self.raw.as_ptr(), port, time) };
        Outcome::of(code).unwrap_or_else(|| broken(name, "publish", code))
    }

    /// Retracts the newest value of an export.
    pub(crate) fn retract(&self, slot: &Slot) {
        let (port, name) = (slot.number(self.ports), slot.name);
        let Some(retract) = self.host.retract else {
            panic!(
                "`{name}` cannot be taken back: {}",
                self.unbound_message("how to take a value back")
            )
        };
        // SAFETY: the context is that of the present call.
        match unsafe { retract(self.raw.as_ptr(), port) } {
            raw::OK => {}
            code => broken(name, "retract", code),
        }
    }

    /// Returns the message for a request that this host is too old to know.
    fn unbound_message(&self, what: &str) -> String {
        let (major, minor) = (self.host.abi_major, self.host.abi_minor);
        format!("this host, of ABI {major}.{minor}, does not know {what}; use a newer one")
    }

    /// Writes a value to an output.
    ///
    /// # Safety
    /// The slot's type is `T`.
    pub(crate) unsafe fn write<T: Value>(&self, slot: &Slot, value: T) -> Outcome {
        // SAFETY: the caller's.
        let Some(room) = (unsafe { self.loan::<T>(slot) }) else {
            return Outcome::Unbound;
        };
        // SAFETY: room for a `T`, aligned, to which no other reference exists until it is published.
        unsafe { room.write(value) };
        self.publish(slot, None)
    }
}

/// The application left this optional port unbound.
pub(crate) struct Unbound;

/// Panics because the host broke the contract of the ABI. The panic makes the schema Faulted with this
/// message.
pub(crate) fn broken(name: &str, call: &str, code: i32) -> ! {
    if code == raw::REFUSED {
        panic!("`{name}` is refused to this call: it draws a panel, or it hung and was given up");
    }
    panic!("the host answered {code} to `{call}` of `{name}`, which it never may")
}
