//! The robot at its port: bytes between the port and the session, and how the connection stands. It publishes nothing.

use core::time::Duration;
use std::time::Instant;

use jde_p2os::{Beams, Event, Options, Session, State, Wish};
use jde_port::{Link, Port};
use jde_schema::prelude::{Connection, Header, Result, Text};

/// How long the last words may take: five packets, which are 50 ms at 9600 baud.
const FAREWELL: Duration = Duration::from_millis(200);

/// A robot that is looked for, or found.
pub(crate) struct Robot {
    port: Port,
    session: Session,
    beams: Beams,
    /// The link is real whatever the application's clock does, so it has a clock of its own.
    clock: Instant,
    /// Whether the session knows that the port is connected.
    linked: bool,
    heard: Vec<u8>,
    told: Option<Connection>,
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
            told: None,
        }
    }

    /// Hears and speaks.
    ///
    /// # Errors
    /// If the robot is one that cannot be driven, which a person must mend; a robot that is not heard is no error.
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

    /// Whether the robot drives and is heard.
    pub(crate) fn is_up(&self) -> bool {
        self.session.state().is_connected()
    }

    pub(crate) fn session(&self) -> &Session {
        &self.session
    }

    pub(crate) fn next_event(&mut self) -> Option<Event> {
        self.session.next_event()
    }

    /// The beams that a laser was asked for.
    pub(crate) fn beams(&self) -> Beams {
        self.beams
    }

    /// How the connection is, if that has not been told.
    pub(crate) fn news(&mut self, now: Duration) -> Option<Connection> {
        let (state, note) = match (self.port.link(), self.session.state()) {
            (Link::Idle, _) => (Connection::IDLE, String::new()),
            (Link::Connecting { .. }, _) => (Connection::CONNECTING, String::new()),
            (Link::Connected { .. }, State::Connected(names)) => (
                Connection::CONNECTED,
                format!("{}, {} {}", names.name, names.class, names.subclass),
            ),
            (Link::Connected { .. }, _) => (
                Connection::CONNECTING,
                "the line is open; looking for the robot".to_owned(),
            ),
            (Link::Lost { reason, .. }, _) => (Connection::LOST, reason.clone()),
        };
        let connection = Connection {
            header: Header::new(now, ""),
            state,
            attempts: self.port.attempts(),
            note: Text::truncated(&note),
            ..Connection::default()
        };
        let said = |told: Connection| (told.state, told.attempts, told.note);
        if self.told.map(said) == Some(said(connection)) {
            return None;
        }
        self.told = Some(connection);
        Some(connection)
    }

    /// Stops the robot, switches it off and lets go of it; the next step looks for it again.
    pub(crate) fn rest(&mut self) {
        let farewell = self.session.close();
        if self.linked && self.port.write(&farewell) {
            self.port.flush(FAREWELL);
            // What came meanwhile is taken, or closing would break the connection off before the robot has read its last words.
            self.port.read(&mut self.heard);
        }
        self.heard.clear();
        self.linked = false;
        self.port.close();
        self.told = None;
    }
}

/// A driver that is thrown away stops its robot.
impl Drop for Robot {
    fn drop(&mut self) {
        self.rest();
    }
}
