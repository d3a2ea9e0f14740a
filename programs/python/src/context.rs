//! The context of the present call, as a schema in Python uses it: its ports, its children, the time and the log.

#![allow(unsafe_code)]

use std::ffi::CStr;
use std::ptr::null_mut;
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU64, Ordering};

use jde_abi::raw::{self, Host};
use jde_isolation::{HOLD, Hold};
use parking_lot::Mutex;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::layout::Layout;
use crate::views::{self, Views};

/// Values of more bytes are not copied: their views show the memory of the port. Smaller ones arrive in messages,
/// whose memory the next message uses.
const MOST_COPIED: usize = 4096;

/// The context of an instance. Its functions work during a call of that instance, on the call's thread.
#[pyclass(frozen, module = "jde._jde")]
pub(crate) struct Context {
    host: Host,
    layouts: Vec<Py<Layout>>,
    /// Whether no value outlives its call: on a bench.
    copies: bool,
    /// The host's context of the present call; null outside calls.
    present: AtomicPtr<raw::Context>,
    /// The thread of the present call.
    thread: AtomicU64,
    given: Mutex<Vec<Py<PyAny>>>,
    /// The values that were read in the present call.
    read: Mutex<Vec<Read>>,
    /// Whether a value is being written. Its elements may be computed in Python, which may try to write another.
    writing: AtomicBool,
}

/// A value that was read, and where the host has it.
struct Read {
    port: u32,
    data: usize,
    sequence: u64,
    value: Py<PyAny>,
}

/// A write that is under way.
struct Writing<'c>(&'c AtomicBool);

impl Drop for Writing<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Relaxed);
    }
}

impl Context {
    pub(crate) fn new(host: Host, layouts: Vec<Py<Layout>>, copies: bool) -> Self {
        Self {
            host,
            layouts,
            copies,
            present: AtomicPtr::new(null_mut()),
            thread: AtomicU64::new(0),
            given: Mutex::default(),
            read: Mutex::default(),
            writing: AtomicBool::new(false),
        }
    }

    /// Begins a call.
    pub(crate) fn begin(&self, context: *mut raw::Context) {
        self.thread.store(thread(), Ordering::Relaxed);
        self.present.store(context, Ordering::Relaxed);
    }

    /// Ends the call: views of values raise errors from now on.
    pub(crate) fn end(&self, py: Python<'_>) {
        self.present.store(null_mut(), Ordering::Relaxed);
        let read = std::mem::take(&mut *self.read.lock());
        let given = std::mem::take(&mut *self.given.lock());
        // Unlocked, because the end of an object may run code of Python.
        drop(read);
        views::release(py, given);
    }

    /// States why the call fails.
    pub(crate) fn fail(&self, reason: &str) {
        if let Ok(context) = self.present() {
            // SAFETY: the context of the present call, and a text of that length.
            unsafe { (self.host.fail)(context, reason.as_ptr().cast(), reason.len() as u64) };
        }
    }

    fn present(&self) -> PyResult<*mut raw::Context> {
        let present = self.present.load(Ordering::Relaxed);
        if present.is_null() {
            return Err(PyRuntimeError::new_err(
                "a port, a child and the context work only during a call of their schema",
            ));
        }
        if self.thread.load(Ordering::Relaxed) != thread() {
            return Err(PyRuntimeError::new_err(
                "a port, a child and the context work only on the thread on which their schema is called",
            ));
        }
        Ok(present)
    }

