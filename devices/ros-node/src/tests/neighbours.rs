//! A node beside others that ask too much of it, or contradict each other; and what it subscribes to only at times.

use super::*;

#[test]
fn requests_are_taken_from_each_service_in_turn_and_the_urgent_one_waits_for_none() {
    let router = Router::open();
    let service = |name: &str| Service::new(format!("/pioneer/{name}"), TRIGGER, standard()).unwrap();
    let services = ["flood", "other", "stop"].map(service);
    let server = Node::start(NodeConfig {
        services: services.to_vec(),
        urgent_service: Some(2),
        ..router.node("pioneer")
    })
    .unwrap();
    let timeout = Duration::from_secs(60);
    let clients = services.map(|service| Client { service, timeout });
    let peer = Node::start(NodeConfig {
        clients: clients.to_vec(),
        ..router.node("peer")
    })
    .unwrap();
    until(|| (0..3).all(|client| peer.has_server(client)).then_some(()));
    for _ in 0..5 {
        peer.call(0, request());
    }
    peer.call(1, request());
    let stop = peer.call(2, request());
    let mut urgent = until(|| server.take_urgent(Duration::from_millis(10)).pop());
    Node::reply_at_once(urgent, request());
    assert_eq!(until(|| peer.take_response(2)).sequence, stop);
    // Zenoh delivers in order, so those before it have arrived.
    let next = || server.take_request(Duration::ZERO).map(|request| request.service);
    let order: Vec<_> = std::iter::from_fn(next).collect();
    assert_eq!(order, [0, 1, 0, 0, 0, 0]);
    peer.call(2, request());
    urgent = until(|| server.take_urgent(Duration::from_millis(10)).pop());
    assert_eq!(urgent.service, 2);
    assert!(server.take_request(Duration::ZERO).is_none());
}

#[test]
fn a_measurement_that_two_nodes_publish_is_received_from_neither_and_both_are_named() {
    let router = Router::open();
    let topic = Topic::new("/odom".to_owned(), &Twist::describe(), Quality::SENSOR_DATA);
    let subscriber = Node::start(NodeConfig {
        subscriptions: vec![Topic {
            has_one_source: true,
            ..topic.clone()
        }],
        ..router.node("subscriber")
    })
    .unwrap();
    let publisher = |name: &str| {
        let config = NodeConfig {
            publications: vec![topic.clone()],
            ..router.node(name)
        };
        let node = Node::start(config).unwrap();
        until(|| node.has_subscribers(0).then_some(()));
        node
    };
    let wheels = publisher("wheels");
    let send = |node: &Node| node.append(0, twist());
    until(|| {
        send(&wheels);
        subscriber.take(0)
    });
    assert!(!subscriber.is_contradicted(0));
    let filter = publisher("filter");
    let remarks = until(|| {
        send(&wheels);
        send(&filter);
        Some(subscriber.remarks()).filter(|remarks| !remarks.is_empty())
    });
    assert!(
        remarks[0].starts_with("node /filter and node /wheels publish /odom, and contradict each other"),
        "{remarks:?}"
    );
    assert_eq!(remarks.len(), 1);
    assert!(subscriber.is_contradicted(0));
    assert!(subscriber.take(0).is_none(), "neither counts");
    // One that has ended contradicts nobody.
    drop(filter);
    until(|| {
        send(&wheels);
        subscriber.take(0)
    });
    assert_eq!(subscriber.remarks(), Vec::<String>::new());
}

#[test]
fn a_subscription_is_announced_and_received_while_it_is_wanted() {
    let router = Router::open();
    let topic = Topic::new("/clock".to_owned(), &Twist::describe(), Quality::SENSOR_DATA);
    let subscriber = Node::start(NodeConfig {
        subscriptions: vec![Topic {
            announced: Announced::WhileWanted,
            ..topic.clone()
        }],
        ..router.node("subscriber")
    })
    .unwrap();
    let publisher = Node::start(NodeConfig {
        publications: vec![topic],
        ..router.node("simulator")
    })
    .unwrap();
    until(|| (publisher.state().0 == NodeState::Connected).then_some(()));
    assert!(!publisher.has_subscribers(0));
    for _ in 0..2 {
        subscriber.want(0, true);
        until(|| {
            publisher.append(0, twist());
            subscriber.take(0)
        });
        subscriber.want(0, false);
        until(|| (!publisher.has_subscribers(0)).then_some(()));
    }
}
