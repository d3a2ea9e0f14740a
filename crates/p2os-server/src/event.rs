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
    /// The client has left, and why.
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
    /// The number of further events within a second, which were left out.
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
            Self::ClientArrived(peer) => write!(f, "{peer} came"),
            Self::ClientRefused(peer) => write!(f, "{peer} was turned away, it has a client"),
            Self::Connected => write!(f, "a client is connected"),
            Self::Closed => write!(f, "the client ended its session"),
            Self::ClientLeft(why) => write!(f, "the client is gone: {why}"),
            Self::Silent(time) => write!(
                f,
                "nothing heard for {:.1} s, its motors stop",
                time.as_secs_f64()
            ),
            Self::Placed => write!(f, "a client put it elsewhere"),
            Self::Refused(why) => write!(f, "refused: {why}"),
            Self::Message(words) => write!(f, "the client says: {words}"),
            Self::Collided => write!(f, "it touches something"),
            Self::EventsDropped(count) => write!(f, "{count} more events within a second are not told"),
        }
    }
}
