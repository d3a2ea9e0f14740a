//! The interface of an observer of every transaction of the rules in a running application, which checks them
//! against rules of its own. It changes nothing.

use jde_core::{Effect, Hierarchy, Nanos, SchemaId};

/// Receives every transaction, in order, under the application's lock. It must return soon and must not call
/// the application.
pub trait TransactionObserver: Send {
    /// Receives a transaction whose effects have just been carried out.
    fn on_transaction(&mut self, transaction: &ObservedTransaction<'_>);
}

/// A transaction of the rules.
#[derive(Debug)]
pub struct ObservedTransaction<'a> {
    /// When it began.
    pub began: Nanos,
    /// When all its effects had been carried out; in lockstep the same time.
    pub done: Nanos,
    /// The input of the rules.
    pub step: TransactionInput,
    /// The effects, in order.
    pub effects: &'a [Effect],
    /// The rules after the transaction.
    pub hierarchy: &'a Hierarchy,
}

/// The input of the rules, as far as the effects do not show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransactionInput {
    /// An iteration began.
    IterationBegan(SchemaId),
    /// An iteration ended in any way, or is no longer expected.
    IterationEnded(SchemaId),
    /// The application ends.
    Shutdown,
    /// Any other input.
    Other,
}
