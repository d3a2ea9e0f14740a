//! The functions of the plugin's tables: each calls a method of the instance's object.

#![allow(unsafe_code)]

use std::ffi::{CStr, c_char, c_void};
use std::ptr::null_mut;

use jde_abi::raw::{self, Host};
use jde_abi::table;
use jde_abi::write::{self, Functions};
use parking_lot::Mutex;
use pyo3::exceptions::PyValueError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyType};

use crate::context::Context;
use crate::describe;
use crate::panel::{Pen, gesture};

/// What every schema offers. The version of a schema's own memory is part of what it saves.
struct InPython;

/// The class of each table that was written.
static CLASSES: Mutex<Vec<(usize, Py<PyType>)>> = Mutex::new(Vec::new());
/// Whether instances run on a bench, where no memory outlives them.
static ON_A_BENCH: std::sync::atomic::AtomicBool = std::sync::atomic::AtomicBool::new(false);
/// On a bench: the error that failed the last call.
static LAST_ERROR: Mutex<Option<PyErr>> = Mutex::new(None);

/// An instance: what the host's pointer points to.
struct Instance {
    object: Py<PyAny>,
    /// What its methods get as their context.
    cx: Py<PyAny>,
    context: Py<Context>,
}

/// Writes the table of a plugin of these classes.
pub(crate) fn table(
    py: Python<'_>,
    about: (String, String, String),
    classes: &[Py<PyType>],
) -> PyResult<&'static raw::Plugin> {
    let table = write::plugin::<InPython>(&describe::plugin(py, about, classes)?);
    let mut known = CLASSES.lock();
    for (index, class) in classes.iter().enumerate() {
        // SAFETY: the table has a schema for each class.
        let schema = unsafe { table.schemas.add(index) };
        known.push((schema as usize, class.clone_ref(py)));
    }
    Ok(table)
}

/// States that instances run on a bench from now on.
pub(crate) fn run_on_a_bench() {
    ON_A_BENCH.store(true, std::sync::atomic::Ordering::Relaxed);
}

/// Returns the error that failed the last call on a bench.
pub(crate) fn take_last_error() -> Option<PyErr> {
    LAST_ERROR.lock().take()
}

fn keep_error(py: Python<'_>, error: &PyErr) {
    if ON_A_BENCH.load(std::sync::atomic::Ordering::Relaxed) {
        *LAST_ERROR.lock() = Some(error.clone_ref(py));
    }
}

fn make(py: Python<'_>, schema: *const raw::Schema, host: Host, cx: *mut raw::Context) -> PyResult<Instance> {
    let class = {
        let known = CLASSES.lock();
        let found = known.iter().find(|(table, _)| *table == schema as usize);
        found.map(|(_, class)| class.clone_ref(py))
    };
    let class = class.ok_or_else(|| PyValueError::new_err("there is no class of this schema"))?;
    let class = class.bind(py);
    let layouts = class.getattr("__jde__")?.getattr("layouts")?.extract()?;
    let copies = ON_A_BENCH.load(std::sync::atomic::Ordering::Relaxed);
    let context = Py::new(py, Context::new(host, layouts, copies))?;
    context.get().begin(cx);
    let made = class.call_method1(intern!(py, "_make"), (context.clone_ref(py),));
    context.get().end(py);
    let object = made?;
    Ok(Instance {
        cx: object.getattr(intern!(py, "_cx"))?.unbind(),
        object: object.unbind(),
        context,
    })
}

