//! What happens between robots and clients, for whoever runs the server.

use core::fmt;
use core::time::Duration;

/// Something that happened to a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// The world's time.
    pub time: Duration,
    /// The robot's name in the world.
    pub robot: String,
    /// What.
    pub what: What,
}

/// What happened to a robot.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// Somebody came by a line; has said nothing yet.
    Came(String),
    /// Somebody else is there already.
    TurnedAway(String),
    /// A client has shaken hands.
    Connected,
    /// A client ended the session, and keeps the line.
    Closed,
    /// The client has left, and why.
    Left(String),
    /// Nothing was heard for that long: the robot was stopped.
    Silent(Duration),
    /// A client put the robot elsewhere or back to its start.
    Placed,
    /// A client asked for what cannot be done.
    Refused(String),
    /// A client said this to whoever watches.
    Said(String),
    /// The body began to touch something.
    Touched,
    /// So many more things happened within a second than anybody reads.
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
