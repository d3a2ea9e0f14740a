//! Asking for a simulator's laser, in the words of old and then in the newer ones. What its packets say is
//! `crate::laser`'s.

use core::time::Duration;

use super::{Beams, Event};
use crate::{Command, ForLaser};

/// How long to wait for a packet before asking in other words: simulators send one with every SIP.
const PATIENCE: Duration = Duration::from_secs(2);

/// How far the asking is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Asking {
    /// Nobody wants one, or it is heard, or there is none.
    Done,
    /// Asked in the words of SRIsim, 35 to 38, which every simulator knows that any client drives.
    Old(Beams, Duration),
    /// Asked in the words of later simulators, 230 to 233.
    New(Duration),
}

impl Asking {
    pub(super) fn begin(beams: Beams, now: Duration, mut say: impl FnMut(Command)) -> Self {
        say(Command::LaserStart36(beams.start_deg));
        say(Command::LaserEnd37(beams.end_deg));
        say(Command::LaserIncrement38(beams.increment_centideg));
        say(Command::LaserOn35(2));
        Self::Old(beams, now)
    }

    /// Asks in other words when it is time.
    pub(super) fn go_on(&mut self, now: Duration, mut say: impl FnMut(Command)) -> Option<Event> {
        match *self {
            Self::Old(beams, since) if now.saturating_sub(since) > PATIENCE => {
                let first = |value| ForLaser { value, laser: 0 };
                say(Command::LrfStart(first(beams.start_deg)));
                say(Command::LrfEnd(first(beams.end_deg)));
                say(Command::LrfResolution(first(
                    beams.increment_centideg.cast_signed(),
                )));
                say(Command::LrfEnable(first(2)));
                *self = Self::New(now);
                None
            }
            Self::New(since) if now.saturating_sub(since) > PATIENCE => {
                *self = Self::Done;
                let words = "it was asked for a laser and sends none; has the simulated robot one?";
                Some(Event::Warning(words.to_owned()))
            }
            Self::Done | Self::Old(..) | Self::New(_) => None,
        }
    }

    /// A packet of the laser came.
    pub(super) fn heard(&mut self) {
        *self = Self::Done;
    }
}
