//! The host's side of the ability to judge commands (R18): its table, and the reasons of judgements. Calls no
//! schema.

#![allow(unsafe_code)]

use core::ffi::{CStr, c_char};
use core::ptr::null_mut;

use crate::{raw, table};

/// Returns the table of a schema type's guard, if it has one.
///
/// # Errors
/// A message that states what is wrong with its table.
///
/// # Safety
/// `schema` follows the rules of [`raw`].
pub unsafe fn of(schema: &raw::Schema) -> Result<Option<raw::Guard>, String> {
    // SAFETY: the caller's.
    let guard = unsafe { table::ability::<raw::Guard>(schema, raw::ABILITY_GUARD) };
    match guard.map_err(|unreadable| unreadable.to_string())? {
        Some(raw::Guard { judge: None, .. }) => Err(String::from("its `judge` is null")),
        guard => Ok(guard),
    }
}

impl raw::Judgement {
    /// The judgement before the call.
    pub const REFUSED: Self = Self {
        size: size_of::<Self>() as u32,
        accepted: 0,
        reason: [0; 128],
        command: null_mut(),
    };

    /// Returns the reason of a refusal or a limit, in words.
    #[must_use]
    pub fn reason(&self) -> String {
        let bytes = self.reason.map(|byte| c_char::to_ne_bytes(byte)[0]);
        let text = CStr::from_bytes_until_nul(&bytes).map_or(&bytes[..], CStr::to_bytes);
        match String::from_utf8_lossy(text) {
            reason if reason.is_empty() => String::from("the guard gave no reason"),
            reason => reason.into_owned(),
        }
    }
}
