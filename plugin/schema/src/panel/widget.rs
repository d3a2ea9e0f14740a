//! Widgets that are passed to the host.

use core::ffi::{CStr, c_char};
use core::ptr;
use std::borrow::Cow;
use std::ffi::CString;

use jde_abi::raw;

/// A widget under construction. It is drawn at the end of the expression that builds it.
pub struct Widget<'p> {
    pen: &'p raw::Pen,
    id: CString,
    label: CString,
    unit: CString,
    texts: Vec<CString>,
    pixels: Cow<'p, [u8]>,
    /// Everything except the texts and the pixels.
    pub(super) table: raw::Widget,
    /// Whether the host has received the widget already, so that the drop does not add it again.
    done: bool,
}

impl<'p> Widget<'p> {
    pub(super) fn new(pen: &'p raw::Pen, kind: u32, id: &str, label: &str) -> Self {
        Self {
            pen,
            id: c(id),
            label: c(label),
            unit: CString::default(),
            texts: Vec::new(),
            pixels: Cow::Borrowed(&[]),
            table: raw::Widget {
                size: size_of::<raw::Widget>() as u32,
                kind,
                id: ptr::null(),
                label: ptr::null(),
                unit: ptr::null(),
                value: 0.0,
                least: 0.0,
                greatest: 0.0,
                area: [0.0; 4],
                texts: ptr::null(),
                pixels: ptr::null(),
                text_count: 0,
                number: 0,
                flags: 0,
                width: 0,
                height: 0,
                channels: 0,
            },
            done: false,
        }
    }

    /// Sets whether the button can be pressed. The default is that it can.
    pub fn enabled(mut self, enabled: bool) {
        self.flag(raw::DISABLED, !enabled);
    }

    /// Reports clicks on an image to the schema.
    pub fn wants_clicks(mut self) -> Self {
        self.flag(raw::WANTS_CLICKS, true);
        self
    }

    /// Reports drags on an image to the schema.
    pub fn wants_drags(mut self) -> Self {
        self.flag(raw::WANTS_DRAGS, true);
        self
    }

    pub(super) fn number(mut self, number: u32) -> Self {
        self.table.number = number;
        self
    }

    pub(super) fn value(mut self, value: f64, unit: &str) -> Self {
        self.table.value = value;
        self.unit = c(unit);
        self
    }

    pub(super) fn texts<T: AsRef<str>>(mut self, texts: impl IntoIterator<Item = T>) -> Self {
        self.texts.extend(texts.into_iter().map(|text| c(text.as_ref())));
        self
    }

    pub(super) fn text_count(&self) -> usize {
        self.texts.len()
    }

    pub(super) fn pixels(mut self, pixels: Cow<'p, [u8]>) -> Self {
        self.pixels = pixels;
        self
    }

    pub(super) fn flag(&mut self, flag: u32, on: bool) {
        if on {
            self.table.flags |= flag;
        } else {
            self.table.flags &= !flag;
        }
    }

    /// Opens the widget, draws its inside, and ends it.
    pub(super) fn around<R>(mut self, inside: impl FnOnce(&'p raw::Pen) -> R) -> R {
        self.add();
        let result = inside(self.pen);
        // SAFETY: the host's pen, which lives as long as the call that `self` cannot outlive.
        unsafe { (self.pen.end)(self.pen.drawing) };
        result
    }

    /// Passes the widget to the host. The host shows any mistake in the panel; the author's code cannot react
    /// to it here.
    fn add(&mut self) {
        self.done = true;
        let texts: Vec<*const c_char> = self.texts.iter().map(|text| text.as_ptr()).collect();
        let or_null = |text: &CStr| {
            if text.is_empty() {
                ptr::null()
            } else {
                text.as_ptr()
            }
        };
        self.table.id = or_null(&self.id);
        self.table.label = or_null(&self.label);
        self.table.unit = or_null(&self.unit);
        self.table.text_count = texts.len() as u32;
        self.table.texts = texts.as_ptr();
        self.table.pixels = self.pixels.as_ptr();
        // SAFETY: the host's pen, which lives as long as the call that `self` cannot outlive. The table and
        // all it points to live until the function returns.
        unsafe { (self.pen.add)(self.pen.drawing, &raw const self.table) };
    }
}

impl Drop for Widget<'_> {
    fn drop(&mut self) {
        if !self.done {
            self.add();
        }
    }
}

/// Converts a text to a C string, up to its first NUL.
pub(super) fn c(text: &str) -> CString {
    let text = text.split('\0').next().unwrap_or_default();
    CString::new(text).unwrap_or_default()
}
