//! Two nodes, over a router of Zenoh in this process, and real sockets of the loopback interface.

use std::net::TcpListener;
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use jde_types::{Twist, Value};
use jde_watchdog::Watchdog;
use parking_lot::Mutex;
use serde_json::json;
use zenoh::handlers::FifoChannelHandler;
use zenoh::pubsub::Subscriber;
use zenoh::query::{ConsolidationMode, ReplyKeyExpr};
use zenoh::sample::Sample;
use zenoh::{Session, Wait};

use super::*;
use crate::interface::standard;

mod neighbours;

const TRIGGER: &str = "std_srvs/srv/Trigger";

/// A router at an unused address.
pub(crate) struct Router {
    address: String,
    session: Option<Session>,
    _watchdog: Watchdog,
}

impl Router {
    pub(crate) fn open() -> Self {
        let mut router = Self::closed();
        router.listen();
        router
    }

    /// A router that does not answer yet.
    fn closed() -> Self {
        let watchdog = Watchdog::for_test();
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        Self {
            address: format!("tcp/{port}"),
            session: None,
            _watchdog: watchdog,
        }
    }

    fn listen(&mut self) {
        let mut config = zenoh::Config::default();
        for (key, value) in [
            ("mode", "\"router\"".to_owned()),
            ("listen/endpoints", format!("[\"{}\"]", self.address)),
            ("scouting/multicast/enabled", "false".to_owned()),
        ] {
            config.insert_json5(key, &value).unwrap();
        }
        self.session = Some(zenoh::open(config).wait().unwrap());
    }

    /// A node without topics and services.
    pub(crate) fn node(&self, node: &str) -> NodeConfig {
        self.settings(node).node_config().unwrap()
    }

    /// A node with one publication, whose messages this subscriber receives.
    fn watched(&self) -> (Node, Session, Subscriber<FifoChannelHandler<Sample>>) {
        let topic = Topic::new("/log".to_owned(), &Twist::describe(), Quality::DEFAULT);
        let publisher = Node::start(NodeConfig {
            publications: vec![topic.clone()],
            ..self.node("publisher")
        })
        .unwrap();
        let config = &self.node("subscriber");
        let session = zenoh::open(config.config.clone()).wait().unwrap();
        let subscriber = session
            .declare_subscriber(topic.key(&config.name))
            .wait()
            .unwrap();
        until(|| publisher.has_subscribers(0).then_some(()));
        (publisher, session, subscriber)
    }

    fn settings<'a>(&'a self, node: &'a str) -> Settings<'a> {
        Settings {
            config: "",
            connect: &self.address,
            listen: "",
            domain: 5,
            namespace: "",
            node,
            owner: "",
            remap: "",
        }
    }
}

pub(crate) fn until<T>(mut result: impl FnMut() -> Option<T>) -> T {
    loop {
        if let Some(result) = result() {
            return result;
        }
        thread::yield_now();
    }
}

fn stop() -> Service {
    Service::new("/pioneer/stop".to_owned(), TRIGGER, standard()).unwrap()
}

fn client(timeout: Duration) -> Client {
    Client {
        service: stop(),
        timeout,
    }
}

fn twist() -> Vec<u8> {
    let mut message = Vec::new();
    jde_ros::cdr::encode(&Twist::describe(), Twist::ZERO.as_bytes(), &mut message);
    message
}

fn request() -> Vec<u8> {
    standard()
        .encode("std_srvs/srv/Trigger_Request", &json!({}))
        .unwrap()
}

#[test]
fn a_request_has_the_response_of_the_node_that_offers_the_service() {
    let router = Router::open();
    let caller = Node::start(NodeConfig {
        clients: vec![client(Duration::from_secs(60))],
        ..router.node("caller")
    })
    .unwrap();
    let server = Node::start(NodeConfig {
        services: vec![stop()],
        ..router.node("server")
    })
    .unwrap();
    until(|| caller.has_server(0).then_some(()));
    for expected in 1..=3 {
        assert_eq!(caller.call(0, request()), expected);
        let request = until(|| server.take_request(Duration::from_millis(10)));
        assert_eq!((request.service, &*request.message()), (0, &*self::request()));
        let text = format!("stop {expected}");
        let response = json!({ "success": true, "message": text });
        let message = standard()
            .encode("std_srvs/srv/Trigger_Response", &response)
            .unwrap();
        server.reply(request, message.clone());
        let response = until(|| caller.take_response(0));
        assert_eq!((response.sequence, response.outcome), (expected, Ok(message)));
    }
    server.close();
    until(|| (!caller.has_server(0)).then_some(()));
}

