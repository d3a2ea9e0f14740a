//! The session with the lidar, from first contact to continuous scans. It does no I/O and has no clock: it takes bytes
//! and times and returns events. It contains all transitions.

mod model;
mod step;

use core::time::Duration;

use jde_device::Protocol;

use super::message::{Receiver, Reply};
use super::samples::{Decoder, Found, Sample};
use crate::scanner::{Scan, range};
use crate::turn::{Point, Turn, Turns};
use crate::watch::{Watch, Words};
use model::Model;
use step::{Meaning, Question, Step};

/// Time limit of a reply.
const REPLY_TIMEOUT: Duration = Duration::from_millis(1000);
/// Time that a lidar needs to stop. What arrives until then is discarded.
const STOP_TIME: Duration = Duration::from_millis(100);
/// How often a request is sent before the lidar counts as lost, because noise can destroy single messages.
const MAX_TRIES: u32 = 3;
/// Speeds of the line that the lidars have.
const SPEEDS: [u32; 4] = [115_200, 256_000, 460_800, 1_000_000];
/// Time of a turn, s: the lidars turn 2 to 20 times a second.
const TURN: core::ops::RangeInclusive<f64> = 0.05..=0.5;
/// Time of a turn before the first was measured, s.
const USUAL_TURN: f64 = 0.1;
/// How much the time of a turn may differ from that of the one before.
const TOLERANCE: f64 = 0.25;
/// Time without bytes, which a lidar that scans sends all the time, after which nothing tells when it measured what
/// comes: several periods of the driver, and times that adapters wait.
const MAX_PAUSE: Duration = Duration::from_millis(50);
/// The status of a lidar that has stopped to protect itself, and that of one that may do so soon.
const ERROR: u8 = 2;
const WARNING: u8 = 1;
/// What it says when no turns come.
const WORDS: Words = Words {
    silent: "it sends no measurements: does its head turn, and are its plugs firm?",
    foreign: "it sends too little to be measurements: does its head turn?",
    corrupt: "most measurements come with wrong checksums: is the cable near a motor's, or its power too weak?",
    incomplete: "its head does not turn: is it blocked, or its motor without power?",
};

type Event = jde_device::Event<Scan>;

/// The configuration.
#[derive(Clone, Debug)]
pub(crate) struct RplidarConfig {
    pub(crate) beams: usize,
    pub(crate) inverted: bool,
    /// Speed of a serial line; `None` over TCP.
    pub(crate) baud: Option<u32>,
    /// The serial number that the lidar must have; empty for any.
    pub(crate) serial_number: String,
    /// Whether to use `SCAN` although the lidar has better modes.
    pub(crate) standard: bool,
}

/// The session.
#[derive(Debug)]
pub(crate) struct RplidarSession {
    config: RplidarConfig,
    receiver: Receiver,
    step: Step,
    tries: u32,
    deadline: Duration,
    /// Number of speeds tried before, and the present one.
    speed: usize,
    baud: Option<u32>,
    stream: Option<Stream>,
}

/// What the session knows while the lidar scans.
#[derive(Debug)]
struct Stream {
    model: Model,
    decoder: Decoder,
    turns: Turns,
    watch: Watch,
    limits: [f32; 2],
    has_intensities: bool,
    /// Time of the last turn, s.
    turn: f64,
    /// Time of the last bytes.
    arrival: Duration,
    /// Time of the last bytes that came after a pause, s.
    resumed: f64,
}

impl Protocol for RplidarSession {
    const DEVICE: &'static str = "lidar";
    /// At SLAMTEC's adapter, DTR stops the motor of an A1.
    const DTR: bool = false;
    type Config = RplidarConfig;
    type Data = Scan;

    fn start(config: RplidarConfig, now: Duration, events: &mut Vec<Event>) -> Self {
        let mut session = Self {
            baud: config.baud,
            config,
            receiver: Receiver::default(),
            step: Step::Scan,
            tries: 0,
            deadline: now,
            speed: 0,
            stream: None,
        };
        session.seek(now, events);
        session
    }

    fn is_ready(&self) -> bool {
        self.stream.as_ref().is_some_and(|stream| stream.watch.is_ready())
    }

