//! An operator's hold that lasts as long as its client. The client renews it, and the application ends it
//! when renewals stop.

use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use parking_lot::Mutex;

use super::Remote;
use crate::Error;
use crate::folder::new_id;
use crate::message::{Action, Request};

/// A hold; dropping it ends it.
pub struct Hold {
    end: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
    lost: Arc<Mutex<Option<String>>>,
    losses: String,
}

impl Hold {
    pub(super) fn begin(remote: Remote, request: &Request, lease: Duration) -> Result<Self, Error> {
        let lease_ms = u64::try_from(lease.as_millis()).unwrap_or(u64::MAX);
        let schema = request.action.schema().to_owned();
        // The name is unique to this hold, so that the hold and actions under the operator's plain name do
        // not undo each other.
        let by = format!("{} (lease {:.6})", request.by, new_id()?);
        let leased = |action: Action, lease_ms: Option<u64>| Request {
            by: by.clone(),
            action,
            lease_ms,
        };
        let mut renewed = Instant::now();
        let losses = remote.operate_reporting(&leased(request.action.clone(), Some(lease_ms)))?;
        let renew = leased(
            Action::Renew {
                schema: schema.clone(),
            },
            Some(lease_ms),
        );
        let let_go = leased(Action::LetGo { schema }, None);
        let (end, ended) = channel::<()>();
        let lost = Arc::new(Mutex::new(None));
        let reason = Arc::clone(&lost);
        let renew_until_ended = move || {
            // Two renewals may fail before the lease expires.
            while let Err(RecvTimeoutError::Timeout) = ended.recv_timeout(lease / 3) {
                let sent = Instant::now();
                match remote.operate(&renew) {
                    Ok(()) => renewed = sent,
                    Err(Error::Refused { .. }) if renewed.elapsed() > lease => {
                        *reason.lock() = Some(late_renewal(renewed.elapsed(), lease));
                        break;
                    }
                    Err(error @ (Error::Refused { .. } | Error::Disconnected(_))) => {
                        *reason.lock() = Some(error.to_string());
                        break;
                    }
                    Err(error) => tracing::warn!("a hold was not renewed: {error}"),
                }
            }
            if let Err(error) = remote.operate(&let_go) {
                tracing::warn!("a hold was not released and ends when its lease expires: {error}");
            }
        };
        let thread = std::thread::Builder::new()
            .name("link-hold".to_owned())
            .spawn(renew_until_ended)
            .map_err(Error::Thread)?;
        Ok(Self {
            end: Some(end),
            thread: Some(thread),
            lost,
            losses,
        })
    }

    /// What awake schemas lose by it: "goon loses its laser"; empty if nothing.
    #[must_use]
    pub fn losses(&self) -> &str {
        &self.losses
    }

    /// Why the hold ended before it was dropped, if it did.
    #[must_use]
    pub fn lost(&self) -> Option<String> {
        self.lost.lock().clone()
    }
}

/// Describes a lease that expired before its renewal arrived.
fn late_renewal(since: Duration, lease: Duration) -> String {
    format!(
        "its renewals came too late: the last one that arrived was sent {:.1} s ago, and the lease allows {:.1} s; this \
         machine or the network is too busy, so free it and repeat the command, or act without a time, which needs no \
         renewal",
        since.as_secs_f64(),
        lease.as_secs_f64()
    )
}

/// Ends the hold and waits for the application's confirmation.
impl Drop for Hold {
    fn drop(&mut self) {
        drop(self.end.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn r14_a_late_renewal_is_described_with_its_delay_and_its_lease() {
        let text = late_renewal(Duration::from_millis(2600), Duration::from_secs(1));
        let expected = ["sent 2.6 s ago", "allows 1.0 s"];
        assert!(expected.iter().all(|part| text.contains(part)), "{text}");
    }
}
