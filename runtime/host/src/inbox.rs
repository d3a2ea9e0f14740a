//! The signals that an instance receives at its next turn. Their number is bounded, however long the instance
//! hangs in a call.

use std::time::Instant;

use jde_core::{GroupId, Level, Nanos};

use crate::engine::Signal;

/// The signals that an instance receives at its next turn.
#[derive(Debug, Default)]
pub(crate) struct Inbox {
    /// Awakenings, with their times, and sleeps (`None`), in order: at most two, of which the last is the
    /// current state.
    pub(crate) transitions: Vec<Option<Nanos>>,
    pub(crate) promoted: bool,
    pub(crate) triggered: bool,
    pub(crate) turn_requested: bool,
    pub(crate) period_changed: bool,
    pub(crate) replaced: bool,
    pub(crate) unloaded: bool,
    /// A viewer opened its panel.
    pub(crate) panel_opened: bool,
    /// Gestures wait for it: see `panels`.
    pub(crate) gesture_queued: bool,
    /// Another build waits to take over: see `reload::BuildRegistry`.
    pub(crate) build_pending: bool,
    /// At most one request for each group.
    pub(crate) arbitration_requests: Vec<(GroupId, u64, Level)>,
    /// When the first of them arrived.
    pub(crate) since: Option<Instant>,
}

impl Inbox {
    pub(crate) fn push(&mut self, signal: Signal) {
        self.since.get_or_insert_with(Instant::now);
        match signal {
            Signal::Awake(time) => self.push_transition(Some(time)),
            Signal::Asleep => {
                self.push_transition(None);
                self.promoted = false;
            }
            Signal::Replaced => self.replaced = true,
            Signal::Unloaded => self.unloaded = true,
            Signal::Promoted => self.promoted = true,
            Signal::Triggered => self.triggered = true,
            Signal::TurnRequested => self.turn_requested = true,
            Signal::PeriodChanged => self.period_changed = true,
            Signal::PanelOpened => self.panel_opened = true,
            Signal::GestureQueued => self.gesture_queued = true,
            Signal::BuildPending => self.build_pending = true,
            Signal::ArbitrationRequested { group, ticket, level } => {
                // A group has one open request at a time, so an older one is void.
                self.arbitration_requests.retain(|(other, ..)| *other != group);
                self.arbitration_requests.push((group, ticket, level));
            }
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        let has_turn = self.promoted || self.triggered || self.turn_requested;
        let has_rule_signal = has_turn || self.period_changed || self.replaced || self.unloaded;
        let has_signal = has_rule_signal || self.panel_opened || self.gesture_queued || self.build_pending;
        self.transitions.is_empty() && self.arbitration_requests.is_empty() && !has_signal
    }

    /// Whether a turn with these signals takes no longer than a periodic turn: it only checks and may
    /// iterate.
    pub(crate) fn is_light(&self) -> bool {
        let is_heavy = self.replaced || self.unloaded || self.gesture_queued || self.build_pending;
        self.transitions.is_empty() && self.arbitration_requests.is_empty() && !is_heavy
    }

    /// Combines sleeps and awakenings. Sleeping and waking up again are two calls; a repetition would have no
    /// further effect.
    fn push_transition(&mut self, awake: Option<Nanos>) {
        if self.transitions.last().map(Option::is_some) == Some(awake.is_some()) {
            return;
        }
        if self.transitions.len() == 2 {
            self.transitions.pop();
        } else {
            self.transitions.push(awake);
        }
    }
}

#[cfg(test)]
mod tests {
    use jde_core::Case;

    use super::*;

    fn arbitration_request(group: u32, ticket: u64) -> Signal {
        let level = Level {
            group: GroupId(group),
            case: Case::Absence,
            candidates: [].into(),
            winner: None,
        };
        Signal::ArbitrationRequested {
            group: GroupId(group),
            ticket,
            level,
        }
    }

    #[test]
    fn a_sequence_of_transitions_is_reduced_to_at_most_two_with_the_same_result() {
        for pattern in 0..1_u32 << 8 {
            let mut inbox = Inbox::default();
            let signals: Vec<Option<Nanos>> =
                (0..8).map(|bit| (pattern >> bit & 1 == 1).then_some(7)).collect();
            for awake in &signals {
                inbox.push(awake.map_or(Signal::Asleep, Signal::Awake));
            }
            assert!((1..=2).contains(&inbox.transitions.len()), "{signals:?}");
            assert_eq!(inbox.transitions.last(), signals.last(), "{signals:?}");
            assert_eq!(inbox.transitions.first(), signals.first(), "{signals:?}");
        }
    }

    #[test]
    fn r4_a_hung_father_receives_only_the_newest_request_of_each_group() {
        let mut inbox = Inbox::default();
        for ticket in 0..1000 {
            inbox.push(arbitration_request(0, 2 * ticket));
            inbox.push(arbitration_request(1, 2 * ticket + 1));
        }
        let tickets: Vec<u64> = inbox
            .arbitration_requests
            .iter()
            .map(|(_, ticket, _)| *ticket)
            .collect();
        assert_eq!(tickets, [1998, 1999]);
    }

    #[test]
    fn r5_sleep_cancels_a_pending_promotion() {
        let mut inbox = Inbox::default();
        inbox.push(Signal::Promoted);
        inbox.push(Signal::Asleep);
        inbox.push(Signal::Awake(0));
        assert!(!inbox.promoted);
        assert!(!inbox.is_empty());
    }
}