    fn begin_write(&self) -> PyResult<Writing<'_>> {
        if self.writing.swap(true, Ordering::Relaxed) {
            return Err(PyRuntimeError::new_err(
                "a value is being written: compute its elements first, and write one value after the other",
            ));
        }
        Ok(Writing(&self.writing))
    }

    fn layout(&self, port: u32) -> PyResult<&Layout> {
        let layout = self.layouts.get(port as usize).map(Py::get);
        layout.ok_or_else(|| PyRuntimeError::new_err(format!("there is no port {port}")))
    }

    fn read_sample(&self, port: u32) -> PyResult<Option<raw::Sample>> {
        let mut sample = raw::Sample {
            data: null_mut(),
            bytes: 0,
            time_ns: 0,
            sequence: 0,
            writer: 0,
            flags: 0,
        };
        // SAFETY: the context of the present call, and room for a sample.
        match unsafe { (self.host.read)(self.present()?, port, &raw mut sample) } {
            raw::OK => Ok(Some(sample)),
            raw::NO_VALUE | raw::UNBOUND => Ok(None),
            raw::REFUSED => Err(given_up()),
            status => Err(failed("read", status)),
        }
    }

    /// Returns a value, which is decoded once in a call.
    fn value<'py>(&self, py: Python<'py>, port: u32, sample: &raw::Sample) -> PyResult<Bound<'py, PyAny>> {
        let (data, sequence) = (sample.data as usize, sample.sequence);
        let is_same = |read: &&Read| (read.port, read.data, read.sequence) == (port, data, sequence);
        if let Some(read) = self.read.lock().iter().find(is_same) {
            return Ok(read.value.bind(py).clone());
        }
        let value = self.decode(py, port, sample)?;
        self.read.lock().push(Read {
            port,
            data,
            sequence,
            value: value.clone().unbind(),
        });
        Ok(value)
    }

    fn decode<'py>(&self, py: Python<'py>, port: u32, sample: &raw::Sample) -> PyResult<Bound<'py, PyAny>> {
        let layout = self.layout(port)?;
        let length = layout.ty.bytes;
        if sample.data.is_null() || sample.bytes as usize != length {
            let message = format!("the host gave {} bytes for a value of {length}", sample.bytes);
            return Err(PyRuntimeError::new_err(message));
        }
        let data = sample.data.cast::<u8>();
        let views = if self.copies || length <= MOST_COPIED {
            // SAFETY: the host's value, unchanged during the call.
            Views::copying(py, unsafe { std::slice::from_raw_parts(data, length) })?
        } else {
            // SAFETY: the host's value; the memory of a port is kept until the process ends.
            unsafe { Views::in_place(data, length) }
        };
        let value = layout.decode(py, &views, 0);
        self.given.lock().extend(views.into_given());
        value
    }
}

