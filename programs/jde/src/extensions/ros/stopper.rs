//! The node's service `stop`. From the network to the engine's lock its requests wait behind no other: they have a queue
//! and a thread of their own, which has the priority of the application's threads and never waits for a client. Another
//! thread sends the responses.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use jde_link::TokenBucket;
use jde_link::message::Action;
use jde_link_host::Running;
use jde_ros_node::interface::standard;
use jde_ros_node::{Node, Request};

use super::{SERVICES, STOP_SERVICE, act};

/// Stops per second. More frequent requests are combined into one stop, and each receives its outcome.
const STOPS_PER_SECOND: f64 = 10.0;
/// Pause before the next attempt when the rate is exceeded.
const RETRY_PAUSE: Duration = Duration::from_millis(10);
/// How soon the end of the run is noticed.
const END_INTERVAL: Duration = Duration::from_millis(50);
/// Most stops whose responses wait for the network; those of further ones are dropped.
const MAX_OUTCOMES: usize = 16;

/// The requests that one stop has answered, and their response.
type Outcome = (Vec<Request>, Vec<u8>);

/// Carries out stops until `end`.
pub(super) fn run(node: &Node, subject: &Running, end: &AtomicBool) {
    let (outcomes, receiver) = sync_channel(MAX_OUTCOMES);
    thread::scope(|scope| {
        let responder = thread::Builder::new()
            .name("ros-stop-reply".to_owned())
            .spawn_scoped(scope, move || respond(&receiver));
        if let Err(error) = responder {
            tracing::error!("ROS 2: stops have no responses: there is no thread to send them: {error}");
        }
        carry_out(node, subject, end, &outcomes);
        drop(outcomes);
    });
}

fn respond(outcomes: &Receiver<Outcome>) {
    for (requests, message) in outcomes {
        for request in requests {
            Node::reply_at_once(request, message.clone());
        }
    }
}

fn carry_out(node: &Node, subject: &Running, end: &AtomicBool, outcomes: &SyncSender<Outcome>) {
    let mut bucket = TokenBucket::new(STOPS_PER_SECOND, Instant::now());
    while !end.load(Ordering::Relaxed) {
        let mut requests = node.take_urgent(END_INTERVAL);
        if requests.is_empty() {
            continue;
        }
        while !bucket.try_take(Instant::now()) {
            thread::sleep(RETRY_PAUSE);
            requests.extend(node.take_urgent(Duration::ZERO));
        }
        // What a request contains does not matter: a stop is never refused for its form.
        let response = act(subject, &Action::StopAll);
        match standard().encode(&format!("{}_Response", SERVICES[STOP_SERVICE].1), &response) {
            // Whose response is dropped asks again.
            Ok(message) => drop(outcomes.try_send((requests, message))),
            Err(error) => tracing::warn!("ROS 2: a stop has no response: {error}"),
        }
    }
}
