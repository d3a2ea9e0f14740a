//! Leases on operators' holds. A lease expires, so that a client that died or was cut off releases its holds.
//! Keeps times and carries out no action.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use crate::message::{Action, Refusal, Request};

/// The shortest and the longest lease, ms.
const MIN_LEASE_MS: u64 = 100;
const MAX_LEASE_MS: u64 = 3_600_000;
/// Most leases at once; more than operators and schemas need.
const MAX_LEASES: usize = 256;

/// The ends of all leases, by operator and schema. An action without a lease changes none: it is a hold of its own.
#[derive(Default)]
pub(super) struct Leases {
    leases: BTreeMap<(String, String), Instant>,
}

impl Leases {
    /// Refuses a request that violates the rules of leases.
    pub(super) fn check(&self, request: &Request) -> Result<(), Refusal> {
        let Some(lease) = request.lease_ms else {
            return match request.action {
                Action::Renew { .. } => Err(Refusal::new("a renewal requires `lease_ms`")),
                _ => Ok(()),
            };
        };
        match request.action {
            Action::Touch { .. } => {
                return Err(Refusal::new("a gesture takes effect once and can have no lease"));
            }
            Action::StopAll | Action::ReleaseAll | Action::Continue | Action::Step => {
                return Err(Refusal::lease_on_global());
            }
            _ => {}
        }
        if let Action::Reload { .. } = request.action {
            return Err(Refusal::new("a reload takes effect once and can have no lease"));
        }
        if !(MIN_LEASE_MS..=MAX_LEASE_MS).contains(&lease) {
            return Err(Refusal::new(format!(
                "a lease of {lease} ms is not possible; request {MIN_LEASE_MS} to {MAX_LEASE_MS} ms"
            )));
        }
        let known = self.leases.contains_key(&key(request));
        match request.action {
            Action::Renew { .. } if !known => Err(Refusal::new(format!(
                "`{}` no longer has a lease on `{}`: it expired, or somebody released the schema",
                request.by,
                request.action.schema()
            ))),
            _ if !known && self.leases.len() >= MAX_LEASES => Err(Refusal::new(format!(
                "there are already {MAX_LEASES} leases; release some"
            ))),
            _ => Ok(()),
        }
    }

    /// Records a request that was carried out.
    pub(super) fn record(&mut self, request: &Request, now: Instant) {
        match (&request.action, request.lease_ms) {
            (Action::Release { schema }, _) => self.leases.retain(|(_, leased), _| leased != schema),
            (Action::LetGo { .. }, _) => {
                self.leases.remove(&key(request));
            }
            (_, None) => {}
            (_, Some(lease)) => {
                self.leases.insert(key(request), expiry(now, lease));
            }
        }
    }

    /// Removes the expired leases and returns requests to let go.
    pub(super) fn take_expired(&mut self, now: Instant) -> Vec<Request> {
        self.leases
            .extract_if(.., |_, until| *until <= now)
            .map(|(key, _)| release_request(key))
            .collect()
    }

    /// Extends all leases by a time in which their holders could not renew them, because this process did not run.
    pub(super) fn extend(&mut self, by: Duration) {
        self.leases.values_mut().for_each(|until| *until += by);
    }

    /// Removes all leases and returns requests to let go.
    pub(super) fn take_all(&mut self) -> Vec<Request> {
        std::mem::take(&mut self.leases)
            .into_keys()
            .map(release_request)
            .collect()
    }

    /// Reinserts a lease that could not be ended now.
    pub(super) fn retry(&mut self, request: &Request, now: Instant) {
        let until = now + Duration::from_millis(MIN_LEASE_MS);
        self.leases.insert(key(request), until);
    }

    /// When the next lease expires.
    pub(super) fn next(&self) -> Option<Instant> {
        self.leases.values().min().copied()
    }
}

fn expiry(now: Instant, lease_ms: u64) -> Instant {
    now + Duration::from_millis(lease_ms.min(MAX_LEASE_MS))
}

