//! The state of a device's connection, exported when it changes. It observes no device: the caller supplies
//! the state.

use core::time::Duration;

use crate::port::{Port, PortState};
use jde_schema::prelude::*;

/// After this time without a reply it is logged that the line is open.
const SILENCE_BEFORE_LOG: Duration = Duration::from_secs(5);

/// The state of the connection to a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConnectionState<'a> {
    /// No attempt yet.
    Idle,
    /// An attempt is in progress.
    Connecting,
    /// The line is open, and the device has not replied yet; the kind of device, such as "scanner".
    Probing(&'a str),
    /// Nothing is connected yet; what that means. It is not logged.
    Unmet(&'a str),
    /// The device replies; the name that it reports.
    Connected(&'a str),
    /// The connection broke, or an attempt failed; the reason, which names the device.
    Lost(&'a str),
}

/// What was exported of a connection. It exports changes only, and logs a repeated failure once.
#[derive(Debug, Default)]
pub struct ConnectionReport {
    exported: Option<Connection>,
    /// The failure that was last logged; empty after the device has connected.
    last_failure: Text<120>,
    /// Since when the line is open without a reply.
    silent_since: Option<Duration>,
}

impl<'a> ConnectionState<'a> {
    /// Returns the state of a device at a port. `name` is the device's name once it is ready; `device` is its
    /// kind, shown before that.
    #[must_use]
    pub fn of(port: &'a Port, name: Option<&'a str>, device: &'a str) -> Self {
        match (port.state(), name) {
            (PortState::Idle, _) => Self::Idle,
            (PortState::Connecting { .. }, _) => Self::Connecting,
            (PortState::Connected { .. }, Some(name)) => Self::Connected(name),
            (PortState::Connected { .. }, None) => Self::Probing(device),
            (PortState::Lost { reason, .. }, _) => Self::Lost(reason),
        }
    }
}

impl ConnectionReport {
    /// Exports the state of a connection after `attempts` attempts, if it has changed. Logs a device that
    /// connects, a failure that differs from the last one logged, and a device that has not replied for five seconds.
    pub fn update(
        &mut self,
        cx: &Context<'_>,
        export: &mut Export<Connection>,
        state: ConnectionState<'_>,
        attempts: u32,
    ) {
        let connection = connection(cx, state, attempts);
        self.report_silence(cx, state, connection.note);
        let key = |connection: Connection| (connection.state, connection.attempts, connection.note);
        if self.exported.map(key) == Some(key(connection)) {
            return;
        }
        let note = connection.note;
        match state {
            ConnectionState::Lost(_) if note != self.last_failure => {
                self.last_failure = note;
                warn!(cx, "{note}");
            }
            ConnectionState::Connected(_) => {
                self.last_failure = Text::EMPTY;
                let is_logged = |exported: Connection| exported.is_up() && exported.note == note;
                if !self.exported.is_some_and(is_logged) {
                    info!(cx, "{note}");
                }
            }
            ConnectionState::Lost(_)
            | ConnectionState::Idle
            | ConnectionState::Connecting
            | ConnectionState::Unmet(_)
            | ConnectionState::Probing(_) => {}
        }
        self.exported = Some(connection);
        export.write(cx, connection);
    }

    fn report_silence(&mut self, cx: &Context<'_>, state: ConnectionState<'_>, note: Text<120>) {
        if !matches!(state, ConnectionState::Probing(_)) {
            self.silent_since = None;
            return;
        }
        let since = *self.silent_since.get_or_insert(cx.now());
        if cx.now().saturating_sub(since) >= SILENCE_BEFORE_LOG && note != self.last_failure {
            self.last_failure = note;
            warn!(cx, "{note}");
        }
    }

    /// Retracts the export and resets the report, when the driver goes to sleep.
    pub fn retract(&mut self, cx: &Context<'_>, export: &mut Export<Connection>) {
        *self = Self::default();
        export.retract(cx);
    }
}

fn connection(cx: &Context<'_>, state: ConnectionState<'_>, attempts: u32) -> Connection {
    let probing;
    let (code, note) = match state {
        ConnectionState::Idle => (Connection::IDLE, ""),
        ConnectionState::Connecting => (Connection::CONNECTING, ""),
        ConnectionState::Probing(device) => {
            probing = format!("the line is open; looking for the {device}");
            (Connection::CONNECTING, &*probing)
        }
        ConnectionState::Unmet(note) => (Connection::CONNECTING, note),
        ConnectionState::Connected(name) => (Connection::CONNECTED, name),
        ConnectionState::Lost(reason) => (Connection::LOST, reason),
    };
    Connection {
        header: Header::new(cx.now(), ""),
        state: code,
        attempts,
        note: Text::truncated(note),
        ..Connection::default()
    }
}

#[cfg(test)]
mod tests;
