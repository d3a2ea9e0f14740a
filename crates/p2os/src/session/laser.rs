//! Requests a simulator's laser, first with the old commands and then with the newer ones. `crate::laser`
//! decodes its packets.

use core::time::Duration;

use super::{Beams, Event};
use crate::{Command, ForLaser};

/// How long to wait for a packet before the next attempt: simulators send one with every SIP.
const PATIENCE: Duration = Duration::from_secs(2);

/// The progress of the request.
#[derive(Clone, Copy, Debug)]
pub(super) enum LaserRequest {
    /// No laser is wanted, packets arrive, or there is no laser.
    Done,
    /// Requested with the commands of SRIsim, 35 to 38, which all simulators in use know.
    Legacy(Beams, Duration),
    /// Requested with the commands of later simulators, 230 to 233.
    Modern(Duration),
}

impl LaserRequest {
    pub(super) fn start(beams: Beams, now: Duration, mut say: impl FnMut(Command)) -> Self {
        say(Command::LaserStart36(beams.start_deg));
        say(Command::LaserEnd37(beams.end_deg));
        say(Command::LaserIncrement38(beams.increment_centideg));
        say(Command::LaserOn35(2));
        Self::Legacy(beams, now)
    }

    /// Tries the next commands when it is time.
    pub(super) fn poll(&mut self, now: Duration, mut say: impl FnMut(Command)) -> Option<Event> {
        match *self {
            Self::Legacy(beams, since) if now.saturating_sub(since) > PATIENCE => {
                let first = |value| ForLaser { value, laser: 0 };
                say(Command::LrfStart(first(beams.start_deg)));
                say(Command::LrfEnd(first(beams.end_deg)));
                say(Command::LrfResolution(first(
                    beams.increment_centideg.cast_signed(),
                )));
                say(Command::LrfEnable(first(2)));
                *self = Self::Modern(now);
                None
            }
            Self::Modern(since) if now.saturating_sub(since) > PATIENCE => {
                *self = Self::Done;
                let words = "it was asked for a laser and sends none; has the simulated robot one?";
                Some(Event::Warning(words.to_owned()))
            }
            Self::Done | Self::Legacy(..) | Self::Modern(_) => None,
        }
    }

    /// Ends the request: a packet of the laser has arrived.
    pub(super) fn confirm(&mut self) {
        *self = Self::Done;
    }
}
