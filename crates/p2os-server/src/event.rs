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
    pub what: What,
}

/// The kinds of events of a robot.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// A client arrived on a line, and has not completed the handshake yet.
    Came(String),
    /// A client was refused, because the robot has another.
    TurnedAway(String),
    /// A client has completed the handshake.
    Connected,
    /// A client has closed the session, and stays on the line.
    Closed,
    /// The client has left, and why.
    Left(String),
    /// No packet arrived for this time, and the robot was stopped.
    Silent(Duration),
    /// A client moved the robot to another pose, or back to its start.
    Placed,
    /// A client requested something that is not possible.
    Refused(String),
    /// A client sent this message for display.
    Said(String),
    /// The body has touched something.
    Touched,
    /// The number of further events within a second, which were left out.
    LeftOut(u64),
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:8.1} s  {}: {}",
            self.time.as_secs_f64(),
            self.robot,
            self.what
        )
    }
}

impl fmt::Display for What {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Came(peer) => write!(f, "{peer} came"),
            Self::TurnedAway(peer) => write!(f, "{peer} was turned away, it has a client"),
            Self::Connected => write!(f, "a client is connected"),
            Self::Closed => write!(f, "the client ended its session"),
            Self::Left(why) => write!(f, "the client is gone: {why}"),
            Self::Silent(time) => write!(
                f,
                "nothing heard for {:.1} s, its motors stop",
                time.as_secs_f64()
            ),
            Self::Placed => write!(f, "a client put it elsewhere"),
            Self::Refused(why) => write!(f, "refused: {why}"),
            Self::Said(words) => write!(f, "the client says: {words}"),
            Self::Touched => write!(f, "it touches something"),
            Self::LeftOut(count) => write!(f, "{count} more events within a second are not told"),
        }
    }
}
