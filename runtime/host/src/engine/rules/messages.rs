//! What transactions have to say. It is collected under the rules' lock and logged once the lock is free: a log may
//! wait, fail or panic.

use jde_core::{GroupId, Nanos, SchemaId, State};

use super::Rules;

/// What a transaction has to say.
pub(super) enum Message {
    /// A takeover was longer than its contract allows.
    Late {
        group: GroupId,
        winner: SchemaId,
        latency: Nanos,
        allowed: Nanos,
    },
    /// A schema changed its state.
    Changed { id: SchemaId, from: State, to: State },
}

impl Rules {
    /// Logs messages. The caller does not hold the lock.
    pub(super) fn log(&self, messages: Vec<Message>) {
        let name = |id: SchemaId| &*self.application.instances[id].name;
        for message in messages {
            match message {
                Message::Late {
                    group,
                    winner,
                    latency,
                    allowed,
                } => tracing::warn!(
                    group = self.application.groups[group].name,
                    winner = name(winner),
                    "took over in {:.1} ms, and its contract allows {:.1} ms",
                    latency as f64 / 1e6,
                    allowed as f64 / 1e6
                ),
                Message::Changed { id, from, to } => {
                    tracing::trace!(target: "jde::state", schema = name(id), ?from, ?to);
                }
            }
        }
    }
}
