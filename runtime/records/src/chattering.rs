//! Chattering: the winner of a group changes repeatedly within a second. It counts switches and judges no
//! single one.

use std::collections::VecDeque;

use jde_core::{Decider, Nanos, Record, SchemaId};

/// The time over which switches are counted, ns.
pub const WINDOW: Nanos = 1_000_000_000;
/// A group chatters when its winner changes more often than this within a second: a robot that switched from
/// one behaviour to another and back twice in a second has completed neither.
pub const MAX_SWITCHES: usize = 4;
/// Chattering ends when at most this many switches are left: there and back.
pub const CALM_SWITCHES: usize = 2;

/// The switches of one group within the last second; `P` identifies the schemas between which a switch
/// occurred.
#[derive(Clone, Debug)]
pub struct ChatterDetector<P> {
    onset: usize,
    calm: usize,
    switches: VecDeque<(Nanos, P)>,
    chattering: bool,
}

impl<P: Clone + PartialEq> Default for ChatterDetector<P> {
    fn default() -> Self {
        Self::new(MAX_SWITCHES, CALM_SWITCHES)
    }
}

impl<P: Clone + PartialEq> ChatterDetector<P> {
    /// Creates a counter. Chattering begins with more than `onset` switches within a second, and ends when at
    /// most `calm` are left.
    #[must_use]
    pub fn new(onset: usize, calm: usize) -> Self {
        Self {
            onset,
            calm,
            switches: VecDeque::new(),
            chattering: false,
        }
    }

    /// Counts a switch. Returns the number of switches within the last second if chattering begins with this
    /// one.
    pub fn record_switch(&mut self, time: Nanos, between: P) -> Option<usize> {
        self.advance(time);
        self.switches.push_back((time, between));
        let count = self.switches.len();
        (count > self.onset && !std::mem::replace(&mut self.chattering, true)).then_some(count)
    }

    /// Advances the time. Returns whether chattering has ended since the last call.
    pub fn advance(&mut self, now: Nanos) -> bool {
        while self
            .switches
            .pop_front_if(|(then, _)| then.saturating_add(WINDOW) <= now)
            .is_some()
        {}
        let calm = self.switches.len() <= self.calm;
        calm && std::mem::replace(&mut self.chattering, false)
    }

    /// Whether it chatters.
    #[must_use]
    pub fn is_chattering(&self) -> bool {
        self.chattering
    }

    /// Switches within the last second.
    #[must_use]
    pub fn count(&self) -> usize {
        self.switches.len()
    }

    /// The pair with the most switches within the last second.
    #[must_use]
    pub fn dominant_pair(&self) -> Option<P> {
        let count = |pair: &P| self.switches.iter().filter(|(_, other)| other == pair).count();
        let most = self.switches.iter().max_by_key(|(_, pair)| count(pair));
        most.map(|(_, pair)| pair.clone())
    }
}

/// The pair of schemas between which a selection switched, the same for either direction. `None` if the
/// winner did not change, or changed by intention: by round-robin or by an operator.
#[must_use]
pub fn switched_pair(record: &Record) -> Option<[Option<SchemaId>; 2]> {
    let intended = match record.decider {
        Decider::Policy(policy) => policy.kind().rotates,
        Decider::Operator => true,
        Decider::Nobody | Decider::Father | Decider::ArbitrationFailed | Decider::AbsencePolicy => false,
    };
    if intended || !record.changed {
        return None;
    }
    let mut pair = [record.before, record.choice];
    pair.sort_unstable();
    Some(pair)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Nanos = 1_000_000;

    #[test]
    fn chattering_begins_with_the_fifth_switch_within_a_second_and_once() {
        let mut chatter = ChatterDetector::default();
        let began: Vec<_> = (0..8)
            .map(|time| chatter.record_switch(time * 200 * MS, ()))
            .collect();
        assert_eq!(began, [None, None, None, None, Some(5), None, None, None]);
    }

    #[test]
    fn four_switches_a_second_are_not_chattering() {
        let mut chatter = ChatterDetector::default();
        assert!((0..100).all(|time| chatter.record_switch(time * 250 * MS, ()).is_none()));
    }

    #[test]
    fn chattering_ends_once_when_a_second_has_at_most_two_switches() {
        let mut chatter = ChatterDetector::default();
        for time in 0..6 {
            chatter.record_switch(time * 100 * MS, ());
        }
        assert!(!chatter.advance(1299 * MS), "three within the last second");
        assert!(chatter.advance(1300 * MS));
        assert!(!chatter.advance(1301 * MS));
        assert_eq!(chatter.count(), 2);
    }

    #[test]
    fn the_dominant_pair_has_the_most_switches() {
        let mut chatter = ChatterDetector::default();
        for (time, pair) in [(0, "ac"), (100, "ab"), (200, "ab"), (300, "bc"), (400, "ab")] {
            chatter.record_switch(time * MS, pair);
        }
        assert_eq!(chatter.dominant_pair(), Some("ab"));
    }
}
