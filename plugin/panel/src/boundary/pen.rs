//! The pen: functions that a plugin calls while it draws. Each adds to one list.

use std::panic::{AssertUnwindSafe, catch_unwind};

use jde_abi::raw;

use super::shapes::{self, Drawn};
use super::{table, widgets};
use crate::limits::wrong;
use crate::{Broken, Builder, List};

/// Lends a pen to `draw` until `draw` returns. Returns its result, and the list that was drawn at `time`, in
/// nanoseconds since the application's start.
pub fn lend_pen<R>(time: u64, draw: impl FnOnce(*const raw::Pen) -> R) -> (R, Result<List, Broken>) {
    let mut builder = Builder::new();
    let drawing: *mut Builder = &raw mut builder;
    let pen = raw::Pen {
        size: size_of::<raw::Pen>() as u32,
        reserved: 0,
        drawing: drawing.cast(),
        add,
        shape,
        end,
    };
    let result = draw(&raw const pen);
    (result, builder.finish(time))
}

unsafe extern "C" fn add(drawing: *mut raw::Drawing, widget: *const raw::Widget) -> i32 {
    // SAFETY: the plugin passes the drawing of its pen and a widget.
    unsafe {
        within(drawing, |builder| {
            let item = widgets::read(&table("a widget", widget)?)?;
            builder.add(item)
        })
    }
}

unsafe extern "C" fn shape(drawing: *mut raw::Drawing, shape: *const raw::Shape) -> i32 {
    // SAFETY: the plugin passes the drawing of its pen and a shape.
    unsafe {
        within(drawing, |builder| {
            let inside = builder.inside().to_owned();
            match shapes::read(&inside, builder.holds(), &table(&inside, shape)?)? {
                Drawn::Shape(shape) => builder.shape(shape),
                Drawn::Solid(solid) => builder.solid(solid),
                Drawn::Trace(trace) => builder.trace(trace),
            }
        })
    }
}

unsafe extern "C" fn end(drawing: *mut raw::Drawing) -> i32 {
    // SAFETY: the plugin passes the drawing of its pen.
    unsafe { within(drawing, Builder::end) }
}

/// Runs one step of a drawing, unless the drawing is broken. A panic never crosses this boundary: it would
/// end the process.
///
/// # Safety
/// `drawing` is null, or belongs to a pen that is lent on this thread.
unsafe fn within(drawing: *mut raw::Drawing, step: impl FnOnce(&mut Builder) -> Result<(), Broken>) -> i32 {
    if drawing.is_null() {
        return raw::BAD_ARGUMENT;
    }
    // SAFETY: the caller's contract; nothing else uses the builder meanwhile.
    let builder = unsafe { &mut *drawing.cast::<Builder>() };
    if builder.broken().is_some() {
        return raw::BAD_ARGUMENT;
    }
    let result = catch_unwind(AssertUnwindSafe(|| step(builder)));
    match result.unwrap_or_else(|_| wrong("", "drawing it panicked, which is a fault of jde")) {
        Ok(()) => raw::OK,
        Err(reason) => {
            builder.refuse(reason);
            raw::BAD_ARGUMENT
        }
    }
}
