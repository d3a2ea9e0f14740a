//! A scripted robot: it answers according to the protocol and records its commands. It has no physics.

use core::time::Duration;

use jde_p2os::*;

/// A session, and the robot at its other end.
pub(crate) struct Talk {
    pub(crate) session: Session,
    pub(crate) now: Duration,
    pub(crate) robot: Robot,
}

/// The robot, and its script.
pub(crate) struct Robot {
    pub(crate) names: Names,
    pub(crate) config: Option<Config>,
    pub(crate) sip: Sip,
    pub(crate) heard: Vec<Command>,
    pub(crate) mute: bool,
    pub(crate) motors_broken: bool,
    pub(crate) camera: bool,
    /// Bytes of the camera that the client has not fetched, and the number that it has requested.
    said: Vec<u8>,
    wanted: usize,
    open: bool,
    synced: u8,
    receiver: Receiver,
}

impl Robot {
    pub(crate) fn new(name: &str, subclass: &str) -> Self {
        let names = Names {
            name: name.into(),
            class: "Pioneer".into(),
            subclass: subclass.into(),
        };
        Self {
            names,
            config: Some(Config::default()),
            sip: Sip::default(),
            heard: Vec::new(),
            mute: false,
            motors_broken: false,
            camera: false,
            said: Vec::new(),
            wanted: 0,
            open: false,
            synced: 0,
            receiver: Receiver::new(),
        }
    }

    /// Processes a client's bytes; returns the answers.
    pub(crate) fn take(&mut self, bytes: &[u8], now: Duration) -> Vec<u8> {
        let mut packets = Vec::new();
        self.receiver.receive(bytes, now, |packet| packets.push(packet));
        let mut answers = Vec::new();
        for packet in packets {
            if !self.open
                && let Some(sync) = SyncStep::from_packet(&packet)
            {
                self.heard.push(Command::from_packet(&packet));
                if sync as u8 != self.synced {
                    continue;
                }
                self.synced += 1;
                answers.extend(match sync {
                    SyncStep::Zero | SyncStep::One => sync.to_packet().to_bytes(),
                    SyncStep::Two => self.names.to_packet().unwrap().to_bytes(),
                });
                continue;
            }
            let command = Command::from_packet(&packet);
            match &command {
                Command::Open(_) => self.open = true,
                Command::Close(_) => (self.open, self.synced) = (false, 0),
                Command::Config(_) => {
                    let config = self.config.as_ref().map(|config| config.to_packet().unwrap());
                    answers.extend(config.into_iter().flat_map(|packet| packet.to_bytes()));
                }
                Command::Enable(on) if !self.motors_broken => {
                    self.sip.flags = self.sip.flags & !Flags::MOTORS | u16::from(*on);
                }
                Command::Tty2(bytes) if self.camera => {
                    let answer = match HeadFrame::from_bytes(bytes) {
                        Ok(HeadFrame::Command(HeadCommand::GetPanTilt)) => HeadReply::position(-400, 178),
                        _ => HeadReply::success(),
                    };
                    self.said.extend(answer.to_bytes());
                }
                Command::GetAux(0) => self.said.clear(),
                Command::GetAux(count) => self.wanted = usize::from(*count),
                _ => {}
            }
            self.heard.push(command);
            if self.wanted > 0 && self.said.len() >= self.wanted {
                let bytes = self.said.drain(..core::mem::take(&mut self.wanted)).collect();
                let aux = SerialAux {
                    port: AuxPort::One,
                    bytes,
                };
                answers.extend(aux.to_packet().unwrap().to_bytes());
            }
        }
        answers
    }

    /// Opens it, as an earlier session left it.
    pub(crate) fn left_open(mut self) -> Self {
        self.open = true;
        self
    }

    /// Returns its unsolicited packets of a tenth of a second.
    pub(crate) fn says(&self) -> Vec<u8> {
        if self.open && !self.mute {
            self.sip.to_packet().unwrap().to_bytes()
        } else {
            Vec::new()
        }
    }
}

impl Talk {
    /// Creates a session that has a connection and nothing more.
    pub(crate) fn new(robot: Robot, options: Options) -> Self {
        let mut session = Session::new(options);
        let now = Duration::from_secs(100);
        session.connected(now);
        Self { session, now, robot }
    }

    /// Creates a session that has completed the handshake.
    pub(crate) fn connected(robot: Robot, options: Options) -> Self {
        let mut talk = Self::new(robot, options);
        talk.run(&Setpoint::default(), 2.0);
        assert!(talk.session.state().is_connected(), "{:?}", talk.session.state());
        talk
    }

    /// Iterates 25 ms at a time, with a wish.
    pub(crate) fn run(&mut self, wish: &Setpoint, seconds: f64) {
        let end = self.now + Duration::from_secs_f64(seconds);
        while self.now < end {
            self.step(Some(wish));
        }
    }

    /// The robot continues while the application hangs.
    pub(crate) fn hang(&mut self, seconds: f64) {
        let end = self.now + Duration::from_secs_f64(seconds);
        while self.now < end {
            self.step(None);
        }
    }

    pub(crate) fn step(&mut self, wish: Option<&Setpoint>) {
        self.now += Duration::from_millis(25);
        if self.now.as_millis().is_multiple_of(100) {
            let says = self.robot.says();
            self.session.receive(&says, self.now);
        }
        if let Some(wish) = wish {
            self.session.drive(wish, self.now);
        }
        let output = self.session.output();
        let answers = self.robot.take(&output, self.now);
        self.session.receive(&answers, self.now);
    }

    /// Returns the commands that the robot has received since the last call.
    pub(crate) fn heard(&mut self) -> Vec<Command> {
        core::mem::take(&mut self.robot.heard)
    }

    pub(crate) fn events(&mut self) -> Vec<Event> {
        core::iter::from_fn(|| self.session.next_event()).collect()
    }

    pub(crate) fn warnings(&mut self) -> Vec<String> {
        let warning = |event| match event {
            Event::Warning(words) => Some(words),
            _ => None,
        };
        self.events().into_iter().filter_map(warning).collect()
    }
}

/// Creates a wish to drive.
pub(crate) fn wish(linear: f64, angular: f64) -> Setpoint {
    Setpoint {
        linear,
        angular,
        ..Setpoint::default()
    }
}
