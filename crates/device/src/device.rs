//! A device at a port: bytes between the port and a conversation, met again by itself after every loss. It
//! publishes nothing but how the connection stands.

use core::time::Duration;

use jde_port::Port;
use jde_schema::prelude::*;

use crate::report::{Report, Standing};

/// How long the last words may take when the driver goes to sleep.
const FAREWELL: Duration = Duration::from_millis(100);

/// What is said to a device and heard of it, from the first word after the line is open. It does no I/O and
/// has no clock.
pub trait Conversation: Sized {
    /// What is looked for, as people call it: "scanner".
    const DEVICE: &'static str;

    /// What the device shall do.
    type Wanted: Clone;

    /// What the driver learns of the device.
    type News;

    /// Begins; the events are the first words.
    fn begin(wanted: Self::Wanted, now: Duration, events: &mut Vec<Event<Self::News>>) -> Self;

    /// Takes in bytes, as they come and cut anywhere, and the time; it is called without any too.
    fn hear(&mut self, bytes: &[u8], now: Duration, events: &mut Vec<Event<Self::News>>);

    /// Whether the device does what it shall.
    fn is_ready(&self) -> bool;

    /// What to say before leaving.
    fn farewell() -> Vec<u8>;
}

/// What follows from what was heard.
#[derive(Clone, Debug, PartialEq)]
pub enum Event<N> {
    /// Say these bytes.
    Send(Vec<u8>),
    /// The line goes at this speed from now on, bits per second.
    Baud(u32),
    /// The device does from now on what it shall; what it calls itself.
    Ready(String),
    /// The driver learns something.
    News(N),
    /// Something is off, and the conversation goes on.
    Warn(String),
    /// Begin anew, for this reason.
    Lose(String),
}

/// A device that is looked for, or found.
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
    /// A device that the first step looks for.
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

    /// What it shall do.
    #[must_use]
    pub fn wanted(&self) -> &C::Wanted {
        &self.wanted
    }

    /// Whether it is heard and does what it shall; if not, what the driver exported of it is to be taken
    /// back.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.conversation.as_ref().is_some_and(C::is_ready)
    }

    /// Hears and speaks; what the driver learns. Call it in every iteration: it never blocks.
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
                // What cannot be sent shows in the link.
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

    /// Publishes how the connection stands, if that has changed.
    pub fn tell(&mut self, cx: &Context<'_>, export: &mut Export<Connection>) {
        let name = self.is_ready().then_some(&*self.name);
        let standing = Standing::of(&self.port, name, C::DEVICE);
        self.report.tell(cx, export, standing, self.port.attempts());
    }

    /// Says farewell, and takes back how the connection stands. It may take a tenth of a second.
    pub fn rest(mut self, cx: &Context<'_>, export: &mut Export<Connection>) {
        if self.conversation.is_some() && self.port.write(&C::farewell()) {
            self.port.flush(FAREWELL);
        }
        self.report.retract(cx, export);
    }
}
