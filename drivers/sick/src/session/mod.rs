//! A conversation with the scanner, from the first word to scans without end. It does no I/O and has no clock: bytes and times
//! come in, events go out. All its transitions are here.

mod step;

use core::time::Duration;

use jde_device::Conversation;

use crate::scan::{Beams, Reach};
use crate::telegram::{Heard, Receiver, Telegram, question};
use step::{Answer, Step};

/// How long a scanner that sends scans may be silent: the slowest, 401 beams at 9600 baud, come every second.
const SILENCE: Duration = Duration::from_secs(3);
/// How often a telegram is sent before the scanner is given up: noise takes one now and then.
const TRIES: u32 = 3;
/// Speeds of its line; the factory's first.
const SPEEDS: [u32; 4] = [9600, 38_400, 19_200, 500_000];
const MEASUREMENT: u8 = 0xb0;
const POWER_ON: u8 = 0x90;

/// What the scanner shall do.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    pub(crate) beams: Beams,
    pub(crate) reach: Reach,
    pub(crate) line: Line,
}

/// Whose speed the line has.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Line {
    /// Ours: it is at `first` when the conversation begins, and at `working` while scans come.
    Serial { first: u32, working: u32 },
    /// A serial server's, which we cannot change.
    Fixed,
}

type Event = jde_device::Event<Scan>;

/// Distances from right to left, m, by REP-117.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scan {
    pub(crate) ranges: Vec<f32>,
    /// How long it took on the wire.
    pub(crate) transfer: Duration,
}

/// The conversation.
#[derive(Debug)]
pub(crate) struct Session {
    wanted: Wanted,
    receiver: Receiver,
    step: Step,
    tries: u32,
    deadline: Duration,
    /// The line's present speed; `None` where it is not ours.
    baud: Option<u32>,
    name: String,
    polluted: bool,
}

impl Conversation for Session {
    const DEVICE: &'static str = "scanner";
    type Wanted = Wanted;
    type News = Scan;

    fn begin(wanted: Wanted, now: Duration, events: &mut Vec<Event>) -> Self {
        let mut session = Self {
            wanted,
            receiver: Receiver::default(),
            step: Step::Meet { speed: 0 },
            tries: 0,
            deadline: now,
            baud: match wanted.line {
                Line::Serial { first, .. } => Some(first),
                Line::Fixed => None,
            },
            name: String::new(),
            polluted: false,
        };
        session.say(now, events);
        session
    }

    fn is_ready(&self) -> bool {
        matches!(self.step, Step::Scan)
    }

    fn hear(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event>) {
        self.receiver.hear(bytes);
        while let Some(heard) = self.receiver.next() {
            match heard {
                // Scans at another speed than ours are full of bytes that look like one; among ours one can stand between.
                Heard::Nack if matches!(self.step, Step::Meet { .. } | Step::Scan) => {}
                Heard::Nack => self.again("it refuses the telegram", now, events),
                Heard::Telegram(telegram) => self.telegram(&telegram, now, events),
            }
            if matches!(events.last(), Some(Event::Lose(_))) {
                return;
            }
        }
        if now >= self.deadline {
            if self.is_ready() {
                let silence = SILENCE.as_secs();
                events.push(Event::Lose(format!("no scan came for {silence} s")));
            } else {
                self.again("no answer", now, events);
            }
        }
    }

    /// No scans any more.
    fn farewell() -> Vec<u8> {
        question(&step::ON_REQUEST)
    }
}

impl Session {
    fn telegram(&mut self, telegram: &Telegram, now: Duration, events: &mut Vec<Event>) {
        match telegram.command {
            POWER_ON if !matches!(self.step, Step::Meet { .. }) => {
                events.push(Event::Lose(
                    "it was switched off and on, or restarted by itself".to_owned(),
                ));
            }
            MEASUREMENT if self.is_ready() => self.measurement(telegram, now, events),
            // Scans of an earlier conversation, while it is being told to stop, are no answer to anything.
            MEASUREMENT | POWER_ON => {}
            _ => match self.step.answer(telegram, &self.wanted) {
                Answer::Good(next) => self.go(next, telegram, now, events),
                Answer::Refused(reason) => self.again(&reason, now, events),
                Answer::Other => {}
            },
        }
    }

