//! The tokens by which other nodes discover the topics and services of a node. Some depend on what other nodes have. To a
//! bridge of DDS a node has no tokens, but a topic of two types has one key there: messages of one type pass.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use zenoh::liveliness::LivelinessToken;
use zenoh::{Session, Wait};

use crate::declare::token;
use crate::keys::{Announced, Direction, Topic};
use crate::node::NodeConfig;
use crate::send_queue::Meeting;
use crate::shared::Shared;

/// A topic: its direction, and its number there.
type Place = (Direction, usize);

/// The declared tokens. Dropping it withdraws them.
#[derive(Default)]
pub(crate) struct Announcements {
    tokens: BTreeMap<Place, LivelinessToken>,
    /// The tokens of other nodes that have a topic in the opposite direction.
    met: BTreeMap<Place, BTreeSet<String>>,
}

impl Announcements {
    /// Records that another node has, or no longer has, a topic in the opposite direction.
    pub(crate) fn record(&mut self, meeting: Meeting) {
        let met = self.met.entry(meeting.place).or_default();
        match meeting.appears {
            true => met.insert(meeting.token),
            false => met.remove(&meeting.token),
        };
    }

    /// Declares and withdraws tokens according to what was met. Without a token only tools do not see a topic; its messages
    /// pass.
    ///
    /// # Errors
    /// Of Zenoh, at the first topic; all others are announced.
    pub(crate) fn update(
        &mut self,
        shared: &Shared,
        config: &NodeConfig,
        session: &Session,
    ) -> zenoh::Result<()> {
        let mut outcome = Ok(());
        for (direction, topics) in config.all_topics() {
            for (number, topic) in topics.iter().enumerate() {
                let place = (direction, number);
                if config.name.is_bridged() {
                    shared.set_passing(place, self.is_passing(place, topic, &topics));
                } else if !self.is_due(shared, place, topic, &topics) {
                    self.tokens.remove(&place);
                } else if let Entry::Vacant(entry) = self.tokens.entry(place) {
                    let token = token(config, session, place, topic);
                    match session.liveliness().declare_token(token).wait() {
                        Ok(declared) => drop(entry.insert(declared)),
                        Err(error) => outcome = outcome.and(Err(error)),
                    }
                }
            }
        }
        outcome
    }

    /// Whether a topic is announced.
    fn is_due(&self, shared: &Shared, place: Place, topic: &Topic, topics: &[Topic]) -> bool {
        if topic.is_standby && place.0 == Direction::Publish {
            return false;
        }
        match topic.announced {
            Announced::Always => true,
            Announced::WhileWanted => shared.is_wanted(place.1),
            Announced::OnceMet => self.is_met(place),
            Announced::Preferably => self.is_met(place) || !self.has_met_other(place, topic, topics),
        }
    }

    /// Whether messages of a topic pass a bridge.
    fn is_passing(&self, place: Place, topic: &Topic, topics: &[Topic]) -> bool {
        match topic.announced {
            Announced::Always | Announced::WhileWanted => true,
            Announced::OnceMet => self.is_met(place),
            Announced::Preferably => !self.has_met_other(place, topic, topics),
        }
    }

    /// Whether others have the topic of this name that is announced once it is met.
    fn has_met_other(&self, (direction, _): Place, topic: &Topic, topics: &[Topic]) -> bool {
        topics.iter().enumerate().any(|(number, other)| {
            other.name == topic.name
                && other.announced == Announced::OnceMet
                && self.is_met((direction, number))
        })
    }

    fn is_met(&self, place: Place) -> bool {
        self.met.get(&place).is_some_and(|tokens| !tokens.is_empty())
    }
}
