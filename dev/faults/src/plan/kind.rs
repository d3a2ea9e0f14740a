//! The kinds of faults: their names, where each can be injected, and into which schemas.

use crate::case::RunMode;

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub enum Kind {
    /// A call panics.
    Panic,
    /// A call returns an error.
    Error,
    /// A call never returns.
    Hang,
    /// A call returns long after the host gave it up.
    Dawdle,
    /// Calls take a part of their budgets.
    Slow,
    /// A winner sends no command, or a perceptive schema or a driver publishes nothing.
    Silence,
    /// Commands and exports are NaN or infinite.
    Nan,
    /// Commands are far out of range.
    Beyond,
    /// Commands are random, whatever is in the way.
    Reckless,
    /// Hundreds of publications, commands and log lines in each iteration.
    Flood,
    /// Commands and wakes without authority.
    Trespass,
    /// A precondition changes at every check.
    Chatter,
    /// A father wakes children, puts them to sleep and changes their policy at random times.
    Meddle,
    /// A schema's own process crashes: a wild pointer, abort, exit, endless recursion, all memory used, or it leaves a
    /// process behind.
    Crash,
    /// A schema's own process is killed.
    Kill,
    /// A schema's own process is stopped.
    Freeze,
    /// Another build takes over and fails in the takeover, or soon after.
    Reload,
    /// An operator stops, forces, plays, re-times, unloads and loads at random times.
    Operator,
    /// An operator stops everything, and releases it.
    StopAll,
    /// The laser or the odometry of the robot is silent, frozen, empty, contradictory or late.
    Sense,
    /// Two operators act on a schema under leases that begin and end, while a third one stops it.
    Leases,
    /// Clients flood the link, and are killed amid requests.
    Client,
    /// The host is killed.
    HostKilled,
    /// The host is stopped.
    HostStopped,
    /// The host is stopped again and again, and goes on.
    HostStutters,
    /// A schema crashes in the host's process.
    HostCrashed,
    /// The line to the robot is cut without notice to either end.
    LineCut,
    /// Two operators stop and release everything concurrently.
    Contest,
    /// While another build takes over, an operator acts on the schema, a third build follows, or the schema
    /// panics.
    AmidReload,
    /// No process reads the output of the host and its clients.
    Unread,
    /// The host loses its terminal.
    TerminalLost,
    /// The disk of the host's recording is full.
    DiskFull,
    /// That disk loses written data.
    DiskFails,
    /// The host gets no more descriptors.
    NoDescriptors,
    /// The host gets no more threads.
    NoThreads,
    /// The host gets no more memory.
    NoMemory,
}

/// The kind of schema that misbehaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetKind {
    /// A motor schema.
    Motor,
    /// A perceptive schema.
    Eye,
    /// A driver.
    Device,
    /// The simulated robot.
    Robot,
}

/// Where faults of a kind can be injected.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Scope {
    /// Into a schema, in virtual time and in real time.
    Schema,
    /// Into a schema, in real time only: the fault takes time.
    RealTime,
    /// Into a whole process.
    Process,
}

/// Schemas of all kinds. Motor schemas are listed repeatedly, as they are the most.
const ANY: &[TargetKind] = &[
    TargetKind::Motor,
    TargetKind::Motor,
    TargetKind::Motor,
    TargetKind::Eye,
    TargetKind::Device,
];
const MOTOR_OR_EYE: &[TargetKind] = &[TargetKind::Motor, TargetKind::Eye];
const MOTOR: &[TargetKind] = &[TargetKind::Motor];
const ROBOT: &[TargetKind] = &[TargetKind::Robot];

impl Kind {
    /// Where it can be injected, the kinds of schemas it can affect, and the troubles of the fault schemas that
    /// cause it.
    fn spec(self) -> (Scope, &'static [TargetKind], &'static [&'static str]) {
        use Scope::{Process, RealTime, Schema};
        match self {
            Self::Panic => (Schema, ANY, &["panic"]),
            Self::Error => (Schema, ANY, &["error"]),
            Self::Hang => (RealTime, ANY, &["hang"]),
            Self::Dawdle => (RealTime, ANY, &["dawdle"]),
            Self::Slow => (RealTime, ANY, &["slow"]),
            Self::Silence => (Schema, ANY, &["silence"]),
            Self::Nan => (Schema, ANY, &["nan", "infinity"]),
            Self::Beyond => (Schema, MOTOR, &["beyond"]),
            Self::Reckless => (Schema, MOTOR, &["reckless"]),
            Self::Flood => (Schema, MOTOR_OR_EYE, &["flood"]),
            Self::Trespass => (Schema, MOTOR, &["trespass"]),
            Self::Chatter => (Schema, MOTOR, &["chatter"]),
            Self::Meddle => (Schema, MOTOR, &["meddle"]),
            Self::Crash => (
                Schema,
                MOTOR_OR_EYE,
                &["segfault", "abort", "exit", "overflow", "eat", "fork"],
            ),
            Self::Kill => (Schema, MOTOR_OR_EYE, &[]),
            Self::Freeze => (RealTime, MOTOR_OR_EYE, &[]),
            Self::Reload | Self::Operator | Self::StopAll | Self::AmidReload => (Schema, MOTOR, &[]),
            Self::Sense => (Schema, ROBOT, &[]),
            Self::Contest | Self::Leases => (RealTime, MOTOR, &[]),
            Self::Client
            | Self::HostKilled
            | Self::HostStopped
            | Self::HostStutters
            | Self::HostCrashed
            | Self::LineCut => (Process, MOTOR, &[]),
            Self::Unread
            | Self::TerminalLost
            | Self::DiskFull
            | Self::DiskFails
            | Self::NoDescriptors
            | Self::NoThreads
            | Self::NoMemory => (Process, MOTOR, &[]),
        }
    }

    /// Whether it can be injected there.
    #[must_use]
    pub fn fits(self, clock: RunMode) -> bool {
        match self.spec().0 {
            Scope::Schema => clock != RunMode::Outside,
            Scope::RealTime => clock == RunMode::RealTime,
            Scope::Process => clock == RunMode::Outside,
        }
    }

    /// Whether its schema must run in its own process.
    #[must_use]
    pub fn needs_process(self) -> bool {
        matches!(self, Self::Crash | Self::Kill | Self::Freeze)
    }

    /// The kinds of schemas that it can affect.
    #[must_use]
    pub fn targets(self) -> &'static [TargetKind] {
        self.spec().1
    }

    /// The troubles of the fault schemas that cause it.
    #[must_use]
    pub fn troubles(self) -> &'static [&'static str] {
        self.spec().2
    }

    /// The calls in which it can occur.
    #[must_use]
    pub fn places(self, target: TargetKind) -> &'static [&'static str] {
        match (self, target) {
            (Self::Trespass | Self::Chatter, _) => &["check"],
            (Self::Silence | Self::Nan | Self::Beyond | Self::Reckless | Self::Flood | Self::Meddle, _) => {
                &["iterate"]
            }
            // Frequent calls are listed twice, since some of the others are too rare to occur in time.
            (_, TargetKind::Motor) => &[
                "check",
                "check",
                "iterate",
                "iterate",
                "awake",
                "sleep",
                "arbitrate",
                "end",
            ],
            (_, TargetKind::Eye | TargetKind::Device | TargetKind::Robot) => {
                &["iterate", "iterate", "awake", "sleep"]
            }
        }
    }
}
