//! Catches panics, with where they were raised. A panic within a drop while another unwinds still ends the process: that is
//! Rust's, not ours.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::Once;

thread_local! {
    /// Whether this thread is inside [`guard`].
    static GUARDED: Cell<bool> = const { Cell::new(false) };
    /// What the last panic inside it said.
    static SAID: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Calls `call`; `Err` with the words and the place of a panic.
///
/// What `call` changes may be left half-changed by a panic: the host puts the schema to sleep and says that it is Faulted.
pub(crate) fn guard<T>(call: impl FnOnce() -> T) -> Result<T, String> {
    listen();
    let outer = GUARDED.replace(true);
    let result = panic::catch_unwind(AssertUnwindSafe(call)).map_err(|payload| {
        let said = SAID
            .take()
            .unwrap_or_else(|| format!("panicked: {}", words(&*payload)));
        // The payload is the author's, and so is its drop, which may panic again; that one's is let go of.
        if let Err(again) = panic::catch_unwind(AssertUnwindSafe(|| drop(payload))) {
            std::mem::forget(again);
            SAID.take();
        }
        said
    });
    GUARDED.set(outer);
    result
}

/// Keeps the words of panics that are caught here off the standard error, and leaves others as they were. Hooks belong to a
/// copy of the standard library, so a plugin's concern only the plugin.
fn listen() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |info: &PanicHookInfo<'_>| {
            if !GUARDED.get() {
                return previous(info);
            }
            let place = info.location().map_or_else(String::new, |place| {
                format!(" at {}:{}", place.file(), place.line())
            });
            let said = format!("panicked{place}: {}", words(info.payload()));
            // Only a thread that is ending has lost it; then the payload's words must do.
            let _ = SAID.try_with(|last| last.replace(Some(said)));
        }));
    });
}

fn words(payload: &dyn Any) -> &str {
    if let Some(text) = payload.downcast_ref::<&str>() {
        text
    } else if let Some(text) = payload.downcast_ref::<String>() {
        text
    } else {
        "without words"
    }
}
