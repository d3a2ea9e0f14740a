//! How long a child is awake without being READY.

use jde_schema::prelude::*;

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wait {
    /// When it began, or was last of no account.
    since: Duration,
}

impl Wait {
    pub(crate) fn begin(now: Duration) -> Self {
        Self { since: now }
    }

    /// Returns whether it has lasted longer than `patience`. Time does not count while the child is READY, or sleeps
    /// because another task or an operator wants it so, or while `suffices`.
    pub(crate) fn ends(&mut self, cx: &Context, child: &Child, suffices: bool, patience: Duration) -> bool {
        let is_missed = child
            .status(cx)
            .is_some_and(|status| status.faulted || status.state == State::Checking);
        if suffices || !is_missed {
            *self = Self::begin(cx.now());
        }
        cx.now().saturating_sub(self.since) > patience
    }
}
