//! The thread of a node: it opens a Zenoh session, announces the node and its topics, sends submitted
//! messages and stores those that arrive. The robot's control does not depend on it, so it lowers its
//! scheduling priority.

use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::CongestionControl;
use zenoh::sample::SampleKind;
use zenoh::{Session, Wait};

use crate::attachment::{attachment, gid};
use crate::keys::{Announced, Direction, mismatch};
use crate::node::{NodeConfig, NodeState};
use crate::shared::Shared;

/// Niceness of this thread and of Zenoh's threads, which inherit it, so that the robot's own threads take
/// precedence.
const NICE: i32 = 10;
/// The pause after the first failed attempt, and the longest pause.
const FIRST_PAUSE: Duration = Duration::from_millis(200);
const LONGEST_PAUSE: Duration = Duration::from_secs(2);
/// Period of the checks for connected nodes.
const CHECK_PERIOD: Duration = Duration::from_millis(200);

/// All declarations. Dropping them undeclares them.
struct Declared {
    publishers: Vec<DeclaredPublisher>,
    _subscribers: Vec<Subscriber<()>>,
    tokens: Vec<LivelinessToken>,
}

/// A publication, and the state of its attachments.
struct DeclaredPublisher {
    publisher: Publisher<'static>,
    sequence: i64,
    /// Identifier of the publication for ROS 2.
    gid: [u8; 16],
}

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
    let _ = rustix::process::nice(NICE);
    let mut pause = FIRST_PAUSE;
    loop {
        match open(shared, config) {
            Ok((session, declared)) => {
                serve(shared, config, &session, declared);
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
    let declared = declare(shared, config, &session)?;
    Ok((session, declared))
}

/// Declares the node, then its topics, then a subscription to the tokens of other nodes.
fn declare(shared: &Arc<Shared>, config: &NodeConfig, session: &Session) -> zenoh::Result<Declared> {
    let (name, id) = (&config.name, session.zid());
    let session_id = id.to_string();
    let mut tokens = vec![
        session
            .liveliness()
            .declare_token(name.token(&session_id))
            .wait()?,
    ];
    let mut publishers = Vec::new();
    for (number, topic) in config.publications.iter().enumerate() {
        let publisher = session
            .declare_publisher(topic.key(name))
            .congestion_control(CongestionControl::Drop)
            .wait()?;
        let shared_in_callback = Arc::clone(shared);
        publisher
            .matching_listener()
            .callback(move |status| shared_in_callback.set_subscribed(number, status.matching()))
            .background()
            .wait()?;
        shared.set_subscribed(number, publisher.matching_status().wait()?.matching());
        publishers.push(DeclaredPublisher {
            publisher,
            sequence: 0,
            gid: gid(id.to_le_bytes(), 1 + number),
        });
        tokens.extend(announce(
            config,
            session,
            Direction::Publish,
            number,
            Announced::Always,
        )?);
    }
    let mut subscribers = Vec::new();
    for (number, topic) in config.subscriptions.iter().enumerate() {
        let shared_in_callback = Arc::clone(shared);
        let subscriber = session
            .declare_subscriber(topic.key(name))
            .callback(move |sample| {
                if sample.kind() == SampleKind::Put {
                    shared_in_callback.arrive(number, sample.payload().clone());
                }
            })
            .wait()?;
        subscribers.push(subscriber);
        tokens.extend(announce(
            config,
            session,
            Direction::Subscribe,
            number,
            Announced::Always,
        )?);
    }
    let (shared_in_callback, topics_of_node) = (Arc::clone(shared), config.clone());
    let all_tokens = session
        .liveliness()
        .declare_subscriber(name.all_tokens())
        .history(true)
        .callback(move |sample| {
            if sample.kind() != SampleKind::Put {
                return;
            }
            let token = sample.key_expr();
            for direction in [Direction::Publish, Direction::Subscribe] {
                let topics = topics_of_node.topics(direction);
                for (number, topic) in topics.iter().enumerate() {
                    if topic.announced == Announced::OnceMet && topic.meets(direction, token) {
                        shared_in_callback.meet(direction, number);
                    }
                }
                if let Some(remark) = mismatch(topics, direction, token) {
                    shared_in_callback.remark(remark);
                }
            }
        })
        .wait()?;
    subscribers.push(all_tokens);
    Ok(Declared {
        publishers,
        _subscribers: subscribers,
        tokens,
    })
}

/// Announces a topic if it is one that is announced at that time.
fn announce(
    config: &NodeConfig,
    session: &Session,
    direction: Direction,
    number: usize,
    at: Announced,
) -> zenoh::Result<Option<LivelinessToken>> {
    let Some(topic) = config
        .topics(direction)
        .get(number)
        .filter(|topic| topic.announced == at)
    else {
        return Ok(None);
    };
    // The node has number 0.
    let number = 1
        + number
        + match direction {
            Direction::Publish => 0,
            Direction::Subscribe => config.publications.len(),
        };
    let token = topic.token(&config.name, &session.zid().to_string(), direction, number);
    session.liveliness().declare_token(token).wait().map(Some)
}

/// Sends messages and checks the connection until the node must end.
fn serve(shared: &Shared, config: &NodeConfig, session: &Session, mut declared: Declared) {
    let mut last_check: Option<Instant> = None;
    let mut was_connected = false;
    let mut announced = Vec::new();
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
            shared.set_state(state);
        }
        let work = shared.work(CHECK_PERIOD);
        for (direction, number) in work.met {
            if !announced.contains(&(direction, number)) {
                announced.push((direction, number));
                // Without it only tools do not see the topic; its messages pass.
                let token = announce(config, session, direction, number, Announced::OnceMet);
                declared.tokens.extend(token.ok().flatten());
            }
        }
        for (number, batch) in work.batches {
            let publisher = &mut declared.publishers[number];
            for message in batch {
                publisher.put(message);
            }
        }
        if work.ending {
            return;
        }
    }
}

