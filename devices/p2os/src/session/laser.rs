//! Requests a simulator's laser, first with the old commands and then with the newer ones. `crate::laser`
//! decodes its packets.

use core::time::Duration;

use super::{Beams, Event};
use crate::{Command, ForLaser};

/// How long to wait for a packet before the next attempt: simulators send one with every SIP.
const ATTEMPT_TIMEOUT: Duration = Duration::from_secs(2);

/// The progress of the request.
#[derive(Clone, Copy, Debug)]
pub(super) enum LaserRequest {
    /// No laser is requested, packets arrive, or there is no laser.
    Done,
    /// Requested with the commands of SRIsim, 35 to 38, which all simulators in use know.
    Legacy(Beams, Duration),
    /// Requested with the commands of later simulators, 230 to 233.
    Modern(Duration),
}

impl LaserRequest {
    pub(super) fn start(beams: Beams, now: Duration, mut send: impl FnMut(Command)) -> Self {
        send(Command::LaserStart36(beams.start_deg));
        send(Command::LaserEnd37(beams.end_deg));
        send(Command::LaserIncrement38(beams.increment_centideg));
        send(Command::LaserOn35(2));
        Self::Legacy(beams, now)
    }

    /// Tries the next commands when it is time.
    pub(super) fn poll(&mut self, now: Duration, mut send: impl FnMut(Command)) -> Option<Event> {
        match *self {
            Self::Legacy(beams, since) if now.saturating_sub(since) > ATTEMPT_TIMEOUT => {
                let first = |value| ForLaser { value, laser: 0 };
                send(Command::LrfStart(first(beams.start_deg)));
                send(Command::LrfEnd(first(beams.end_deg)));
                send(Command::LrfResolution(first(
                    beams.increment_centideg.cast_signed(),
                )));
                send(Command::LrfEnable(first(2)));
                *self = Self::Modern(now);
                None
            }
            Self::Modern(since) if now.saturating_sub(since) > ATTEMPT_TIMEOUT => {
                *self = Self::Done;
                let message =
                    "the simulator sends no laser packets on request; does the simulated robot have a laser?";
                Some(Event::Warning(message.to_owned()))
            }
            Self::Done | Self::Legacy(..) | Self::Modern(_) => None,
        }
    }

    /// Ends the request: a packet of the laser has arrived.
    pub(super) fn confirm(&mut self) {
        *self = Self::Done;
    }
}
