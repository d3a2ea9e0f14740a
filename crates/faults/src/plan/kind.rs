//! The kinds of faults: what each is called, where it can be injected, and into whom.

use crate::case::Clock;

/// A kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, clap::ValueEnum)]
pub enum Kind {
    /// A call panics.
    Panic,
    /// A call answers with an error.
    Error,
    /// A call never returns.
    Hang,
    /// A call returns long after it was given up.
    Dawdle,
    /// Calls take some of their budgets.
    Slow,
    /// A winner commands nothing, an eye or a device says nothing.
    Silence,
    /// Commands and exports are NaN or infinite.
    Nan,
    /// Commands are far out of range.
    Beyond,
    /// Hundreds of publications, commands and log lines in each iteration.
    Flood,
    /// Commands and wakes without authority.
    Trespass,
    /// A precondition flips with every look.
    Chatter,
    /// A father wakes children, lays them down and changes their policy at odd times.
    Meddle,
    /// A process of a schema's own crashes: a wild pointer, abort, exit, a stack without end, all memory.
    Crash,
    /// A process of a schema's own is killed.
    Kill,
    /// A process of a schema's own stands still.
    Freeze,
    /// Another build takes over and fails at it, or soon after.
    Reload,
    /// Somebody stops, forces, plays, re-times, unloads and loads at odd times.
    Operator,
    /// Somebody stops everything, and lets it go on.
    StopAll,
    /// Clients of the link flood it, and are killed in the middle.
    Client,
    /// The host is killed.
    HostKilled,
    /// The host stands still.
    HostStopped,
    /// A schema crashes in the host's own process.
    HostCrashed,
    /// The line to the robot is cut, and nobody is told.
    LineCut,
    /// Two operators stop everything and let it go on, against each other.
    Contest,
    /// Somebody acts on a schema, or its process is killed, while another build takes over.
    AmidReload,
    /// Nobody reads what the host and its clients say.
    Unread,
    /// The terminal of the host is gone.
    TerminalLost,
    /// The disk on which the host records is full.
    DiskFull,
    /// That disk loses what it took.
    DiskFails,
}