#[test]
fn a_request_without_a_response_fails_with_the_reason() {
    let router = Router::open();
    let caller = Node::start(NodeConfig {
        clients: vec![client(Duration::from_millis(300))],
        ..router.node("caller")
    })
    .unwrap();
    let outcome = |caller: &Node| until(|| caller.take_response(0)).outcome.unwrap_err();
    caller.call(0, request());
    assert!(outcome(&caller).contains("no node answers `/pioneer/stop`"));
    let server = Node::start(NodeConfig {
        services: vec![stop()],
        ..router.node("server")
    })
    .unwrap();
    until(|| caller.has_server(0).then_some(()));
    caller.call(0, request());
    let kept = until(|| server.take_request(Duration::from_millis(10)));
    assert!(outcome(&caller).contains("no node answers `/pioneer/stop`"));
    drop(kept);
}

#[test]
fn a_latched_topic_has_its_newest_messages_for_subscriptions_of_any_time() {
    let router = Router::open();
    let topic = Topic::new(
        "/map".to_owned(),
        &Twist::describe(),
        Quality {
            depth: 2,
            ..Quality::LATCHED
        },
    );
    let publisher = Node::start(NodeConfig {
        publications: vec![topic.clone()],
        ..router.node("publisher")
    })
    .unwrap();
    let subscribe = |node: &str| {
        Node::start(NodeConfig {
            subscriptions: vec![topic.clone()],
            ..router.node(node)
        })
        .unwrap()
    };
    let early = subscribe("early");
    for number in 0..3 {
        publisher.append(0, vec![number]);
        until(|| publisher.has_sent(0).then_some(()));
    }
    let receive = |node: &Node, last: u8| {
        let mut received = Vec::new();
        until(|| {
            let messages = node.take_all(0).into_iter();
            received.extend(messages.map(|message| message.message.to_bytes()[0]));
            (received.last() == Some(&last)).then_some(())
        });
        received
    };
    assert!(receive(&early, 2).is_sorted());
    assert_eq!(receive(&subscribe("late"), 2), [1, 2]);
    // A subscriber of rmw_zenoh queries twice, and knows a repeated message by its time.
    let session = router.session.as_ref().unwrap();
    let times = || {
        let replies = session.get("**/@adv/pub/**").accept_replies(ReplyKeyExpr::Any);
        let replies = replies.consolidation(ConsolidationMode::None).wait().unwrap();
        let samples = replies.iter().map(|reply| reply.into_result().unwrap());
        samples
            .map(|sample| sample.timestamp().copied())
            .collect::<Vec<_>>()
    };
    let first = times();
    assert!(
        first.len() == 2 && first[0] < first[1] && first[0].is_some(),
        "{first:?}"
    );
    assert_eq!(times(), first);
    publisher.append(0, vec![3]);
    assert_eq!(receive(&early, 3), [3]);
}

#[test]
fn what_is_latched_before_a_router_answers_is_sent_later_and_a_call_ends() {
    let mut router = Router::closed();
    let topic = Topic::new("/map".to_owned(), &Twist::describe(), Quality::LATCHED);
    let publisher = Node::start(NodeConfig {
        publications: vec![topic.clone()],
        clients: vec![client(Duration::from_secs(5))],
        ..router.node("publisher")
    })
    .unwrap();
    publisher.append(0, vec![7]);
    publisher.call(0, request());
    let outcome = until(|| publisher.take_response(0)).outcome;
    assert_eq!(outcome, Err("no router answers".to_owned()));
    router.listen();
    let subscriber = Node::start(NodeConfig {
        subscriptions: vec![topic],
        ..router.node("subscriber")
    })
    .unwrap();
    let received = until(|| subscriber.take(0));
    assert_eq!(received.message.to_bytes()[0], 7);
}

