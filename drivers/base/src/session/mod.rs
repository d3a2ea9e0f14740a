//! The session with a board. It does no I/O and has no clock. It drives nothing before the board has said what it is and
//! has acknowledged a command to stand.

mod clock;
mod commands;
mod losses;
mod rest;

use core::time::Duration;

use jde_device::{Event, Protocol};
use jde_schema::prelude::Twist;

use crate::hello::Hello;
use crate::line::{Line, Receiver, line};
use crate::odometer::{Odometer, Step};
use crate::report::Report;
use clock::Clock;
use commands::Commands;
use losses::{Losses, Throttle, Warnings};
use rest::Rest;

/// A board is lost after this time without a line of its state that is new: as long as `odometry` is valid.
pub(crate) const SILENCE: Duration = Duration::from_millis(500);
/// Time for the first reply: boards start anew when the line is opened, and their loaders wait for a program.
const START: Duration = Duration::from_secs(6);
/// Time between two greetings.
const GREETING: Duration = Duration::from_millis(300);

/// What `connection` says while the board reports `stalled`.
const STALLED: &str = "a wheel is blocked, or its encoder is silent or counts backwards: the motors are off until a command to \
                       stand";

/// The configuration of the driver.
#[derive(Clone, Debug)]
pub(crate) struct BaseConfig {
    /// The serial number that the board must have; empty for any.
    pub(crate) serial_number: String,
}

/// What a session gives to the driver.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Data {
    /// What the board is: first, and again when it has started anew.
    Hello(Box<Hello>),
    /// A line of its state, how long ago that was, and its motion since the line before.
    State {
        report: Box<Report>,
        step: Step,
        age: Duration,
    },
}

/// The session.
#[derive(Debug)]
pub(crate) struct BaseSession {
    config: BaseConfig,
    receiver: Receiver,
    /// The number of the greeting that waits for its reply, or had it.
    greeting: u16,
    phase: Phase,
    /// Time of the last reading.
    read: Duration,
    tally: Tally,
    losses: Losses,
    warnings: Warnings,
    /// The warnings of lines without a motion, and without a command in force.
    leaps: Throttle,
    idleness: Throttle,
}

/// What arrived since the last line that counts.
#[derive(Debug, Default)]
struct Tally {
    bytes: usize,
    good: usize,
    corrupt: usize,
}

#[derive(Debug)]
enum Phase {
    /// It has not said what it is.
    Greeting {
        next: Duration,
        deadline: Duration,
    },
    Known(Box<Board>),
}

#[derive(Debug)]
struct Board {
    hello: Hello,
    odometer: Odometer,
    clock: Clock,
    commands: Commands,
    rest: Rest,
    /// The number of the last line, and its count of refused lines.
    last: Option<(u16, Option<u32>)>,
    /// Until when a line must arrive.
    deadline: Duration,
    is_ready: bool,
    /// Whether `connection` says that the wheels run, and that they are stopped.
    trouble: [bool; 2],
}

impl Protocol for BaseSession {
    const DEVICE: &'static str = "base";
    type Config = BaseConfig;
    type Data = Data;

    fn start(config: BaseConfig, now: Duration, events: &mut Vec<Event<Data>>) -> Self {
        let mut session = Self {
            config,
            receiver: Receiver::default(),
            // A reply to a program before this one has another number, most likely.
            greeting: now.as_nanos() as u16,
            phase: Phase::Greeting {
                next: now,
                deadline: now + START,
            },
            read: now,
            tally: Tally::default(),
            losses: Losses::default(),
            warnings: Warnings::default(),
            leaps: Throttle::default(),
            idleness: Throttle::default(),
        };
        session.greet(now);
        session.send_greeting(now, events);
        session
    }

    fn is_ready(&self) -> bool {
        matches!(&self.phase, Phase::Known(board) if board.is_ready)
    }