    fn receive(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event>) {
        if let Some(stream) = &mut self.stream {
            stream.receive(bytes, now, events);
            return;
        }
        if let Step::Stop { then } = &self.step {
            if now >= self.deadline {
                let then = (**then).clone();
                self.enter(then, now, events);
            }
            return;
        }
        self.receiver.receive(bytes);
        while let Some(reply) = self.receiver.next() {
            self.reply(&reply, now, events);
            if !self.step.is_asking() || matches!(events.last(), Some(Event::Disconnect(_))) {
                return;
            }
        }
        if now >= self.deadline {
            self.retry(now, events);
        }
    }

    fn refuse_baud(&mut self, now: Duration, events: &mut Vec<Event>) {
        // No lidar has heard of this speed, so what it would have been sent is not awaited.
        self.step = Step::Info { before: None };
        self.retry(now, events);
    }

    /// Stops the scan, and the motor if it can be.
    fn closing_bytes() -> Vec<u8> {
        step::closing()
    }
}

impl RplidarSession {
    /// Looks for the lidar, which may be scanning.
    fn seek(&mut self, now: Duration, events: &mut Vec<Event>) {
        let then = Box::new(Step::Info { before: None });
        self.enter(Step::Stop { then }, now, events);
    }

    /// Enters a step with its first request.
    fn enter(&mut self, step: Step, now: Duration, events: &mut Vec<Event>) {
        (self.step, self.tries) = (step, 0);
        self.send(now, events);
    }

    /// Sends the request of the step. What arrived before does not answer it.
    fn send(&mut self, now: Duration, events: &mut Vec<Event>) {
        self.tries += 1;
        self.receiver.clear();
        self.deadline = now
            + match self.step {
                Step::Stop { .. } => STOP_TIME,
                _ => REPLY_TIMEOUT,
            };
        events.push(Event::Send(self.step.requests()));
    }

    fn reply(&mut self, reply: &Reply, now: Duration, events: &mut Vec<Event>) {
        match self.step.meaning(reply) {
            Meaning::Other => {}
            Meaning::Info(model) => self.identify(model, now, events),
            Meaning::Health(_, ERROR, code) => events.push(Event::Disconnect(format!(
                "it stopped to protect itself (error {code:#06x}): free its head, unplug it and plug it in again"
            ))),
            Meaning::Health(model, status, code) => {
                if status == WARNING {
                    events.push(Event::Warn(format!(
                        "the lidar warns of error {code:#06x}: it may stop to protect itself"
                    )));
                }
                let question = self.first_scan(&model);
                self.enter(Step::Ask(model, question), now, events);
            }
            Meaning::Next(step) => self.enter(step, now, events),
            Meaning::Unreadable(kind) => events.push(Event::Disconnect(format!(
                "it answers in a format ({kind:#04x}) that this driver does not read"
            ))),
            Meaning::Stream(model, format) => {
                let mut stream = Stream {
                    decoder: Decoder::new(format),
                    turns: Turns::new(self.config.beams, self.config.inverted),
                    watch: Watch::new(now),
                    limits: model.limits(format),
                    model,
                    has_intensities: format.has_quality(),
                    turn: USUAL_TURN,
                    arrival: now,
                    resumed: 0.0,
                };
                stream.receive(&self.receiver.take_rest(), now, events);
                (self.step, self.stream) = (Step::Scan, Some(stream));
            }
        }
    }

    /// Takes what the lidar says that it is, if it says so twice.
    fn identify(&mut self, model: Model, now: Duration, events: &mut Vec<Event>) {
        let Step::Info { before } = &mut self.step else {
            return;
        };
        if before.replace(model.clone()).as_ref() != Some(&model) {
            if self.tries > MAX_TRIES {
                events.push(Event::Disconnect(
                    "each time it says something else of what it is: is the cable near a motor's?".to_owned(),
                ));
                return;
            }
            return self.send(now, events);
        }
        let (wanted, found) = (&self.config.serial_number, &model.serial_number);
        if !wanted.is_empty() && !wanted.eq_ignore_ascii_case(found) {
            events.push(Event::Disconnect(format!(
                "its serial number is {found}, not that of `serial_number`: are two adapters swapped?"
            )));
            return;
        }
        self.enter(Step::Ask(model, Question::Health), now, events);
    }

    /// What leads a lidar to a scan.
    fn first_scan(&self, model: &Model) -> Question {
        match self.config.standard {
            false if model.has_modes() => Question::Typical,
            false if model.has_express() => Question::Start { mode: Some(0) },
            _ => Question::Start { mode: None },
        }
    }

