//! Chattering: the winner of a group changes repeatedly within a second. It counts switches and judges no
//! single one.

use std::collections::VecDeque;

use jde_core::{Decider, Nanos, Policy, Record};

/// The time over which switches are counted, ns.
pub const WINDOW: Nanos = 1_000_000_000;
/// A group chatters when its winner changes more often than this within a second: a robot that switched from
/// one behaviour to another and back twice in a second has completed neither.
pub const MANY: usize = 4;
/// Chattering ends when at most this many switches are left: there and back.
pub const FEW: usize = 2;

/// The switches of one group within the last second; `P` identifies the schemas between which a switch
/// occurred.
#[derive(Clone, Debug)]
pub struct Chatter<P> {
    many: usize,
    few: usize,
    switches: VecDeque<(Nanos, P)>,
    on: bool,
}

impl<P: Clone + PartialEq> Default for Chatter<P> {
    fn default() -> Self {
        Self::new(MANY, FEW)
    }
}

impl<P: Clone + PartialEq> Chatter<P> {
    /// Creates a counter. Chattering begins with more than `many` switches within a second, and ends when at
    /// most `few` are left.
    #[must_use]
    pub fn new(many: usize, few: usize) -> Self {
        Self {
            many,
            few,
            switches: VecDeque::new(),
            on: false,
        }
    }

    /// Counts a switch. Returns the number of switches within the last second if chattering begins with this
    /// one.
    pub fn switched(&mut self, time: Nanos, between: P) -> Option<usize> {
        self.calmed(time);
        self.switches.push_back((time, between));
        let count = self.switches.len();
        (count > self.many && !std::mem::replace(&mut self.on, true)).then_some(count)
    }

    /// Advances the time. Returns whether chattering has ended since the last call.
    pub fn calmed(&mut self, now: Nanos) -> bool {
        while self
            .switches
            .pop_front_if(|(then, _)| then.saturating_add(WINDOW) <= now)
            .is_some()
        {}
        let calm = self.switches.len() <= self.few;
        calm && std::mem::replace(&mut self.on, false)
    }

    /// Whether it chatters.
    #[must_use]
    pub fn is_on(&self) -> bool {
        self.on
    }

    /// Switches within the last second.
    #[must_use]
    pub fn count(&self) -> usize {
        self.switches.len()
    }

    /// The pair with the most switches within the last second.
    #[must_use]
    pub fn between(&self) -> Option<P> {
        let times = |pair: &P| self.switches.iter().filter(|(_, other)| other == pair).count();
        let most = self.switches.iter().max_by_key(|(_, pair)| times(pair));
        most.map(|(_, pair)| pair.clone())
    }
}

/// The pair of schemas between which a selection switched, the same for either direction. `None` if the
/// winner did not change, or changed by intention: by round-robin or by an operator.
#[must_use]
pub fn pair(record: &Record) -> Option<[Option<usize>; 2]> {
    let meant = match record.decider {
        Decider::Policy(Policy::RoundRobin { .. }) | Decider::Operator => true,
        Decider::Nobody
        | Decider::Policy(_)
        | Decider::Father
        | Decider::ArbitrationFailed
        | Decider::AbsencePolicy => false,
    };
    if meant || !record.changed {
        return None;
    }
    let mut pair = [record.before, record.choice].map(|id| id.map(jde_core::SchemaId::index));
    pair.sort_unstable();
    Some(pair)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Nanos = 1_000_000;

    #[test]
    fn chattering_begins_with_the_fifth_switch_within_a_second_and_once() {
        let mut chatter = Chatter::default();
        let began: Vec<_> = (0..8).map(|time| chatter.switched(time * 200 * MS, ())).collect();
        assert_eq!(began, [None, None, None, None, Some(5), None, None, None]);
    }

    #[test]
    fn four_switches_a_second_are_none() {
        let mut chatter = Chatter::default();
        assert!((0..100).all(|time| chatter.switched(time * 250 * MS, ()).is_none()));
    }

    #[test]
    fn it_is_over_when_a_second_has_no_more_than_two_and_is_told_once() {
        let mut chatter = Chatter::default();
        for time in 0..6 {
            chatter.switched(time * 100 * MS, ());
        }
        assert!(!chatter.calmed(1299 * MS), "three within the last second");
        assert!(chatter.calmed(1300 * MS));
        assert!(!chatter.calmed(1301 * MS));
        assert_eq!(chatter.count(), 2);
    }

    #[test]
    fn the_two_that_alternate_most_are_named() {
        let mut chatter = Chatter::default();
        for (time, pair) in [(0, "ac"), (100, "ab"), (200, "ab"), (300, "bc"), (400, "ab")] {
            chatter.switched(time * MS, pair);
        }
        assert_eq!(chatter.between(), Some("ab"));
    }
}