    fn receive(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event<Data>>) {
        let pause = now.saturating_sub(core::mem::replace(&mut self.read, now));
        if pause > SILENCE
            && let Phase::Known(board) = &mut self.phase
        {
            // The driver did not run: the board is not to blame. What has waited is as old as its lines say.
            board.deadline = board.deadline.max(now + SILENCE);
            board.commands.forgive();
        }
        self.tally.bytes += bytes.len();
        for line in self.receiver.receive(bytes) {
            let result = match line {
                Line::Good(text) => {
                    self.tally.good += 1;
                    self.line(&text, now, events)
                }
                Line::Corrupt => {
                    self.tally.corrupt += 1;
                    self.losses.corrupt += u64::from(matches!(self.phase, Phase::Known(_)));
                    Ok(())
                }
            };
            if let Err(reason) = result {
                return lose(reason, events);
            }
        }
        self.send_greeting(now, events);
        if let Some(reason) = self.lost(now) {
            return lose(reason, events);
        }
        if let Some(words) = self.warnings.update(self.losses, now) {
            events.push(Event::Warn(words));
        }
    }

    fn closing_bytes() -> Vec<u8> {
        line("stop")
    }
}

/// Ends the session. The board hears that it must stop, if it hears anything.
fn lose(reason: String, events: &mut Vec<Event<Data>>) {
    events.push(Event::Send(BaseSession::closing_bytes()));
    events.push(Event::Disconnect(reason));
}

impl BaseSession {
    /// Returns the bytes that command these speeds, within the board's limits: 0 until it is ready.
    pub(crate) fn drive(&mut self, twist: &Twist, now: Duration) -> Vec<u8> {
        let Phase::Known(board) = &mut self.phase else {
            return Vec::new();
        };
        let twist = if board.is_ready { *twist } else { Twist::ZERO };
        board.commands.drive(&twist, &board.hello, now)
    }

    /// Asks the board anew what it is.
    fn greet(&mut self, now: Duration) {
        // 0 is that of a board that greets by itself.
        self.greeting = self.greeting.checked_add(1).unwrap_or(1);
        self.phase = Phase::Greeting {
            next: now,
            deadline: now + START,
        };
    }

    fn send_greeting(&mut self, now: Duration, events: &mut Vec<Event<Data>>) {
        if let Phase::Greeting { next, .. } = &mut self.phase
            && now >= *next
        {
            *next = now + GREETING;
            events.push(Event::Send(line(&format!("? {}", self.greeting))));
        }
    }

    fn line(&mut self, text: &str, now: Duration, events: &mut Vec<Event<Data>>) -> Result<(), String> {
        let mut words = text.split(' ');
        match words.next() {
            Some("hello") => {
                let (reply, hello) =
                    Hello::read(words).map_err(|reason| format!("its greeting cannot be used: {reason}"))?;
                self.hello(reply, hello, now, events)
            }
            Some("s") => self.state(words, now, events),
            // What later boards may add.
            Some(_) | None => Ok(()),
        }
    }

    fn hello(
        &mut self,
        reply: u16,
        hello: Hello,
        now: Duration,
        events: &mut Vec<Event<Data>>,
    ) -> Result<(), String> {
        match &self.phase {
            Phase::Greeting { .. } if reply == self.greeting => {
                let (wanted, number) = (&self.config.serial_number, &hello.serial_number);
                if !wanted.is_empty() && wanted != number {
                    return Err(format!(
                        "its serial number is {number}, not {wanted} as `serial_number` says: are two boards swapped?"
                    ));
                }
                let odometer = Odometer::new(&hello)
                    .map_err(|reason| format!("its greeting cannot be used: {reason}"))?;
                events.push(Event::Data(Data::Hello(Box::new(hello.clone()))));
                self.tally = Tally::default();
                self.phase = Phase::Known(Box::new(Board {
                    odometer,
                    clock: Clock::default(),
                    commands: Commands::default(),
                    rest: Rest::default(),
                    last: None,
                    deadline: now + SILENCE,
                    is_ready: false,
                    trouble: [false; 2],
                    hello,
                }));
            }
            Phase::Greeting { .. } => {}
            // It replies to an earlier one of the same greetings.
            Phase::Known(_) if reply == self.greeting => {}
            Phase::Known(board) if board.hello != hello => {
                return Err("it has become another board, or its sketch was changed".to_owned());
            }
            Phase::Known(_) => self.restart(now, events),
        }
        Ok(())
    }

    /// The board has started anew: its counts begin anew, too.
    fn restart(&mut self, now: Duration, events: &mut Vec<Event<Data>>) {
        events.push(Event::Warn(
            "the board started anew; the pose goes on from the last one: is its power too weak for its motors?"
                .to_owned(),
        ));
        self.greet(now);
    }

