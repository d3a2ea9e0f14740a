//! Whoever watches every transaction of the rules in a running application, to judge it by rules of its own. It changes nothing.

use jde_core::{Effect, Hierarchy, Nanos, SchemaId};

/// Sees every transaction, in order, under the application's lock: it must return soon and must not call the application.
pub trait Witness: Send {
    /// Sees one whose effects were carried out just now.
    fn see(&mut self, seen: &Seen<'_>);
}

/// A transaction of the rules.
#[derive(Debug)]
pub struct Seen<'a> {
    /// When it began.
    pub began: Nanos,
    /// When all that follows from it was carried out; in lockstep the same.
    pub done: Nanos,
    /// What the rules were told.
    pub step: Step,
    /// What follows from it, in order.
    pub effects: &'a [Effect],
    /// The rules as they are since.
    pub hierarchy: &'a Hierarchy,
}

/// What the rules were told, as far as their effects do not say it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// An iteration began.
    Began(SchemaId),
    /// An iteration ended, in whatever way, or is not waited for any more.
    Ended(SchemaId),
    /// The application ends.
    Over,
    /// Anything else.
    Told,
}
