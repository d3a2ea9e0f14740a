//! The requests to the services of a node, until its owner takes them. Those to the urgent service have a queue of their
//! own; those to the others are taken from each service in turn, so that a flood of one delays no other.

use std::collections::VecDeque;
use std::time::Duration;

use parking_lot::{Condvar, Mutex, MutexGuard};

use crate::services::Request;
use crate::shared::MAX_WAITING;

/// Most requests to the urgent service that wait. All are taken at once, so there are more only while the owner has no time.
const MAX_URGENT: usize = 256;

/// The queues.
#[derive(Debug)]
pub(crate) struct Requests {
    urgent_service: Option<usize>,
    urgent: Queue,
    others: Queue,
}

#[derive(Debug, Default)]
struct Queue {
    waiting: Mutex<Waiting>,
    arrived: Condvar,
}

#[derive(Debug, Default)]
struct Waiting {
    requests: VecDeque<Request>,
    /// The service to take from next.
    turn: usize,
}

impl Requests {
    pub(crate) fn new(urgent_service: Option<usize>) -> Self {
        Self {
            urgent_service,
            urgent: Queue::default(),
            others: Queue::default(),
        }
    }

    /// Stores a request, or returns it with the number of those that wait, if these are too many.
    pub(crate) fn push(&self, request: Request) -> Option<(Request, usize)> {
        let (queue, most) = if self.urgent_service == Some(request.service) {
            (&self.urgent, MAX_URGENT)
        } else {
            (&self.others, MAX_WAITING)
        };
        let mut waiting = queue.waiting.lock();
        let of_service = |other: &&Request| other.service == request.service;
        if waiting.requests.iter().filter(of_service).count() >= most {
            return Some((request, most));
        }
        waiting.requests.push_back(request);
        drop(waiting);
        queue.arrived.notify_one();
        None
    }

    /// Takes the next request to a service that is not urgent. Waits for one for at most `timeout`.
    pub(crate) fn take(&self, timeout: Duration) -> Option<Request> {
        self.others.wait(timeout).take_next()
    }

    /// Takes all requests to the urgent service. Waits for one for at most `timeout`.
    pub(crate) fn take_urgent(&self, timeout: Duration) -> Vec<Request> {
        self.urgent.wait(timeout).requests.drain(..).collect()
    }

    /// Takes the next request to a service that is not urgent.
    pub(crate) fn take_of(&self, service: usize) -> Option<Request> {
        let mut waiting = self.others.waiting.lock();
        let requests = &mut waiting.requests;
        let place = requests.iter().position(|request| request.service == service)?;
        requests.remove(place)
    }
}

impl Queue {
    /// Waits for a request for at most `timeout`.
    fn wait(&self, timeout: Duration) -> MutexGuard<'_, Waiting> {
        let mut waiting = self.waiting.lock();
        if waiting.requests.is_empty() && !timeout.is_zero() {
            self.arrived.wait_for(&mut waiting, timeout);
        }
        waiting
    }
}

impl Waiting {
    /// Takes the oldest request of the next service that has one.
    fn take_next(&mut self) -> Option<Request> {
        let turn = self.turn;
        // The services before `turn` come after those from it on.
        let rank = |service: usize| (service < turn, service);
        let services = self.requests.iter().map(|request| rank(request.service));
        let (place, (_, service)) = services.enumerate().min_by_key(|(_, rank)| *rank)?;
        self.turn = service + 1;
        self.requests.remove(place)
    }
}
