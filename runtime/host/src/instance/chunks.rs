//! Chunks that an instance imports (R7): those of before the end of its authority are void. It reads none itself.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use jde_abi::describe::{Kind, Role, Schema};
use jde_core::Nanos;
use jde_types::{Chunk, Value};

/// When the authority of an instance ended last, plus 1 ns; 0 if it never did.
#[derive(Debug, Default)]
pub(crate) struct AuthorityEnd(AtomicU64);

/// The chunks of an instance, by port.
#[derive(Default)]
pub(crate) struct Chunks(Vec<ImportedChunk>);

struct ImportedChunk {
    port: usize,
    end: Arc<AuthorityEnd>,
    /// The end that a look before this turn has found.
    known: Nanos,
    /// The end that this turn has found. It stays the same until the turn is over (R8).
    found: Option<Nanos>,
}

impl AuthorityEnd {
    pub(crate) fn record(&self, now: Nanos) {
        self.0.store(now.saturating_add(1), Ordering::Release);
    }
}

impl Chunks {
    /// The imports of chunks of a motor schema. Others have no authority.
    pub(crate) fn of(schema: &Schema, end: &Arc<AuthorityEnd>) -> Self {
        let chunk = Chunk::describe();
        let ports = schema.ports.iter().enumerate().filter(|(_, port)| {
            schema.kind == Kind::Motor && matches!(port.role, Role::Import) && port.value_type.same_as(&chunk)
        });
        let imports = ports.map(|(port, _)| ImportedChunk {
            port,
            end: Arc::clone(end),
            known: 0,
            found: None,
        });
        Self(imports.collect())
    }

    /// Whether a port imports chunks.
    pub(super) fn contains(&self, port: usize) -> bool {
        self.0.iter().any(|imported| imported.port == port)
    }

    /// Whether a value of that time is void: it is of before the end of the authority, or this turn is the first to look
    /// since then. What the instance made of older ones is void too, and so it learns of it.
    pub(super) fn is_void(&mut self, port: usize, time: Nanos) -> bool {
        let imported = self.0.iter_mut().find(|imported| imported.port == port);
        imported.is_some_and(|imported| {
            let now = || imported.end.0.load(Ordering::Acquire);
            let end = *imported.found.get_or_insert_with(now);
            end != imported.known || time < end
        })
    }

    /// Ends a turn.
    pub(super) fn release(&mut self) {
        for imported in &mut self.0 {
            imported.known = imported.found.take().unwrap_or(imported.known);
        }
    }
}