impl DeclaredPublisher {
    fn put(&mut self, message: Vec<u8>) {
        self.sequence += 1;
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let attachment = attachment(self.sequence, since.as_nanos() as i64, self.gid);
        // A message that cannot be sent is lost, as on an unreliable network; the check of the connection
        // reports the reason.
        let _ = self.publisher.put(message).attachment(attachment).wait();
    }
}

/// Returns the error's text without locations in Zenoh's source.
fn describe_error(error: &zenoh::Error) -> String {
    let text = error.to_string();
    let mut rest = text.as_str();
    let mut result = String::new();
    while let Some((before, after)) = rest.split_once(" at /") {
        result += before.trim_end();
        rest = after.split_once(".rs:").map_or("", |(_, line)| {
            line.trim_start_matches(|letter: char| letter.is_ascii_digit())
                .trim_start_matches('.')
        });
    }
    result += rest;
    // Zenoh gives no other reason if a client finds no router.
    if result.starts_with("Unable to connect to any of") {
        return "no router answers at this address; is it running?".to_owned();
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_described_without_source_locations() {
        let error = |text: &str| describe_error(&zenoh::Error::from(text.to_owned()));
        let port_in_use = "Can not listen: [127.0.0.1:1: Address already in use (os error 98) at /a b/tcp.rs:61.] at /c/unicast.rs:338.";
        assert_eq!(
            error(port_in_use),
            "Can not listen: [127.0.0.1:1: Address already in use (os error 98)]"
        );
        assert_eq!(error("plain"), "plain");
        let unreachable = "Unable to connect to any of [Single(tcp/a:1)]!  at /c/orchestrator.rs:447.";
        assert_eq!(
            error(unreachable),
            "no router answers at this address; is it running?"
        );
        assert_eq!(error("cut at /home/x"), "cut");
    }
}
