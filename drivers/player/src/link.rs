//! The session behind a port of `jde-device`.

use core::time::Duration;

use jde_device::{Event, Protocol};
use jde_player::{Options, Session, Setpoint, State};

/// A session with a server.
#[derive(Debug)]
pub(crate) struct Link(Session);

impl Protocol for Link {
    const DEVICE: &'static str = "robot";
    type Config = Options;
    type Data = jde_player::Event;

    fn start(options: Options, now: Duration, _: &mut Vec<Event<Self::Data>>) -> Self {
        Self(Session::new(options, now))
    }

    fn receive(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event<Self::Data>>) {
        self.0.receive(bytes, now);
        events.push(Event::Send(self.0.output()));
        for event in self.0.events() {
            if let jde_player::Event::Ready(robot) = &event {
                events.push(Event::Ready(robot.to_string()));
            }
            events.push(match event {
                jde_player::Event::Warning(words) => Event::Warn(words),
                data => Event::Data(data),
            });
        }
        if let State::Lost(reason) = self.0.state() {
            events.push(Event::Disconnect(reason.clone()));
        }
    }

    fn is_ready(&self) -> bool {
        self.0.robot().is_some()
    }

    /// The velocity 0 depends on the base; [`Link::stop`] has it.
    fn closing_bytes() -> Vec<u8> {
        Vec::new()
    }
}

impl Link {
    /// Returns the bytes that drive the robot according to the setpoint.
    pub(crate) fn drive(&mut self, setpoint: &Setpoint, now: Duration) -> Vec<u8> {
        self.0.drive(setpoint, now);
        self.0.output()
    }

    /// Returns the bytes that stop the robot.
    pub(crate) fn stop(&self) -> Vec<u8> {
        self.0.stop()
    }
}
