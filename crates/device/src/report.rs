//! The state of a device's connection, exported when it changes. It observes no device: the caller supplies
//! the state.

use jde_port::{Link, Port};
use jde_schema::prelude::*;

/// The state of the connection to a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing<'a> {
    /// No attempt yet.
    Idle,
    /// An attempt is in progress.
    Connecting,
    /// The line is open, and the device has not answered yet; the kind of device, such as "scanner".
    Looking(&'a str),
    /// The device answers; the name that it reports.
    Connected(&'a str),
    /// The connection broke, or an attempt failed; the reason, in words that name the device.
    Lost(&'a str),
}

/// What was exported of a connection. It exports changes only, and logs a repeated failure once, however
/// often the attempt is repeated.
#[derive(Debug, Default)]
pub struct Report {
    told: Option<Connection>,
    /// The failure that was last logged; empty after the device has connected.
    trouble: Text<120>,
}

impl<'a> Standing<'a> {
    /// Returns the state of a device at a port. `name` is the device's name once it is ready; `device` is its
    /// kind, shown before that.
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
    /// Exports the state of a connection after `attempts` attempts, if it has changed. Logs a device that
    /// connects, and a failure that differs from the last one logged.
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

    /// Retracts the export and resets the report, when the driver goes to sleep.
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
