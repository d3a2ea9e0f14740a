//! The tokens by which other nodes discover the topics and services of a node. Some depend on what other nodes have. To a
//! bridge of DDS a node has no tokens, but a topic of two types has one key there: messages of one type pass.

use std::collections::{BTreeMap, BTreeSet};

use zenoh::liveliness::LivelinessToken;
use zenoh::{Session, Wait};

use crate::declare::token;
use crate::keys::{Announced, Direction, Topic};
use crate::node::NodeConfig;
use crate::shared::Shared;

/// The declared tokens. Dropping it withdraws them.
#[derive(Default)]
pub(crate) struct Announcements {
    tokens: BTreeMap<(Direction, usize), LivelinessToken>,
    /// Topics that other nodes have in the opposite direction.
    met: BTreeSet<(Direction, usize)>,
}

impl Announcements {
    /// Records that another node has a topic in the opposite direction. Returns whether that is new.
    pub(crate) fn meet(&mut self, direction: Direction, number: usize) -> bool {
        self.met.insert((direction, number))
    }

    /// Declares and withdraws tokens according to what was met. Without a token only tools do not see a topic; its messages
    /// pass.
    ///
    /// # Errors
    /// Of Zenoh.
    pub(crate) fn update(
        &mut self,
        shared: &Shared,
        config: &NodeConfig,
        session: &Session,
    ) -> zenoh::Result<()> {
        for (direction, topics) in config.all_topics() {
            for (number, topic) in topics.iter().enumerate() {
                let place = (direction, number);
                if config.name.is_bridged() {
                    shared.set_passing(place, self.is_due(place, topic, &topics));
                } else if !self.is_due(place, topic, &topics) {
                    self.tokens.remove(&place);
                } else if !self.tokens.contains_key(&place) {
                    let token = token(config, session, place, topic);
                    let declared = session.liveliness().declare_token(token).wait()?;
                    self.tokens.insert(place, declared);
                }
            }
        }
        Ok(())
    }

    fn is_due(&self, place: (Direction, usize), topic: &Topic, topics: &[Topic]) -> bool {
        let is_met = self.met.contains(&place);
        match topic.announced {
            Announced::Always => true,
            Announced::OnceMet => is_met,
            Announced::Preferably => {
                let mut others = topics.iter().enumerate();
                let has_met_other = others.any(|(number, other)| {
                    other.name == topic.name
                        && other.announced == Announced::OnceMet
                        && self.met.contains(&(place.0, number))
                });
                is_met || !has_met_other
            }
        }
    }
}
