//! Loss of the display: the display, or one of its windows, can disappear while windows are open. winit
//! panics then. [`hold`] turns that panic into an error with its reason. It catches no other panic.

use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::path::{Component, Path};
use std::sync::{Arc, OnceLock};
use std::thread;

/// Runs `show`, which shows windows until they are closed.
///
/// # Errors
/// The message of a panic in winit on this thread. Other panics continue.
pub(crate) fn hold<T>(show: impl FnOnce() -> T) -> Result<T, String> {
    let reason = Arc::new(OnceLock::new());
    let (first_reason, this_thread) = (Arc::clone(&reason), thread::current().id());
    let before = Arc::new(panic::take_hook());
    let previous = Arc::clone(&before);
    panic::set_hook(Box::new(move |info| {
        let from_winit = info.location().is_some_and(|place| is_from_winit(place.file()));
        if from_winit && thread::current().id() == this_thread {
            // The first panic has the cause; later ones follow from it.
            let _ = first_reason.set(message(info));
        } else {
            previous(info);
        }
    }));
    let ended = panic::catch_unwind(AssertUnwindSafe(show));
    panic::set_hook(Box::new(move |info| before(info)));
    ended.map_err(|panic| match reason.get() {
        Some(reason) => reason.clone(),
        None => panic::resume_unwind(panic),
    })
}

/// Whether a source file belongs to winit.
fn is_from_winit(file: &str) -> bool {
    let parts = Path::new(file).components();
    parts.into_iter().any(|part| match part {
        Component::Normal(name) => name
            .to_str()
            .is_some_and(|name| name == "winit" || name.starts_with("winit-")),
        _ => false,
    })
}

fn message(info: &PanicHookInfo<'_>) -> String {
    let message = info.payload_as_str().unwrap_or("the panic has no message");
    let first = message.lines().next().unwrap_or_default();
    let unwrapped = "called `Result::unwrap()` on an `Err` value: ";
    first.strip_prefix(unwrapped).unwrap_or(first).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_panics_in_winit_become_errors() {
        assert!(is_from_winit(
            "/home/ana/.cargo/registry/src/index/winit-0.30.13/src/platform_impl/linux/x11/window.rs"
        ));
        assert!(is_from_winit("vendor/winit/src/event_loop.rs"));
        assert!(!is_from_winit("programs/view/src/app.rs"));
        assert!(!is_from_winit("/registry/egui-winit-0.37.0/src/lib.rs"));
        assert_eq!(hold(|| 7), Ok(7));
        let panic = panic::catch_unwind(|| hold(|| panic!("other"))).expect_err("the panic continues");
        assert_eq!(panic.downcast_ref::<&str>(), Some(&"other"));
    }
}
