//! The pen with which a schema draws its panel, and the gestures on it.

#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char};
use std::ptr::null;
use std::sync::atomic::{AtomicBool, Ordering};

use jde_abi::raw;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The host's pen. It draws until the call of `draw` returns.
#[pyclass(frozen, module = "jde._jde")]
pub(crate) struct Pen {
    pen: raw::Pen,
    has_ended: AtomicBool,
}

// SAFETY: its pointer is used only during the call that lends it, and Python runs one thread at a time.
unsafe impl Send for Pen {}
// SAFETY: as above.
unsafe impl Sync for Pen {}

impl Pen {
    pub(crate) fn new(pen: raw::Pen) -> Self {
        Self {
            pen,
            has_ended: AtomicBool::new(false),
        }
    }

    /// Ends the call that lends the pen.
    pub(crate) fn end(&self) {
        self.has_ended.store(true, Ordering::Relaxed);
    }

    fn pen(&self) -> PyResult<&raw::Pen> {
        if self.has_ended.load(Ordering::Relaxed) {
            return Err(PyRuntimeError::new_err(
                "a pen works only during the call of `draw` that lends it",
            ));
        }
        Ok(&self.pen)
    }
}

#[pymethods]
impl Pen {
    /// Adds a widget of a kind.
    #[pyo3(signature = (kind, *, id="", label="", unit="", value=0.0, least=0.0, greatest=0.0, area=[0.0; 4],
        texts=Vec::new(), pixels=None, number=0, flags=0, width=0, height=0, channels=0))]
    #[allow(clippy::too_many_arguments, reason = "the fields of the table")]
    fn add(
        &self,
        kind: u32,
        id: &str,
        label: &str,
        unit: &str,
        value: f64,
        least: f64,
        greatest: f64,
        area: [f64; 4],
        texts: Vec<String>,
        pixels: Option<&[u8]>,
        number: u32,
        flags: u32,
        width: u32,
        height: u32,
        channels: u32,
    ) -> PyResult<()> {
        let expected = u64::from(width) * u64::from(height) * u64::from(channels);
        if pixels.map_or(0, <[u8]>::len) as u64 != expected {
            let message = format!(
                "{} bytes of pixels, and {width} x {height} pixels of {channels} bytes have {expected}",
                pixels.map_or(0, <[u8]>::len)
            );
            return Err(PyValueError::new_err(message));
        }
        let (id, label, unit) = (text(id)?, text(label)?, text(unit)?);
        let texts = texts
            .iter()
            .map(|word| text(word))
            .collect::<PyResult<Vec<_>>>()?;
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        let widget = raw::Widget {
            size: size_of::<raw::Widget>() as u32,
            kind,
            id: id.as_ptr(),
            label: label.as_ptr(),
            unit: unit.as_ptr(),
            value,
            least,
            greatest,
            area,
            texts: pointers.as_ptr(),
            pixels: pixels.map_or(null(), <[u8]>::as_ptr),
            text_count: pointers.len() as u32,
            number,
            flags,
            width,
            height,
            channels,
        };
        let pen = self.pen()?;
        // SAFETY: the host's pen during its call, and a table that lives until this function returns. A mistake is shown
        // in the panel.
        unsafe { (pen.add)(pen.drawing, &raw const widget) };
        Ok(())
    }

    /// Adds a shape of a kind. `points` are two or three numbers for each.
    #[pyo3(signature = (kind, points, count, *, color=0, width=0.0, radius=0.0, extent=[0.0; 3], turned=[0.0; 3],
        label="", flags=0))]
    #[allow(clippy::too_many_arguments, reason = "the fields of the table")]
    fn shape(
        &self,
        kind: u32,
        points: Vec<f64>,
        count: u32,
        color: u32,
        width: f64,
        radius: f64,
        extent: [f64; 3],
        turned: [f64; 3],
        label: &str,
        flags: u32,
    ) -> PyResult<()> {
        let label = text(label)?;
        let shape = raw::Shape {
            size: size_of::<raw::Shape>() as u32,
            kind,
            points: points.as_ptr(),
            point_count: count.min((points.len() / 2) as u32),
            color,
            width,
            radius,
            extent,
            turned,
            text: label.as_ptr(),
            flags,
            reserved: 0,
        };
        let pen = self.pen()?;
        // SAFETY: as in `add`.
        unsafe { (pen.shape)(pen.drawing, &raw const shape) };
        Ok(())
    }

    /// Closes the container that was opened last.
    fn close(&self) -> PyResult<()> {
        let pen = self.pen()?;
        // SAFETY: the host's pen during its call.
        unsafe { (pen.end)(pen.drawing) };
        Ok(())
    }
}

/// Returns the fields of a gesture.
///
/// # Safety
/// The gesture is the host's, and its texts live.
pub(crate) unsafe fn gesture<'py>(py: Python<'py>, gesture: &raw::Gesture) -> PyResult<Bound<'py, PyDict>> {
    let text = |text: *const c_char| match text.is_null() {
        true => String::new(),
        // SAFETY: the caller's.
        false => unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned(),
    };
    let fields = PyDict::new(py);
    fields.set_item("kind", gesture.kind)?;
    fields.set_item("widget", text(gesture.widget))?;
    fields.set_item("by", text(gesture.by))?;
    fields.set_item("key", text(gesture.key))?;
    fields.set_item("start", (gesture.from[0], gesture.from[1], gesture.from[2]))?;
    fields.set_item("at", (gesture.at[0], gesture.at[1], gesture.at[2]))?;
    fields.set_item("value", gesture.value)?;
    fields.set_item("number", gesture.number)?;
    fields.set_item("button", gesture.button)?;
    fields.set_item("has_ended", gesture.flags & raw::DRAG_ENDED != 0)?;
    Ok(fields)
}

fn text(text: &str) -> PyResult<CString> {
    CString::new(text).map_err(|_| PyValueError::new_err("a text of a panel contains no NUL"))
}
