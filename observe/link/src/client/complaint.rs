//! Messages of an application that are not used, because they cannot be read or make no sense. The first of a
//! subscription is logged; the rest would fill the log, 20 a second.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::Error;
use crate::decode::Refused;

/// The complaints about the messages of one subscription.
pub(super) struct Complaint {
    application: String,
    count: AtomicU64,
}

impl Complaint {
    pub(super) fn about(application: &str) -> Self {
        Self {
            application: application.to_owned(),
            count: AtomicU64::new(0),
        }
    }

    /// Logs a refused message: the first, and then each whose number is a power of two.
    pub(super) fn say(&self, refused: Refused) {
        let count = self.count.fetch_add(1, Ordering::Relaxed) + 1;
        if count.is_power_of_two() {
            let error = Error::refused(&self.application, refused);
            match count {
                1 => tracing::warn!("{error}"),
                count => tracing::warn!("{error} ({count} messages so far)"),
            }
        }
    }
}