#[test]
fn the_owner_of_a_message_that_waits_is_called_once_it_was_taken() {
    let mut router = Router::closed();
    let (sender, calls) = mpsc::channel();
    let sender = Mutex::new(sender);
    let publisher = Node::start(NodeConfig {
        publications: vec![Topic::new(
            "/map".to_owned(),
            &Twist::describe(),
            Quality::LATCHED,
        )],
        arrival: Arrival::new(move || sender.lock().send(()).unwrap_or_default()),
        ..router.node("publisher")
    })
    .unwrap();
    assert!(!publisher.is_waiting(0));
    publisher.append(0, vec![7]);
    assert!(publisher.is_waiting(0), "no router answers");
    router.listen();
    calls.recv().unwrap();
    assert!(!publisher.is_waiting(0));
}

#[test]
fn appended_messages_wait_up_to_the_depth_of_their_topic() {
    let router = Router::open();
    let (publisher, _session, subscriber) = router.watched();
    // More than the depth, faster than they can be sent: the newest ones arrive in order.
    (0..100).for_each(|number| publisher.append(0, vec![number]));
    let mut received = Vec::new();
    while received.last() != Some(&99) {
        received.push(subscriber.recv().unwrap().payload().to_bytes()[0]);
    }
    assert!(
        received.is_sorted() && received.ends_with(&Vec::from_iter(90..100)),
        "{received:?}"
    );
}

#[test]
fn the_owner_leaves_sending_to_the_thread_if_a_subscriber_does_not_read() {
    let router = Router::closed();
    let topic = Topic::new("/flood".to_owned(), &Twist::describe(), Quality::DEFAULT);
    // The subscriber connects to it directly.
    let listening = Settings {
        connect: "",
        listen: &router.address,
        ..router.settings("publisher")
    };
    let publisher = Node::start(NodeConfig {
        publications: vec![topic.clone()],
        ..listening.node_config().unwrap()
    })
    .unwrap();
    until(|| (publisher.state().0 == NodeState::Alone).then_some(()));
    let config = &router.node("subscriber");
    let session = zenoh::open(config.config.clone()).wait().unwrap();
    let (reads, may_read) = mpsc::channel::<()>();
    let (received, newest) = mpsc::channel();
    let may_read = Mutex::new(may_read);
    let _subscriber = session
        .declare_subscriber(topic.key(&config.name))
        .callback(move |sample| {
            let _ended = may_read.lock().recv();
            let _ = received.send(sample.payload().to_bytes()[0]);
        })
        .wait()
        .unwrap();
    until(|| publisher.has_subscribers(0).then_some(()));
    // Far more than the buffers on the way take.
    let message = |number: u8| {
        let mut message = vec![0; 16 << 10];
        message[0] = number;
        message
    };
    for _ in 0..4000 {
        publisher.publish(0, vec![message(1)]);
    }
    until(|| {
        publisher.publish(0, vec![message(1)]);
        publisher.0.publishers.wait().is_left_to_thread().then_some(())
    });
    drop(reads);
    until(|| {
        publisher.publish(0, vec![message(2)]);
        newest.try_iter().find(|number| *number == 2)
    });
}

#[test]
fn messages_of_a_publication_stay_in_order_whoever_sends_them() {
    let router = Router::open();
    let (publisher, _session, subscriber) = router.watched();
    let (mut sent, mut received) = (0_u32, Vec::new());
    while received.len() < 500 {
        // The thread sends the large one, and the owner tries to send the small one at once.
        for bytes in [40_000, 4] {
            sent += 1;
            let mut message = sent.to_le_bytes().to_vec();
            message.resize(bytes, 0);
            publisher.append(0, message);
        }
        let number = |payload: &[u8]| u32::from_le_bytes(*payload.first_chunk().unwrap());
        let arrived = std::iter::from_fn(|| subscriber.try_recv().unwrap());
        received.extend(arrived.map(|sample| number(&sample.payload().to_bytes())));
    }
    assert!(received.is_sorted(), "{received:?}");
}

#[test]
fn a_node_that_listens_and_meets_nobody_says_so_once() {
    let router = Router::closed();
    let settings = Settings {
        connect: "",
        listen: &router.address,
        ..router.settings("lonely")
    };
    let name = settings.name().unwrap();
    let lonely = Node::start(NodeConfig::new(name, settings.connection_config().unwrap())).unwrap();
    let remarks = until(|| Some(lonely.remarks()).filter(|remarks| !remarks.is_empty()));
    let expected = format!(
        "{}: no router and no other node is connected yet; is the router running?",
        router.address
    );
    assert_eq!(remarks, [expected]);
}