/// Runs a call of an instance, and returns its status. An error becomes the reason of a failure.
///
/// # Safety
/// `instance` is what `create` returned, and `cx` the context of this call.
unsafe fn call(
    instance: *mut c_void,
    cx: *mut raw::Context,
    run: impl FnOnce(Python<'_>, &Bound<'_, PyAny>, &Py<PyAny>) -> PyResult<()>,
) -> i32 {
    // SAFETY: the caller's.
    let instance = unsafe { &*instance.cast::<Instance>() };
    Python::attach(|py| {
        let context = instance.context.get();
        context.begin(cx);
        let result = run(py, instance.object.bind(py), &instance.cx);
        let status = match &result {
            Ok(()) => raw::OK,
            Err(error) if is_no_value(py, error) => {
                context.fail(&error.value(py).to_string());
                raw::NO_VALUE
            }
            Err(error) => {
                context.fail(&reason(py, error));
                keep_error(py, error);
                raw::FAILED
            }
        };
        context.end(py);
        status
    })
}

/// Returns an error in words, with its traceback.
pub(crate) fn reason(py: Python<'_>, error: &PyErr) -> String {
    // Before Python 3.12 an error and its traceback are apart.
    if let Some(traceback) = error.traceback(py) {
        drop(error.value(py).setattr(intern!(py, "__traceback__"), traceback));
    }
    let described = py
        .import("jde._errors")
        .and_then(|module| module.call_method1("describe", (error.value(py),)))
        .and_then(|text| text.extract::<String>());
    described.unwrap_or_else(|_| error.to_string())
}

/// Whether the error only says that an input has no value.
fn is_no_value(py: Python<'_>, error: &PyErr) -> bool {
    let class = py
        .import("jde._errors")
        .and_then(|module| module.getattr("NoValue"));
    class.is_ok_and(|class| error.is_instance(py, &class))
}

/// Reads what a check returned: a bool, or a `Precondition`.
fn precondition(result: &Bound<'_, PyAny>) -> PyResult<(bool, f64)> {
    if let Ok(ready) = result.extract::<bool>() {
        return Ok((ready, 0.0));
    }
    let py = result.py();
    let wrong = |_| {
        let kind = crate::layout::kind_of(result);
        pyo3::exceptions::PyTypeError::new_err(format!(
            "check returns True, False or a Precondition, not {kind}"
        ))
    };
    let ready: bool = result.getattr(intern!(py, "ready")).map_err(wrong)?.extract()?;
    let urgency: f64 = result.getattr(intern!(py, "urgency")).map_err(wrong)?.extract()?;
    if !urgency.is_finite() {
        let message = format!("its check offered an urgency of {urgency}; it must be finite");
        return Err(PyValueError::new_err(message));
    }
    Ok((ready, urgency))
}

/// Returns the candidates of a level: role, state, precondition, urgency.
///
/// # Safety
/// The level follows the rules of [`raw`].
unsafe fn candidates(level: &raw::Level) -> Vec<(u32, u32, bool, f64)> {
    if level.candidate_count == 0 {
        return Vec::new();
    }
    // SAFETY: the caller's: that many tables, of which the first states the stride.
    unsafe {
        let stride = level.candidates.cast::<u32>().read() as usize;
        let read = |index| table::read(level.candidates.byte_add(index * stride)).ok();
        (0..level.candidate_count as usize)
            .filter_map(read)
            .map(|candidate| {
                (
                    candidate.child,
                    candidate.state,
                    candidate.ready != 0,
                    candidate.urgency,
                )
            })
            .collect()
    }
}

impl Functions for InPython {
    unsafe extern "C" fn create(
        schema: *const raw::Schema,
        host: *const Host,
        cx: *mut raw::Context,
    ) -> *mut c_void {
        // SAFETY: the host's table.
        let Ok(host) = (unsafe { table::read(host) }) else {
            return null_mut();
        };
        Python::attach(|py| {
            let made = make(py, schema, host, cx);
            match made {
                Ok(instance) => Box::into_raw(Box::new(instance)).cast(),
                Err(error) => {
                    let reason = reason(py, &error);
                    keep_error(py, &error);
                    // SAFETY: the context of this call, and a text of that length.
                    unsafe { (host.fail)(cx, reason.as_ptr().cast(), reason.len() as u64) };
                    null_mut()
                }
            }
        })
    }

