//! The judgement of commands by a guard (R18): a function of the plugin without an instance. It refuses and
//! reports nothing; the host does.

#![allow(unsafe_code)]

use jde_abi::{guard, raw};
use jde_core::Nanos;

use super::{AlignedBytes, SchemaFunctions, forked};

/// The function of a guard that judges commands. Any number of threads may call it at once.
#[derive(Clone, Copy)]
pub struct Judge(raw::Guard);

/// What a guard says of a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Judgement {
    /// It may take effect.
    Accepted,
    /// This one takes effect instead, for the reason.
    Limited(AlignedBytes, String),
    /// It must not take effect, for the reason.
    Refused(String),
}

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
    /// # Safety
    /// `state` and `command` are values of the types that the guard states, aligned for them.
    pub unsafe fn judge(&self, state: &[u8], age: Nanos, command: &[u8]) -> Judgement {
        let judge = self.0.judge.expect("a guard without this function is refused");
        let mut limited = AlignedBytes::new(command);
        let mut judgement = raw::Judgement {
            command: limited.bytes_mut().as_mut_ptr().cast(),
            ..raw::Judgement::REFUSED
        };
        // SAFETY: the caller's values, and room for the judgement, which states its size, and for a command.
        let status = forked::call(|| unsafe {
            judge(
                state.as_ptr().cast(),
                age,
                command.as_ptr().cast(),
                &raw mut judgement,
            )
        });
        match (status, judgement.accepted) {
            (raw::OK, 1) => Judgement::Accepted,
            (raw::OK, raw::LIMITED) => Judgement::Limited(limited, judgement.reason()),
            (raw::OK, _) => Judgement::Refused(judgement.reason()),
            (_, _) => Judgement::Refused(format!("the judgement failed: {}", judgement.reason())),
        }
    }
}
