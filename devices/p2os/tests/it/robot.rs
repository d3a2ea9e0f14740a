//! A scripted robot: it replies according to the protocol and records the received commands. It has no
//! physics.

use core::time::Duration;

use jde_p2os::*;

/// A session connected to a scripted robot.
pub(crate) struct Dialogue {
    pub(crate) session: Session,
    pub(crate) now: Duration,
    pub(crate) robot: Robot,
}

/// The robot with its script.
pub(crate) struct Robot {
    pub(crate) names: Names,
    pub(crate) config: Option<Config>,
    pub(crate) sip: Sip,
    pub(crate) commands: Vec<Command>,
    pub(crate) silent: bool,
    pub(crate) motors_broken: bool,
    pub(crate) camera: bool,
    /// Bytes from the camera that the client has not fetched, and the number of bytes that it has requested.
    camera_bytes: Vec<u8>,
    requested: usize,
    open: bool,
    next_sync: u8,
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
            commands: Vec::new(),
            silent: false,
            motors_broken: false,
            camera: false,
            camera_bytes: Vec::new(),
            requested: 0,
            open: false,
            next_sync: 0,
            receiver: Receiver::new(),
        }
    }

    /// Processes a client's bytes; returns the replies.
    pub(crate) fn receive(&mut self, bytes: &[u8], now: Duration) -> Vec<u8> {
        let mut packets = Vec::new();
        self.receiver.receive(bytes, now, |packet| packets.push(packet));
        let mut replies = Vec::new();
        for packet in packets {
            if !self.open
                && let Some(sync) = SyncStep::from_packet(&packet)
            {
                self.commands.push(Command::from_packet(&packet));
                if sync as u8 != self.next_sync {
                    continue;
                }
                self.next_sync += 1;
                replies.extend(match sync {
                    SyncStep::Zero | SyncStep::One => sync.to_packet().to_bytes(),
                    SyncStep::Two => self.names.to_packet().unwrap().to_bytes(),
                });
                continue;
            }
            let command = Command::from_packet(&packet);
            match &command {
                Command::Open(_) => self.open = true,
                Command::Close(_) => (self.open, self.next_sync) = (false, 0),
                Command::Config(_) => {
                    let config = self.config.as_ref().map(|config| config.to_packet().unwrap());
                    replies.extend(config.into_iter().flat_map(|packet| packet.to_bytes()));
                }
                Command::Enable(on) if !self.motors_broken => {
                    self.sip.flags = self.sip.flags & !Flags::MOTORS | u16::from(*on);
                }
                Command::Tty2(bytes) if self.camera => {
                    let reply = match HeadFrame::from_bytes(bytes) {
                        Ok(HeadFrame::Command(HeadCommand::GetPanTilt)) => HeadReply::position(-400, 178),
                        _ => HeadReply::success(),
                    };
                    self.camera_bytes.extend(reply.to_bytes());
                }
                Command::GetAux(0) => self.camera_bytes.clear(),
                Command::GetAux(count) => self.requested = usize::from(*count),
                _ => {}
            }
            self.commands.push(command);
            if self.requested > 0 && self.camera_bytes.len() >= self.requested {
                let bytes = self
                    .camera_bytes
                    .drain(..core::mem::take(&mut self.requested))
                    .collect();
                let aux = SerialAux {
                    port: AuxPort::One,
                    bytes,
                };
                replies.extend(aux.to_packet().unwrap().to_bytes());
            }
        }
        replies
    }

    /// Sets the robot to the open state, as an earlier session may have left it.
    pub(crate) fn already_open(mut self) -> Self {
        self.open = true;
        self
    }

    /// Returns the packets that the robot sends every 100 ms without a request.
    pub(crate) fn periodic_output(&self) -> Vec<u8> {
        if self.open && !self.silent {
            self.sip.to_packet().unwrap().to_bytes()
        } else {
            Vec::new()
        }
    }
}

impl Dialogue {
    /// Creates a session that has only a connection.
    pub(crate) fn new(robot: Robot, options: Options) -> Self {
        let mut session = Session::new(options);
        let now = Duration::from_secs(100);
        session.connected(now);
        Self { session, now, robot }
    }

    /// Creates a session that has completed the handshake.
    pub(crate) fn connected(robot: Robot, options: Options) -> Self {
        let mut dialogue = Self::new(robot, options);
        dialogue.run(&Setpoint::default(), 2.0);
        assert!(
            dialogue.session.state().is_connected(),
            "{:?}",
            dialogue.session.state()
        );
        dialogue
    }

    /// Iterates 25 ms at a time with a setpoint.
    pub(crate) fn run(&mut self, setpoint: &Setpoint, seconds: f64) {
        let end = self.now + Duration::from_secs_f64(seconds);
        while self.now < end {
            self.step(Some(setpoint));
        }
    }

    /// Lets the robot continue while the application hangs.
    pub(crate) fn hang(&mut self, seconds: f64) {
        let end = self.now + Duration::from_secs_f64(seconds);
        while self.now < end {
            self.step(None);
        }
    }

    pub(crate) fn step(&mut self, setpoint: Option<&Setpoint>) {
        self.now += Duration::from_millis(25);
        if self.now.as_millis().is_multiple_of(100) {
            let periodic_output = self.robot.periodic_output();
            self.session.receive(&periodic_output, self.now);
        }
        if let Some(setpoint) = setpoint {
            self.session.drive(setpoint, self.now);
        }
        let output = self.session.output();
        let replies = self.robot.receive(&output, self.now);
        self.session.receive(&replies, self.now);
    }

    /// Returns the commands that the robot has received since the last call.
    pub(crate) fn commands(&mut self) -> Vec<Command> {
        core::mem::take(&mut self.robot.commands)
    }

    pub(crate) fn events(&mut self) -> Vec<Event> {
        core::iter::from_fn(|| self.session.next_event()).collect()
    }

    pub(crate) fn warnings(&mut self) -> Vec<String> {
        let warning = |event| match event {
            Event::Warning(message) => Some(message),
            _ => None,
        };
        self.events().into_iter().filter_map(warning).collect()
    }
}

/// Creates a setpoint for driving.
pub(crate) fn setpoint(linear: f64, angular: f64) -> Setpoint {
    Setpoint {
        linear,
        angular,
        ..Setpoint::default()
    }
}
