//! The robot at its port: it moves bytes between port and session, and reports the state of the connection.
//! It publishes nothing else.

use core::time::Duration;
use std::time::Instant;

use jde_device::port::Port;
use jde_device::{ConnectionReport, ConnectionState};
use jde_p2os::{Beams, Event, Options, Session, Setpoint, State};
use jde_schema::prelude::{Connection, Context, Export, Result};

/// Time limit for sending the last packets: five of them, which take 50 ms at 9600 baud.
const CLOSE_TIMEOUT: Duration = Duration::from_millis(200);

/// A robot that the driver is looking for or has found.
pub(crate) struct RobotConnection {
    port: Port,
    session: Session,
    beams: Beams,
    /// Real time, because the link does not follow the application's clock.
    clock: Instant,
    /// Whether the session was informed that the port is connected.
    was_connected: bool,
    received: Vec<u8>,
    report: ConnectionReport,
}

impl RobotConnection {
    pub(crate) fn new(port: Port, options: Options, beams: Beams) -> Self {
        Self {
            port,
            session: Session::new(options),
            beams,
            clock: Instant::now(),
            was_connected: false,
            received: Vec::new(),
            report: ConnectionReport::default(),
        }
    }

    /// Receives bytes, advances the session, and sends its output.
    ///
    /// # Errors
    /// If the robot cannot be driven, which a person must correct. A robot that does not reply is not an
    /// error.
    pub(crate) fn step(&mut self, setpoint: &Setpoint) -> Result {
        let now = self.clock.elapsed();
        if self.port.poll(now).is_connected() {
            if !self.was_connected {
                self.was_connected = true;
                self.session.connected(now);
            }
            self.received.clear();
            self.port.read(&mut self.received);
            self.session.receive(&self.received, now);
            self.session.drive(setpoint, now);
            self.port.write(&self.session.output());
        }
        match self.session.state() {
            State::Refused(reason) => {
                let reason = reason.clone();
                self.port.disconnect_with(&reason);
                self.was_connected = false;
                return Err(reason.into());
            }
            State::Lost(reason) if self.was_connected => self.port.disconnect_with(reason),
            State::Idle | State::Syncing | State::Opening(_) | State::Connected(_) | State::Lost(_) => {}
        }
        if self.was_connected && !self.port.state().is_connected() {
            self.was_connected = false;
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
    pub(crate) fn export_connection(&mut self, cx: &Context, export: &mut Export<Connection>) {
        let name = match self.session.state() {
            State::Connected(names) => Some(format!("{}, {} {}", names.name, names.class, names.subclass)),
            State::Idle | State::Syncing | State::Opening(_) | State::Refused(_) | State::Lost(_) => None,
        };
        let state = ConnectionState::of(&self.port, name.as_deref(), "robot");
        self.report.update(cx, export, state, self.port.attempts());
    }

    /// Stops the robot, switches it off and closes the port. The next step looks for it again.
    pub(crate) fn close(&mut self) {
        let last_packets = self.session.close();
        if self.was_connected && self.port.write(&last_packets) {
            self.port.flush(CLOSE_TIMEOUT);
            // Bytes received meanwhile are read; otherwise closing could reset the connection before the
            // robot has read the last packets.
            self.port.read(&mut self.received);
        }
        self.received.clear();
        self.was_connected = false;
        self.port.close();
        self.report = ConnectionReport::default();
    }
}

/// Dropping the driver stops its robot.
impl Drop for RobotConnection {
    fn drop(&mut self) {
        self.close();
    }
}
