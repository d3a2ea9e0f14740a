//! The session with the scanner, from first contact to continuous scans. It does no I/O and has no
//! clock: it takes bytes and times and returns events. It contains all transitions.

mod step;

use core::time::Duration;

use jde_device::Protocol;

use crate::message::{Message, Receiver};
use crate::scan::{Beams, Letters, Parameters, Scan};
use step::{Step, StepResult};

/// Time limit of a reply; the slowest waits for the motor to reach its speed.
const REPLY_TIMEOUT: Duration = Duration::from_secs(1);
/// Time without a scan after which a streaming scanner counts as lost. A slow one that skips nine of ten
/// turns sends one scan per second.
const SILENCE: Duration = Duration::from_secs(3);
/// How often a request is sent before the scanner counts as lost, because noise can destroy single messages.
const MAX_TRIES: u32 = 3;
/// Speeds of the serial line; the factory's default first.
const SPEEDS: [u32; 7] = [19_200, 115_200, 57_600, 38_400, 750_000, 500_000, 250_000];

/// The requested mode of operation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScannerConfig {
    /// Angle to cover, centred ahead, rad.
    pub(crate) view: f64,
    /// Turns skipped between two scans.
    pub(crate) skip: u32,
    pub(crate) letters: Letters,
    /// Speed of a serial line; `None` over TCP.
    pub(crate) baud: Option<u32>,
}

/// Data for the driver.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ScannerData {
    /// Scans of these beams follow.
    Beams(Beams),
    Scan(Scan),
}

type Event = jde_device::Event<ScannerData>;

/// The session.
#[derive(Debug)]
pub(crate) struct Session {
    config: ScannerConfig,
    receiver: Receiver,
    step: Step,
    tries: u32,
    deadline: Duration,
    /// Current speed of the line.
    baud: Option<u32>,
    /// Model, firmware, serial number and state, as the scanner reports them.
    name: Vec<String>,
    warned: bool,
}

impl Protocol for Session {
    const DEVICE: &'static str = "scanner";
    type Config = ScannerConfig;
    type Data = ScannerData;

    fn start(config: ScannerConfig, now: Duration, events: &mut Vec<Event>) -> Self {
        let mut session = Self {
            config,
            receiver: Receiver::default(),
            step: Step::Connect { speed: 0 },
            tries: 0,
            deadline: now,
            baud: config.baud,
            name: Vec::new(),
            warned: false,
        };
        session.send_request(now, events);
        session
    }

    fn is_ready(&self) -> bool {
        matches!(self.step, Step::Scan { .. })
    }

    fn receive(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event>) {
        self.receiver.receive(bytes);
        while let Some(message) = self.receiver.next() {
            self.message(&message, now, events);
            if matches!(events.last(), Some(Event::Disconnect(_))) {
                return;
            }
        }
        if now >= self.deadline {
            if self.is_ready() {
                events.push(Event::Disconnect(format!(
                    "no scan came for {} s",
                    SILENCE.as_secs()
                )));
            } else {
                self.retry("no answer", now, events);
            }
        }
    }

    fn refuse_baud(&mut self, now: Duration, events: &mut Vec<Event>) {
        self.retry("the line lacks the speed", now, events);
    }

    /// Switches the laser off.
    fn closing_bytes() -> Vec<u8> {
        b"QT\n".to_vec()
    }
}

impl Session {
    fn message(&mut self, message: &Message, now: Duration, events: &mut Vec<Event>) {
        if let Step::Scan { beams } = self.step {
            if message.echo.starts_with(&beams.request()) {
                self.scan(beams, message, now, events);
            }
            return;
        }
        match self.step.handle_reply(message, &self.config) {
            StepResult::Good(next) => self.advance(next, message, now, events),
            StepResult::Refused(reason) => self.retry(&reason, now, events),
            StepResult::Other => {}
        }
    }

