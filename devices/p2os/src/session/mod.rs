//! The client's end of a connection: handshake, driving, close. It has no clock, no thread and no socket; its
//! owner transfers the bytes and supplies the time.
//!
//! Once connected, only [`Session::drive`] and [`Session::close`] send anything. If the application
//! hangs, the robot receives nothing, and its watchdog stops it.

mod base;
mod event;
mod handshake;
mod head;
mod laser;
mod options;

use core::time::Duration;
use std::collections::VecDeque;

use crate::encoders;
use crate::{
    Assembler, Command, Config, Dropped, Encoders, Form, LaserPacket, Model, Odometer, Packet, Pose,
    Receiver, SerialAux, Sip,
};

use base::Base;
pub use event::{Event, State};
use handshake::Handshake;
use head::HeadChannel;
use laser::LaserRequest;
pub use options::{Beams, HeadKind, HeadSetpoint, LaserMode, Options, Setpoint};

/// A robot that is silent for this time is lost: it normally sends ten SIPs in it.
const SILENCE_UNTIL_LOST: Duration = Duration::from_secs(1);
/// Most events that wait for the owner. The oldest are dropped first, because they are out of date.
const MAX_EVENTS: usize = 256;

/// A client's session with a robot.
#[derive(Clone, Debug)]
pub struct Session {
    options: Options,
    state: State,
    handshake: Option<Handshake>,
    receiver: Receiver,
    output: Vec<u8>,
    events: VecDeque<Event>,
    model: Option<Model>,
    config: Option<Config>,
    sip: Option<Sip>,
    last_received: Duration,
    odometer: Odometer,
    base: Base,
    laser_request: LaserRequest,
    assembler: Assembler,
    head: Option<HeadChannel>,
    /// The last counts over this connection.
    last_encoders: Option<Encoders>,
    /// The ticks of the wheels, over all connections.
    ticks: [i64; 2],
}

impl Session {
    /// Creates a session without a connection.
    #[must_use]
    pub fn new(options: Options) -> Self {
        Self {
            state: State::Idle,
            handshake: None,
            receiver: Receiver::new(),
            output: Vec::new(),
            events: VecDeque::new(),
            model: options.model.clone(),
            config: None,
            sip: None,
            last_received: Duration::ZERO,
            odometer: Odometer::new(options.start),
            base: Base::new(Duration::ZERO),
            laser_request: LaserRequest::Done,
            assembler: Assembler::default(),
            head: None,
            last_encoders: None,
            ticks: [0; 2],
            options,
        }
    }

    /// Starts the handshake over a new connection. All earlier state is discarded, except the odometry and
    /// the encoder ticks, which continue.
    pub fn connected(&mut self, now: Duration) {
        self.receiver = Receiver::new();
        self.output.clear();
        self.events.clear();
        self.config = None;
        self.sip = None;
        self.laser_request = LaserRequest::Done;
        self.assembler = Assembler::default();
        self.head = None;
        // The robot may restart its counts, so the motion in between is unknown.
        self.last_encoders = None;
        self.odometer.rebase();
        self.last_received = now;
        self.state = State::Syncing;
        let mut handshake = Handshake::new(now);
        handshake.send_step(&mut self.output);
        self.handshake = Some(handshake);
    }

    /// Ends the session after a loss of the connection, with the reason.
    pub fn lost(&mut self, reason: &str) {
        if !matches!(self.state, State::Refused(_)) {
            self.state = State::Lost(reason.to_owned());
        }
        self.handshake = None;
        self.output.clear();
    }

    /// Processes bytes that arrived by `now`. They may be split anywhere.
    pub fn receive(&mut self, bytes: &[u8], now: Duration) {
        let mut packets = Vec::new();
        self.receiver.receive(bytes, now, |packet| packets.push(packet));
        for packet in packets {
            match self.state {
                State::Syncing | State::Opening(_) => self.handle_handshake(&packet, now),
                State::Connected(_) => self.handle_packet(&packet, now),
                State::Idle | State::Lost(_) | State::Refused(_) => {}
            }
        }
    }

    /// Continues the handshake, or drives according to the setpoint. Only its owner calls it, in every
    /// iteration.
    pub fn drive(&mut self, setpoint: &Setpoint, now: Duration) {
        match self.state {
            State::Syncing | State::Opening(_) => self.retry_handshake(now),
            State::Connected(_) => self.drive_connected(setpoint, now),
            State::Idle | State::Lost(_) | State::Refused(_) => {}
        }
    }

    /// Returns the bytes to send now, each once.
    pub fn output(&mut self) -> Vec<u8> {
        core::mem::take(&mut self.output)
    }