fn key(request: &Request) -> (String, String) {
    (request.by.clone(), request.action.schema().to_owned())
}

fn release_request((by, schema): (String, String)) -> Request {
    Request {
        by,
        action: Action::LetGo { schema },
        lease_ms: Some(MIN_LEASE_MS),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(by: &str, action: Action, lease_ms: Option<u64>) -> Request {
        Request {
            by: by.to_owned(),
            action,
            lease_ms,
        }
    }

    fn play() -> Action {
        Action::Play {
            schema: "goon".to_owned(),
        }
    }

    fn renew() -> Action {
        Action::Renew {
            schema: "goon".to_owned(),
        }
    }

    #[test]
    fn r14_a_lease_ends_unless_it_is_renewed() {
        let (mut leases, start) = (Leases::default(), Instant::now());
        leases.record(&request("ana", play(), Some(1000)), start);
        assert!(leases.take_expired(start + Duration::from_millis(999)).is_empty());
        let renewal = request("ana", renew(), Some(1000));
        assert_eq!(leases.check(&renewal), Ok(()));
        leases.record(&renewal, start + Duration::from_millis(999));
        assert!(
            leases
                .take_expired(start + Duration::from_millis(1998))
                .is_empty()
        );
        let expired = leases.take_expired(start + Duration::from_millis(1999));
        assert_eq!(expired.len(), 1);
        assert_eq!(
            (expired[0].by.as_str(), expired[0].action.schema()),
            ("ana", "goon")
        );
        assert!(leases.check(&renewal).is_err(), "an expired lease is not renewed");
        assert_eq!(leases.next(), None);
    }

    #[test]
    fn r14_a_lease_does_not_end_while_its_application_does_not_run() {
        let (mut leases, start) = (Leases::default(), Instant::now());
        leases.record(&request("ana", play(), Some(1000)), start);
        leases.extend(Duration::from_secs(5));
        assert!(
            leases
                .take_expired(start + Duration::from_millis(5999))
                .is_empty()
        );
        assert_eq!(leases.take_expired(start + Duration::from_millis(6000)).len(), 1);
    }

    #[test]
    fn r14_an_action_without_a_lease_is_no_part_of_a_lease_and_a_release_ends_all() {
        let (mut leases, start) = (Leases::default(), Instant::now());
        leases.record(&request("ana", play(), Some(1000)), start);
        leases.record(&request("ben", play(), Some(1000)), start);
        let period = Action::Period {
            schema: "goon".to_owned(),
            period_s: 0.05,
        };
        leases.record(&request("ben", period, None), start);
        leases.record(&request("ana", play(), None), start);
        let expired = leases.take_expired(start + Duration::from_secs(2));
        assert!(expired.iter().all(|request| request.lease_ms.is_some()) && expired.len() == 2);
        leases.record(&request("ana", play(), Some(1000)), start);
        let release = Action::Release {
            schema: "goon".to_owned(),
        };
        leases.record(&request("eva", release, None), start);
        assert_eq!(leases.next(), None);
    }

    #[test]
    fn leases_of_invalid_length_and_too_many_leases_are_refused() {
        let mut leases = Leases::default();
        assert!(leases.check(&request("ana", play(), Some(0))).is_err());
        assert!(leases.check(&request("ana", play(), Some(u64::MAX))).is_err());
        assert!(leases.check(&request("ana", renew(), None)).is_err());
        for action in [Action::StopAll, Action::ReleaseAll] {
            assert_eq!(leases.check(&request("ana", action.clone(), None)), Ok(()));
            assert!(leases.check(&request("ana", action, Some(1000))).is_err());
        }
        for number in 0..MAX_LEASES {
            leases.record(
                &request(&format!("a{number}"), play(), Some(1000)),
                Instant::now(),
            );
        }
        assert!(leases.check(&request("ana", play(), Some(1000))).is_err());
        assert_eq!(leases.check(&request("a0", play(), Some(1000))), Ok(()));
    }
}
