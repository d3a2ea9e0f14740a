//! The restarts of one schema, counted under its restart policy.
//!
//! It refuses to restart: it states when a restart is due.

use crate::spec::{Nanos, Restart};

/// The times of the restarts, in order: those that still count under the policy, and possibly older ones.
#[derive(Clone, Default, PartialEq, Eq, Hash, Debug)]
pub(super) struct Restarts(Vec<Nanos>);

impl Restarts {
    pub(super) fn record(&mut self, now: Nanos) {
        self.0.push(now);
    }

    pub(super) fn forget(&mut self) {
        self.0.clear();
    }

    /// Returns how many restarts a policy still grants; `None` if it never grants one.
    pub(super) fn left(&self, policy: Restart, now: Nanos) -> Option<u32> {
        match policy {
            Restart::OnFault { limit, within, .. } => {
                let counted = self.0.iter().filter(|time| counts(**time, within, now));
                Some(limit.saturating_sub(u32::try_from(counted.count()).unwrap_or(u32::MAX)))
            }
            Restart::Never => None,
        }
    }

    /// Returns when the schema is restarted, if the policy grants one more restart. The back-off doubles with
    /// each restart that still counts.
    pub(super) fn due(&mut self, policy: Restart, now: Nanos) -> Option<Nanos> {
        let Restart::OnFault {
            backoff,
            limit,
            within,
        } = policy
        else {
            return None;
        };
        self.0.retain(|time| counts(*time, within, now));
        let counted = u32::try_from(self.0.len()).unwrap_or(u32::MAX);
        (counted < limit).then(|| {
            let doubled = 1u64.checked_shl(counted).unwrap_or(Nanos::MAX);
            now.saturating_add(backoff.saturating_mul(doubled))
        })
    }
}

/// Whether a restart at `time` still counts at `now`.
fn counts(time: Nanos, within: Nanos, now: Nanos) -> bool {
    now.saturating_sub(time) < within
}
