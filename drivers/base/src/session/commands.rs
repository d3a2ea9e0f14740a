//! The commands to a board: what is sent and when, and whether it is acknowledged.

use core::time::Duration;
use std::collections::VecDeque;

use jde_schema::prelude::Twist;

use crate::hello::Hello;
use crate::line::line;

/// Longest time without an acknowledgement. A line waits for the board's period and for ours.
const PATIENCE: Duration = Duration::from_millis(500);
/// Longest round trip of a command and its acknowledgement, beyond the board's period.
const ROUND_TRIP: Duration = Duration::from_millis(200);
/// Time for which all round trips may be longer.
const SLOW: Duration = Duration::from_secs(2);
/// A board hears so many commands in the time of its watchdog: three may be lost.
const COMMANDS_A_WATCHDOG: u32 = 4;
/// Longest time between two commands, for a board with a long watchdog.
const MAX_INTERVAL: Duration = Duration::from_millis(100);

/// The commands of one session.
#[derive(Debug, Default)]
pub(super) struct Commands {
    /// The number of the next command.
    next: u16,
    /// The last one: its speeds in thousandths, and when it was sent.
    last: Option<([i32; 3], Duration)>,
    /// The last one that the board has acknowledged; the first before that.
    acknowledged: u16,
    /// Since when all round trips are too long.
    slow_since: Option<Duration>,
    /// Those that are not acknowledged yet, with the times at which they were sent.
    pending: VecDeque<(u16, Duration)>,
    /// Since when the speeds are 0.
    standing_since: Option<Duration>,
}

impl Commands {
    /// Returns the line that commands these speeds, if they are new or due again.
    pub(super) fn drive(&mut self, twist: &Twist, hello: &Hello, now: Duration) -> Vec<u8> {
        let speeds = [
            thousandths(twist.linear.x),
            thousandths(twist.linear.y),
            thousandths(twist.angular.z),
        ];
        let interval = Duration::from_millis(hello.watchdog.into()) / COMMANDS_A_WATCHDOG;
        let interval = interval.min(MAX_INTERVAL);
        let is_due = |(last, sent): ([i32; 3], Duration)| last != speeds || now >= sent + interval;
        if !self.last.is_none_or(is_due) {
            return Vec::new();
        }
        if speeds == [0; 3] {
            self.standing_since.get_or_insert(now);
        } else {
            self.standing_since = None;
        }
        self.last = Some((speeds, now));
        self.pending.push_back((self.next, now));
        let [ahead, left, turn] = speeds;
        let text = format!("v {} {ahead} {left} {turn}", self.next);
        self.next = self.next.wrapping_add(1);
        line(&text)
    }

    /// When a command was sent that is not acknowledged yet.
    pub(super) fn sent(&self, number: u16) -> Option<Duration> {
        let command = self.pending.iter().find(|(other, _)| *other == number);
        command.map(|(_, sent)| *sent)
    }

    /// Notes at `now` the command that the board has in force. Returns whether it can be one of these.
    pub(super) fn acknowledge(&mut self, number: u16, hello: &Hello, now: Duration) -> bool {
        let Some(last) = self.last.map(|_| self.next.wrapping_sub(1)) else {
            return false;
        };
        if number.wrapping_sub(self.acknowledged) > last.wrapping_sub(self.acknowledged) {
            return false;
        }
        if let Some(sent) = self.sent(number) {
            let longest = ROUND_TRIP + Duration::from_millis(hello.period.into());
            if now.saturating_sub(sent) > longest {
                self.slow_since.get_or_insert(now);
            } else {
                self.slow_since = None;
            }
        }
        self.acknowledged = number;
        self.pending
            .retain(|(sent, _)| (number.wrapping_sub(*sent) as i16) < 0);
        true
    }

    /// Whether the last round trip was not too long.
    pub(super) fn is_quick(&self) -> bool {
        self.slow_since.is_none()
    }

    /// Whether the round trips have been too long for too long a time.
    pub(super) fn is_slow(&self, now: Duration) -> bool {
        self.slow_since
            .is_some_and(|since| now.saturating_sub(since) > SLOW)
    }

    /// Whether a command has waited too long for its acknowledgement.
    pub(super) fn is_ignored(&self, now: Duration) -> bool {
        self.pending
            .front()
            .is_some_and(|(_, sent)| now.saturating_sub(*sent) > PATIENCE)
    }

    /// Waits for no earlier command: nothing was read meanwhile.
    pub(super) fn forgive(&mut self) {
        self.pending.clear();
    }

    /// Since when the board has been told to stand, if it has.
    pub(super) fn standing_since(&self) -> Option<Duration> {
        self.standing_since
    }
}

/// NaN becomes 0, and what is larger than any limit stays so.
fn thousandths(value: f64) -> i32 {
    (value * 1000.0).round().clamp(-999_999.0, 999_999.0) as i32
}
