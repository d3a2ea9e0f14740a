//! How a device's connection stands, told when it changes. It looks at no device: whoever does says how it
//! stands.

use jde_port::{Link, Port};
use jde_schema::prelude::*;

/// How the connection to a device stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing<'a> {
    /// Nobody has tried yet.
    Idle,
    /// An attempt is under way.
    Connecting,
    /// The line is open, and nobody has answered yet; what is looked for, as in "scanner".
    Looking(&'a str),
    /// The device is heard; what it calls itself.
    Connected(&'a str),
    /// The connection broke, or an attempt failed; why, in words that name the device.
    Lost(&'a str),
}

/// What was told of a connection: it tells a change alone, and complains of the same trouble once, however
/// often it is tried again.
#[derive(Debug, Default)]
pub struct Report {
    told: Option<Connection>,
    /// What was last complained of; nothing once the device was heard.
    trouble: Text<120>,
}

impl<'a> Standing<'a> {
    /// That of a device at a port; `name` is what it calls itself, once it is heard, and `device` what is
    /// looked for before.
    #[must_use]
    pub fn of(port: &'a Port, name: Option<&'a str>, device: &'a str) -> Self {
        match (port.link(), name) {
            (Link::Idle, _) => Self::Idle,
            (Link::Connecting { .. }, _) => Self::Connecting,
            (Link::Connected { .. }, Some(name)) => Self::Connected(name),
            (Link::Connected { .. }, None) => Self::Looking(device),
            (Link::Lost { reason, .. }, _) => Self::Lost(reason),
        }
    }
}

impl Report {
    /// Publishes how a connection stands after so many attempts, if that has not been told, and logs who is
    /// heard and what is the trouble.
    pub fn tell(
        &mut self,
        cx: &Context<'_>,
        export: &mut Export<Connection>,
        standing: Standing<'_>,
        attempts: u32,
    ) {
        let connection = connection(cx, standing, attempts);
        let said = |told: Connection| (told.state, told.attempts, told.note);
        if self.told.map(said) == Some(said(connection)) {
            return;
        }
        let note = connection.note;
        match standing {
            Standing::Lost(_) if note != self.trouble => {
                self.trouble = note;
                warn!(cx, "{note}");
            }
            Standing::Connected(_) => {
                self.trouble = Text::EMPTY;
                let told = |told: Connection| told.is_up() && told.note == note;
                if !self.told.is_some_and(told) {
                    info!(cx, "{note}");
                }
            }
            Standing::Lost(_) | Standing::Idle | Standing::Connecting | Standing::Looking(_) => {}
        }
        self.told = Some(connection);
        export.write(cx, connection);
    }

    /// Takes back what was told and forgets it, when the driver goes to sleep.
    pub fn retract(&mut self, cx: &Context<'_>, export: &mut Export<Connection>) {
        *self = Self::default();
        export.retract(cx);
    }
}

fn connection(cx: &Context<'_>, standing: Standing<'_>, attempts: u32) -> Connection {
    let looking;
    let (state, note) = match standing {
        Standing::Idle => (Connection::IDLE, ""),
        Standing::Connecting => (Connection::CONNECTING, ""),
        Standing::Looking(device) => {
            looking = format!("the line is open; looking for the {device}");
            (Connection::CONNECTING, &*looking)
        }
        Standing::Connected(name) => (Connection::CONNECTED, name),
        Standing::Lost(reason) => (Connection::LOST, reason),
    };
    Connection {
        header: Header::new(cx.now(), ""),
        state,
        attempts,
        note: Text::truncated(note),
        ..Connection::default()
    }
}

#[cfg(test)]
mod tests;
