//! The handshake: three synchronisations in order, OPEN, CONFIG, and the commands that switch the robot on.
//! No step moves the robot.

use core::time::Duration;

use super::base::Base;
use super::head::HeadChannel;
use super::laser::LaserRequest;
use super::{HeadKind, LaserMode, Session, State, send_command};
use crate::sip::{MOVING, STOPPED};
use crate::{Command, Config, Form, Model, Names, Packet, SyncStep};

/// An unanswered synchronisation or OPEN is repeated after this time.
const SYNC_RETRY: Duration = Duration::from_secs(1);
/// The same for CONFIG, to which old robots never reply.
const CONFIG_RETRY: Duration = Duration::from_millis(300);
const MAX_CONFIG_ATTEMPTS: u32 = 3;
/// Unanswered attempts after which the session is lost.
const MAX_ATTEMPTS: u32 = 10;
/// Time between two CLOSEs to a robot that is still open: SIPs in transit are no reason for another.
const CLOSE_RETRY: Duration = Duration::from_millis(500);

/// What the handshake waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Awaited {
    /// The echo.
    Sync(SyncStep),
    /// The first SIP.
    Open,
    /// The configuration.
    Config,
}

/// The progress of the handshake.
#[derive(Clone, Debug)]
pub(super) struct Handshake {
    step: Awaited,
    sent_at: Duration,
    attempts: u32,
    close_sent_at: Option<Duration>,
}

impl Handshake {
    pub(super) fn new(now: Duration) -> Self {
        Self {
            step: Awaited::Sync(SyncStep::Zero),
            sent_at: now,
            attempts: 0,
            close_sent_at: None,
        }
    }

    /// Sends the packet of the present step.
    pub(super) fn send_step(&mut self, output: &mut Vec<u8>) {
        self.attempts += 1;
        match self.step {
            Awaited::Sync(sync) => output.extend(sync.to_packet().to_bytes()),
            Awaited::Open => send_command(output, &Command::Open(Form::One)),
            Awaited::Config => send_command(output, &Command::Config(Form::One)),
        }
    }

    fn go_to(&mut self, step: Awaited, now: Duration, output: &mut Vec<u8>) {
        (self.step, self.sent_at, self.attempts) = (step, now, 0);
        self.send_step(output);
    }
}

impl Session {
    /// Processes a packet during the handshake.
    pub(super) fn handle_handshake(&mut self, packet: &Packet, now: Duration) {
        let Some(mut handshake) = self.handshake.take() else {
            return;
        };
        let is_sip = matches!(packet.id(), STOPPED | MOVING);
        match handshake.step {
            Awaited::Sync(_) if is_sip => {
                // The robot is still open from an earlier session of any client.
                if handshake
                    .close_sent_at
                    .is_none_or(|closed| now.saturating_sub(closed) > CLOSE_RETRY)
                {
                    handshake.close_sent_at = Some(now);
                    send_command(&mut self.output, &Command::Close(Form::One));
                    let attempts = handshake.attempts;
                    handshake.go_to(Awaited::Sync(SyncStep::Zero), now, &mut self.output);
                    handshake.attempts += attempts;
                }
            }
            Awaited::Sync(SyncStep::Two) => {
                if packet.data().is_empty() {
                    // An echo without names is caused by the line, not by a robot.
                } else if let Ok(names) = Names::from_packet(packet)
                    && !self.accept_names(names, &mut handshake, now)
                {
                    return;
                }
            }
            Awaited::Sync(step) => {
                if SyncStep::from_packet(packet) == Some(step) {
                    let next = if step == SyncStep::Zero {
                        SyncStep::One
                    } else {
                        SyncStep::Two
                    };
                    handshake.go_to(Awaited::Sync(next), now, &mut self.output);
                }
            }
            Awaited::Open if is_sip => handshake.go_to(Awaited::Config, now, &mut self.output),
            Awaited::Open => {}
            Awaited::Config => {
                if is_sip {
                    self.last_received = now;
                } else if let Ok(config) = Config::from_packet(packet) {
                    self.set_config(config);
                    self.switch_on(now);
                    return;
                }
            }
        }
        self.handshake = Some(handshake);
    }

    /// Repeats an unanswered packet, or gives up.
    pub(super) fn retry_handshake(&mut self, now: Duration) {
        let Some(mut handshake) = self.handshake.take() else {
            return;
        };
        let (interval, max_attempts) = match handshake.step {
            Awaited::Sync(_) | Awaited::Open => (SYNC_RETRY, MAX_ATTEMPTS),
            Awaited::Config => (CONFIG_RETRY, MAX_CONFIG_ATTEMPTS),
        };
        if now.saturating_sub(handshake.sent_at) >= interval {
            handshake.sent_at = now;
            match handshake.step {
                Awaited::Config if handshake.attempts >= max_attempts => {
                    self.switch_on(now);
                    return;
                }
                Awaited::Sync(_) | Awaited::Open if handshake.attempts >= max_attempts => {
                    self.lost("no reply from a Pioneer robot: is it switched on, and is the speed of the line right?");
                    return;
                }
                Awaited::Sync(_) | Awaited::Open | Awaited::Config => handshake.send_step(&mut self.output),
            }
        }
        self.handshake = Some(handshake);
    }

    /// Processes the robot's names. Returns whether the robot can be driven.
    fn accept_names(&mut self, names: Names, handshake: &mut Handshake, now: Duration) -> bool {
        let model = match &self.options.model {
            Some(model) => model.clone(),
            None => match Model::of_subclass(&names.subclass) {
                Ok(model) => model,
                Err(error) => {
                    self.state = State::Refused(format!(
                        "the robot `{}` is a {} `{}`: {error}",
                        names.name, names.class, names.subclass
                    ));
                    return false;
                }
            },
        };
        self.model = Some(model);
        self.state = State::Opening(names);
        handshake.go_to(Awaited::Open, now, &mut self.output);
        true
    }

    /// Switches everything on. From then on, setpoints drive the robot.
    fn switch_on(&mut self, now: Duration) {
        let State::Opening(names) = &self.state else {
            return;
        };
        self.state = State::Connected(names.clone());
        let output = &mut self.output;
        // Sonars first: one server disconnects a client that opens it and does not switch on the sonars
        // within a second.
        for command in [Command::Sonar(1), Command::Enable(true), Command::Encoder(2)] {
            send_command(output, &command);
        }
        self.last_received = now;
        self.base = Base::new(now);
        let beams = match self.options.laser {
            LaserMode::Auto(beams) => self.is_simulator().then_some(beams),
            LaserMode::On(beams) => Some(beams),
            LaserMode::Off => None,
        };
        if let Some(beams) = beams {
            let output = &mut self.output;
            self.laser_request = LaserRequest::start(beams, now, |command| send_command(output, &command));
        }
        self.head = match self.options.head {
            HeadKind::None => None,
            HeadKind::VcC4 => Some(HeadChannel::new(true, now)),
            HeadKind::VcC4OneWay => Some(HeadChannel::new(false, now)),
        };
    }
}
