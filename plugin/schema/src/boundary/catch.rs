//! Catches panics and records where they occurred. A panic in a drop during another panic's unwinding still
//! ends the process: Rust requires it.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::Once;

thread_local! {
    /// Whether this thread is inside [`catch`].
    static CATCHING: Cell<bool> = const { Cell::new(false) };
    /// The message of the last panic inside it.
    static PANIC_MESSAGE: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Calls `call`. `Err` contains the message and the place of a panic.
///
/// A panic may leave incomplete what `call` was changing. The host therefore puts the schema to sleep and
/// marks it Faulted.
pub(crate) fn catch<T>(call: impl FnOnce() -> T) -> Result<T, String> {
    install_hook();
    let outer = CATCHING.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(call)).map_err(|payload| {
        let message = PANIC_MESSAGE
            .take()
            .unwrap_or_else(|| format!("panicked: {}", payload_text(&*payload)));
        // The author's code defines the drop of the payload, so it may panic too. The payload of that second
        // panic is leaked.
        if let Err(again) = panic::catch_unwind(AssertUnwindSafe(|| drop(payload))) {
            std::mem::forget(again);
            PANIC_MESSAGE.take();
        }
        message
    });
    CATCHING.set(outer);
    result
}

/// Installs a hook that keeps panics that [`catch`] catches off the standard error and passes all others to the previous
/// hook. Each copy of the standard library has its own hook, so a plugin's hook affects only that plugin.
fn install_hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |info: &PanicHookInfo<'_>| {
            if !CATCHING.get() {
                return previous(info);
            }
            let place = info.location().map_or_else(String::new, |place| {
                format!(" at {}:{}", place.file(), place.line())
            });
            let message = format!("panicked{place}: {}", payload_text(info.payload()));
            // This fails only in a thread that is ending. The message is then that of the payload, without
            // the place.
            let _ = PANIC_MESSAGE.try_with(|last| last.replace(Some(message)));
        }));
    });
}

fn payload_text(payload: &dyn Any) -> &str {
    if let Some(text) = payload.downcast_ref::<&str>() {
        text
    } else if let Some(text) = payload.downcast_ref::<String>() {
        text
    } else {
        "without words"
    }
}
