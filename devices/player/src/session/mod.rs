//! A client's session with a server: it finds the robot, receives its data and drives it. It has no clock, no
//! thread and no socket; its owner transfers the bytes and supplies the time.
//!
//! Once connected, only [`Session::drive`] sends anything.

mod options;
mod robot;
mod step;

use core::time::Duration;

pub use options::{Choice, HeadSetpoint, Options, Setpoint};
pub use robot::{Event, Laser, Ring, Robot, State};
use step::{Inquiry, Search};

use crate::{Head, Interface, Kind, Message, Receiver, Scan, data};

/// Time limit of a reply. A subscription waits until the server has started the device.
const REPLY_TIMEOUT: Duration = Duration::from_secs(20);
/// Time without data of the base after which the robot counts as lost.
const SILENCE_UNTIL_LOST: Duration = Duration::from_secs(3);
/// How often an unchanged velocity is sent.
const VELOCITY_REPEAT: Duration = Duration::from_millis(200);
/// Command to a base: velocity. Command to a pan-tilt unit: state.
const SET_VELOCITY: u8 = 1;
const HEAD_STATE: u8 = 1;
/// Synch message of the server: it dropped messages.
const SERVER_OVERFLOW: u8 = 2;

/// A client's session with a server, over one connection.
#[derive(Clone, Debug)]
pub struct Session {
    state: State,
    receiver: Receiver,
    search: Search,
    output: Vec<u8>,
    events: Vec<Event>,
    /// Time of the last request or, once connected, of the last data of the base.
    last: Duration,
    /// The velocity that was sent last, and its time.
    velocity: Option<([f64; 3], Duration)>,
    head: HeadState,
    has_warned: bool,
}

/// The head as it was measured and commanded last.
#[derive(Clone, Copy, Debug, Default)]
struct HeadState {
    measured: Option<Head>,
    /// The target of each axis that has been commanded.
    targets: [Option<f32>; 2],
    is_moving: [bool; 2],
    sent: Option<([f32; 2], [f32; 2])>,
}

impl Session {
    /// Creates the session of a new connection.
    #[must_use]
    pub fn new(options: Options, now: Duration) -> Self {
        Self {
            state: State::Opening,
            receiver: Receiver::default(),
            search: Search::new(options),
            output: Vec::new(),
            events: Vec::new(),
            last: now,
            velocity: None,
            head: HeadState::default(),
            has_warned: false,
        }
    }

    /// Returns the state of the session.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Returns the robot, once it can be driven.
    #[must_use]
    pub fn robot(&self) -> Option<&Robot> {
        (self.state == State::Connected).then_some(&self.search.robot)
    }

    /// Returns the bytes to send now, each once.
    pub fn output(&mut self) -> Vec<u8> {
        core::mem::take(&mut self.output)
    }

    /// Returns what has happened, each event once.
    pub fn events(&mut self) -> Vec<Event> {
        core::mem::take(&mut self.events)
    }

    /// Processes bytes that arrived by `now`, split anywhere, and the time. Call it without bytes too.
    pub fn receive(&mut self, bytes: &[u8], now: Duration) {
        let mut messages = Vec::new();
        let received = self.receiver.receive(bytes, |message| messages.push(message));
        if self.search.step == Inquiry::Greeting
            && let Some(version) = self.receiver.version()
        {
            self.search.robot.version = version.to_owned();
            self.search.step = Inquiry::List;
            self.send_request(now);
        }
        for message in &messages {
            let taken = match self.state {
                State::Opening => self.take_reply(message, now),
                State::Connected => self.take_data(message, now),
                State::Lost(_) => return,
            };
            if let Err(reason) = taken {
                self.state = State::Lost(reason);
            }
        }
        if let Err(error) = received {
            self.state = State::Lost(error.to_string());
        }
        self.check_time(now);
    }

    /// Drives according to the setpoint. Only its owner calls it, in every iteration.
    pub fn drive(&mut self, setpoint: &Setpoint, now: Duration) {
        if self.state != State::Connected {
            return;
        }
        let velocity = setpoint
            .velocity
            .map(|speed| if speed.is_finite() { speed } else { 0.0 });
        let is_due =
            |(sent, at): ([f64; 3], Duration)| sent != velocity || now.saturating_sub(at) >= VELOCITY_REPEAT;
        if self.velocity.is_none_or(is_due) {
            self.velocity = Some((velocity, now));
            let message = self.velocity_message(velocity);
            self.output.extend(message.to_bytes());
        }
        if let Some(device) = self.search.robot.head
            && let Some(command) = self.head.step(&setpoint.head)
        {
            let body = command.into_iter().flat_map(f32::to_be_bytes).collect();
            let message = Message::to(device, Kind::Command, HEAD_STATE, body);
            self.output.extend(message.to_bytes());
        }
    }

    /// Returns the bytes that stop the robot; send them last. Closing the connection ends the subscriptions.
    #[must_use]
    pub fn stop(&self) -> Vec<u8> {
        match self.state {
            State::Connected => self.velocity_message([0.0; 3]).to_bytes(),
            State::Opening | State::Lost(_) => Vec::new(),
        }
    }

    fn velocity_message(&self, velocity: [f64; 3]) -> Message {
        let mut body: Vec<u8> = velocity.into_iter().flat_map(f64::to_be_bytes).collect();
        let motors_on = 1_u32;
        body.extend(motors_on.to_be_bytes());
        Message::to(self.search.robot.base, Kind::Command, SET_VELOCITY, body)
    }

