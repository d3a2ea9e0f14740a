//! The kinds of faults: their names, where each can be injected, and into which schemas.

use crate::case::Clock;

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
    /// Hundreds of publications, commands and log lines in each iteration.
    Flood,
    /// Commands and wakes without authority.
    Trespass,
    /// A precondition changes at every check.
    Chatter,
    /// A father wakes children, puts them to sleep and changes their policy at random times.
    Meddle,
    /// A schema's own process crashes: a wild pointer, abort, exit, endless recursion, all memory used.
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
    /// Clients flood the link, and are killed amid requests.
    Client,
    /// The host is killed.
    HostKilled,
    /// The host is stopped.
    HostStopped,
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
}

impl Kind {
    /// All kinds.
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

    /// The name on the command line and in output.
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

    /// Whether it can be injected under this clock. Faults by lateness are not possible in
    /// lockstep, which has no deadlines (R16).
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

    /// The kinds of schemas that it can affect.
    #[must_use]
    pub fn targets(self) -> &'static [TargetKind] {
        match self {
            Self::Panic
            | Self::Error
            | Self::Hang
            | Self::Dawdle
            | Self::Slow
            | Self::Silence
            | Self::Nan => &[
                TargetKind::Motor,
                TargetKind::Motor,
                TargetKind::Motor,
                TargetKind::Eye,
                TargetKind::Device,
            ],
            Self::Flood => &[TargetKind::Motor, TargetKind::Eye],
            Self::Crash | Self::Kill | Self::Freeze => &[TargetKind::Motor, TargetKind::Eye],
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
            | Self::DiskFails => &[TargetKind::Motor],
        }
    }

    /// The values of the modulation `trouble` that cause it.
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

    /// The calls in which it can occur.
    #[must_use]
    pub fn places(self, target: TargetKind) -> &'static [&'static str] {
        match (self, target) {
            (Self::Trespass | Self::Chatter, _) => &["check"],
            (Self::Silence | Self::Nan | Self::Beyond | Self::Flood | Self::Meddle, _) => &["iterate"],
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
            (_, TargetKind::Eye | TargetKind::Device) => &["iterate", "iterate", "awake", "sleep"],
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum as _;

    use super::Kind;

    #[test]
    fn the_command_line_name_of_a_kind_is_its_displayed_name() {
        assert_eq!(Kind::value_variants(), Kind::ALL);
        for kind in Kind::ALL {
            let value = kind.to_possible_value().expect("none is hidden");
            assert_eq!(value.get_name(), kind.name());
        }
    }
}