    unsafe extern "C" fn destroy(instance: *mut c_void) {
        // SAFETY: what `create` returned, passed back once.
        let instance = unsafe { Box::from_raw(instance.cast::<Instance>()) };
        Python::attach(|_| drop(instance));
    }

    unsafe extern "C" fn awake(instance: *mut c_void, cx: *mut raw::Context) -> i32 {
        // SAFETY: the host's pointers.
        unsafe {
            call(instance, cx, |py, object, cx| {
                object.call_method1(intern!(py, "awake"), (cx,)).map(drop)
            })
        }
    }

    unsafe extern "C" fn check(
        instance: *mut c_void,
        cx: *mut raw::Context,
        out: *mut raw::Precondition,
    ) -> i32 {
        let check = |py: Python<'_>, object: &Bound<'_, PyAny>, cx: &Py<PyAny>| {
            let result = object.call_method1(intern!(py, "check"), (cx,))?;
            let (ready, urgency) = precondition(&result)?;
            let filled = raw::Precondition {
                size: size_of::<raw::Precondition>() as u32,
                ready: u32::from(ready),
                urgency,
            };
            // SAFETY: the host's room for the result, which states its size.
            unsafe { table::write(out, &filled) };
            Ok(())
        };
        // SAFETY: the host's pointers.
        unsafe { call(instance, cx, check) }
    }

    unsafe extern "C" fn iterate(instance: *mut c_void, cx: *mut raw::Context) -> i32 {
        // SAFETY: the host's pointers.
        unsafe {
            call(instance, cx, |py, object, cx| {
                object.call_method1(intern!(py, "iterate"), (cx,)).map(drop)
            })
        }
    }

    unsafe extern "C" fn sleep(instance: *mut c_void, cx: *mut raw::Context) {
        // SAFETY: the host's pointers.
        unsafe {
            call(instance, cx, |py, object, cx| {
                object.call_method1(intern!(py, "sleep"), (cx,)).map(drop)
            });
        }
    }

    unsafe extern "C" fn arbitrate(
        instance: *mut c_void,
        cx: *mut raw::Context,
        level: *const raw::Level,
        out: *mut raw::Verdict,
    ) -> i32 {
        // SAFETY: the host's table, which lives until this call returns.
        let Ok(level) = (unsafe { table::read(level) }) else {
            return raw::BAD_ARGUMENT;
        };
        let arbitrate = |py: Python<'_>, object: &Bound<'_, PyAny>, cx: &Py<PyAny>| {
            // SAFETY: the host's name of the group, and its candidates, of which the first states the stride.
            let (group, candidates) =
                unsafe { (CStr::from_ptr(level.group).to_string_lossy(), candidates(&level)) };
            let arguments = (cx, level.case, group, candidates, level.winner);
            let answer = object.call_method1(intern!(py, "_arbitrate"), arguments)?;
            let (child, text): (i32, String) = answer.extract()?;
            let mut verdict = raw::Verdict {
                size: size_of::<raw::Verdict>() as u32,
                child,
                reason: [0; 128],
            };
            let mut end = text.len().min(verdict.reason.len() - 1);
            while !text.is_char_boundary(end) {
                end -= 1;
            }
            for (place, byte) in verdict.reason.iter_mut().zip(&text.as_bytes()[..end]) {
                *place = c_char::from_ne_bytes([*byte]);
            }
            // SAFETY: the host's room for the verdict, which states its size.
            unsafe { table::write(out, &verdict) };
            Ok(())
        };
        // SAFETY: the host's pointers.
        unsafe { call(instance, cx, arbitrate) }
    }

