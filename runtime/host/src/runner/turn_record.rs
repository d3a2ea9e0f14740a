//! The record of the turn under way: its calls, what it reported to the rules, and the values it used.

use std::sync::Arc;

use jde_core::{Nanos, SchemaId};
use jde_records::turn::{Call, Exchange, Moment, Permission, Turn, TurnKind};

use crate::instance::{Instance, PortWrite, TurnOverflow};
use crate::journal::Journal;

/// The record of the turn under way.
pub(super) struct TurnRecord {
    pub(super) turn: Turn,
    overflow: TurnOverflow,
    /// Receives the turns, if they are recorded.
    journal: Option<Arc<Journal>>,
    /// Whether the calls matter: turns are recorded, or repeated.
    has_calls: bool,
}

impl TurnRecord {
    pub(super) fn new(schema: SchemaId, journal: Option<Arc<Journal>>, is_replayed: bool) -> Self {
        Self {
            has_calls: journal.is_some() || is_replayed,
            turn: Turn::new(TurnKind::Cycled(None), schema),
            overflow: TurnOverflow::default(),
            journal,
        }
    }

    /// Starts the record of a turn of that kind.
    pub(super) fn begin(&mut self, kind: TurnKind) -> &mut Turn {
        // A turn is large, and most runs record none.
        if self.journal.is_some() {
            self.turn = Turn::new(kind, SchemaId(self.turn.schema));
            self.overflow.ports.clear();
        }
        &mut self.turn
    }

    /// Adds the last call of the instance: its check, or the only call of the turn.
    pub(super) fn add_look(&mut self, instance: &Instance) {
        if self.has_calls {
            self.turn.looked = instance.copy_last_call(&mut self.turn, &mut self.overflow);
        }
    }

    /// Adds the last call of the instance, an iteration.
    pub(super) fn add_iteration(&mut self, instance: &Instance) {
        if self.has_calls {
            self.turn.acted = instance.copy_last_call(&mut self.turn, &mut self.overflow);
        }
    }

    /// Adds the last call of the instance: its check, and then its iteration if `iterated`, which began for the
    /// rules before the check.
    pub(super) fn add_combined(&mut self, instance: &Instance, begun: Moment, iterated: bool) {
        self.turn.begun = begun;
        self.turn.set_kind(TurnKind::Cycled(Some(Permission::Any)));
        if self.has_calls {
            let call = instance.copy_last_call(&mut self.turn, &mut self.overflow);
            let Moment { order, time } = begun;
            self.turn.looked = Call {
                after: order,
                time,
                ..call
            };
            if iterated {
                self.turn.acted = call;
            }
        }
    }

    /// Ends the turn, and forwards it if a step of it was taken.
    pub(super) fn finish(&mut self) {
        if let Some(journal) = &self.journal {
            if !self.turn.is_empty() {
                journal.forward_with_ports(&self.turn, &self.overflow.ports);
            }
            self.begin(TurnKind::Cycled(None));
        }
    }

    /// Forwards that another build takes the turns from now on.
    pub(super) fn forward_swap(&self, exchange: Exchange, now: Nanos) {
        if let Some(journal) = &self.journal {
            let mut turn = Turn::new(TurnKind::Reloaded(exchange), SchemaId(self.turn.schema));
            turn.looked = Call {
                after: journal.last(),
                time: now,
                clock: now,
            };
            journal.forward(&turn);
        }
    }

    /// Returns the writes since the last call of this function, in a replay.
    pub(super) fn take_writes(&mut self) -> Vec<PortWrite> {
        std::mem::take(&mut self.overflow.writes)
    }
}