/// Who misbehaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whom {
    /// A motor schema.
    Motor,
    /// A perceptive schema.
    Eye,
    /// A driver.
    Device,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 29] = [
        Self::Panic,
        Self::Error,
        Self::Hang,
        Self::Dawdle,
        Self::Slow,
        Self::Silence,
        Self::Nan,
        Self::Beyond,
        Self::Flood,
        Self::Trespass,
        Self::Chatter,
        Self::Meddle,
        Self::Crash,
        Self::Kill,
        Self::Freeze,
        Self::Reload,
        Self::Operator,
        Self::StopAll,
        Self::Client,
        Self::HostKilled,
        Self::HostStopped,
        Self::HostCrashed,
        Self::LineCut,
        Self::Contest,
        Self::AmidReload,
        Self::Unread,
        Self::TerminalLost,
        Self::DiskFull,
        Self::DiskFails,
    ];

    /// What people type and read.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Panic => "panic",
            Self::Error => "error",
            Self::Hang => "hang",
            Self::Dawdle => "dawdle",
            Self::Slow => "slow",
            Self::Silence => "silence",
            Self::Nan => "nan",
            Self::Beyond => "beyond",
            Self::Flood => "flood",
            Self::Trespass => "trespass",
            Self::Chatter => "chatter",
            Self::Meddle => "meddle",
            Self::Crash => "crash",
            Self::Kill => "kill",
            Self::Freeze => "freeze",
            Self::Reload => "reload",
            Self::Operator => "operator",
            Self::StopAll => "stop-all",
            Self::Client => "client",
            Self::HostKilled => "host-killed",
            Self::HostStopped => "host-stopped",
            Self::HostCrashed => "host-crashed",
            Self::LineCut => "line-cut",
            Self::Contest => "contest",
            Self::AmidReload => "amid-reload",
            Self::Unread => "unread",
            Self::TerminalLost => "terminal-lost",
            Self::DiskFull => "disk-full",
            Self::DiskFails => "disk-fails",
        }
    }

    /// Whether it can be injected under this clock. In lockstep there is no time to miss, so nothing there is late (R16).
    #[must_use]
    pub fn fits(self, clock: Clock) -> bool {
        match self {
            Self::Client
            | Self::HostKilled
            | Self::HostStopped
            | Self::HostCrashed
            | Self::LineCut
            | Self::Unread
            | Self::TerminalLost
            | Self::DiskFull
            | Self::DiskFails => clock == Clock::Outside,
            Self::Hang | Self::Dawdle | Self::Slow | Self::Freeze | Self::Contest => clock == Clock::RealTime,
            Self::Panic
            | Self::Error
            | Self::Silence
            | Self::Nan
            | Self::Beyond
            | Self::Flood
            | Self::Trespass
            | Self::Chatter
            | Self::Meddle
            | Self::Crash
            | Self::Kill
            | Self::Reload
            | Self::Operator
            | Self::StopAll
            | Self::AmidReload => clock != Clock::Outside,
        }
    }

    /// Whether only a schema in a process of its own survives it.
    #[must_use]
    pub fn needs_process(self) -> bool {
        matches!(self, Self::Crash | Self::Kill | Self::Freeze)
    }

    /// Who can do it.
    #[must_use]
    pub fn whom(self) -> &'static [Whom] {
        match self {
            Self::Panic
            | Self::Error
            | Self::Hang
            | Self::Dawdle
            | Self::Slow
            | Self::Silence
            | Self::Nan => &[Whom::Motor, Whom::Motor, Whom::Motor, Whom::Eye, Whom::Device],
            Self::Flood => &[Whom::Motor, Whom::Eye],
            Self::Crash | Self::Kill | Self::Freeze => &[Whom::Motor, Whom::Eye],
            Self::Beyond
            | Self::Trespass
            | Self::Chatter
            | Self::Meddle
            | Self::Reload
            | Self::Operator
            | Self::StopAll
            | Self::Client
            | Self::HostKilled
            | Self::HostStopped
            | Self::HostCrashed
            | Self::LineCut
            | Self::Contest
            | Self::AmidReload
            | Self::Unread
            | Self::TerminalLost
            | Self::DiskFull
            | Self::DiskFails => &[Whom::Motor],
        }
    }

    /// The words of it that schemas know.
    #[must_use]
    pub fn troubles(self) -> &'static [&'static str] {
        match self {
            Self::Panic => &["panic"],
            Self::Error => &["error"],
            Self::Hang => &["hang"],
            Self::Dawdle => &["dawdle"],
            Self::Slow => &["slow"],
            Self::Silence => &["silence"],
            Self::Nan => &["nan", "infinity"],
            Self::Beyond => &["beyond"],
            Self::Flood => &["flood"],
            Self::Trespass => &["trespass"],
            Self::Chatter => &["chatter"],
            Self::Meddle => &["meddle"],
            Self::Crash => &["segfault", "abort", "exit", "overflow", "eat"],
            Self::Reload => &["panic", "error"],
            Self::Kill
            | Self::Freeze
            | Self::Operator
            | Self::StopAll
            | Self::Client
            | Self::HostKilled
            | Self::HostStopped
            | Self::HostCrashed
            | Self::LineCut
            | Self::Contest
            | Self::AmidReload
            | Self::Unread
            | Self::TerminalLost
            | Self::DiskFull
            | Self::DiskFails => &[],
        }
    }

    /// The calls in which one can do it.
    #[must_use]
    pub fn places(self, whom: Whom) -> &'static [&'static str] {
        match (self, whom) {
            (Self::Trespass | Self::Chatter, _) => &["check"],
            (Self::Silence | Self::Nan | Self::Beyond | Self::Flood | Self::Meddle, _) => &["iterate"],
            // What is called often is named twice: of the others some come too seldom to be met.
            (_, Whom::Motor) => &[
                "check",
                "check",
                "iterate",
                "iterate",
                "awake",
                "sleep",
                "arbitrate",
                "end",
            ],
            (_, Whom::Eye | Whom::Device) => &["iterate", "iterate", "awake", "sleep"],
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum as _;

    use super::Kind;

    #[test]
    fn a_kind_is_typed_as_it_is_shown() {
        assert_eq!(Kind::value_variants(), Kind::ALL);
        for kind in Kind::ALL {
            let typed = kind.to_possible_value().expect("none is hidden");
            assert_eq!(typed.get_name(), kind.name());
        }
    }
}
