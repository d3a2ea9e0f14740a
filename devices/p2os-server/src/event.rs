//! The events between robots and clients, for the program that runs the server.

use core::fmt;
use core::time::Duration;

/// An event of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// The time of the event, in the world.
    pub time: Duration,
    /// The robot's name in the world.
    pub robot: String,
    /// The kind of event.
    pub kind: EventKind,
}

/// The kinds of events of a robot.
#[derive(Clone, Debug, PartialEq)]
pub enum EventKind {
    /// A client arrived on a line, and has not completed the handshake yet.
    ClientArrived(String),
    /// A client was refused, because the robot has another.
    ClientRefused(String),
    /// A client has completed the handshake.
    Connected,
    /// A client has closed the session, and stays on the line.
    Closed,
    /// The client has left, with the reason.
    ClientLeft(String),
    /// No packet arrived for this time, and the robot was stopped.
    Silent(Duration),
    /// A client moved the robot to another pose, or back to its start.
    Placed,
    /// A client requested something that is not possible.
    Refused(String),
    /// A client sent this message for display.
    Message(String),
    /// The body has touched something.
    Collided,
    /// The number of further events within a second, which were not reported.
    EventsDropped(u64),
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:8.1} s  {}: {}",
            self.time.as_secs_f64(),
            self.robot,
            self.kind
        )
    }
}

impl fmt::Display for EventKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ClientArrived(peer) => write!(f, "{peer} connected"),
            Self::ClientRefused(peer) => write!(f, "{peer} was refused: the robot has a client"),
            Self::Connected => write!(f, "a client is connected"),
            Self::Closed => write!(f, "the client ended its session"),
            Self::ClientLeft(reason) => write!(f, "the client disconnected: {reason}"),
            Self::Silent(time) => write!(f, "no packet for {:.1} s, the motors stop", time.as_secs_f64()),
            Self::Placed => write!(f, "a client moved the robot to another pose"),
            Self::Refused(reason) => write!(f, "refused: {reason}"),
            Self::Message(text) => write!(f, "message from the client: {text}"),
            Self::Collided => write!(f, "the robot collides"),
            Self::EventsDropped(count) => write!(f, "{count} more events within a second are not shown"),
        }
    }
}