    fn measurement(&mut self, telegram: &Telegram, now: Duration, events: &mut Vec<Event>) {
        self.deadline = now + SILENCE;
        // Bits 0 to 2: from 3 on it is an error, and what it measures cannot be trusted.
        if telegram.status & 0x07 >= 3 {
            let status = telegram.status;
            events.push(Event::Lose(format!(
                "it reports a fault of its own (status 0x{status:02x}): clean its window, then switch it off and on"
            )));
            return;
        }
        let polluted = telegram.status & 0x80 != 0;
        if polluted && !self.polluted {
            events.push(Event::Warn("its window is dirty: clean it".to_owned()));
        }
        self.polluted = polluted;
        match self.wanted.reach.decode(self.wanted.beams, &telegram.data) {
            Ok(ranges) => {
                // Ten bits a byte: one to start, eight, one to stop.
                let seconds = self
                    .baud
                    .map_or(0.0, |baud| telegram.size as f64 * 10.0 / f64::from(baud));
                events.push(Event::News(Scan {
                    ranges,
                    transfer: Duration::from_secs_f64(seconds),
                }));
            }
            Err(unusable) => events.push(Event::Lose(unusable.to_string())),
        }
    }

    /// Goes on to the next step, with what the answer to the last one told.
    fn go(&mut self, next: Step, telegram: &Telegram, now: Duration, events: &mut Vec<Event>) {
        if matches!(self.step, Step::Name) {
            self.name = step::name(&telegram.data);
        }
        if matches!(self.step, Step::Speed)
            && let Line::Serial { working, .. } = self.wanted.line
        {
            self.set_baud(working, events);
        }
        self.step = match (next, self.baud, self.wanted.line) {
            // Nothing to change.
            (Step::Speed, Some(baud), Line::Serial { working, .. }) if baud != working => Step::Speed,
            (Step::Speed, _, _) => Step::Install,
            (next, _, _) => next,
        };
        self.tries = 0;
        if self.is_ready() {
            self.deadline = now + SILENCE;
            let speed = self.baud.map(|baud| format!(", {baud} baud")).unwrap_or_default();
            events.push(Event::Ready(format!("{}{speed}", self.name)));
        } else {
            self.say(now, events);
        }
    }

    /// Sends the telegram of the present step.
    fn say(&mut self, now: Duration, events: &mut Vec<Event>) {
        self.tries += 1;
        self.deadline = now + self.step.patience();
        events.push(Event::Send(question(&self.step.payload(&self.wanted))));
    }

    /// Says it once more, at the next speed where it is not known yet, or gives up.
    fn again(&mut self, why: &str, now: Duration, events: &mut Vec<Event>) {
        if let Step::Meet { speed } = &mut self.step {
            let Line::Serial { first, .. } = self.wanted.line else {
                if self.tries < TRIES {
                    return self.say(now, events);
                }
                events.push(Event::Lose(
                    "no scanner answers: is it switched on, and does the serial server go at its speed?"
                        .to_owned(),
                ));
                return;
            };
            // The address's own speed twice, because noise on the line comes when plugs are put in; the others once.
            let candidates = [first]
                .into_iter()
                .chain([first])
                .chain(SPEEDS.into_iter().filter(|baud| *baud != first));
            *speed += 1;
            let Some(baud) = candidates.into_iter().nth(*speed) else {
                events.push(Event::Lose(
                    "no scanner answers at any speed: is it switched on, are its two data lines crossed, and is it \
                     RS-232 or RS-422 at both ends?"
                        .to_owned(),
                ));
                return;
            };
            self.set_baud(baud, events);
            return self.say(now, events);
        }
        if self.tries < TRIES {
            return self.say(now, events);
        }
        let step = self.step.what();
        events.push(Event::Lose(format!("it would not {step}: {why}")));
    }

    fn set_baud(&mut self, baud: u32, events: &mut Vec<Event>) {
        if self.baud != Some(baud) {
            self.baud = Some(baud);
            self.receiver.clear();
            events.push(Event::Baud(baud));
        }
    }
}

#[cfg(test)]
mod tests;