#[pymethods]
impl Context {
    /// Returns the value of an input; none if it has none.
    fn read<'py>(&self, py: Python<'py>, port: u32) -> PyResult<Option<Bound<'py, PyAny>>> {
        let sample = self.read_sample(port)?;
        sample.map(|sample| self.value(py, port, &sample)).transpose()
    }

    /// Returns the value of an input with its time, ns, its sequence number, its writer and its flags.
    fn sample<'py>(&self, py: Python<'py>, port: u32) -> PyResult<Option<Bound<'py, PyTuple>>> {
        let Some(sample) = self.read_sample(port)? else {
            return Ok(None);
        };
        let value = self.value(py, port, &sample)?;
        let raw::Sample {
            time_ns,
            sequence,
            writer,
            flags,
            ..
        } = sample;
        Some((value, time_ns, sequence, writer, flags).into_pyobject(py)).transpose()
    }

    /// Writes the next value of an output, measured at that time, ns (0: now). Returns a status.
    fn write(&self, port: u32, value: &Bound<'_, PyAny>, time_ns: u64) -> PyResult<i32> {
        let layout = self.layout(port)?;
        let context = self.present()?;
        let _writing = self.begin_write()?;
        let mut buffer = null_mut();
        // SAFETY: the context of the present call, and room for a pointer.
        match unsafe { (self.host.loan)(context, port, &raw mut buffer) } {
            raw::OK if !buffer.is_null() => {
                // SAFETY: the host's buffer for a value of the port, which nobody else uses until it is published:
                // a second write is refused meanwhile.
                let bytes = unsafe { std::slice::from_raw_parts_mut(buffer.cast::<u8>(), layout.ty.bytes) };
                layout.encode(value, bytes)?;
            }
            status @ (raw::UNBOUND | raw::REFUSED) => return Ok(status),
            status => return Err(failed("write", status)),
        }
        // SAFETY: as above.
        match unsafe { (self.host.publish)(context, port, time_ns) } {
            raw::BAD_ARGUMENT => Err(failed("write", raw::BAD_ARGUMENT)),
            status => Ok(status),
        }
    }

    /// Retracts the newest value of an export.
    fn retract(&self, port: u32) -> PyResult<()> {
        let context = self.present()?;
        let _writing = self.begin_write()?;
        if let Some(retract) = self.host.retract {
            // SAFETY: the context of the present call.
            unsafe { retract(context, port) };
        }
        Ok(())
    }

    /// Wakes a child. Returns a status.
    fn wake(&self, child: u32) -> PyResult<i32> {
        // SAFETY: the context of the present call.
        Ok(unsafe { (self.host.wake)(self.present()?, child) })
    }

    /// Puts a child to sleep. Returns a status.
    fn sleep(&self, child: u32) -> PyResult<i32> {
        // SAFETY: the context of the present call.
        Ok(unsafe { (self.host.sleep)(self.present()?, child) })
    }

    /// Returns the state of a child, as a number, and whether it is Faulted; none if nobody has the role.
    fn child(&self, child: u32) -> PyResult<Option<(u32, bool)>> {
        let mut status = raw::ChildStatus {
            size: size_of::<raw::ChildStatus>() as u32,
            state: raw::SLEPT,
            faulted: 0,
            reserved: 0,
        };
        // SAFETY: the context of the present call, and room for a status.
        let found = unsafe { (self.host.child)(self.present()?, child, &raw mut status) };
        Ok((found == raw::OK).then_some((status.state, status.faulted != 0)))
    }

    /// Changes the policy of a child's group. Returns a status.
    fn set_policy(&self, child: u32, policy: u32, dwell_ns: u64, hysteresis: f64) -> PyResult<i32> {
        // SAFETY: the context of the present call.
        Ok(unsafe { (self.host.set_policy)(self.present()?, child, policy, dwell_ns, hysteresis) })
    }

    /// Returns the time since the application's start, ns.
    fn now_ns(&self) -> PyResult<u64> {
        // SAFETY: the context of the present call.
        Ok(unsafe { (self.host.now)(self.present()?) })
    }

    /// Returns a seed that depends on the application's seed and the name alone.
    fn seed(&self) -> PyResult<u64> {
        // SAFETY: the context of the present call.
        Ok(unsafe { (self.host.seed)(self.present()?) })
    }

    /// Returns whether the application runs in real time.
    fn real_time(&self) -> PyResult<bool> {
        let context = self.present()?;
        // SAFETY: the context of the present call.
        Ok(self
            .host
            .real_time
            .is_some_and(|real_time| unsafe { real_time(context) } != 0))
    }

    /// Returns the instance's name in the application.
    fn name(&self) -> PyResult<String> {
        // SAFETY: the context of the present call; the text lives as long as the instance.
        let name = unsafe { CStr::from_ptr((self.host.name)(self.present()?)) };
        Ok(name.to_string_lossy().into_owned())
    }

    /// Lets a debugger hold the present call, or go on.
    fn hold(&self, py: Python<'_>, held: bool) -> PyResult<()> {
        let context = self.present()?;
        // SAFETY: the context of the present call, and a text with a null at its end.
        let table = unsafe { (self.host.extension)(context, HOLD.as_ptr()) }.cast::<Hold>();
        // SAFETY: the table of that name lives as long as the process.
        let Some(Hold { hold }) = (unsafe { table.as_ref() }) else {
            return Err(PyRuntimeError::new_err("this host has no debugger"));
        };
        let context = context as usize;
        // Other threads go on while this one waits for the terminal.
        // SAFETY: the context of the present call.
        py.detach(|| unsafe { hold(context as *mut raw::Context, held) });
        Ok(())
    }

    /// Writes a message to the log.
    fn log(&self, level: u32, text: &str) -> PyResult<()> {
        if level > raw::ERROR {
            return Err(PyValueError::new_err(format!("there is no level {level}")));
        }
        // SAFETY: the context of the present call, and a text of that length.
        unsafe { (self.host.log)(self.present()?, level, text.as_ptr().cast(), text.len() as u64) };
        Ok(())
    }
}

fn given_up() -> PyErr {
    PyRuntimeError::new_err("the host has given this call up")
}

fn failed(what: &str, status: i32) -> PyErr {
    PyRuntimeError::new_err(format!("the host cannot {what} this port: status {status}"))
}

/// Returns a number of this thread.
fn thread() -> u64 {
    thread_local!(static MARK: u8 = const { 0 });
    MARK.with(|mark| std::ptr::from_ref(mark) as u64)
}
