//! The judgement of a command by the guards of its schema (R18), as one port sees it. It changes nothing: the
//! caller refuses and reports.

#![allow(unsafe_code)]

use jde_board::Reader;
use jde_core::Nanos;
use jde_loader::Judge;

/// The periods of a guard after which its state is too old to judge by. One late or skipped turn is usual on
/// a machine without real-time scheduling; two in a row are not.
const MAX_AGE_PERIODS: Nanos = 3;

/// A guard of the commands of one port.
pub(crate) struct PortGuard {
    guard: usize,
    state: Reader,
    /// The schemas whose commands it judges.
    commanders: Vec<u32>,
}

/// Why a command does not take effect.
pub(crate) struct Refusal {
    /// The schema that gave it.
    pub(crate) commander: usize,
    /// The guard.
    pub(crate) guard: usize,
    /// The reason of the guard, in words.
    pub(crate) reason: String,
}

/// The guards of an application as they are at present.
pub(crate) trait Guards {
    /// Returns the function of a guard and its period; `None` if nothing is judged, as in a replay.
    fn guard(&self, guard: usize) -> Option<(Judge, Nanos)>;
}

impl PortGuard {
    pub(crate) fn new(guard: usize, state: Reader, commanders: Vec<u32>) -> Self {
        Self {
            guard,
            state,
            commanders,
        }
    }

    /// Returns the same guard for a successor of the port.
    pub(super) fn duplicate(&self) -> Self {
        Self::new(self.guard, self.state.duplicate(), self.commanders.clone())
    }

    /// Judges a command by the newest state.
    fn judge(&mut self, guards: &dyn Guards, now: Nanos, command: &[u8]) -> Result<(), String> {
        let Some((judge, period)) = guards.guard(self.guard) else {
            return Ok(());
        };
        let state = self
            .state
            .latch_newest(now)
            .filter(|state| state.stamp.sequence > 0);
        let Some(state) = state else {
            return Err(String::from("the guard has no state"));
        };
        let age = now.saturating_sub(state.stamp.time);
        if age > period.saturating_mul(MAX_AGE_PERIODS) {
            return Err(format!(
                "the state of the guard is {:.0} ms old",
                age as f64 / 1e6
            ));
        }
        // SAFETY: the application was refused unless the guard states the types of its export and of the
        // command. Both values are on 64-byte boundaries.
        unsafe { judge.judge(state.bytes, age, command) }
    }
}

/// Lets the guards of a schema judge a command of it. The neutral value is accepted.
pub(super) fn judge(
    port_guards: &mut [PortGuard],
    guards: &dyn Guards,
    now: Nanos,
    commander: u32,
    (command, neutral): (&[u8], &[u8]),
) -> Result<(), Refusal> {
    if command == neutral {
        return Ok(());
    }
    for port_guard in port_guards.iter_mut() {
        if port_guard.commanders.contains(&commander) {
            port_guard.judge(guards, now, command).map_err(|reason| Refusal {
                commander: commander as usize,
                guard: port_guard.guard,
                reason,
            })?;
        }
    }
    Ok(())
}
