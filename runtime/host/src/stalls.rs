//! Time in which the host itself did not run: its process was stopped, the machine slept or had no time for it. No call
//! of a schema is slow because of it. The supervisor notices it by its own lateness; nothing here waits or reads a clock.

use std::collections::VecDeque;
use std::time::Duration;

use jde_core::Nanos;
use parking_lot::Mutex;

/// A supervisor that is later than this did not run because the host did not: a loaded machine delays a thread by some
/// tens of milliseconds.
pub(crate) const MIN_STALL: Duration = Duration::from_millis(100);
/// Stalls that are kept: those of calls that run now.
const MAX_STALLS: usize = 16;

/// When the host did not run.
#[derive(Debug, Default)]
pub(crate) struct Stalls(Mutex<State>);

#[derive(Debug, Default)]
struct State {
    stalls: VecDeque<(Nanos, Nanos)>,
    /// When the supervisor ran last, and until when it must run again; `None` before its first pause.
    pause: Option<(Nanos, Nanos)>,
}

impl Stalls {
    /// The supervisor runs at `now`.
    pub(crate) fn wake(&self, now: Nanos) {
        let mut state = self.0.lock();
        if let Some(stall) = state.present(now) {
            if state.stalls.len() == MAX_STALLS {
                state.stalls.pop_front();
            }
            state.stalls.push_back(stall);
        }
        state.pause = None;
    }

    /// The supervisor pauses at `now`, and runs again by `latest` unless the host does not run.
    pub(crate) fn pause(&self, now: Nanos, latest: Nanos) {
        self.0.lock().pause = Some((now, latest));
    }

    /// Returns the time since `since` in which the host did not run. A stall counts from when the supervisor ran last.
    pub(crate) fn within(&self, since: Nanos, now: Nanos) -> Nanos {
        let state = self.0.lock();
        let stalls = state.stalls.iter().copied().chain(state.present(now));
        let within = stalls.map(|(from, to)| to.min(now).saturating_sub(from.max(since)));
        within.fold(0, Nanos::saturating_add)
    }
}

impl State {
    /// The stall that ends now, before the supervisor has noticed it.
    fn present(&self, now: Nanos) -> Option<(Nanos, Nanos)> {
        let (from, latest) = self.pause?;
        (now > latest).then_some((from, now))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_that_ends_in_time_is_no_stall() {
        let stalls = Stalls::default();
        stalls.pause(10, 20);
        assert_eq!(stalls.within(0, 20), 0);
        stalls.wake(20);
        assert_eq!(stalls.within(0, 100), 0);
    }

    #[test]
    fn a_stall_counts_at_once_and_as_far_as_it_overlaps() {
        let stalls = Stalls::default();
        stalls.pause(10, 20);
        assert_eq!(stalls.within(0, 50), 40, "before the supervisor has run again");
        stalls.wake(50);
        assert_eq!(stalls.within(0, 100), 40);
        assert_eq!(stalls.within(30, 100), 20);
        assert_eq!(stalls.within(50, 100), 0);
        stalls.pause(60, 70);
        stalls.wake(90);
        assert_eq!(stalls.within(0, 100), 70);
    }

    #[test]
    fn only_the_newest_stalls_are_kept() {
        let stalls = Stalls::default();
        for number in 0..2 * MAX_STALLS as Nanos {
            stalls.pause(100 * number, 100 * number + 10);
            stalls.wake(100 * number + 50);
        }
        assert_eq!(stalls.within(0, 10_000), 50 * MAX_STALLS as Nanos);
    }
}
