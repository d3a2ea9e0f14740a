//! The tables of the ability [`ABILITY_STATE`]: a schema that hands what it remembers to another build of itself, which goes on
//! where it left off.
//!
//! What is saved are bytes that only the schema understands, under a version that it counts. They live as long as the process at
//! most: they are never written to a file, so numbers may be in the machine's own order.

use core::ffi::c_void;

use super::Context;

/// The id of the ability, whose table is a [`State`]. Since minor version 3, as all that belongs to it.
pub const ABILITY_STATE: &str = "jde.state";

/// Most bytes that a schema may save.
pub const STATE_MOST: u64 = 16_777_216;

/// What [`super::Schema::ability`] gives for [`ABILITY_STATE`].
#[repr(C)]
#[derive(Clone, Copy)]
pub struct State {
    /// Bytes of this table.
    pub size: u32,
    /// The version of what `save` writes, as the author counts.
    pub version: u32,
    /// Writes down what the instance remembers, between two iterations or while it is SLEPT. It changes nothing: whatever writes
    /// a variable, wakes or puts to sleep is [`super::REFUSED`]. After an error the instance goes on as it was.
    pub save: Option<unsafe extern "C" fn(*mut c_void, *mut Context, *const Saver) -> i32>,
    /// Takes over what another instance of this type saved in that version, maybe of another build: after `create`, and after
    /// `awake` if it is awake, before the first check or iteration. It changes nothing else, as `save`. An error refuses: the
    /// other instance goes on, and this one ends.
    pub restore: Option<
        unsafe extern "C" fn(
            *mut c_void,
            *mut Context,
            version: u32,
            bytes: *const c_void,
            length: u64,
        ) -> i32,
    >,
}

/// What is being saved; opaque to the plugin.
#[repr(C)]
pub struct Saving {
    _opaque: [u8; 0],
}

/// What a plugin saves with, only until its [`State::save`] returns and on its thread.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Saver {
    /// Bytes of this table.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// The first argument of the function below.
    pub saving: *mut Saving,
    /// Adds bytes behind those before; they are copied. [`super::BAD_ARGUMENT`] beyond [`STATE_MOST`], and then nothing of it is
    /// kept.
    pub write: unsafe extern "C" fn(*mut Saving, bytes: *const c_void, length: u64) -> i32,
}
