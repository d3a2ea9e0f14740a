//! The interface of an observer of every transaction of the rules in a running application, which checks them
//! against rules of its own. It changes nothing.

use jde_core::{Effect, Hierarchy, Nanos, SchemaId};

/// Receives every transaction, in order, under the application's lock. It must return soon and must not call
/// the application.
pub trait Witness: Send {
    /// Receives a transaction whose effects have just been carried out.
    fn see(&mut self, seen: &Seen<'_>);
}

/// A transaction of the rules.
#[derive(Debug)]
pub struct Seen<'a> {
    /// When it began.
    pub began: Nanos,
    /// When all its effects had been carried out; in lockstep the same time.
    pub done: Nanos,
    /// The input of the rules.
    pub step: Step,
    /// The effects, in order.
    pub effects: &'a [Effect],
    /// The rules after the transaction.
    pub hierarchy: &'a Hierarchy,
}

/// The input of the rules, as far as the effects do not show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// An iteration began.
    Began(SchemaId),
    /// An iteration ended in any way, or is no longer waited for.
    Ended(SchemaId),
    /// The application ends.
    Over,
    /// Any other input.
    Told,
}