    fn send_request(&mut self, now: Duration) {
        self.last = now;
        match self.search.step.request(self.search.robot.base) {
            Some(request) => self.output.extend(request.to_bytes()),
            None => {
                self.state = State::Connected;
                self.events
                    .push(Event::Ready(Box::new(self.search.robot.clone())));
            }
        }
    }

    fn take_reply(&mut self, message: &Message, now: Duration) -> Result<(), String> {
        if !self.search.is_reply(message) {
            return Ok(());
        }
        self.search.take_reply(message)?;
        let warnings = self.search.warnings.drain(..);
        self.events.extend(warnings.map(Event::Warning));
        self.send_request(now);
        Ok(())
    }

    fn take_data(&mut self, message: &Message, now: Duration) -> Result<(), String> {
        let device = Some(message.device);
        let robot = &self.search.robot;
        let sonars = robot.sonars.as_ref().map(|ring| ring.device);
        let bumpers = robot.bumpers.as_ref().map(|(device, _)| *device);
        let event = match (message.kind, message.subtype) {
            (Kind::Data, 1) if message.device == robot.base => {
                let base = data::base(message).map_err(|error| error.to_string())?;
                if ![base.pose, base.velocity]
                    .as_flattened()
                    .iter()
                    .all(|number| number.is_finite())
                {
                    return Err(format!("{} reports a pose that is not finite", message.device));
                }
                self.last = now;
                Ok(Event::Base(base))
            }
            (Kind::Data, 1 | 2) if robot.laser.is_some_and(|laser| laser.device == message.device) => {
                let limits = robot.laser.and_then(|laser| laser.limits);
                scan(message, limits).map(Event::Laser)
            }
            (Kind::Data, 1 | 2) if device == sonars => match message.device.interface {
                Interface::RANGER => data::ranger(message).map(Event::Sonars),
                // The other data of the interface `sonar` are its places.
                _ if message.subtype == 2 => return Ok(()),
                _ => data::sonar(message).map(Event::Sonars),
            },
            (Kind::Data, 1) if device == bumpers => data::bumpers(message).map(Event::Bumpers),
            (Kind::Data, 1) if device == robot.battery => data::power(message).map(Event::Battery),
            (Kind::Data, 1) if device == robot.head => {
                let head = data::head(message);
                self.head.measured = head.as_ref().ok().copied();
                head.map(Event::Head)
            }
            (Kind::Synch, SERVER_OVERFLOW) if !self.has_warned => {
                self.has_warned = true;
                Ok(Event::Warning(
                    "the server dropped messages: it sends more than is read".to_owned(),
                ))
            }
            _ => return Ok(()),
        };
        self.events.push(event.map_err(|error| error.to_string())?);
        Ok(())
    }

    fn check_time(&mut self, now: Duration) {
        let elapsed = now.saturating_sub(self.last);
        let reason = match (&self.state, &self.search.step) {
            (State::Opening, Inquiry::Greeting) if elapsed >= SILENCE_UNTIL_LOST => {
                format!(
                    "it has sent no greeting of a Player server for {} s",
                    SILENCE_UNTIL_LOST.as_secs()
                )
            }
            (State::Opening, step) if elapsed >= REPLY_TIMEOUT => {
                let request = step.request(self.search.robot.base);
                let device = request.map_or(self.search.robot.base, |request| request.device);
                format!("no reply of {device} for {} s", REPLY_TIMEOUT.as_secs())
            }
            (State::Connected, _) if elapsed >= SILENCE_UNTIL_LOST => format!(
                "no data of {} for {} s: is the simulation paused, or the robot off?",
                self.search.robot.base,
                SILENCE_UNTIL_LOST.as_secs()
            ),
            (State::Opening | State::Connected | State::Lost(_), _) => return,
        };
        self.state = State::Lost(reason);
    }
}

impl HeadState {
    /// Returns the command to send: pan, tilt, field of view, speeds. `None` if nothing has changed.
    fn step(&mut self, setpoint: &HeadSetpoint) -> Option<[f32; 5]> {
        let measured = self.measured.unwrap_or_default();
        for (axis, now) in [measured.pan, measured.tilt].into_iter().enumerate() {
            let is_finite = setpoint.angles[axis].is_finite() && setpoint.speeds[axis].is_finite();
            if is_finite && setpoint.speeds[axis] != 0.0 {
                self.targets[axis] = Some(setpoint.angles[axis]);
                self.is_moving[axis] = true;
            } else if self.is_moving[axis] || self.targets[axis].is_none() {
                self.targets[axis] = Some(now);
                self.is_moving[axis] = false;
            }
        }
        let speeds = setpoint
            .speeds
            .map(|speed| if speed.is_finite() { speed.abs() } else { 0.0 });
        let targets = self.targets.map(Option::unwrap_or_default);
        let is_idle = self.sent.is_none() && speeds == [0.0; 2];
        if is_idle || self.sent.replace((targets, speeds)) == Some((targets, speeds)) {
            return None;
        }
        Some([targets[0], targets[1], measured.zoom, speeds[0], speeds[1]])
    }
}

fn scan(message: &Message, limits: Option<[f64; 4]>) -> Result<Scan, crate::Error> {
    let Some([angle_min, angle_max, range_min, range_max]) = limits else {
        return data::laser(message);
    };
    Ok(Scan {
        angle_min,
        angle_max,
        range_min,
        range_max,
        ranges: data::ranger(message)?,
    })
}