    unsafe extern "C" fn draw(instance: *mut c_void, cx: *mut raw::Context, pen: *const raw::Pen) -> i32 {
        // SAFETY: the host's table, which lives until this call returns.
        let Ok(pen) = (unsafe { table::read(pen) }) else {
            return raw::BAD_ARGUMENT;
        };
        let draw = |py: Python<'_>, object: &Bound<'_, PyAny>, cx: &Py<PyAny>| {
            let pen = Py::new(py, Pen::new(pen))?;
            let drawn = object.call_method1(intern!(py, "_draw"), (cx, pen.clone_ref(py)));
            pen.get().end();
            drawn.map(drop)
        };
        // SAFETY: the host's pointers.
        unsafe { call(instance, cx, draw) }
    }

    unsafe extern "C" fn touch(
        instance: *mut c_void,
        cx: *mut raw::Context,
        touched: *const raw::Gesture,
    ) -> i32 {
        // SAFETY: the host's table, which lives until this call returns.
        let Ok(touched) = (unsafe { table::read(touched) }) else {
            return raw::BAD_ARGUMENT;
        };
        // SAFETY: the host's pointers, and its gesture.
        unsafe {
            call(instance, cx, |py, object, cx| {
                let gesture = gesture(py, &touched)?;
                object
                    .call_method1(intern!(py, "_touch"), (cx, gesture))
                    .map(drop)
            })
        }
    }

    unsafe extern "C" fn save(instance: *mut c_void, cx: *mut raw::Context, saver: *const raw::Saver) -> i32 {
        // SAFETY: the host's table, which lives until this call returns.
        let Ok(saver) = (unsafe { table::read(saver) }) else {
            return raw::BAD_ARGUMENT;
        };
        let save = |py: Python<'_>, object: &Bound<'_, PyAny>, cx: &Py<PyAny>| {
            let saved = object.call_method1(intern!(py, "_save"), (cx,))?;
            let bytes = saved.cast::<PyBytes>()?.as_bytes();
            // SAFETY: the host's function and its first argument, and bytes of that length.
            match unsafe { (saver.write)(saver.saving, bytes.as_ptr().cast(), bytes.len() as u64) } {
                raw::OK => Ok(()),
                _ => {
                    let message = format!("it saves {} bytes, more than are kept", bytes.len());
                    Err(PyValueError::new_err(message))
                }
            }
        };
        // SAFETY: the host's pointers.
        unsafe { call(instance, cx, save) }
    }

    unsafe extern "C" fn restore(
        instance: *mut c_void,
        cx: *mut raw::Context,
        _: u32,
        bytes: *const c_void,
        length: u64,
    ) -> i32 {
        let bytes = match length {
            0 => &[][..],
            // SAFETY: the host's bytes, which live until this call returns.
            length => unsafe { std::slice::from_raw_parts(bytes.cast::<u8>(), length as usize) },
        };
        // SAFETY: the host's pointers.
        unsafe {
            call(instance, cx, |py, object, cx| {
                let bytes = PyBytes::new(py, bytes);
                object
                    .call_method1(intern!(py, "_restore"), (cx, bytes))
                    .map(drop)
            })
        }
    }

    unsafe extern "C" fn inspect(
        instance: *mut c_void,
        cx: *mut raw::Context,
        problems: *const raw::Problems,
    ) -> i32 {
        // SAFETY: the host's table, which lives until this call returns.
        let Ok(list) = (unsafe { table::read(problems) }) else {
            return raw::BAD_ARGUMENT;
        };
        let inspect = |py: Python<'_>, object: &Bound<'_, PyAny>, cx: &Py<PyAny>| {
            let found = object.call_method1(intern!(py, "_inspect"), (cx,))?;
            for (port, is_unavailable, text) in found.extract::<Vec<(u32, bool, String)>>()? {
                let kind = if is_unavailable {
                    raw::PROBLEM_UNAVAILABLE
                } else {
                    raw::PROBLEM_WRONG
                };
                // SAFETY: the host's function and its first argument, and a text of that length.
                unsafe { (list.add)(list.found, kind, port, text.as_ptr().cast(), text.len() as u64) };
            }
            Ok(())
        };
        // SAFETY: the host's pointers.
        unsafe { call(instance, cx, inspect) }
    }
}
