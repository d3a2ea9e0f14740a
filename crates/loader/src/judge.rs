//! The judgement of commands by a guard (R18): a function of the plugin without an instance. It refuses and
//! reports nothing; the host does.

#![allow(unsafe_code)]

use jde_abi::{guard, raw};
use jde_core::Nanos;

use super::SchemaFunctions;

/// The function of a guard that judges commands. Any number of threads may call it at once.
#[derive(Clone, Copy)]
pub struct Judge(raw::Guard);

// SAFETY: a plugin's tables are immutable and live until the process ends, and the ABI lets any thread call
// this function.
unsafe impl Send for Judge {}
// SAFETY: as above.
unsafe impl Sync for Judge {}

impl Judge {
    /// Returns the function of a type of schema, if it is a guard.
    #[must_use]
    pub fn of(table: &SchemaFunctions) -> Option<Self> {
        // SAFETY: the table was checked when its plugin was loaded.
        unsafe { guard::of(table) }.ok().flatten().map(Self)
    }

    /// Judges a command by a state of that age.
    ///
    /// # Errors
    /// The reason of a refusal, in words.
    ///
    /// # Safety
    /// `state` and `command` are values of the types that the guard states, aligned for them.
    pub unsafe fn judge(&self, state: &[u8], age: Nanos, command: &[u8]) -> Result<(), String> {
        let judge = self.0.judge.expect("a guard without this function is refused");
        let mut judgement = raw::Judgement::REFUSED;
        // SAFETY: the caller's values, and room for the judgement, which states its size.
        let status = unsafe {
            judge(
                state.as_ptr().cast(),
                age,
                command.as_ptr().cast(),
                &raw mut judgement,
            )
        };
        match (status, judgement.accepted) {
            (raw::OK, 1) => Ok(()),
            (raw::OK, _) => Err(judgement.reason()),
            (_, _) => Err(format!("the judgement failed: {}", judgement.reason())),
        }
    }
}
