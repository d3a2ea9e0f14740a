//! The robot at its port: it moves bytes between port and session, and reports the state of the connection.
//! It publishes nothing else.

use core::time::Duration;
use std::time::Instant;

use jde_device::{Report, Standing};
use jde_p2os::{Beams, Event, Options, Session, State, Wish};
use jde_port::Port;
use jde_schema::prelude::{Connection, Context, Export, Result};

/// Time limit for sending the last packets: five of them, which take 50 ms at 9600 baud.
const FAREWELL: Duration = Duration::from_millis(200);

/// A robot that the driver is looking for or has found.
pub(crate) struct Robot {
    port: Port,
    session: Session,
    beams: Beams,
    /// Real time, because the link does not follow the application's clock.
    clock: Instant,
    /// Whether the session was informed that the port is connected.
    linked: bool,
    heard: Vec<u8>,
    report: Report,
}

impl Robot {
    pub(crate) fn new(port: Port, options: Options, beams: Beams) -> Self {
        Self {
            port,
            session: Session::new(options),
            beams,
            clock: Instant::now(),
            linked: false,
            heard: Vec::new(),
            report: Report::default(),
        }
    }

    /// Receives bytes, advances the session, and sends its output.
    ///
    /// # Errors
    /// If the robot cannot be driven, which a person must correct. A robot that does not answer is not an
    /// error.
    pub(crate) fn step(&mut self, wish: &Wish) -> Result {
        let now = self.clock.elapsed();
        if self.port.poll(now).is_connected() {
            if !self.linked {
                self.linked = true;
                self.session.connected(now);
            }
            self.heard.clear();
            self.port.read(&mut self.heard);
            self.session.receive(&self.heard, now);
            self.session.drive(wish, now);
            self.port.write(&self.session.output());
        }
        match self.session.state() {
            State::Refused(words) => {
                let words = words.clone();
                self.port.lose(&words);
                self.linked = false;
                return Err(words.into());
            }
            State::Lost(words) if self.linked => self.port.lose(words),
            State::Idle | State::Syncing | State::Opening(_) | State::Connected(_) | State::Lost(_) => {}
        }
        if self.linked && !self.port.link().is_connected() {
            self.linked = false;
            self.session.lost("its connection is gone");
        }
        Ok(())
    }

    /// Whether the robot is connected.
    pub(crate) fn is_up(&self) -> bool {
        self.session.state().is_connected()
    }

    pub(crate) fn session(&self) -> &Session {
        &self.session
    }

    pub(crate) fn next_event(&mut self) -> Option<Event> {
        self.session.next_event()
    }

    /// The beams requested from the laser.
    pub(crate) fn beams(&self) -> Beams {
        self.beams
    }

    /// Publishes the state of the connection if it changed.
    pub(crate) fn tell(&mut self, cx: &Context, export: &mut Export<Connection>) {
        let name = match self.session.state() {
            State::Connected(names) => Some(format!("{}, {} {}", names.name, names.class, names.subclass)),
            State::Idle | State::Syncing | State::Opening(_) | State::Refused(_) | State::Lost(_) => None,
        };
        let standing = Standing::of(&self.port, name.as_deref(), "robot");
        self.report.tell(cx, export, standing, self.port.attempts());
    }

    /// Stops the robot, switches it off and closes the port. The next step looks for it again.
    pub(crate) fn rest(&mut self) {
        let farewell = self.session.close();
        if self.linked && self.port.write(&farewell) {
            self.port.flush(FAREWELL);
            // Bytes received meanwhile are read; otherwise closing could reset the connection before the
            // robot has read the last packets.
            self.port.read(&mut self.heard);
        }
        self.heard.clear();
        self.linked = false;
        self.port.close();
        self.report = Report::default();
    }
}

/// Dropping the driver stops its robot.
impl Drop for Robot {
    fn drop(&mut self) {
        self.rest();
    }
}
