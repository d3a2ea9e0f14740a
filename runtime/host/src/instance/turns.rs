//! The extension by which an instance requests turns from its own threads (R12).

#![allow(unsafe_code)]

use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null_mut;
use std::sync::{Arc, Weak};

use jde_abi::host::Host as _;
use jde_abi::raw::{Context, Turns};
use jde_core::SchemaId;

use super::call::CallContext;
use crate::engine::Engine;

pub(super) static TURNS: Turns = Turns {
    size: size_of::<Turns>() as u32,
    reserved: 0,
    open,
    request,
    close,
};

/// What a handle points to.
struct Handle {
    /// The application may end before the thread that has the handle.
    engine: Weak<Engine>,
    number: SchemaId,
}

unsafe extern "C" fn open(context: *mut Context) -> *mut c_void {
    // SAFETY: the plugin gives the context of this call.
    unsafe {
        CallContext::request(context, null_mut(), |call| {
            let handle = Handle {
                engine: Arc::downgrade(call.engine),
                number: call.number,
            };
            Box::into_raw(Box::new(handle)).cast()
        })
    }
}

unsafe extern "C" fn request(handle: *const c_void) {
    // SAFETY: the plugin gives a handle that it has not closed.
    let handle = unsafe { &*handle.cast::<Handle>() };
    // The application may end here, so its end is inside, too. A panic can no longer be reported then.
    let _ = catch_unwind(AssertUnwindSafe(|| {
        if let Some(engine) = handle.engine.upgrade() {
            engine.request_turn(handle.number);
        }
    }));
}

unsafe extern "C" fn close(handle: *mut c_void) {
    // SAFETY: the plugin gives a handle of `open`, once.
    drop(unsafe { Box::from_raw(handle.cast::<Handle>()) });
}
