//! What an author writes: the calls that the host makes, one at a time, each on whatever thread it likes.

#![allow(unsafe_code)]

use jde_abi::raw;

use crate::context::Context;
use crate::error::Result;
use crate::level::{Level, Verdict};

/// A task that runs by iterations. Only [`iterate`](Self::iterate) must be written.
///
/// The host keeps one value per instance and calls it in this order: `awake`, then `check` and `iterate` as often as it takes,
/// then `sleep`, then `awake` again; the value keeps its memory meanwhile. Calls of one instance never overlap. A call that
/// returns an error or panics makes the schema Faulted: the host puts it to sleep, selects again in its level, and wakes it
/// as its restart policy says.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not say what it does",
    note = "write `impl Schema for {Self}`"
)]
pub trait Schema: Describe {
    /// It leaves SLEPT.
    ///
    /// # Errors
    /// Whatever makes it unable to run: it becomes Faulted.
    fn awake(&mut self, cx: &Context) -> Result {
        let _ = cx;
        Ok(())
    }

    /// Whether the precondition of a motor schema holds at present; it always does by default. Others are not asked.
    ///
    /// # Errors
    /// Whatever makes it unable to tell: it becomes Faulted. A value that is not there yet is no error.
    fn check(&mut self, cx: &Context) -> Result<Precondition> {
        let _ = cx;
        Ok(true.into())
    }

    /// One iteration, as WINNER; must return within the budget.
    ///
    /// # Errors
    /// Whatever makes it unable to go on: it becomes Faulted.
    fn iterate(&mut self, cx: &Context) -> Result;

    /// It goes to SLEPT. A driver stops its actuators here.
    fn sleep(&mut self, cx: &Context) {
        let _ = cx;
    }
}

/// A father's own arbitration (R4); a motor schema that has this is asked when its policy is "father".
pub trait Arbitrate: Schema {
    /// Chooses among the awake children of a group on collision or absence. If it fails, or answers later than its budget, the
    /// order of priority decides.
    ///
    /// # Errors
    /// Whatever makes it unable to choose.
    fn arbitrate(&mut self, cx: &Context, level: &Level) -> Result<Verdict>;
}

/// What a schema says of itself; made by `#[derive(Describe)]`.
///
/// No safe code makes an instance but the bench, which hosts it; so no schema holds another and calls it with its own context:
///
/// ```compile_fail,E0133
/// use jde_schema::{Describe, Schema};
///
/// fn made<S: Schema>() -> S {
///     S::build()
/// }
/// ```
///
/// Nor does a modulation contradict itself: its default is within its limits, and these are in order.
///
/// ```compile_fail,E0080
/// use jde_schema::prelude::*;
///
/// #[derive(Describe)]
/// #[schema(motor, period = "1s")]
/// struct Below {
///     #[modulation(default = -1.0, min = 0.0)]
///     speed: Modulation<f64>,
/// }
///
/// impl Schema for Below {
///     fn iterate(&mut self, _: &Context) -> Result {
///         Ok(())
///     }
/// }
/// ```
///
/// ```compile_fail,E0080
/// use jde_schema::prelude::*;
///
/// #[derive(Describe)]
/// #[schema(motor, period = "1s")]
/// struct Crossed {
///     #[modulation(default = 1, min = 2, max = 0)]
///     count: Modulation<u32>,
/// }
///
/// impl Schema for Crossed {
///     fn iterate(&mut self, _: &Context) -> Result {
///         Ok(())
///     }
/// }
/// ```
///
/// # Safety
/// `TABLE` describes the ports and children of `Self`, with the types they have there, in the order of `build`; its ports are in a
/// static of this type alone, of which those that `build` makes are.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not describe itself",
    note = "put `#[derive(Describe)]` and `#[schema(...)]` on it"
)]
pub unsafe trait Describe: Sized + Send + 'static {
    /// The table of its type.
    const TABLE: raw::Schema;

    /// The table of its panel.
    #[doc(hidden)]
    const PANEL: Option<raw::Panel>;

    /// The table of its memory.
    #[doc(hidden)]
    const STATE: Option<raw::State>;

    /// The table of its inspection.
    #[doc(hidden)]
    const INSPECT: Option<raw::Inspect>;

    /// A new instance.
    ///
    /// # Safety
    /// It is called through `TABLE` alone: two of a type would share their rooms for values.
    #[doc(hidden)]
    unsafe fn build() -> Self;
}

/// The answer to a check.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precondition {
    /// Whether it holds.
    pub ready: bool,
    /// How urgent it is to win, for policies that ask; finite.
    pub urgency: f64,
}

impl Precondition {
    /// The same, this urgent.
    #[must_use]
    pub fn urgency(self, urgency: f64) -> Self {
        Self { urgency, ..self }
    }
}

impl From<bool> for Precondition {
    fn from(ready: bool) -> Self {
        Self { ready, urgency: 0.0 }
    }
}