    fn state<'a>(
        &mut self,
        words: impl Iterator<Item = &'a str>,
        now: Duration,
        events: &mut Vec<Event<Data>>,
    ) -> Result<(), String> {
        let Phase::Known(board) = &mut self.phase else {
            return Ok(());
        };
        let report = Report::read(words, board.hello.kind)
            .map_err(|reason| format!("its state cannot be used: {reason}"))?;
        let sent = report.acknowledged.and_then(|number| board.commands.sent(number));
        let Some(time) = board.clock.read(report.time, now, sent) else {
            self.restart(now, events);
            return Ok(());
        };
        if let Some((number, refused)) = board.last.replace((report.number, report.bad)) {
            let missing = report.number.wrapping_sub(number).wrapping_sub(1);
            self.losses.missing += u64::from(missing);
            let more = report.bad.zip(refused);
            let more = more.and_then(|(bad, before)| bad.checked_sub(before));
            self.losses.refused += u64::from(more.unwrap_or(0));
        }
        if let Some(number) = report.acknowledged
            && !board.commands.acknowledge(number, &board.hello, now)
        {
            return Err(
                "it has a command in force that this driver did not give: who else drives it?".to_owned(),
            );
        }
        if time.age < SILENCE && board.commands.is_ignored(now) {
            return Err("it does not acknowledge commands: is its RX wired to the adapter's TX?".to_owned());
        }
        if board.commands.is_slow(now) {
            return Err(
                "its acknowledgements take more than 0.2 s: is the line too slow for its lines, or a network in between?"
                    .to_owned(),
            );
        }
        let step = match board.odometer.step(time.board, report.motion) {
            Ok(step) => step,
            // Such a line says nothing of the base.
            Err(words) => {
                if self.leaps.is_time(now) {
                    events.push(Event::Warn(format!(
                        "{words}; the pose goes on from the last one"
                    )));
                }
                return Ok(());
            }
        };
        if time.age < SILENCE {
            board.deadline = now + SILENCE;
            self.tally = Tally::default();
        }
        if !board.is_ready && report.acknowledged.is_some() && board.commands.is_quick() {
            board.is_ready = true;
            events.push(Event::Ready(board.hello.name()));
        }
        if board.is_ready {
            let standing = board.commands.standing_since();
            let running = board.rest.update(&step.twist, standing, &board.hello, now);
            let trouble = [running.is_some(), report.stalled];
            if trouble != core::mem::replace(&mut board.trouble, trouble) {
                let problem = running.or_else(|| report.stalled.then(|| STALLED.to_owned()));
                let name = board.hello.name();
                events.extend(problem.clone().map(Event::Warn));
                events.push(Event::Ready(match problem {
                    Some(problem) => format!("{problem} ({name})"),
                    None => name,
                }));
            }
        }
        if board.is_ready && report.acknowledged.is_none() && time.age < SILENCE && self.idleness.is_time(now)
        {
            events.push(Event::Warn(
                "it has no command in force: were commands lost, or is its watchdog shorter than it says?"
                    .to_owned(),
            ));
        }
        events.push(Event::Data(Data::State {
            report: Box::new(report),
            step,
            age: time.age,
        }));
        Ok(())
    }

    /// Returns why the board is lost, if it is.
    fn lost(&self, now: Duration) -> Option<String> {
        let tally = &self.tally;
        let reason = match &self.phase {
            Phase::Greeting { deadline, .. } if now < *deadline => return None,
            Phase::Known(board) if now < board.deadline => return None,
            Phase::Greeting { .. } | Phase::Known(_) if tally.bytes == 0 => {
                "it sends nothing: is it switched on, and is its TX wired to RX?"
            }
            Phase::Greeting { .. } | Phase::Known(_) if tally.good == 0 && tally.corrupt < 3 => {
                "bytes come, but no lines of a base: is the speed of the line right, and is it that board?"
            }
            Phase::Greeting { .. } | Phase::Known(_) if tally.corrupt > tally.good => {
                "most lines come with wrong checksums: is the speed of the line right, or the cable near a motor's?"
            }
            Phase::Greeting { .. } => {
                "it sends lines, and no reply to `?`: is its RX wired to the adapter's TX?"
            }
            Phase::Known(_) => {
                "its lines are old, or say nothing of its state: is the line too slow for them, or is its clock slow?"
            }
        };
        Some(reason.to_owned())
    }
}

#[cfg(test)]
mod tests;
