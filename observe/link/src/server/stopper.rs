//! Requests to stop everything (R14). From their arrival to the engine's lock they wait behind no other work:
//! they have queues of their own and this thread, which has the priority of the application's own threads. It
//! handles no other request and never waits for a client; the worker sends the replies.

use std::sync::Arc;
use std::time::{Duration, Instant};

use zenoh::query::Query;

use super::bucket::TokenBucket;
use super::inbox::{Inbox, Origin, QueuedQuery};
use super::operator_workers::JobOutcome;
use super::subject::Subject;
use super::worker::{matches_key, may_operate, parse_query};
use crate::message::{Action, Network, Refusal};

/// Stops per second. More frequent requests are combined into one stop, and each receives its outcome.
const STOPS_PER_SECOND: f64 = 10.0;
/// Pause before the next attempt when the rate is exceeded.
const RETRY_PAUSE: Duration = Duration::from_millis(10);
/// Most operators named when several stopped everything at once.
const MAX_NAMES: usize = 4;

/// The thread that stops everything.
pub(super) struct Stopper {
    pub(super) subject: Arc<dyn Subject>,
    pub(super) inbox: Arc<Inbox>,
    /// The key of requests to this application.
    pub(super) key: String,
    pub(super) network: Network,
}

impl Stopper {
    /// Carries out stops until the link ends.
    pub(super) fn run(self) {
        let mut bucket = TokenBucket::new(STOPS_PER_SECOND, Instant::now());
        while !self.inbox.is_stopping() {
            let requests: Vec<_> = std::iter::from_fn(|| self.inbox.next_stop()).collect();
            if requests.is_empty() {
                std::thread::park();
                continue;
            }
            let (mut queries, mut names) = (Vec::new(), Vec::new());
            for request in requests {
                match self.read(&request) {
                    Some(Ok(by)) => {
                        queries.push(request.query);
                        names.push(by);
                    }
                    Some(Err(refusal)) => self.push_outcome(vec![request.query], Err(refusal)),
                    // The request is for other applications.
                    None => {}
                }
            }
            if queries.is_empty() {
                continue;
            }
            while !bucket.try_take(Instant::now()) {
                std::thread::park_timeout(RETRY_PAUSE);
            }
            names.sort();
            names.dedup();
            names.truncate(MAX_NAMES);
            let outcome = self.subject.act(&names.join(", "), &Action::StopAll);
            self.push_outcome(queries, outcome);
        }
    }

    /// The operator, or the reason for a refusal; `None` if the request is not for this application.
    fn read(&self, QueuedQuery { origin, query, .. }: &QueuedQuery) -> Option<Result<String, Refusal>> {
        if !matches_key(query.key_expr(), &self.key) {
            return None;
        }
        let read = || {
            if *origin == Origin::Network {
                may_operate(self.network)?;
            }
            let request = parse_query(query)?;
            match request.lease_ms {
                Some(_) => Err(Refusal::lease_on_global()),
                None => Ok(request.by),
            }
        };
        Some(read())
    }

    fn push_outcome(&self, queries: Vec<Query>, outcome: Result<(), Refusal>) {
        // If the queue is full, the query ends without a reply, and the client repeats it.
        let _ = self
            .inbox
            .stop_outcomes
            .push(JobOutcome::Stopped(queries, outcome));
        self.inbox.wake();
    }
}

#[cfg(test)]
mod tests {
    use jde_board::{Board, Nanos};
    use jde_records::snapshot::Snapshot;
    use jde_watchdog::Watchdog;
    use zenoh::Wait;

    use super::*;
    use crate::message::Schemas;
    use crate::server::subject::SubjectInfo;
    use crate::session::{SessionOptions, open};

    /// A subject that must not be called, since all requests are refused.
    struct UncalledSubject;

    impl Subject for UncalledSubject {
        fn info(&self) -> SubjectInfo {
            unreachable!()
        }

        fn schemas(&self) -> Schemas {
            unreachable!()
        }

        fn board(&self) -> &Board {
            unreachable!()
        }

        fn writer(&self, _: u32) -> String {
            unreachable!()
        }

        fn now(&self) -> Nanos {
            unreachable!()
        }

        fn snapshot(&self) -> Snapshot {
            unreachable!()
        }

        fn act(&self, _: &str, _: &Action) -> Result<(), Refusal> {
            unreachable!()
        }
    }

    #[test]
    fn r14_refused_stops_do_not_displace_other_replies() {
        let _watchdog = Watchdog::for_test();
        let inbox = Arc::new(Inbox::new());
        let key = "jde/1/robot/ab12/operate";
        let stopper = Stopper {
            subject: Arc::new(UncalledSubject),
            inbox: Arc::clone(&inbox),
            key: key.to_owned(),
            network: Network::Read,
        };
        let stopper = std::thread::spawn(|| stopper.run());
        let this_thread = std::thread::current();
        inbox.attach(&this_thread, &this_thread, stopper.thread());
        let session = open(&SessionOptions::default()).unwrap();
        let receiver = Arc::clone(&inbox);
        let _queryable = session
            .declare_queryable(key)
            .callback(move |query| receiver.push_query(Origin::Network, query))
            .wait()
            .unwrap();
        // No thread takes the outcomes.
        while !inbox.stop_outcomes.is_full() && !inbox.outcomes.is_full() {
            let request = r#"{"by": "eve", "action": "stop-all"}"#;
            session.get(key).payload(request).callback(drop).wait().unwrap();
        }
        assert_eq!(inbox.outcomes.len(), 0);
        inbox.stop();
        stopper.join().unwrap();
    }
}
