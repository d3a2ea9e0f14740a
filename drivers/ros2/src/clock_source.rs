//! The clock of the stamps in ROS 2, and what happens to that of a simulation.

use core::time::Duration;

use jde_schema::prelude::*;

/// The topic of the time of a simulation, for all nodes of a domain.
pub(crate) const TOPIC: &str = "/clock";

/// The clock of the stamps, for a driver that follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
#[repr(u8)]
pub(crate) enum FollowedClock {
    /// That of the machine.
    Wall,
    /// That of `/clock`.
    Follow,
}

/// The clock of the stamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Choice)]
#[repr(u8)]
pub(crate) enum ClockSource {
    /// That of the machine.
    Wall,
    /// That of `/clock`.
    Follow,
    /// That of the application, which is published on `/clock`.
    Publish,
}

/// The time of a simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Value)]
#[repr(C)]
#[value(name = "rosgraph_msgs/msg/Clock")]
pub(crate) struct ClockMessage {
    pub(crate) clock: Time,
}

impl From<FollowedClock> for ClockSource {
    fn from(clock: FollowedClock) -> Self {
        match clock {
            FollowedClock::Wall => Self::Wall,
            FollowedClock::Follow => Self::Follow,
        }
    }
}

/// How long the time on `/clock` may stand until it counts as none: longer than between two messages of any simulation.
const STANDSTILL_TIME: Duration = Duration::from_secs(2);
/// A step forward by more than this and by more than [`MAX_RATE`] times the time of this machine is a jump.
const JUMP: Duration = Duration::from_secs(1);
/// The fastest simulation, in its time per time of this machine.
const MAX_RATE: u32 = 20;

/// What the messages of `/clock` have told.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ClockWatch {
    /// The newest time, and when it arrived first.
    newest: Option<(Duration, Duration)>,
    has_ended: bool,
}

/// What a message of `/clock` tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tick {
    /// The time goes on.
    Onward,
    /// It stands.
    Same,
    /// It has jumped forward.
    Forward(Duration),
    /// It has jumped back.
    Back(Duration),
}

impl ClockWatch {
    /// Takes a time that arrived at `now`.
    pub(crate) fn take(&mut self, now: Duration, time: Duration) -> Tick {
        let Some((newest, since)) = self.newest else {
            self.newest = Some((time, now));
            return Tick::Onward;
        };
        if time == newest {
            return Tick::Same;
        }
        (self.newest, self.has_ended) = (Some((time, now)), false);
        let Some(step) = time.checked_sub(newest) else {
            return Tick::Back(newest - time);
        };
        let passed = now.saturating_sub(since);
        if step > passed + JUMP && step > passed * MAX_RATE {
            return Tick::Forward(step);
        }
        Tick::Onward
    }

    /// Whether the time has just been standing for too long. It is none until it goes on.
    pub(crate) fn ends(&mut self, now: Duration) -> bool {
        let stands = self
            .newest
            .is_some_and(|(_, since)| now > since + STANDSTILL_TIME);
        let is_new = stands && !self.has_ended;
        self.has_ended |= stands;
        is_new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_that_jumps_or_stands_is_noticed() {
        let mut watch = ClockWatch::default();
        let ms = Duration::from_millis;
        assert!(!watch.ends(ms(9_000)), "there was none yet");
        for (now, time, expected) in [
            (0, 50_000, Tick::Onward),
            (100, 52_000, Tick::Onward),
            (200, 52_000, Tick::Same),
            (300, 51_000, Tick::Back(ms(1_000))),
            (400, 61_000, Tick::Forward(ms(10_000))),
            (500, 61_010, Tick::Onward),
        ] {
            assert_eq!(watch.take(ms(now), ms(time)), expected, "at {now} ms");
        }
        assert!(!watch.ends(ms(2_500)));
        assert_eq!(watch.take(ms(2_501), ms(61_010)), Tick::Same);
        assert!(watch.ends(ms(2_502)), "the same time again is none");
        assert!(!watch.ends(ms(2_503)), "it is said once");
        assert_eq!(watch.take(ms(2_600), ms(61_010)), Tick::Same);
        assert!(!watch.ends(ms(8_000)));
        assert_eq!(watch.take(ms(9_000), ms(61_020)), Tick::Onward);
    }
}
