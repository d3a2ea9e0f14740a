//! The session with the scanner, from first contact to continuous scans. It does no I/O and has no
//! clock: it takes bytes and times and returns events. It contains all transitions.

mod step;

use core::time::Duration;

use jde_device::Protocol;

use crate::scan::{Beams, Reach};
use crate::telegram::{Received, Receiver, Telegram, request};
use step::{Step, StepResult};

/// Time without a scan after which a streaming scanner counts as lost. The slowest scans, 401 beams at 9600
/// baud, arrive once per second.
const SILENCE: Duration = Duration::from_secs(3);
/// How often a telegram is sent before the scanner counts as lost, because noise can destroy single
/// telegrams.
const MAX_TRIES: u32 = 3;
/// Speeds of the serial line; the factory's default first.
const SPEEDS: [u32; 4] = [9600, 38_400, 19_200, 500_000];
const MEASUREMENT: u8 = 0xb0;
const POWER_ON: u8 = 0x90;

/// The requested mode of operation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScannerConfig {
    pub(crate) beams: Beams,
    pub(crate) reach: Reach,
    pub(crate) speed: SerialSpeed,
}

/// Control of the line's speed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SerialSpeed {
    /// The driver sets it: `first` when the session begins, and `working` while scans arrive.
    Serial { first: u32, working: u32 },
    /// A serial server sets it; the driver cannot change it.
    Fixed,
}

type Event = jde_device::Event<Scan>;

/// A scan: distances from right to left, m, by REP-117.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scan {
    pub(crate) ranges: Vec<f32>,
    /// Time of its transfer on the wire; 0 if the speed is unknown.
    pub(crate) transfer: Duration,
}

/// The session.
#[derive(Debug)]
pub(crate) struct Session {
    config: ScannerConfig,
    receiver: Receiver,
    step: Step,
    tries: u32,
    deadline: Duration,
    /// Current speed of the line; `None` if the driver does not control it.
    baud: Option<u32>,
    name: String,
    polluted: bool,
}

impl Protocol for Session {
    const DEVICE: &'static str = "scanner";
    type Config = ScannerConfig;
    type Data = Scan;

    fn start(config: ScannerConfig, now: Duration, events: &mut Vec<Event>) -> Self {
        let mut session = Self {
            config,
            receiver: Receiver::default(),
            step: Step::Connect { speed: 0 },
            tries: 0,
            deadline: now,
            baud: match config.speed {
                SerialSpeed::Serial { first, .. } => Some(first),
                SerialSpeed::Fixed => None,
            },
            name: String::new(),
            polluted: false,
        };
        session.send_request(now, events);
        session
    }

    fn is_ready(&self) -> bool {
        matches!(self.step, Step::Scan)
    }

    fn receive(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event>) {
        self.receiver.receive(bytes);
        while let Some(received) = self.receiver.next() {
            match received {
                // Scans received at a wrong speed contain many bytes that look like a NACK. At the right
                // speed, one can occur between scans.
                Received::Nack if matches!(self.step, Step::Connect { .. } | Step::Scan) => {}
                Received::Nack => self.retry("it refuses the telegram", now, events),
                Received::Telegram(telegram) => self.telegram(&telegram, now, events),
            }
            if matches!(events.last(), Some(Event::Disconnect(_))) {
                return;
            }
        }
        if now >= self.deadline {
            if self.is_ready() {
                let silence = SILENCE.as_secs();
                events.push(Event::Disconnect(format!("no scan came for {silence} s")));
            } else {
                self.retry("no answer", now, events);
            }
        }
    }

    fn refuse_baud(&mut self, now: Duration, events: &mut Vec<Event>) {
        self.retry("the line lacks the speed", now, events);
    }

    /// Stops the scans.
    fn closing_bytes() -> Vec<u8> {
        request(&step::ON_REQUEST)
    }
}

impl Session {
    fn telegram(&mut self, telegram: &Telegram, now: Duration, events: &mut Vec<Event>) {
        match telegram.command {
            POWER_ON if !matches!(self.step, Step::Connect { .. }) => {
                events.push(Event::Disconnect(
                    "it was switched off and on, or restarted by itself".to_owned(),
                ));
            }
            MEASUREMENT if self.is_ready() => self.measurement(telegram, now, events),
            // Scans of an earlier session, sent before the scanner stops, are no replies.
            MEASUREMENT | POWER_ON => {}
            _ => match self.step.handle_reply(telegram, &self.config) {
                StepResult::Good(next) => self.advance(next, telegram, now, events),
                StepResult::Refused(reason) => self.retry(&reason, now, events),
                StepResult::Other => {}
            },
        }
    }

