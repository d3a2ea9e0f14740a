//! A device at a port: a conversation over the port, restarted after every loss. It exports only the state of
//! the connection.

use core::time::Duration;

use jde_port::Port;
use jde_schema::prelude::*;

use crate::report::{ConnectionReport, ConnectionState};

/// How long the last bytes may take when the driver goes to sleep.
const CLOSE_TIMEOUT: Duration = Duration::from_millis(100);

/// The protocol of a device, from the first bytes after the line is open. It does no I/O and has no clock.
pub trait Protocol: Sized {
    /// The kind of device, as a person would name it: "scanner".
    const DEVICE: &'static str;

    /// The configuration that the device shall have.
    type Config: Clone;

    /// What the driver learns from the device.
    type Data;

    /// Starts the conversation. `events` receives the first bytes to send.
    fn start(wanted: Self::Config, now: Duration, events: &mut Vec<Event<Self::Data>>) -> Self;

    /// Processes bytes, split anywhere, and the time. It is also called without any bytes.
    fn receive(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event<Self::Data>>);

    /// Returns whether the device is configured as wanted.
    fn is_ready(&self) -> bool;

    /// Returns the bytes to send before closing.
    fn closing_bytes() -> Vec<u8>;
}

/// An action or a result of a conversation.
#[derive(Clone, Debug, PartialEq)]
pub enum Event<N> {
    /// Send these bytes.
    Send(Vec<u8>),
    /// Change the speed of the line to this, in bits per second.
    Baud(u32),
    /// The device is now configured as wanted; the name that it reports.
    Ready(String),
    /// News for the driver.
    Data(N),
    /// A problem that does not end the conversation.
    Warn(String),
    /// Break the connection and start again, for this reason.
    Disconnect(String),
}

/// A device that is sought, or found.
#[derive(Debug)]
pub struct Device<C: Protocol> {
    port: Port,
    config: C::Config,
    protocol: Option<C>,
    name: String,
    report: ConnectionReport,
    received: Vec<u8>,
}

impl<C: Protocol> Device<C> {
    /// Creates a device. The first step starts to connect.
    #[must_use]
    pub fn new(port: Port, wanted: C::Config) -> Self {
        Self {
            port,
            config: wanted,
            protocol: None,
            name: String::new(),
            report: ConnectionReport::default(),
            received: Vec::new(),
        }
    }

    /// Returns the configuration that the device shall have.
    #[must_use]
    pub fn config(&self) -> &C::Config {
        &self.config
    }

    /// Returns whether the device is connected and configured as wanted. If not, the driver retracts what it
    /// exported of it.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.protocol.as_ref().is_some_and(C::is_ready)
    }

    /// Reads and writes at the port, and returns the news. Call it in every iteration: it never blocks.
    pub fn step(&mut self, cx: &Context<'_>) -> Vec<C::Data> {
        let now = cx.now();
        if !self.port.poll(now).is_connected() {
            self.protocol = None;
            return Vec::new();
        }
        self.received.clear();
        self.port.read(&mut self.received);
        let mut events = Vec::new();
        let conversation = match &mut self.protocol {
            Some(conversation) => conversation,
            none => none.insert(C::start(self.config.clone(), now, &mut events)),
        };
        conversation.receive(&self.received, now, &mut events);
        let mut learnt = Vec::new();
        for event in events {
            match event {
                // A failure to send shows in the link.
                Event::Send(bytes) => drop(self.port.write(&bytes)),
                Event::Baud(baud) => self.port.set_baud(baud),
                Event::Ready(name) => self.name = name,
                Event::Data(news) => learnt.push(news),
                Event::Warn(words) => warn!(cx, "{words}"),
                Event::Disconnect(reason) => self.port.disconnect_with(&reason),
            }
        }
        if !self.port.state().is_connected() {
            self.protocol = None;
        }
        learnt
    }

    /// Exports the state of the connection, if it has changed.
    pub fn export_connection(&mut self, cx: &Context<'_>, export: &mut Export<Connection>) {
        let name = self.is_ready().then_some(&*self.name);
        let standing = ConnectionState::of(&self.port, name, C::DEVICE);
        self.report.update(cx, export, standing, self.port.attempts());
    }

    /// Sends the farewell and retracts the state of the connection. It may take a tenth of a second.
    pub fn close(mut self, cx: &Context<'_>, export: &mut Export<Connection>) {
        if self.protocol.is_some() && self.port.write(&C::closing_bytes()) {
            self.port.flush(CLOSE_TIMEOUT);
        }
        self.report.retract(cx, export);
    }
}
