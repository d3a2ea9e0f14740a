//! The numbers in values.

use jde_abi::describe::Scalar;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFloat};

use crate::layout::kind_of;
use crate::views;

/// Applies a macro to the kind of a scalar and its type in Rust.
macro_rules! with_type {
    ($scalar:expr, $macro:ident) => {
        match $scalar {
            Scalar::Bool | Scalar::U8 => $macro!(u8),
            Scalar::U16 => $macro!(u16),
            Scalar::U32 => $macro!(u32),
            Scalar::U64 => $macro!(u64),
            Scalar::I8 => $macro!(i8),
            Scalar::I16 => $macro!(i16),
            Scalar::I32 => $macro!(i32),
            Scalar::I64 => $macro!(i64),
            Scalar::F32 => $macro!(f32),
            Scalar::F64 => $macro!(f64),
        }
    };
}

/// Returns the number with these bytes.
pub(crate) fn decode<'py>(py: Python<'py>, scalar: Scalar, bytes: &[u8]) -> PyResult<Bound<'py, PyAny>> {
    macro_rules! number {
        ($type:ty) => {
            Ok(<$type>::from_ne_bytes(bytes.try_into().unwrap_or_default())
                .into_pyobject(py)?
                .into_any())
        };
    }
    if scalar == Scalar::Bool {
        return Ok(PyBool::new(py, bytes[0] != 0).to_owned().into_any());
    }
    with_type!(scalar, number)
}

/// Writes a number.
pub(crate) fn encode(scalar: Scalar, value: &Bound<'_, PyAny>, bytes: &mut [u8]) -> PyResult<()> {
    macro_rules! number {
        ($type:ty) => {{
            let number: $type = value.extract().map_err(|_| refuse(scalar, value))?;
            bytes.copy_from_slice(&number.to_ne_bytes());
            Ok(())
        }};
    }
    if scalar == Scalar::Bool {
        let truth: bool = value.extract().map_err(|_| refuse(scalar, value))?;
        bytes[0] = u8::from(truth);
        return Ok(());
    }
    with_type!(scalar, number)
}

fn refuse(scalar: Scalar, value: &Bound<'_, PyAny>) -> PyErr {
    // An int that is too large has the right type.
    if value.hasattr("__index__").unwrap_or(false) && !value.is_instance_of::<PyFloat>() {
        return PyValueError::new_err(format!("{value} is outside the range of {}", scalar.ros_name()));
    }
    PyTypeError::new_err(format!(
        "this takes a {}, not {}",
        scalar.ros_name(),
        kind_of(value)
    ))
}

/// Returns the letter of the number in formats of the module `struct` and of memoryviews.
pub(crate) fn format(scalar: Scalar) -> &'static str {
    match scalar {
        Scalar::Bool => "?",
        Scalar::U8 => "B",
        Scalar::U16 => "H",
        Scalar::U32 => "I",
        Scalar::U64 => "Q",
        Scalar::I8 => "b",
        Scalar::I16 => "h",
        Scalar::I32 => "i",
        Scalar::I64 => "q",
        Scalar::F32 => "f",
        Scalar::F64 => "d",
    }
}

/// Copies the numbers of an object with a buffer, such as an array of NumPy, if they have the same type and lie
/// without gaps. Returns whether it did.
pub(crate) fn copy_buffer(scalar: Scalar, value: &Bound<'_, PyAny>, room: &mut [u8]) -> PyResult<bool> {
    let py = value.py();
    let Ok(view) = pyo3::types::PyMemoryView::from(value) else {
        return Ok(false);
    };
    let (letter, itemsize, is_contiguous): (String, usize, bool) = (
        view.getattr("format")?.extract()?,
        view.getattr("itemsize")?.extract()?,
        view.getattr("c_contiguous")?.extract()?,
    );
    // On this machine `l` and `q` are the same number, and so are `L` and `Q`.
    let letter = match letter.as_str() {
        "l" => "q",
        "L" => "Q",
        letter => letter,
    };
    let size: usize = view.getattr("nbytes")?.extract()?;
    if letter != format(scalar) || !is_contiguous || size != room.len() || itemsize == 0 {
        return Ok(false);
    }
    if size > 0 {
        let bytes = view.call_method1(pyo3::intern!(py, "cast"), ("B",))?;
        views::writable(py, room)?.set_item(pyo3::types::PySlice::full(py), bytes)?;
    }
    Ok(true)
}