    fn measurement(&mut self, telegram: &Telegram, now: Duration, events: &mut Vec<Event>) {
        self.deadline = now + SILENCE;
        // Bits 0 to 2: a value from 3 on is an error, and the measurement is unreliable.
        if telegram.status & 0x07 >= 3 {
            let status = telegram.status;
            events.push(Event::Disconnect(format!(
                "it reports a fault of its own (status 0x{status:02x}): clean its window, then switch it off and on"
            )));
            return;
        }
        let polluted = telegram.status & 0x80 != 0;
        if polluted && !self.polluted {
            events.push(Event::Warn("its window is dirty: clean it".to_owned()));
        }
        self.polluted = polluted;
        match self.config.reach.decode(self.config.beams, &telegram.data) {
            Ok(ranges) => {
                // Ten bits per byte: one start bit, eight data bits, one stop bit.
                let seconds = self
                    .baud
                    .map_or(0.0, |baud| telegram.size as f64 * 10.0 / f64::from(baud));
                events.push(Event::Data(Scan {
                    ranges,
                    transfer: Duration::from_secs_f64(seconds),
                }));
            }
            Err(unusable) => events.push(Event::Disconnect(unusable.to_string())),
        }
    }

    /// Stores the data of this reply, and enters the next step.
    fn advance(&mut self, next: Step, telegram: &Telegram, now: Duration, events: &mut Vec<Event>) {
        if matches!(self.step, Step::Name) {
            self.name = step::name(&telegram.data);
        }
        if matches!(self.step, Step::Speed)
            && let SerialSpeed::Serial { working, .. } = self.config.speed
        {
            self.set_baud(working, events);
        }
        self.step = match (next, self.baud, self.config.speed) {
            // The speed needs no change if it is right already, or if the driver does not control it.
            (Step::Speed, Some(baud), SerialSpeed::Serial { working, .. }) if baud != working => Step::Speed,
            (Step::Speed, _, _) => Step::Install,
            (next, _, _) => next,
        };
        self.tries = 0;
        if self.is_ready() {
            self.deadline = now + SILENCE;
            let speed = self.baud.map(|baud| format!(", {baud} baud")).unwrap_or_default();
            events.push(Event::Ready(format!("{}{speed}", self.name)));
        } else {
            self.send_request(now, events);
        }
    }

    /// Sends the telegram of the current step.
    fn send_request(&mut self, now: Duration, events: &mut Vec<Event>) {
        self.tries += 1;
        self.deadline = now + self.step.reply_timeout();
        events.push(Event::Send(request(&self.step.payload(&self.config))));
    }

    /// Sends the telegram again, at the next speed while the speed is unknown, or gives up.
    fn retry(&mut self, reason: &str, now: Duration, events: &mut Vec<Event>) {
        if let Step::Connect { speed } = &mut self.step {
            let SerialSpeed::Serial { first, .. } = self.config.speed else {
                if self.tries < MAX_TRIES {
                    return self.send_request(now, events);
                }
                events.push(Event::Disconnect(
                    "no scanner answers: is it switched on, and does the serial server go at its speed?"
                        .to_owned(),
                ));
                return;
            };
            // The address's own speed is tried twice, because plugging in causes noise on the line; all
            // others once.
            let candidates = [first]
                .into_iter()
                .chain([first])
                .chain(SPEEDS.into_iter().filter(|baud| *baud != first));
            *speed += 1;
            let Some(baud) = candidates.into_iter().nth(*speed) else {
                events.push(Event::Disconnect(
                    "no scanner answers at any speed: is it switched on, are its two data lines crossed, and is it \
                     RS-232 or RS-422 at both ends?"
                        .to_owned(),
                ));
                return;
            };
            self.set_baud(baud, events);
            return self.send_request(now, events);
        }
        if self.tries < MAX_TRIES {
            return self.send_request(now, events);
        }
        let step = self.step.describe();
        events.push(Event::Disconnect(format!("it would not {step}: {reason}")));
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
