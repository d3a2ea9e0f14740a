//! What pages look at beside the state: values of a schema, its panel, the robot from above. All pages that look at the same
//! share one subscription, and their number is bounded, so pages cost the application no more than one of them. Those who
//! only look have a part of it, which gives way to those who may operate.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use jde_link::Subscription;
use parking_lot::Mutex;
use serde::{Deserialize, Serialize};
use tokio::sync::Notify;
use tokio::time::sleep;

use crate::floor::{self, Floor};
use crate::model::Model;
use crate::server::Page;
use crate::settings::Right;
use crate::{panel, values};

/// Topics at once: each has at most 64 variables, and a session of the link has 4096.
const MAX_TOPICS: usize = 32;
/// Topics of pages that only look, among them.
const MAX_ONLOOKERS: usize = 16;
/// Topics that are opened before others may be wanted.
const MAX_OPENED: usize = 4;
/// How long the application is left alone between two changes of what is wanted.
const PAUSE: Duration = Duration::from_millis(100);

/// What a page can look at.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "what", content = "of")]
pub(crate) enum Topic {
    /// The values of a schema.
    Values(String),
    /// The panel of a schema.
    Panel(String),
    /// The robots from above.
    Floor,
}

/// What all pages look at.
#[derive(Default)]
pub(crate) struct Feeds {
    /// By the number of the socket, which grows.
    wanted: Mutex<BTreeMap<u64, (Right, BTreeSet<Topic>)>>,
    open: Mutex<BTreeMap<Topic, Arc<Feed>>>,
    changed: Notify,
}

/// A topic, for as long as a page looks at it.
pub(crate) struct Feed {
    parts: Arc<Parts>,
    floor: Option<Arc<Mutex<Floor>>>,
    /// None if there is no such topic, or no room for it.
    subscriptions: Option<Vec<Subscription>>,
}

/// The newest content of a topic, each part as JSON with the number of its version.
#[derive(Default)]
pub(crate) struct Parts(Mutex<BTreeMap<usize, (u64, String)>>);

/// The versions of all parts of all topics, so that a topic that is opened again is newer than it was.
static VERSION: AtomicU64 = AtomicU64::new(1);

impl Parts {
    /// Replaces a part.
    pub(crate) fn set(&self, place: usize, part: &impl Serialize) {
        // Text and numbers always have a form in JSON.
        let part = serde_json::to_string(part).unwrap_or_default();
        let mut parts = self.0.lock();
        parts.insert(place, (VERSION.fetch_add(1, Ordering::Relaxed), part));
    }
}

impl Feed {
    /// Creates the feed of a topic. Waits for the link.
    fn open(model: &Model, topic: &Topic) -> Self {
        let parts = Arc::new(Parts::default());
        let opened = match topic {
            Topic::Values(schema) => values::open(model, schema, &parts).map(|all| (all, None)),
            Topic::Panel(schema) => panel::open(model, schema, &parts).map(|all| (all, None)),
            Topic::Floor => floor::open(model).map(|(all, floor)| (all, Some(floor))),
        };
        match opened {
            Ok((subscriptions, floor)) => Self {
                parts,
                floor,
                subscriptions: Some(subscriptions),
            },
            Err(reason) => Self::refused(&reason),
        }
    }

    fn refused(reason: &str) -> Self {
        let parts = Parts::default();
        parts.set(0, &serde_json::json!({ "error": reason }));
        Self {
            parts: Arc::new(parts),
            floor: None,
            subscriptions: None,
        }
    }

    /// Returns what is newer than a version, as a list in JSON, and its version.
    pub(crate) fn after(&self, seen: u64) -> Option<(u64, String)> {
        if let Some(floor) = &self.floor {
            floor.lock().draw(&self.parts);
        }
        let parts = self.parts.0.lock();
        let newer = parts.values().filter(|(version, _)| *version > seen);
        let newest = newer.clone().map(|(version, _)| *version).max()?;
        let parts: Vec<_> = newer.map(|(_, part)| part.as_str()).collect();
        Some((newest, format!("[{}]", parts.join(","))))
    }
}

impl Feeds {
    /// Sets what a page looks at. Waits for nothing.
    pub(crate) fn want(&self, socket: u64, right: Right, topics: BTreeSet<Topic>) {
        let mut wanted = self.wanted.lock();
        if topics.is_empty() {
            wanted.remove(&socket);
        } else {
            wanted.insert(socket, (right, topics));
        }
        drop(wanted);
        self.changed.notify_one();
    }

