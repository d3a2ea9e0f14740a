//! The phases of an instance's life, and the transitions between them. Each owns the data that exists only in
//! it.

use jde_core::Nanos;

use super::deadlines::Deadlines;
use super::trial::Trial;
use crate::instance::Instance;

/// A phase of an instance's life. A transition consumes it; meanwhile, the runner's phase is `Absent`.
#[derive(Default)]
pub(super) enum Phase {
    /// There is no instance: it was not created yet, or it faulted or was unloaded.
    #[default]
    Absent,
    Slept(Installed),
    Awake(Installed, Awake),
}

/// An instance, and the trial of its build while the build is on one.
pub(super) struct Installed {
    pub(super) instance: Instance,
    pub(super) trial: Option<Trial>,
}

/// What exists while an instance is awake.
pub(super) struct Awake {
    pub(super) deadlines: Deadlines,
    /// When a requested turn begins, in addition to its deadlines (R12).
    pub(super) requested: Option<Nanos>,
    /// When a triggered turn has rested, and begins (R12).
    pub(super) rested: Option<Nanos>,
    /// When its last check was. A change of readiness occurred after that.
    pub(super) last_check: Nanos,
    /// A build took over in this turn; its next turn follows at once, in addition to its deadlines.
    pub(super) is_due_at_once: bool,
    /// The instance ends as soon as it sleeps.
    pub(super) unloading: bool,
}

impl Phase {
    /// An instance that is awake if there is `awake`.
    pub(super) fn new(installed: Installed, awake: Option<Awake>) -> Self {
        match awake {
            Some(awake) => Self::Awake(installed, awake),
            None => Self::Slept(installed),
        }
    }

    /// Takes the instance out, and leaves `Absent`.
    pub(super) fn take(&mut self) -> Option<(Installed, Option<Awake>)> {
        match std::mem::take(self) {
            Self::Absent => None,
            Self::Slept(installed) => Some((installed, None)),
            Self::Awake(installed, awake) => Some((installed, Some(awake))),
        }
    }

    /// Takes the instance out if it is awake, and leaves `Absent`.
    pub(super) fn take_awake(&mut self) -> Option<(Installed, Awake)> {
        self.awake()?;
        let (installed, awake) = self.take()?;
        Some((installed, awake?))
    }

    fn installed(&mut self) -> Option<&mut Installed> {
        match self {
            Self::Absent => None,
            Self::Slept(installed) | Self::Awake(installed, _) => Some(installed),
        }
    }

    pub(super) fn instance(&mut self) -> Option<&mut Instance> {
        self.installed().map(|installed| &mut installed.instance)
    }

    pub(super) fn awake(&mut self) -> Option<&mut Awake> {
        match self {
            Self::Absent | Self::Slept(_) => None,
            Self::Awake(_, awake) => Some(awake),
        }
    }

    pub(super) fn trial(&mut self) -> Option<&mut Trial> {
        self.installed()?.trial.as_mut()
    }

    pub(super) fn take_trial(&mut self) -> Option<Trial> {
        self.installed()?.trial.take()
    }

    pub(super) fn is_awake(&self) -> bool {
        matches!(self, Self::Awake(..))
    }
}

impl Installed {
    /// Wakes it up at `now`.
    pub(super) fn wake_up(mut self, deadlines: Deadlines, now: Nanos) -> (Phase, Result<(), String>) {
        let result = self.instance.awake();
        let awake = Awake {
            deadlines,
            requested: None,
            rested: None,
            last_check: now,
            is_due_at_once: false,
            unloading: false,
        };
        (Phase::Awake(self, awake), result)
    }

    /// Puts it to sleep; it was awake.
    pub(super) fn sleep(mut self) -> (Phase, Result<(), String>) {
        let result = self.instance.sleep();
        (Phase::Slept(self), result)
    }
}
