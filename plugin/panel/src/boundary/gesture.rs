//! Converts gestures to tables of the ABI, and back.

use std::ffi::CString;

use jde_abi::raw;

use super::{codes, table, text};
use crate::{Broken, Gesture, Touch};

/// Lends a gesture of the user `by` to `call`, as the table that a plugin reads, until `call` returns.
pub fn lend_gesture<R>(by: &str, gesture: &Gesture, call: impl FnOnce(*const raw::Gesture) -> R) -> R {
    let key = match &gesture.touch {
        Touch::Key { key, .. } => key,
        Touch::Pressed
        | Touch::Toggled(_)
        | Touch::Moved(_)
        | Touch::Chose(_)
        | Touch::Clicked { .. }
        | Touch::Dragged { .. } => "",
    };
    let [widget, by, key] = [&gesture.widget, by, key].map(to_c_string);
    let mut table = raw::Gesture {
        size: size_of::<raw::Gesture>() as u32,
        kind: 0,
        widget: widget.as_ptr(),
        by: by.as_ptr(),
        key: key.as_ptr(),
        from: [0.0; 3],
        at: [0.0; 3],
        value: 0.0,
        number: 0,
        button: 0,
        flags: 0,
        reserved: 0,
    };
    match &gesture.touch {
        Touch::Pressed => table.kind = raw::TOUCH_PRESSED,
        Touch::Toggled(on) => (table.kind, table.number) = (raw::TOUCH_TOGGLED, u32::from(*on)),
        Touch::Moved(to) => (table.kind, table.value) = (raw::TOUCH_MOVED, *to),
        Touch::Chose(place) => (table.kind, table.number) = (raw::TOUCH_CHOSE, *place),
        Touch::Clicked { at, button } => {
            (table.kind, table.at) = (raw::TOUCH_CLICKED, *at);
            table.button = codes::button_code(*button);
        }
        Touch::Dragged {
            from,
            to,
            button,
            ended,
        } => {
            (table.kind, table.from, table.at) = (raw::TOUCH_DRAGGED, *from, *to);
            table.button = codes::button_code(*button);
            table.flags = if *ended { raw::DRAG_ENDED } else { 0 };
        }
        Touch::Key { down, .. } => (table.kind, table.number) = (raw::TOUCH_KEY, u32::from(*down)),
    }
    call(&raw const table)
}

/// Reads a gesture and its user from their table. Returns `None` for an unknown kind or button, which a later
/// version of the ABI may have added.
///
/// # Errors
/// It is not such a table, or a text in it is not UTF-8.
///
/// # Safety
/// `gesture` is null or a table that follows the rules of `raw`.
pub unsafe fn read_gesture(gesture: *const raw::Gesture) -> Result<Option<(String, Gesture)>, Broken> {
    // SAFETY: the caller's contract.
    let table = unsafe { table("a gesture", gesture) }?;
    // SAFETY: as above.
    let [widget, by, key] =
        [table.widget, table.by, table.key].map(|pointer| unsafe { text("a gesture", pointer) });
    let (widget, by, key) = (widget?, by?, key?);
    let Some(touch) = touch(&table, key) else {
        return Ok(None);
    };
    Ok(Some((by, Gesture { widget, touch })))
}

/// Returns the kind of the gesture, if it is known.
fn touch(table: &raw::Gesture, key: String) -> Option<Touch> {
    // Only gestures with a button read the button's number; later versions may use it in others.
    let button = || codes::button(table.button);
    Some(match table.kind {
        raw::TOUCH_PRESSED => Touch::Pressed,
        raw::TOUCH_TOGGLED => Touch::Toggled(table.number != 0),
        raw::TOUCH_MOVED => Touch::Moved(table.value),
        raw::TOUCH_CHOSE => Touch::Chose(table.number),
        raw::TOUCH_CLICKED => Touch::Clicked {
            at: table.at,
            button: button()?,
        },
        raw::TOUCH_DRAGGED => Touch::Dragged {
            from: table.from,
            to: table.at,
            button: button()?,
            ended: table.flags & raw::DRAG_ENDED != 0,
        },
        raw::TOUCH_KEY => Touch::Key {
            key,
            down: table.number != 0,
        },
        _ => return None,
    })
}

fn to_c_string(text: &str) -> CString {
    let text = text.split('\0').next().unwrap_or_default();
    CString::new(text).unwrap_or_default()
}
