//! The tables of the ability [`ABILITY_STATE`]: a schema passes its memory to another build of itself, which
//! continues from it.
//!
//! The memory is a number of bytes that only the schema interprets, with a version of their format. They
//! exist at most as long as the process and are never written to a file, so numbers may be in the machine's
//! own byte order.

use core::ffi::c_void;

use super::Context;

/// The id of the ability, whose table is a [`State`]. It and all that belongs to it exist since minor version
/// 3.
pub const ABILITY_STATE: &str = "jde.state";

/// The largest number of bytes that a schema may save.
pub const STATE_MOST: u64 = 16_777_216;

/// The table that [`super::Schema::ability`] returns for [`ABILITY_STATE`].
#[repr(C)]
#[derive(Clone, Copy)]
pub struct State {
    /// Bytes of this table.
    pub size: u32,
    /// The version of the format that `save` writes, in the author's own numbering.
    pub version: u32,
    /// Saves the memory of the instance. Called between two iterations, or while it is SLEPT. It must change
    /// nothing: any call that writes a variable, wakes or puts to sleep is [`super::REFUSED`]. After an error
    /// the instance continues as before.
    pub save: Option<unsafe extern "C" fn(*mut c_void, *mut Context, *const Saver) -> i32>,
    /// Restores what another instance of this type, perhaps of another build, saved in that version. Called
    /// after `create`, and after `awake` if the schema is awake, before the first check or iteration. As for
    /// `save`, it must change nothing else. After an error the other instance continues, and this one ends.
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

/// The memory under construction; opaque to the plugin.
#[repr(C)]
pub struct Saving {
    _opaque: [u8; 0],
}

/// The functions with which a plugin saves. Valid only until its [`State::save`] returns, and on its thread.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Saver {
    /// Bytes of this table.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// The first argument of the function below.
    pub saving: *mut Saving,
    /// Appends bytes, which are copied. [`super::BAD_ARGUMENT`] beyond [`STATE_MOST`]; then nothing of the
    /// memory is kept.
    pub write: unsafe extern "C" fn(*mut Saving, bytes: *const c_void, length: u64) -> i32,
}
