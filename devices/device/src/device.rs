//! A device at a port: a session of its protocol over the port, restarted after every loss. It exports only
//! the state of the connection.

use core::time::Duration;
use std::collections::VecDeque;

use jde_schema::prelude::*;

use crate::port::Port;
use crate::report::{ConnectionReport, ConnectionState};

/// How long sending the last bytes may take when the driver goes to sleep.
const CLOSE_TIMEOUT: Duration = Duration::from_millis(100);

/// The protocol of a device, from the first bytes after the line is open. It does no I/O and has no clock.
pub trait Protocol: Sized {
    /// The kind of device for messages: "scanner".
    const DEVICE: &'static str;

    /// The configuration that the device must have.
    type Config: Clone;

    /// The data that the driver receives from the device.
    type Data;

    /// Whether the signal DTR of a serial line stays on, as opening sets it. Some devices take it for a command.
    const DTR: bool = true;

    /// Starts a session. `events` receives the first bytes to send.
    fn start(config: Self::Config, now: Duration, events: &mut Vec<Event<Self::Data>>) -> Self;

    /// Processes bytes, split anywhere, and the time. It is also called without any bytes.
    fn receive(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event<Self::Data>>);

    /// Goes on without a speed that the session asked for by [`Event::Baud`] and that the line lacks. Nothing of what
    /// followed that event was done. A session that is searching for the device's speed tries another.
    fn refuse_baud(&mut self, _now: Duration, events: &mut Vec<Event<Self::Data>>) {
        events.push(Event::Disconnect("it needs another speed of the line".to_owned()));
    }

    /// Returns whether the device has its configuration.
    fn is_ready(&self) -> bool;

    /// Returns the bytes to send before closing.
    fn closing_bytes() -> Vec<u8>;
}

/// An action or a result of a session.
#[derive(Clone, Debug, PartialEq)]
pub enum Event<N> {
    /// Send these bytes.
    Send(Vec<u8>),
    /// Change the speed of the line to this, in bits per second.
    Baud(u32),
    /// The device now has its configuration; the name that it reports.
    Ready(String),
    /// Data for the driver.
    Data(N),
    /// A problem that does not end the session.
    Warn(String),
    /// Break the connection and start again, for this reason.
    Disconnect(String),
}

/// A device, connected or not.
#[derive(Debug)]
pub struct Device<C: Protocol> {
    port: Port,
    config: C::Config,
    protocol: Option<C>,
    name: String,
    report: ConnectionReport,
    received: Vec<u8>,
    /// Speeds that the session asked for and that the line lacks.
    lacking: Vec<u32>,
}

impl<C: Protocol> Device<C> {
    /// Creates a device. The first step starts to connect.
    #[must_use]
    pub fn new(port: Port, config: C::Config) -> Self {
        Self {
            port,
            config,
            protocol: None,
            name: String::new(),
            report: ConnectionReport::default(),
            received: Vec::new(),
            lacking: Vec::new(),
        }
    }

    /// Returns the configuration that the device must have.
    #[must_use]
    pub fn config(&self) -> &C::Config {
        &self.config
    }

    /// Returns whether the device is connected and has its configuration. If not, the driver retracts the
    /// exports of the device's data.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.protocol.as_ref().is_some_and(C::is_ready)
    }

    /// Returns the session, while the port is connected: for commands, whose bytes go to [`Self::send`].
    pub fn protocol_mut(&mut self) -> Option<&mut C> {
        self.protocol.as_mut()
    }

    /// Sends bytes of the session. Nothing is sent without a connection.
    pub fn send(&mut self, bytes: &[u8]) {
        // A failure to send changes the state of the port.
        self.port.write(bytes);
    }

    /// Reads and writes at the port, and returns the device's data. Call it in every iteration: it never
    /// blocks.
    pub fn step(&mut self, cx: &Context<'_>) -> Vec<C::Data> {
        let now = cx.now();
        if !self.port.poll(now).is_connected() {
            self.protocol = None;
            return Vec::new();
        }
        self.received.clear();
        self.port.read(&mut self.received);
        let mut events = Vec::new();
        let protocol = match &mut self.protocol {
            Some(protocol) => protocol,
            none => {
                if !C::DTR {
                    self.port.clear_dtr();
                }
                self.lacking.clear();
                none.insert(C::start(self.config.clone(), now, &mut events))
            }
        };
        protocol.receive(&self.received, now, &mut events);
        let mut data = Vec::new();
        let mut events = VecDeque::from(events);
        while let Some(event) = events.pop_front() {
            match event {
                // A failure to send changes the state of the port.
                Event::Send(bytes) => drop(self.port.write(&bytes)),
                Event::Baud(baud) if self.port.set_baud(baud) => {}
                Event::Baud(baud) => {
                    self.lacking.push(baud);
                    let mut instead = Vec::new();
                    protocol.refuse_baud(now, &mut instead);
                    events = instead.into();
                }
                Event::Ready(name) => self.name = name,
                Event::Data(datum) => data.push(datum),
                Event::Warn(message) => warn!(cx, "{message}"),
                Event::Disconnect(reason) if self.lacking.is_empty() || protocol.is_ready() => {
                    self.port.disconnect_with(&reason);
                }
                Event::Disconnect(reason) => {
                    let lacking = &self.lacking;
                    let reason = format!("{reason} (the adapter lacks these speeds: {lacking:?})");
                    self.port.disconnect_with(&reason);
                }
            }
        }
        if !self.port.state().is_connected() {
            self.protocol = None;
        }
        data
    }

    /// Exports the state of the connection, if it has changed.
    pub fn export_connection(&mut self, cx: &Context<'_>, export: &mut Export<Connection>) {
        let name = self.is_ready().then_some(&*self.name);
        let state = ConnectionState::of(&self.port, name, C::DEVICE);
        self.report.update(cx, export, state, self.port.attempts());
    }

    /// Sends the closing bytes and retracts the state of the connection. It may take a tenth of a second.
    pub fn close(mut self, cx: &Context<'_>, export: &mut Export<Connection>) {
        if self.protocol.is_some() && self.port.write(&C::closing_bytes()) {
            self.port.flush(CLOSE_TIMEOUT);
        }
        self.report.retract(cx, export);
    }
}
