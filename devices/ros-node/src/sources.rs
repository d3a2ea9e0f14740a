//! The nodes that send one measurement. Two that do contradict each other, so none of their messages counts while both send.

use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

use crate::attachment::Gid;

/// How long after its newest message a publication counts as one that sends: longer than the period of any sensor of a base.
const SENDS_WITHIN: Duration = Duration::from_secs(2);
/// Contradicting messages until a publication without a known name is remarked, too: its token may come after its messages.
const UNNAMED_MESSAGES: u32 = 20;
/// Most publications that are remembered.
const MAX_PUBLICATIONS: usize = 64;

/// The publications of a topic that has one source.
#[derive(Debug, Default)]
pub(crate) struct Sources {
    /// The names of their nodes, by the tokens.
    names: BTreeMap<Gid, String>,
    /// When each sent its newest message.
    sent: BTreeMap<Gid, Instant>,
    /// Those that have ended. A message of theirs may still come.
    ended: VecDeque<Gid>,
    contradicting: u32,
}

/// Whether a message counts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Acceptance {
    /// It is of the only source.
    Only,
    /// It is of a source that has ended.
    Late,
    /// Another source sends too: what to remark, once it is known.
    Contradicted(Option<String>),
}

impl Sources {
    /// A publication begins, of a node of that name.
    pub(crate) fn appear(&mut self, publication: Gid, name: String) {
        self.ended.retain(|ended| *ended != publication);
        if self.names.len() < MAX_PUBLICATIONS {
            self.names.insert(publication, name);
        }
    }

    /// A publication ends.
    pub(crate) fn disappear(&mut self, publication: Gid) {
        self.names.remove(&publication);
        self.sent.remove(&publication);
        if self.ended.len() >= MAX_PUBLICATIONS {
            self.ended.pop_front();
        }
        self.ended.push_back(publication);
    }

    /// Judges a message of a publication.
    pub(crate) fn judge(&mut self, topic: &str, publication: Gid, now: Instant) -> Acceptance {
        if self.ended.contains(&publication) {
            return Acceptance::Late;
        }
        if self.sent.len() < MAX_PUBLICATIONS || self.sent.contains_key(&publication) {
            self.sent.insert(publication, now);
        }
        if !self.contradict(now) {
            self.contradicting = 0;
            return Acceptance::Only;
        }
        self.contradicting = self.contradicting.saturating_add(1);
        let names: Vec<_> = self.sent.keys().map(|gid| self.names.get(gid)).collect();
        if self.contradicting < UNNAMED_MESSAGES && names.iter().any(Option::is_none) {
            return Acceptance::Contradicted(None);
        }
        let mut names: Vec<_> = names
            .into_iter()
            .map(|name| {
                name.map_or_else(
                    || "a node without a token".to_owned(),
                    |name| format!("node {name}"),
                )
            })
            .collect();
        names.sort();
        Acceptance::Contradicted(Some(format!(
            "{} publish {topic}, and contradict each other: it has no value here until only one does; stop the others, or give \
             them other topics",
            names.join(" and ")
        )))
    }

    /// Whether more than one source sends.
    pub(crate) fn contradict(&mut self, now: Instant) -> bool {
        self.sent
            .retain(|_, sent| now.saturating_duration_since(*sent) <= SENDS_WITHIN);
        self.sent.len() > 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gid(number: u8) -> Gid {
        [number; 16]
    }

    #[test]
    fn messages_of_two_publications_count_only_while_one_alone_sends() {
        let (mut sources, start) = (Sources::default(), Instant::now());
        let at = |ms| start + Duration::from_millis(ms);
        sources.appear(gid(1), "/lidar".to_owned());
        sources.appear(gid(2), "/bag".to_owned());
        assert_eq!(sources.judge("/scan", gid(1), at(0)), Acceptance::Only);
        let Acceptance::Contradicted(Some(remark)) = sources.judge("/scan", gid(2), at(100)) else {
            panic!("two send");
        };
        assert!(
            remark.starts_with("node /bag and node /lidar publish /scan, and contradict each other"),
            "{remark}"
        );
        assert!(matches!(
            sources.judge("/scan", gid(1), at(200)),
            Acceptance::Contradicted(_)
        ));
        assert_eq!(
            sources.judge("/scan", gid(1), at(2101)),
            Acceptance::Only,
            "the other is silent"
        );
        assert!(matches!(
            sources.judge("/scan", gid(2), at(2200)),
            Acceptance::Contradicted(_)
        ));
        sources.disappear(gid(1));
        assert_eq!(
            sources.judge("/scan", gid(2), at(2300)),
            Acceptance::Only,
            "the other has ended"
        );
        assert_eq!(sources.judge("/scan", gid(1), at(2310)), Acceptance::Late);
        assert_eq!(sources.judge("/scan", gid(2), at(2320)), Acceptance::Only);
        sources.appear(gid(1), "/lidar".to_owned());
        assert_ne!(
            sources.judge("/scan", gid(1), at(2330)),
            Acceptance::Late,
            "it is there again"
        );
    }

    #[test]
    fn a_source_without_a_token_is_remarked_later() {
        let (mut sources, now) = (Sources::default(), Instant::now());
        sources.appear(gid(1), "/lidar".to_owned());
        assert_eq!(sources.judge("/scan", gid(1), now), Acceptance::Only);
        let remarks = (0..UNNAMED_MESSAGES).filter_map(|_| match sources.judge("/scan", gid(9), now) {
            Acceptance::Contradicted(remark) => remark,
            Acceptance::Only | Acceptance::Late => panic!("two send"),
        });
        let remarks: Vec<_> = remarks.collect();
        assert_eq!(remarks.len(), 1);
        assert!(
            remarks[0].starts_with("a node without a token and node /lidar publish"),
            "{remarks:?}"
        );
    }
}