    /// Sends the request again, at the next speed while the speed is unknown, or does without it, or gives up.
    fn retry(&mut self, now: Duration, events: &mut Vec<Event>) {
        if let (Step::Info { before: None }, Some(first)) = (&self.step, self.config.baud) {
            // The address's own speed is tried twice, because plugging in causes noise on the line; all others once.
            let others = SPEEDS.into_iter().filter(|baud| *baud != first);
            self.speed += 1;
            let Some(baud) = [first, first].into_iter().chain(others).nth(self.speed) else {
                events.push(Event::Disconnect(
                    "no RPLIDAR answers at any speed: is it switched on, and is it that model?".to_owned(),
                ));
                return;
            };
            if self.baud != Some(baud) {
                self.baud = Some(baud);
                events.push(Event::Baud(baud));
            }
            return self.seek(now, events);
        }
        if self.tries < MAX_TRIES {
            return self.send(now, events);
        }
        match self.step.without_answer() {
            Some(step) => self.enter(step, now, events),
            None => {
                let step = self.step.describe();
                events.push(Event::Disconnect(format!("no answer: it would not {step}")));
            }
        }
    }
}

impl Step {
    /// Whether a reply is awaited.
    fn is_asking(&self) -> bool {
        !matches!(self, Self::Stop { .. } | Self::Scan)
    }
}

impl Stream {
    fn receive(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event>) {
        if !self.watch.receive(bytes.len(), now) {
            self.decoder.clear();
            self.turns.clear();
            return;
        }
        if !bytes.is_empty() {
            let before = core::mem::replace(&mut self.arrival, now);
            if now.saturating_sub(before) > MAX_PAUSE {
                self.resumed = now.as_secs_f64();
            }
        }
        self.decoder.receive(bytes);
        while let Some(found) = self.decoder.next() {
            let (size, samples) = match found {
                Found::Samples(size, samples) => (size, samples),
                Found::Corrupt => {
                    self.watch.corrupt(1);
                    continue;
                }
            };
            self.watch.good(size);
            for sample in samples {
                let Some(turn) = self.add(&sample, now) else {
                    continue;
                };
                if !self.watch.is_ready() {
                    events.push(Event::Ready(self.model.to_string()));
                }
                self.watch.accept(now);
                events.push(Event::Data(Scan {
                    age: Duration::try_from_secs_f64(now.as_secs_f64() - turn.end).unwrap_or_default(),
                    turn,
                    limits: self.limits,
                    has_intensities: self.has_intensities,
                }));
            }
        }
        if self.watch.warns() {
            events.push(Event::Warn(
                "measurements come with wrong checksums and are skipped: is the cable near a motor's?"
                    .to_owned(),
            ));
        }
        if let Some(reason) = self.watch.lost(now, &WORDS) {
            events.push(Event::Disconnect(reason));
        }
    }

    /// Adds a sample. Returns the turn that ends before it.
    fn add(&mut self, sample: &Sample, now: Duration) -> Option<Turn> {
        let turn = self.turns.add(&Point {
            angle: sample.angle,
            range: range(sample.distance / 1000.0, self.limits),
            intensity: f32::from(sample.quality),
            time: now.as_secs_f64() - sample.lag / 360.0 * self.turn,
        })?;
        if !self.watch.end_turn(now) {
            return None;
        }
        if turn.end - turn.duration <= self.resumed {
            self.watch.refuse(format!(
                "a turn came with a pause of more than {} ms: is the machine or the network too busy?",
                MAX_PAUSE.as_millis()
            ));
            return None;
        }
        if !TURN.contains(&turn.duration) {
            self.watch.refuse(format!(
                "a turn takes {:.2} s, which is no speed of these lidars: is its motor powered, and the machine not too busy?",
                turn.duration
            ));
            return None;
        }
        let before = core::mem::replace(&mut self.turn, turn.duration);
        if (turn.duration / before - 1.0).abs() > TOLERANCE {
            self.watch.refuse(format!(
                "a turn takes {:.2} s, and the one before took {before:.2} s: is its motor powered, and the machine not too busy?",
                turn.duration
            ));
            return None;
        }
        Some(turn)
    }
}

#[cfg(test)]
mod tests;
