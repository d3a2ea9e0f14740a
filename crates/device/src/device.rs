//! A device at a port: a conversation over the port, restarted after every loss. It exports only the state of
//! the connection.

use core::time::Duration;

use jde_port::Port;
use jde_schema::prelude::*;

use crate::report::{Report, Standing};

/// How long the last bytes may take when the driver goes to sleep.
const FAREWELL: Duration = Duration::from_millis(100);

/// The protocol of a device, from the first bytes after the line is open. It does no I/O and has no clock.
pub trait Conversation: Sized {
    /// The kind of device, as a person would name it: "scanner".
    const DEVICE: &'static str;

    /// The configuration that the device shall have.
    type Wanted: Clone;

    /// What the driver learns from the device.
    type News;

    /// Starts the conversation. `events` receives the first bytes to send.
    fn begin(wanted: Self::Wanted, now: Duration, events: &mut Vec<Event<Self::News>>) -> Self;

    /// Processes bytes, split anywhere, and the time. It is also called without any bytes.
    fn hear(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event<Self::News>>);

    /// Returns whether the device is configured as wanted.
    fn is_ready(&self) -> bool;

    /// Returns the bytes to send before closing.
    fn farewell() -> Vec<u8>;
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
    News(N),
    /// A problem that does not end the conversation.
    Warn(String),
    /// Break the connection and start again, for this reason.
    Lose(String),
}

/// A device that is sought, or found.
#[derive(Debug)]
pub struct Device<C: Conversation> {
    port: Port,
    wanted: C::Wanted,
    conversation: Option<C>,
    name: String,
    report: Report,
    heard: Vec<u8>,
}

impl<C: Conversation> Device<C> {
    /// Creates a device. The first step starts to connect.
    #[must_use]
    pub fn new(port: Port, wanted: C::Wanted) -> Self {
        Self {
            port,
            wanted,
            conversation: None,
            name: String::new(),
            report: Report::default(),
            heard: Vec::new(),
        }
    }

    /// Returns the configuration that the device shall have.
    #[must_use]
    pub fn wanted(&self) -> &C::Wanted {
        &self.wanted
    }

    /// Returns whether the device is connected and configured as wanted. If not, the driver retracts what it
    /// exported of it.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.conversation.as_ref().is_some_and(C::is_ready)
    }

    /// Reads and writes at the port, and returns the news. Call it in every iteration: it never blocks.
    pub fn step(&mut self, cx: &Context<'_>) -> Vec<C::News> {
        let now = cx.now();
        if !self.port.poll(now).is_connected() {
            self.conversation = None;
            return Vec::new();
        }
        self.heard.clear();
        self.port.read(&mut self.heard);
        let mut events = Vec::new();
        let conversation = match &mut self.conversation {
            Some(conversation) => conversation,
            none => none.insert(C::begin(self.wanted.clone(), now, &mut events)),
        };
        conversation.hear(&self.heard, now, &mut events);
        let mut learnt = Vec::new();
        for event in events {
            match event {
                // A failure to send shows in the link.
                Event::Send(bytes) => drop(self.port.write(&bytes)),
                Event::Baud(baud) => self.port.set_baud(baud),
                Event::Ready(name) => self.name = name,
                Event::News(news) => learnt.push(news),
                Event::Warn(words) => warn!(cx, "{words}"),
                Event::Lose(reason) => self.port.lose(&reason),
            }
        }
        if !self.port.link().is_connected() {
            self.conversation = None;
        }
        learnt
    }

    /// Exports the state of the connection, if it has changed.
    pub fn tell(&mut self, cx: &Context<'_>, export: &mut Export<Connection>) {
        let name = self.is_ready().then_some(&*self.name);
        let standing = Standing::of(&self.port, name, C::DEVICE);
        self.report.tell(cx, export, standing, self.port.attempts());
    }

    /// Sends the farewell and retracts the state of the connection. It may take a tenth of a second.
    pub fn rest(mut self, cx: &Context<'_>, export: &mut Export<Connection>) {
        if self.conversation.is_some() && self.port.write(&C::farewell()) {
            self.port.flush(FAREWELL);
        }
        self.report.retract(cx, export);
    }
}