    /// Returns the next event.
    pub fn next_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// Ends the session. Returns the bytes that stop the robot and switch it off; send them last.
    pub fn close(&mut self) -> Vec<u8> {
        let mut closing_bytes = Vec::new();
        let commands: &[Command] = match self.state {
            State::Connected(_) | State::Opening(_) => &[
                Command::Velocity(0),
                Command::RotVelocity(0),
                Command::Enable(false),
                Command::Sonar(0),
                Command::Close(Form::One),
            ],
            State::Syncing => &[Command::Close(Form::One)],
            State::Idle | State::Lost(_) | State::Refused(_) => &[],
        };
        for command in commands {
            send_command(&mut closing_bytes, command);
        }
        self.output.clear();
        self.handshake = None;
        self.state = State::Idle;
        closing_bytes
    }

    /// Returns the state of the session.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Returns the robot's model, once it is known.
    #[must_use]
    pub fn model(&self) -> Option<&Model> {
        self.model.as_ref()
    }

    /// Returns the robot's configuration, once it has arrived.
    #[must_use]
    pub fn config(&self) -> Option<&Config> {
        self.config.as_ref()
    }

    /// Returns whether the robot reports that it is a simulator.
    #[must_use]
    pub fn is_simulator(&self) -> bool {
        let named = match &self.state {
            State::Opening(names) | State::Connected(names) => crate::config::is_simulators_name(&names.name),
            State::Idle | State::Syncing | State::Lost(_) | State::Refused(_) => false,
        };
        named || self.config.as_ref().is_some_and(Config::is_simulator)
    }

    /// Returns the pose of the odometry.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.odometer.pose()
    }

    /// Returns what the receiver discarded over this connection.
    #[must_use]
    pub fn dropped(&self) -> Dropped {
        self.receiver.dropped()
    }

    fn drive_connected(&mut self, setpoint: &Setpoint, now: Duration) {
        if now.saturating_sub(self.last_received) > SILENCE_UNTIL_LOST {
            self.lost(
                "the robot has sent nothing for a second: is it switched on, and is the cable connected?",
            );
            return;
        }
        let Some(model) = &self.model else { return };
        let limits = base::limits(model, self.config.as_ref());
        let output = &mut self.output;
        self.base
            .drive(setpoint, limits, now, |command| send_command(output, &command));
        let mut events = Vec::new();
        if let Some(sip) = &self.sip {
            events.extend(
                self.base
                    .motors(sip, now, |command| send_command(output, &command)),
            );
        }
        events.extend(
            self.laser_request
                .poll(now, |command| send_command(output, &command)),
        );
        if let Some(head) = &mut self.head {
            events.extend(head.drive(&setpoint.head, now, |command| send_command(output, &command)));
        }
        for event in events {
            self.push_event(event);
        }
    }

    /// Processes a packet of a connected robot.
    fn handle_packet(&mut self, packet: &Packet, now: Duration) {
        if let Ok(sip) = Sip::from_packet(packet) {
            self.last_received = now;
            if let Some(model) = &self.model {
                self.odometer.update(model, &sip, now);
            }
            self.sip = Some(sip.clone());
            self.push_event(Event::Sip(Box::new(sip)));
        } else if LaserPacket::is_laser_packet(packet) {
            let Ok(part) = LaserPacket::from_packet(packet) else {
                return;
            };
            self.laser_request.confirm();
            if let Some(sweep) = self.assembler.add(&part) {
                self.push_event(Event::Laser(sweep));
            }
        } else if packet.id() == encoders::KIND {
            let Ok(encoders) = Encoders::from_packet(packet) else {
                return;
            };
            let last = self.last_encoders.replace(encoders).unwrap_or(encoders);
            self.ticks[0] += i64::from(encoders.left.wrapping_sub(last.left));
            self.ticks[1] += i64::from(encoders.right.wrapping_sub(last.right));
            let [left, right] = self.ticks;
            self.push_event(Event::Encoders { left, right });
        } else if let Ok(config) = Config::from_packet(packet) {
            self.set_config(config);
        } else if let (Ok(aux), Some(head)) = (SerialAux::from_packet(packet), &mut self.head)
            && let Some(event) = head.receive(&aux, now)
        {
            self.push_event(event);
        }
    }

    fn set_config(&mut self, config: Config) {
        self.push_event(Event::Config(Box::new(config.clone())));
        self.config = Some(config);
    }

    fn push_event(&mut self, event: Event) {
        if self.events.len() == MAX_EVENTS {
            self.events.pop_front();
        }
        self.events.push_back(event);
    }
}

/// Appends a command's packet. Every command of a session fits into a packet.
fn send_command(output: &mut Vec<u8>, command: &Command) {
    if let Ok(packet) = command.to_packet() {
        output.extend(packet.to_bytes());
    }
}
