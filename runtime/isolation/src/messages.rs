//! The messages between the host and a child. Both ends are the same build, so they have no version.
//!
//! The host sends a [`Call`], the child requests what the call needs ([`FromChild`]) and receives a [`Reply`] to each
//! that is not unanswered, and the call ends with [`Done`]. The host trusts no message: an unexpected one ends the child.

use jde_loader::instance::{ArbitrationQuery, Verdict};
use jde_panel::Gesture;
use serde::{Deserialize, Serialize, Serializer};

use super::launch::Launch;

/// A message of the host.
#[derive(Debug, Serialize, Deserialize)]
pub enum ToChild<'a> {
    /// Before a call and without a reply: an input that the call may read.
    Early {
        /// The port.
        port: u32,
        /// What it shows, or the status of an input without a value.
        #[serde(borrow)]
        input: Result<Input<'a>, i32>,
    },
    /// Before a call and without a reply: memory for the next value of an output.
    EarlyLoan {
        /// The port.
        port: u32,
        /// The offset in the port's mapped memory, bytes.
        place: usize,
    },
    /// A call, which the child ends with [`FromChild::Done`].
    Call(Call),
    /// The last message: end the instance and the process. The child replies with [`FromChild::Done`].
    Destroy,
    /// The reply to a request.
    Reply(#[serde(borrow)] Reply<'a>),
}

/// A call of a function.
#[derive(Debug, Serialize, Deserialize)]
pub struct Call {
    /// The application's time, ns.
    pub now: u64,
    /// The machine's time, ns.
    pub machine: u64,
    /// Seconds of the application in a second of the machine; 0 if calls take no time.
    pub speed: f64,
    /// The release of the ports in which it runs.
    pub release: u64,
    /// What it may change.
    pub changes: Changes,
    /// The function.
    pub function: Function,
}

/// What a call may change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Changes {
    /// All that its authority allows.
    #[default]
    All,
    /// Not all that its authority allows: the host answers every change.
    Answered,
    /// Nothing.
    Nothing,
}

/// The function to call.
#[derive(Debug, Serialize, Deserialize)]
pub enum Function {
    /// The first: load the type. The outcome is [`Returned::Started`].
    Start(Box<Launch>),
    /// Create an instance. A failure is [`Returned::Refused`].
    Create,
    /// Wake it up.
    Awake,
    /// Evaluate its precondition. The outcome is [`Returned::Checked`].
    Check,
    /// Iterate.
    Iterate,
    /// Evaluate its precondition, and iterate if that is true. The outcome is [`Returned::Checked`].
    CheckAndIterate,
    /// Arbitrate among its children. The outcome is [`Returned::Arbitrated`].
    Arbitrate(ArbitrationQuery),
    /// Put it to sleep.
    Sleep,
    /// Draw its panel. The outcome is [`Returned::Drawn`].
    Draw,
    /// Deliver a gesture on its panel.
    Touch {
        /// Who made it.
        by: String,
        /// The gesture.
        gesture: Gesture,
    },
    /// Save its memory. The outcome is [`Returned::Saved`].
    Save,
    /// Restore saved memory.
    Restore {
        /// The version of its format.
        version: u32,
        /// The saved bytes.
        memory: Bytes<Vec<u8>>,
    },
}

/// The reply to a request. An error is a status of the ABI.
#[derive(Debug, Serialize, Deserialize)]
pub enum Reply<'a> {
    /// To [`FromChild::Read`].
    Input(#[serde(borrow)] Result<Input<'a>, i32>),
    /// To [`FromChild::Loan`]: the offset in the port's mapped memory, bytes; `None` if the value is to be sent.
    Loan(Result<Option<usize>, i32>),
    /// To [`FromChild::Child`]: its state, as the ABI numbers it, and whether it is Faulted.
    Child(Result<(u32, bool), i32>),
    /// To every other request.
    Status(i32),
}

/// What an input shows.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Input<'a> {
    /// Identifies the value.
    pub stamp: Stamp,
    /// The value.
    #[serde(borrow)]
    pub value: Value<'a>,
}

/// What identifies a value, as in a sample of the ABI.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamp {
    /// Its time, ns.
    pub time_ns: u64,
    /// Its number.
    pub sequence: u64,
    /// Who wrote it.
    pub writer: u32,
    /// The ABI's flags of a sample.
    pub flags: u32,
}

/// Where a value is.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub enum Value<'a> {
    /// Here.
    Sent(#[serde(borrow)] Bytes<&'a [u8]>),
    /// At that offset in the port's mapped memory, bytes.
    InPlace(usize),
    /// It is the one that the child was sent last.
    Unchanged,
}

/// A message of the child during a call. All but the last three are requests.
#[derive(Debug, Serialize, Deserialize)]
pub enum FromChild<'a> {
    /// The value of an input.
    Read {
        /// The port.
        port: u32,
    },
    /// Memory for the next value of an output.
    Loan {
        /// The port.
        port: u32,
    },
    /// Publish the loan.
    Publish {
        /// The port.
        port: u32,
        /// When it was measured, ns.
        time: u64,
        /// The value, unless it is in mapped memory.
        #[serde(borrow)]
        value: Option<Bytes<&'a [u8]>>,
        /// Whether the child knows the outcome and waits for no reply.
        unanswered: bool,
    },
    /// Retract the last value.
    Retract {
        /// The port.
        port: u32,
        /// Whether the child knows the outcome and waits for no reply.
        unanswered: bool,
    },
    /// Wake a child.
    Wake {
        /// Its role.
        child: u32,
    },
    /// Put a child to sleep.
    PutToSleep {
        /// Its role.
        child: u32,
    },
    /// The state of a child.
    Child {
        /// Its role.
        child: u32,
    },
    /// Change the policy of a group.
    SetPolicy {
        /// The role of a child in the group.
        child: u32,
        /// The policy, as the ABI numbers it.
        policy: u32,
        /// The dwell time, ns.
        dwell_ns: u64,
        /// The hysteresis.
        hysteresis: f64,
    },
    /// From now on its debugger holds the call, or no longer does.
    Hold(bool),
    /// A line for the log.
    Log {
        /// The level, as the ABI numbers it.
        level: u32,
        /// The line.
        text: &'a str,
    },
    /// Why the call fails.
    Fail(&'a str),
    /// The call ended.
    Done(Done),
}

/// The end of a call.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Done {
    /// A status of the ABI.
    pub status: i32,
    /// The ports whose early values it read, a bit each.
    pub read_early: u128,
    /// The first time that it obtained from the clock, ns.
    pub first_time: Option<u64>,
    /// What the function returned.
    pub outcome: Returned,
}

/// What a function returns besides its status.
#[derive(Debug, Default, Serialize, Deserialize)]
pub enum Returned {
    /// Nothing.
    #[default]
    Nothing,
    /// The limits that the system cannot set.
    Started(Vec<String>),
    /// Why there is no instance.
    Refused(String),
    /// The precondition.
    Checked {
        /// Whether it is true.
        ready: bool,
        /// The urgency.
        urgency: f64,
    },
    /// The verdict.
    Arbitrated(Verdict),
    /// A `Result<List, String>` in the encoding of panels, which limits how deep and how long a list is.
    Drawn(Bytes<Vec<u8>>),
    /// The memory, or why there is none.
    Saved(Result<Bytes<Vec<u8>>, String>),
}

/// Bytes that are encoded as one piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub struct Bytes<T>(pub T);

impl<T: AsRef<[u8]>> Serialize for Bytes<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(self.0.as_ref())
    }
}
