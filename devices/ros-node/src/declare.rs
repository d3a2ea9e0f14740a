//! What a node declares in its session: its topics and services, and the tokens by which others discover them.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::Queryable;
use zenoh::sample::{Locality, SampleKind};
use zenoh::{Session, Wait};

use crate::announcements::Announcements;
use crate::attachment::gid;
use crate::keys::{Announced, Direction, Topic, mismatch, rival, source};
use crate::latched::{self, Cache};
use crate::node::NodeConfig;
use crate::own::OwnCommands;
use crate::publishers::DeclaredPublisher;
use crate::send_queue::Meeting;
use crate::services;
use crate::shared::Shared;

/// All declarations. Dropping them undeclares them.
pub(crate) struct Declared {
    pub(crate) publishers: Vec<DeclaredPublisher>,
    _subscribers: Vec<Subscriber<()>>,
    /// Those of subscriptions that the owner does not always want.
    wanted: BTreeMap<usize, Subscriber<()>>,
    _services: Vec<Queryable<()>>,
    _node: Option<LivelinessToken>,
    pub(crate) announcements: Announcements,
}

/// Declares the node, then its topics and services, then a subscription to the tokens of other nodes.
pub(crate) fn declare(
    shared: &Arc<Shared>,
    config: &NodeConfig,
    session: &Session,
) -> zenoh::Result<Declared> {
    let (name, id) = (&config.name, session.zid());
    let token = (!name.is_bridged()).then(|| {
        session
            .liveliness()
            .declare_token(name.token(&id.to_string()))
            .wait()
    });
    let mut declared = Declared {
        publishers: Vec::new(),
        _subscribers: Vec::new(),
        wanted: BTreeMap::new(),
        _services: Vec::new(),
        _node: token.transpose()?,
        announcements: Announcements::default(),
    };
    let all_topics = config.all_topics();
    for (direction, topics) in &all_topics {
        for (number, topic) in topics.iter().enumerate() {
            let key = topic.key(name);
            match direction {
                Direction::Publish => {
                    let publisher = publish(shared, config, session, (number, topic), key)?;
                    declared.publishers.push(publisher);
                }
                Direction::Subscribe if topic.announced == Announced::WhileWanted => {}
                Direction::Subscribe => {
                    if topic.quality.latched {
                        let caches = latched::find_caches(session, &key, shared, number)?;
                        declared._subscribers.push(caches);
                    }
                    declared
                        ._subscribers
                        .push(subscribe(shared, session, number, key)?);
                }
                Direction::Serve | Direction::Call if name.is_bridged() => {}
                Direction::Serve => declared
                    ._services
                    .push(services::serve(session, &key, shared, number)?),
                Direction::Call => {}
            }
        }
    }
    declared.subscribe_wanted(shared, config, session)?;
    declared.announcements.update(shared, config, session)?;
    let shared = Arc::clone(shared);
    let all_tokens = session
        .liveliness()
        .declare_subscriber(name.all_tokens())
        .history(true)
        .callback(move |sample| {
            let appears = sample.kind() == SampleKind::Put;
            all_topics.iter().for_each(|(direction, topics)| {
                let token = sample.key_expr();
                compare(&shared, *direction, topics, token, appears);
                if *direction == Direction::Subscribe {
                    for (number, name) in source(topics, token) {
                        shared.set_source(number, gid(token), appears.then_some(name));
                    }
                }
                if appears
                    && *direction == Direction::Publish
                    && let Some(remark) = rival(topics, token)
                {
                    shared.remark(remark);
                }
            });
        })
        .wait()?;
    declared._subscribers.push(all_tokens);
    Ok(declared)
}

impl Declared {
    /// Subscribes to what the owner wants, and to nothing else of what it does not always want.
    ///
    /// # Errors
    /// Of Zenoh, at the first topic.
    pub(crate) fn subscribe_wanted(
        &mut self,
        shared: &Arc<Shared>,
        config: &NodeConfig,
        session: &Session,
    ) -> zenoh::Result<()> {
        for (number, topic) in config.subscriptions.iter().enumerate() {
            if topic.announced != Announced::WhileWanted {
                continue;
            }
            if !shared.is_wanted(number) {
                self.wanted.remove(&number);
            } else if let Entry::Vacant(entry) = self.wanted.entry(number) {
                entry.insert(subscribe(shared, session, number, topic.key(&config.name))?);
            }
        }
        Ok(())
    }
}

/// Compares the token of another node that appears or disappears with own topics of a direction.
fn compare(shared: &Shared, direction: Direction, topics: &[Topic], token: &str, appears: bool) {
    for (number, topic) in topics.iter().enumerate() {
        if !topic.meets(direction, token) {
            continue;
        }
        if direction == Direction::Call {
            shared.set_server(number, token, appears);
        }
        if topic.announced != Announced::Always {
            shared.meet(Meeting {
                place: (direction, number),
                token: token.to_owned(),
                appears,
            });
        }
    }
    if let Some(remark) = mismatch(topics, direction, token).filter(|_| appears) {
        shared.remark(remark);
    }
}

fn publish(
    shared: &Arc<Shared>,
    config: &NodeConfig,
    session: &Session,
    (number, topic): (usize, &Topic),
    key: String,
) -> zenoh::Result<DeclaredPublisher> {
    let entity = entity(config, Direction::Publish, number);
    let cache = topic
        .quality
        .latched
        .then(|| Cache::declare(session, &key, entity, topic.quality.depth))
        .transpose()?;
    let publisher = session
        .declare_publisher(key)
        .congestion_control(CongestionControl::Drop)
        .allowed_destination(match topic.is_standby {
            true => Locality::Remote,
            false => Locality::Any,
        })
        .priority(match topic.is_large {
            true => Priority::DataLow,
            // Requests and responses have `Data` and may block; these do not wait for them.
            false => Priority::DataHigh,
        })
        .wait()?;
    let shared_in_callback = Arc::clone(shared);
    // Zenoh calls a new listener if there are subscribers already.
    shared.set_subscribed(number, false);
    publisher
        .matching_listener()
        .callback(move |status| shared_in_callback.set_subscribed(number, status.matching()))
        .background()
        .wait()?;
    let gid = gid(&token(config, session, (Direction::Publish, number), topic));
    Ok(DeclaredPublisher {
        publisher,
        sequence: 0,
        gid,
        cache,
        _own: topic.is_command.then(|| OwnCommands::of(gid)),
    })
}

fn subscribe(
    shared: &Arc<Shared>,
    session: &Session,
    number: usize,
    key: String,
) -> zenoh::Result<Subscriber<()>> {
    let shared = Arc::clone(shared);
    session
        .declare_subscriber(key)
        .callback(move |sample| {
            if sample.kind() == SampleKind::Put {
                shared.arrive(number, &sample, false);
            }
        })
        .wait()
}

/// The token of a topic or service of the node.
pub(crate) fn token(
    config: &NodeConfig,
    session: &Session,
    (direction, number): (Direction, usize),
    topic: &Topic,
) -> String {
    let entity = entity(config, direction, number);
    topic.token(&config.name, &session.zid().to_string(), direction, entity)
}

/// The number of a topic or service among all of the node, which has number 0.
fn entity(config: &NodeConfig, direction: Direction, number: usize) -> usize {
    let before = match direction {
        Direction::Publish => 0,
        Direction::Subscribe => config.publications.len(),
        Direction::Serve => config.publications.len() + config.subscriptions.len(),
        Direction::Call => config.publications.len() + config.subscriptions.len() + config.services.len(),
    };
    1 + before + number
}
