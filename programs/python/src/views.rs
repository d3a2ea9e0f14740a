//! The memory of values, as Python sees it: views that are released at the end of the call.
//!
//! A released view raises an error when it is used. A view that another object uses, such as an array of NumPy, cannot
//! be released: that object may see later values then, and never invalid memory, because no memory of a port is
//! freed while the process lives.

#![allow(unsafe_code)]

use std::cell::RefCell;
use std::ffi::{c_char, c_int};

use pyo3::ffi;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// `PyBUF_READ` and `PyBUF_WRITE` of Python's headers.
const READ: c_int = 0x100;
const WRITE: c_int = 0x200;

/// The memory of one value, and the views of it that were given out.
pub(crate) struct Views<'py> {
    memory: *const u8,
    length: usize,
    /// The copy that the memory is in.
    owner: Option<Bound<'py, PyBytes>>,
    given: RefCell<Vec<Py<PyAny>>>,
}

impl<'py> Views<'py> {
    /// Views of the memory itself.
    ///
    /// # Safety
    /// The memory is readable until the process ends.
    pub(crate) unsafe fn in_place(memory: *const u8, length: usize) -> Self {
        Self {
            memory,
            length,
            owner: None,
            given: RefCell::default(),
        }
    }

    /// Views of a copy.
    pub(crate) fn copying(py: Python<'py>, bytes: &[u8]) -> PyResult<Self> {
        let owner = PyBytes::new_with(py, bytes.len(), |copy| {
            copy.copy_from_slice(bytes);
            Ok(())
        })?;
        Ok(Self {
            memory: owner.as_bytes().as_ptr(),
            length: bytes.len(),
            owner: Some(owner),
            given: RefCell::default(),
        })
    }

    /// Returns some of its bytes, for use before anything else runs.
    pub(crate) fn bytes(&self, start: usize, length: usize) -> &[u8] {
        assert!(start + length <= self.length, "a layout stays within its bytes");
        // SAFETY: within the memory, which is readable by the contract of the constructors.
        unsafe { std::slice::from_raw_parts(self.memory.add(start), length) }
    }

    /// Returns the number of elements of a sequence.
    pub(crate) fn length(&self, at: usize) -> u32 {
        u32::from_ne_bytes(self.bytes(at, 4).try_into().unwrap_or_default())
    }

    /// Returns a read-only view of numbers.
    pub(crate) fn view(
        &self,
        py: Python<'py>,
        start: usize,
        length: usize,
        format: &str,
    ) -> PyResult<Bound<'py, PyAny>> {
        let bytes = self.bytes(start, length);
        let view = match &self.owner {
            Some(owner) => {
                let whole = pyo3::types::PyMemoryView::from(owner.as_any())?;
                let range = pyo3::types::PySlice::new(py, start as isize, (start + length) as isize, 1);
                whole.get_item(range)?
            }
            // SAFETY: the memory is readable until the process ends.
            None => unsafe { memory_view(py, bytes.as_ptr().cast_mut(), length, READ)? },
        };
        let view = view.call_method1(pyo3::intern!(py, "cast"), (format,))?;
        self.given.borrow_mut().push(view.clone().unbind());
        Ok(view)
    }

    /// Returns the views that were given out.
    pub(crate) fn into_given(self) -> Vec<Py<PyAny>> {
        self.given.into_inner()
    }
}

/// Releases views at the end of a call, except those that other objects use.
pub(crate) fn release(py: Python<'_>, given: Vec<Py<PyAny>>) {
    for view in given {
        // A view in use raises `BufferError`, and stays.
        drop(view.call_method0(py, pyo3::intern!(py, "release")));
    }
}

/// Returns a writable view of bytes. The caller drops it before the bytes.
pub(crate) fn writable<'py>(py: Python<'py>, bytes: &mut [u8]) -> PyResult<Bound<'py, PyAny>> {
    // SAFETY: the caller's bytes, which outlive the view.
    unsafe { memory_view(py, bytes.as_mut_ptr(), bytes.len(), WRITE) }
}

/// # Safety
/// The memory has that length, is readable, and writable if the flags say so, as long as the view lives.
unsafe fn memory_view(
    py: Python<'_>,
    memory: *mut u8,
    length: usize,
    flags: c_int,
) -> PyResult<Bound<'_, PyAny>> {
    // SAFETY: the caller's.
    unsafe {
        let view = ffi::PyMemoryView_FromMemory(memory.cast::<c_char>(), length as isize, flags);
        Bound::from_owned_ptr_or_err(py, view)
    }
}
