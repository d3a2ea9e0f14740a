//! The lease of a program on what it holds as an operator (R14): a program that hangs holds nothing any more.

use std::collections::BTreeSet;

use jde_core::{Nanos, SchemaId};
use jde_host::OperatorHandle;

/// A lease, and the schemas on which the program acted.
#[derive(Default)]
pub(crate) struct Lease {
    until: Option<Nanos>,
    held: BTreeSet<SchemaId>,
}

impl Lease {
    /// Begins or renews the lease; without a time, actions last until they are released.
    pub(crate) fn renew(&mut self, until: Option<Nanos>) {
        self.until = until;
    }

    /// Whether what the program does now is under a lease.
    pub(crate) fn is_set(&self) -> bool {
        self.until.is_some()
    }

    /// Notes an action on a schema.
    pub(crate) fn hold(&mut self, schema: SchemaId) {
        self.held.insert(schema);
    }

    /// Notes that nothing is held on a schema any more.
    pub(crate) fn release(&mut self, schema: SchemaId) {
        self.held.remove(&schema);
    }

    /// When the lease ends, if anything is held under one.
    pub(crate) fn end(&self) -> Option<Nanos> {
        self.until.filter(|_| !self.held.is_empty())
    }

    /// Undoes what the operator holds if the lease has ended. Actions after that last, until the lease is renewed.
    pub(crate) fn check(&mut self, now: Nanos, operator: &OperatorHandle) {
        if self.until.is_some_and(|until| until <= now) {
            for schema in std::mem::take(&mut self.held) {
                // It is refused once the application has ended, when nothing is held.
                let _ = operator.release_own(schema);
            }
            self.until = None;
        }
    }
}
