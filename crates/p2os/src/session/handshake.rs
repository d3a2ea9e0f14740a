//! The handshake: three synchronisations in order, OPEN, CONFIG, and the commands that switch the robot on.
//! Nothing here moves it.

use core::time::Duration;

use super::base::Base;
use super::head::HeadLine;
use super::laser::Asking;
use super::{Head, Laser, Session, State, say};
use crate::sip::{MOVING, STOPPED};
use crate::{Command, Config, Form, Model, Names, Packet, Sync};

/// An unanswered synchronisation or OPEN is repeated after this time.
const AGAIN: Duration = Duration::from_secs(1);
/// The same for CONFIG, which old robots never answer.
const CONFIG_AGAIN: Duration = Duration::from_millis(300);
const CONFIG_TRIES: u32 = 3;
/// Unanswered attempts after which the session is lost.
const TRIES: u32 = 10;
/// Time between two CLOSEs to a robot that is still open: SIPs in transit are no reason for another.
const CLOSE_AGAIN: Duration = Duration::from_millis(500);

/// What the handshake waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// The echo.
    Sync(Sync),
    /// The first SIP.
    Open,
    /// The configuration.
    Config,
}

/// The progress of the handshake.
#[derive(Clone, Debug)]
pub(super) struct Handshake {
    step: Step,
    said: Duration,
    tries: u32,
    closed: Option<Duration>,
}

impl Handshake {
    pub(super) fn new(now: Duration) -> Self {
        Self {
            step: Step::Sync(Sync::Zero),
            said: now,
            tries: 0,
            closed: None,
        }
    }

    /// Sends the packet of the present step.
    pub(super) fn hello(&mut self, output: &mut Vec<u8>) {
        self.tries += 1;
        match self.step {
            Step::Sync(sync) => output.extend(sync.to_packet().to_bytes()),
            Step::Open => say(output, &Command::Open(Form::One)),
            Step::Config => say(output, &Command::Config(Form::One)),
        }
    }

    fn go_to(&mut self, step: Step, now: Duration, output: &mut Vec<u8>) {
        (self.step, self.said, self.tries) = (step, now, 0);
        self.hello(output);
    }
}

impl Session {
    /// Processes a packet during the handshake.
    pub(super) fn shake(&mut self, packet: &Packet, now: Duration) {
        let Some(mut handshake) = self.handshake.take() else {
            return;
        };
        let is_sip = matches!(packet.id(), STOPPED | MOVING);
        match handshake.step {
            Step::Sync(_) if is_sip => {
                // The robot is still open from an earlier session of any client.
                if handshake
                    .closed
                    .is_none_or(|closed| now.saturating_sub(closed) > CLOSE_AGAIN)
                {
                    handshake.closed = Some(now);
                    say(&mut self.output, &Command::Close(Form::One));
                    let tries = handshake.tries;
                    handshake.go_to(Step::Sync(Sync::Zero), now, &mut self.output);
                    handshake.tries += tries;
                }
            }
            Step::Sync(Sync::Two) => {
                if packet.data().is_empty() {
                    // An echo without names comes from the line, not from a robot.
                } else if let Ok(names) = Names::from_packet(packet)
                    && !self.meet(names, &mut handshake, now)
                {
                    return;
                }
            }
            Step::Sync(step) => {
                if Sync::from_packet(packet) == Some(step) {
                    let next = if step == Sync::Zero { Sync::One } else { Sync::Two };
                    handshake.go_to(Step::Sync(next), now, &mut self.output);
                }
            }
            Step::Open if is_sip => handshake.go_to(Step::Config, now, &mut self.output),
            Step::Open => {}
            Step::Config => {
                if is_sip {
                    self.heard = now;
                } else if let Ok(config) = Config::from_packet(packet) {
                    self.set_to(config);
                    self.switch_on(now);
                    return;
                }
            }
        }
        self.handshake = Some(handshake);
    }

    /// Repeats an unanswered packet, or gives up.
    pub(super) fn wait(&mut self, now: Duration) {
        let Some(mut handshake) = self.handshake.take() else {
            return;
        };
        let (again, tries) = match handshake.step {
            Step::Sync(_) | Step::Open => (AGAIN, TRIES),
            Step::Config => (CONFIG_AGAIN, CONFIG_TRIES),
        };
        if now.saturating_sub(handshake.said) >= again {
            handshake.said = now;
            match handshake.step {
                Step::Config if handshake.tries >= tries => {
                    self.switch_on(now);
                    return;
                }
                Step::Sync(_) | Step::Open if handshake.tries >= tries => {
                    self.lost("nobody answers as a Pioneer does: is it switched on, and at this speed?");
                    return;
                }
                Step::Sync(_) | Step::Open | Step::Config => handshake.hello(&mut self.output),
            }
        }
        self.handshake = Some(handshake);
    }

    /// Processes the robot's names. Returns whether the robot can be driven.
    fn meet(&mut self, names: Names, handshake: &mut Handshake, now: Duration) -> bool {
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
        handshake.go_to(Step::Open, now, &mut self.output);
        true
    }

    /// Switches everything on. From here on, a wish drives the robot.
    fn switch_on(&mut self, now: Duration) {
        let State::Opening(names) = &self.state else {
            return;
        };
        self.state = State::Connected(names.clone());
        let output = &mut self.output;
        // Sonars first: one server disconnects a client that opens it and does not switch on the sonars
        // within a second.
        for command in [Command::Sonar(1), Command::Enable(true), Command::Encoder(2)] {
            say(output, &command);
        }
        self.heard = now;
        self.base = Base::new(now);
        let beams = match self.options.laser {
            Laser::Auto(beams) => self.is_simulator().then_some(beams),
            Laser::On(beams) => Some(beams),
            Laser::Off => None,
        };
        if let Some(beams) = beams {
            let output = &mut self.output;
            self.asking = Asking::begin(beams, now, |command| say(output, &command));
        }
        self.head = match self.options.head {
            Head::None => None,
            Head::VcC4 => Some(HeadLine::new(true, now)),
            Head::VcC4OneWay => Some(HeadLine::new(false, now)),
        };
    }
}