    /// Returns a topic, if it is open.
    pub(crate) fn get(&self, topic: &Topic) -> Option<Arc<Feed>> {
        self.open.lock().get(topic).cloned()
    }

    /// Returns the topics that have room, those of operators first, and the others.
    fn choose(&self) -> (Vec<Topic>, Vec<Topic>) {
        let (mut chosen, mut left_out) = (Vec::new(), Vec::new());
        let wanted = self.wanted.lock();
        for (wanting, room) in [(Right::Operate, MAX_TOPICS), (Right::Read, MAX_ONLOOKERS)] {
            let before = chosen.len();
            let of_right = wanted.values().filter(|(right, _)| *right == wanting);
            for topic in of_right.flat_map(|(_, topics)| topics) {
                if chosen.contains(topic) || left_out.contains(topic) {
                    continue;
                }
                let has_room = chosen.len() < MAX_TOPICS && chosen.len() - before < room;
                let list = if has_room { &mut chosen } else { &mut left_out };
                list.push(topic.clone());
            }
        }
        (chosen, left_out)
    }

    /// Opens and closes topics as they are wanted. Waits for the link. Returns whether all that is wanted is open.
    fn settle(&self, model: &Model) -> bool {
        let (chosen, left_out) = self.choose();
        let mut closed = Vec::new();
        self.open.lock().retain(|topic, feed| {
            let is_kept = chosen.contains(topic) && feed.subscriptions.is_some();
            if !is_kept {
                closed.push(Arc::clone(feed));
            }
            is_kept
        });
        // Subscriptions end here, where nobody waits.
        drop(closed);
        let is_new = |topic: &&Topic| !self.open.lock().contains_key(*topic);
        let new: Vec<_> = chosen.iter().filter(is_new).collect();
        for topic in new.iter().take(MAX_OPENED) {
            let feed = Arc::new(Feed::open(model, topic));
            self.open.lock().insert((*topic).clone(), feed);
        }
        for topic in left_out {
            let text = "the pages look at too much at once; close something on another page";
            self.open.lock().insert(topic, Arc::new(Feed::refused(text)));
        }
        new.len() <= MAX_OPENED
    }
}

/// Opens and closes topics for as long as the page is served.
pub(crate) async fn keep(page: &Arc<Page>) {
    loop {
        page.feeds.changed.notified().await;
        let served = Arc::clone(page);
        let settled = tokio::task::spawn_blocking(move || served.feeds.settle(&served.model)).await;
        if !settled.unwrap_or(true) {
            page.feeds.changed.notify_one();
        }
        sleep(PAUSE).await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(schemas: impl IntoIterator<Item = usize>) -> BTreeSet<Topic> {
        let topics = schemas
            .into_iter()
            .map(|schema| Topic::Values(format!("schema{schema}")));
        topics.collect()
    }

    #[test]
    fn those_who_only_look_never_take_what_an_operator_looks_at() {
        let feeds = Feeds::default();
        for page in 0..48 {
            feeds.want(
                page,
                Right::Read,
                values(3 * page as usize..3 * page as usize + 3),
            );
        }
        let (chosen, left_out) = feeds.choose();
        assert_eq!(
            (chosen.len(), left_out.len()),
            (MAX_ONLOOKERS, 48 * 3 - MAX_ONLOOKERS)
        );
        // An operator has what nobody else has, and what others were refused.
        feeds.want(99, Right::Operate, values([1000, 143]));
        let (chosen, left_out) = feeds.choose();
        assert_eq!(
            chosen[..2],
            [
                Topic::Values("schema1000".to_owned()),
                Topic::Values("schema143".to_owned())
            ]
        );
        assert_eq!(
            (chosen.len(), left_out.len()),
            (2 + MAX_ONLOOKERS, 143 - MAX_ONLOOKERS)
        );
        for page in 100..120 {
            feeds.want(
                page,
                Right::Operate,
                values(2000 + 3 * page as usize..2003 + 3 * page as usize),
            );
        }
        let (chosen, _) = feeds.choose();
        assert_eq!(chosen.len(), MAX_TOPICS);
        assert!(
            !chosen.contains(&Topic::Values("schema0".to_owned())),
            "they give way"
        );
    }

    #[test]
    fn pages_that_look_at_the_same_cost_what_one_costs() {
        let feeds = Feeds::default();
        for page in 0..60 {
            feeds.want(page, Right::Read, values([7]));
        }
        assert_eq!(feeds.choose().0.len(), 1);
        (0..60).for_each(|page| feeds.want(page, Right::Read, BTreeSet::new()));
        assert_eq!(feeds.choose().0.len(), 0);
    }
}
