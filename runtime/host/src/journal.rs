//! Numbers the transactions that turns refer to, and forwards turns to the recorder.

use std::sync::atomic::{AtomicU64, Ordering};

use jde_core::SchemaId;
use jde_records::turn::{INPUTS, OnTurn, Turn, TurnKind};

/// Numbers the transactions and forwards turns.
pub(crate) struct Journal {
    last: AtomicU64,
    on_turn: OnTurn,
}

impl Journal {
    pub(crate) fn new(on_turn: OnTurn) -> Self {
        Self {
            last: AtomicU64::new(0),
            on_turn,
        }
    }

    /// Returns the number of the next transaction. Called under the rules' lock.
    pub(crate) fn next(&self) -> u64 {
        self.last.fetch_add(1, Ordering::AcqRel) + 1
    }

    /// Returns the number of the last transaction.
    pub(crate) fn last(&self) -> u64 {
        self.last.load(Ordering::Acquire)
    }

    pub(crate) fn forward(&self, turn: &Turn) {
        (self.on_turn)(turn);
    }

    /// Forwards a turn of a schema, preceded by turns of kind [`TurnKind::MorePorts`] for the ports that do not
    /// fit into it.
    pub(crate) fn forward_with_ports(&self, turn: &Turn, more: &[u32]) {
        for (place, ports) in more.chunks(INPUTS).enumerate() {
            let first = (INPUTS * (place + 1)) as u64;
            let mut next = Turn::new(TurnKind::MorePorts { first }, SchemaId(turn.schema));
            // Not a step, but every recorded message needs a time.
            next.checked.time = turn.time();
            next.inputs.resize(ports.len()).copy_from_slice(ports);
            self.forward(&next);
        }
        self.forward(turn);
    }
}
