//! The thread of a node: it opens a Zenoh session, declares the node in it, and sends submitted messages. The robot's control does not depend on it, so it lowers its
//! scheduling priority.

use std::sync::Arc;
use std::time::{Duration, Instant};

use zenoh::{Session, Wait};

use crate::attachment::gid;
use crate::declare::{Declared, declare, token};
use crate::error::describe_error;
use crate::keys::Direction;
use crate::node::{NodeConfig, NodeState};
use crate::own::remember_session;
use crate::send_queue::Work;
use crate::shared::Shared;
use crate::{latched, services};

/// Niceness of this thread and of Zenoh's threads, which inherit it, so that the robot's own threads take
/// precedence.
const THREAD_NICENESS: i32 = 10;
/// The pause after the first failed attempt, and the longest pause.
const FIRST_PAUSE: Duration = Duration::from_millis(200);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);
/// Period of the checks for connected nodes.
const CHECK_PERIOD: Duration = Duration::from_millis(200);

/// The time without any other node after which it is remarked.
const NO_NODE_REMARK: Duration = Duration::from_secs(2);

/// Reports the end of the thread, also after a panic.
struct EndGuard<'a>(&'a Shared);

impl Drop for EndGuard<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0
                .failed("its session of Zenoh failed; start the node again".to_owned());
        }
        self.0.end();
    }
}

/// Keeps the node connected until it must end.
pub(crate) fn run(shared: &Arc<Shared>, config: &NodeConfig) {
    let _ending = EndGuard(shared);
    // Without the permission the niceness stays the same, which is not an error.
    let _ = rustix::process::nice(THREAD_NICENESS);
    let mut pause = FIRST_PAUSE;
    loop {
        match open(shared, config) {
            Ok((session, mut declared)) => {
                shared.publishers.set(std::mem::take(&mut declared.publishers));
                serve(shared, config, &session, declared);
                shared.publishers.set(Vec::new());
                let _ = session.close().wait();
                return;
            }
            Err(error) => shared.failed(format!("{}: {}", config.endpoint, describe_error(&error))),
        }
        if shared.pause(pause) {
            return;
        }
        pause = (2 * pause).min(LONGEST_PAUSE);
    }
}

fn open(shared: &Arc<Shared>, config: &NodeConfig) -> zenoh::Result<(Session, Declared)> {
    let session = zenoh::open(config.config.clone()).wait()?;
    remember_session(session.zid().to_string());
    let declared = declare(shared, config, &session)?;
    Ok((session, declared))
}

/// Sends messages and checks the connection until the node must end.
fn serve(shared: &Arc<Shared>, config: &NodeConfig, session: &Session, mut declared: Declared) {
    let opened_at = Instant::now();
    let mut last_check: Option<Instant> = None;
    let mut was_connected = false;
    loop {
        if last_check.is_none_or(|last_check| last_check.elapsed() >= CHECK_PERIOD) {
            last_check = Some(Instant::now());
            let others =
                session.info().routers_zid().wait().count() + session.info().peers_zid().wait().count();
            let state = match (others, was_connected) {
                (0, false) => NodeState::Alone,
                (0, true) => NodeState::Lost(format!(
                    "{}: no router or node is connected any more",
                    config.endpoint
                )),
                _ => NodeState::Connected,
            };
            was_connected |= others > 0;
            if state == NodeState::Alone && opened_at.elapsed() >= NO_NODE_REMARK {
                shared.remark(format!(
                    "{}: no router and no other node is connected yet; is the router running?",
                    config.endpoint
                ));
            }
            shared.set_state(state);
        }
        let Work {
            calls,
            replies,
            caches,
            met,
            is_rewired,
            ending,
        } = shared.work(CHECK_PERIOD);
        if is_rewired {
            // What fails is tried again with the next session.
            let _ = declared.subscribe_wanted(shared, config, session);
        }
        if is_rewired || !met.is_empty() {
            met.into_iter()
                .for_each(|meeting| declared.announcements.record(meeting));
            // What cannot be announced is tried again at the next meeting.
            let _ = declared.announcements.update(shared, config, session);
        }
        shared.send_waiting(ending);
        for (request, response) in replies {
            let _ = request.reply(response);
        }
        for (number, sequence, message) in calls.into_iter().filter(|_| !config.name.is_bridged()) {
            let client = &config.clients[number];
            let topic = client.service.topic();
            let gid = gid(&token(config, session, (Direction::Call, number), &topic));
            let key = topic.key(&config.name);
            services::call(session, &key, shared, (number, client), (sequence, message), gid);
        }
        for (number, key) in caches {
            let depth = config.subscriptions[number].quality.depth;
            let _ = latched::query(session, &key, shared, number, depth);
        }
        if ending {
            return;
        }
    }
}