    fn scan(&mut self, beams: Beams, message: &Message, now: Duration, events: &mut Vec<Event>) {
        match &message.status {
            b"99" => match beams.decode(message) {
                Ok(scan) => {
                    self.deadline = now + SILENCE;
                    self.warned = false;
                    events.push(Event::Data(ScannerData::Scan(scan)));
                }
                Err(unusable) if !self.warned => {
                    self.warned = true;
                    events.push(Event::Warn(unusable.to_string()));
                }
                Err(_) => {}
            },
            // The reply to the request itself, and the end of a pause in which the scanner checked itself.
            b"00" | b"98" => {}
            status => {
                let status = String::from_utf8_lossy(status).into_owned();
                events.push(Event::Disconnect(format!(
                    "it stopped with status {}: let it turn freely, then switch it off and on",
                    status.escape_default()
                )));
            }
        }
    }

    /// Stores the data of this reply, and enters the next step.
    fn advance(&mut self, next: Step, message: &Message, now: Duration, events: &mut Vec<Event>) {
        match &self.step {
            Step::Speed => self.set_baud(self.config.baud, events),
            Step::Version => self.record_name(message, &["FIRM", "SERI"]),
            Step::Parameters => self.record_name(message, &["MODL"]),
            Step::State { .. } => self.record_name(message, &["STAT"]),
            Step::Connect { .. } | Step::Laser { .. } | Step::Start { .. } | Step::Scan { .. } => {}
        }
        self.step = match next {
            Step::Speed if self.baud == self.config.baud => Step::Version,
            next => next,
        };
        self.tries = 0;
        if let Step::Scan { beams } = self.step {
            self.deadline = now + SILENCE;
            events.push(Event::Data(ScannerData::Beams(beams)));
            events.push(Event::Ready(self.name.join(", ")));
        } else {
            self.send_request(now, events);
        }
    }

    fn record_name(&mut self, message: &Message, keys: &[&str]) {
        for key in keys {
            if let Some(value) = message
                .value(key)
                .map(str::trim)
                .filter(|value| !value.is_empty())
            {
                let value = value.chars().filter(|letter| !letter.is_control()).collect();
                // The model is first, whenever it arrives.
                let index = if *key == "MODL" { 0 } else { self.name.len() };
                self.name.insert(index, value);
            }
        }
    }

    /// Sends the request of the current step.
    fn send_request(&mut self, now: Duration, events: &mut Vec<Event>) {
        self.tries += 1;
        self.deadline = now + REPLY_TIMEOUT;
        events.push(Event::Send(
            format!("{}\n", self.step.request(&self.config)).into_bytes(),
        ));
    }

    /// Sends the request again, at the next speed while the speed is unknown, or gives up.
    fn retry(&mut self, reason: &str, now: Duration, events: &mut Vec<Event>) {
        if let (Step::Connect { speed }, Some(first)) = (&mut self.step, self.config.baud) {
            // The address's own speed is tried twice, because plugging in causes noise on the line; all
            // others once.
            let others = SPEEDS.into_iter().filter(|baud| *baud != first);
            *speed += 1;
            let Some(baud) = [first, first].into_iter().chain(others).nth(*speed) else {
                events.push(Event::Disconnect(
                    "no SCIP 2 scanner answers at any speed: is it switched on, and are its data lines crossed?"
                        .to_owned(),
                ));
                return;
            };
            self.set_baud(Some(baud), events);
            return self.send_request(now, events);
        }
        if self.tries < MAX_TRIES {
            return self.send_request(now, events);
        }
        let step = self.step.describe();
        events.push(Event::Disconnect(format!("it would not {step}: {reason}")));
    }

    fn set_baud(&mut self, baud: Option<u32>, events: &mut Vec<Event>) {
        if let Some(speed) = baud
            && self.baud != baud
        {
            self.baud = baud;
            self.receiver.clear();
            events.push(Event::Baud(speed));
        }
    }
}

/// Returns the beams to request, from the scanner's parameters.
fn beams(message: &Message, config: &ScannerConfig) -> Result<Beams, String> {
    let parameters = Parameters::read(message)?;
    Ok(Beams::new(parameters, config.view, config.skip, config.letters))
}

#[cfg(test)]
mod tests;
