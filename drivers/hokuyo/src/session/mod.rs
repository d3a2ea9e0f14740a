//! The conversation with the scanner, from first contact to continuous scans. It does no I/O and has no
//! clock: it takes bytes and times and returns events. It contains all transitions.

mod step;

use core::time::Duration;

use jde_device::Conversation;

use crate::message::{Message, Receiver};
use crate::scan::{Beams, Letters, Parameters, Scan};
use step::{Answer, Step};

/// Time limit of an answer; the slowest waits for the motor to reach its speed.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time without a scan after which a streaming scanner counts as lost. A slow one that skips nine of ten
/// turns sends one scan per second.
const SILENCE: Duration = Duration::from_secs(3);
/// How often a question is sent before the scanner counts as lost, because noise can destroy single messages.
const TRIES: u32 = 3;
/// Speeds of the serial line; the factory's default first.
const SPEEDS: [u32; 7] = [19_200, 115_200, 57_600, 38_400, 750_000, 500_000, 250_000];

/// The requested mode of operation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    /// Angle to cover, centred ahead, rad.
    pub(crate) view: f64,
    /// Turns skipped between two scans.
    pub(crate) skip: u32,
    pub(crate) letters: Letters,
    /// Speed of a serial line; `None` over TCP.
    pub(crate) baud: Option<u32>,
}

/// News for the driver.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum News {
    /// Scans of these beams follow.
    Beams(Beams),
    Scan(Scan),
}

type Event = jde_device::Event<News>;

/// The conversation.
#[derive(Debug)]
pub(crate) struct Session {
    wanted: Wanted,
    receiver: Receiver,
    step: Step,
    tries: u32,
    deadline: Duration,
    /// Present speed of the line.
    baud: Option<u32>,
    /// Model, firmware, serial number and state, as the scanner reports them.
    name: Vec<String>,
    warned: bool,
}

impl Conversation for Session {
    const DEVICE: &'static str = "scanner";
    type Wanted = Wanted;
    type News = News;

    fn begin(wanted: Wanted, now: Duration, events: &mut Vec<Event>) -> Self {
        let mut session = Self {
            wanted,
            receiver: Receiver::default(),
            step: Step::Meet { speed: 0 },
            tries: 0,
            deadline: now,
            baud: wanted.baud,
            name: Vec::new(),
            warned: false,
        };
        session.say(now, events);
        session
    }

    fn is_ready(&self) -> bool {
        matches!(self.step, Step::Scan { .. })
    }

    fn hear(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event>) {
        self.receiver.hear(bytes);
        while let Some(message) = self.receiver.next() {
            self.message(&message, now, events);
            if matches!(events.last(), Some(Event::Lose(_))) {
                return;
            }
        }
        if now >= self.deadline {
            if self.is_ready() {
                events.push(Event::Lose(format!("no scan came for {} s", SILENCE.as_secs())));
            } else {
                self.again("no answer", now, events);
            }
        }
    }

    /// Switches the laser off.
    fn farewell() -> Vec<u8> {
        b"QT\n".to_vec()
    }
}

impl Session {
    fn message(&mut self, message: &Message, now: Duration, events: &mut Vec<Event>) {
        if let Step::Scan { beams } = self.step {
            if message.echo.starts_with(&beams.question()) {
                self.scan(beams, message, now, events);
            }
            return;
        }
        match self.step.answer(message, &self.wanted) {
            Answer::Good(next) => self.go(next, message, now, events),
            Answer::Refused(reason) => self.again(&reason, now, events),
            Answer::Other => {}
        }
    }

    fn scan(&mut self, beams: Beams, message: &Message, now: Duration, events: &mut Vec<Event>) {
        match &message.status {
            b"99" => match beams.decode(message) {
                Ok(scan) => {
                    self.deadline = now + SILENCE;
                    self.warned = false;
                    events.push(Event::News(News::Scan(scan)));
                }
                Err(unusable) if !self.warned => {
                    self.warned = true;
                    events.push(Event::Warn(unusable.to_string()));
                }
                Err(_) => {}
            },
            // The answer to the question itself, and the end of a pause in which the scanner checked itself.
            b"00" | b"98" => {}
            status => {
                let status = String::from_utf8_lossy(status).into_owned();
                events.push(Event::Lose(format!(
                    "it stopped with status {}: let it turn freely, then switch it off and on",
                    status.escape_default()
                )));
            }
        }
    }

    /// Stores the data of this answer, and enters the next step.
    fn go(&mut self, next: Step, message: &Message, now: Duration, events: &mut Vec<Event>) {
        match &self.step {
            Step::Speed => self.set_baud(self.wanted.baud, events),
            Step::Version => self.learn(message, &["FIRM", "SERI"]),
            Step::Parameters => self.learn(message, &["MODL"]),
            Step::State { .. } => self.learn(message, &["STAT"]),
            Step::Meet { .. } | Step::Laser { .. } | Step::Start { .. } | Step::Scan { .. } => {}
        }
        self.step = match next {
            Step::Speed if self.baud == self.wanted.baud => Step::Version,
            next => next,
        };
        self.tries = 0;
        if let Step::Scan { beams } = self.step {
            self.deadline = now + SILENCE;
            events.push(Event::News(News::Beams(beams)));
            events.push(Event::Ready(self.name.join(", ")));
        } else {
            self.say(now, events);
        }
    }

    fn learn(&mut self, message: &Message, keys: &[&str]) {
        for key in keys {
            if let Some(value) = message
                .value(key)
                .map(str::trim)
                .filter(|value| !value.is_empty())
            {
                let value = value.chars().filter(|letter| !letter.is_control()).collect();
                // The model is first, whenever it arrives.
                let place = if *key == "MODL" { 0 } else { self.name.len() };
                self.name.insert(place, value);
            }
        }
    }

    /// Sends the question of the present step.
    fn say(&mut self, now: Duration, events: &mut Vec<Event>) {
        self.tries += 1;
        self.deadline = now + PATIENCE;
        events.push(Event::Send(
            format!("{}\n", self.step.question(&self.wanted)).into_bytes(),
        ));
    }

    /// Sends the question again, at the next speed while the speed is unknown, or gives up.
    fn again(&mut self, why: &str, now: Duration, events: &mut Vec<Event>) {
        if let (Step::Meet { speed }, Some(first)) = (&mut self.step, self.wanted.baud) {
            // The address's own speed is tried twice, because plugging in causes noise on the line; all
            // others once.
            let others = SPEEDS.into_iter().filter(|baud| *baud != first);
            *speed += 1;
            let Some(baud) = [first, first].into_iter().chain(others).nth(*speed) else {
                events.push(Event::Lose(
                    "no scanner that speaks SCIP 2 answers at any speed: is it switched on, and are its data lines crossed?"
                        .to_owned(),
                ));
                return;
            };
            self.set_baud(Some(baud), events);
            return self.say(now, events);
        }
        if self.tries < TRIES {
            return self.say(now, events);
        }
        let step = self.step.what();
        events.push(Event::Lose(format!("it would not {step}: {why}")));
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
fn beams(message: &Message, wanted: &Wanted) -> Result<Beams, String> {
    let parameters = Parameters::read(message)?;
    Ok(Beams::new(parameters, wanted.view, wanted.skip, wanted.letters))
}

#[cfg(test)]
mod tests;
