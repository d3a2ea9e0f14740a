//! What a reader of a recording leaves out.

use std::collections::BTreeMap;

use jde_ros::cdr;

/// Messages that are no values of their type, by topic: how many, and why the first is none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LeftOut(BTreeMap<String, (u64, cdr::Error)>);

impl LeftOut {
    /// Counts a message.
    pub fn add(&mut self, topic: &str, reason: cdr::Error) {
        match self.0.get_mut(topic) {
            Some((count, _)) => *count += 1,
            None => drop(self.0.insert(topic.to_owned(), (1, reason))),
        }
    }

    /// Returns a line for each topic.
    pub fn lines(&self) -> impl Iterator<Item = String> {
        self.0.iter().map(|(topic, (count, reason))| {
            format!("messages of {topic} that are left out: {count}, because {reason}")
        })
    }
}
