//! The two clocks of R16: real time, at any speed, and virtual time, which advances only when it is set. A
//! third is for tests of timing guarantees: it is virtual and advances while calls last.

mod counted;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use jde_core::Nanos;

use counted::Counted;

/// The application's time, ns since its start.
#[derive(Debug)]
pub(crate) enum Clock {
    /// Follows the machine's monotonic clock.
    Real {
        /// The instant of time 0.
        start: Instant,
        /// Seconds of the application in a second of the machine.
        speed: f64,
    },
    /// Advances when all threads wait.
    Counted(Counted),
    /// Advances only when it is set.
    Virtual {
        /// The current time.
        now: AtomicU64,
        /// In a replay, whether the recorded clock ran at the speed of wall-clock time; `None` outside a
        /// replay.
        recorded_real_time: Option<bool>,
    },
}

impl Clock {
    pub(crate) fn real(speed: f64) -> Self {
        Self::Real {
            start: Instant::now(),
            speed,
        }
    }

    pub(crate) fn counted() -> Self {
        Self::Counted(Counted::default())
    }

    pub(crate) fn new_virtual() -> Self {
        Self::Virtual {
            now: AtomicU64::new(0),
            recorded_real_time: None,
        }
    }

    /// Repeats the times of a recorded clock, which may have run at the speed of wall-clock time.
    pub(crate) fn replayed(at_wall_clock_speed: bool) -> Self {
        Self::Virtual {
            now: AtomicU64::new(0),
            recorded_real_time: Some(at_wall_clock_speed),
        }
    }

    pub(crate) fn now(&self) -> Nanos {
        match self {
            Self::Real { start, speed } => scaled(start.elapsed(), *speed),
            Self::Counted(counted) => counted.now(),
            Self::Virtual { now, .. } => now.load(Ordering::Acquire),
        }
    }

    /// Advances virtual time; real time advances by itself.
    pub(crate) fn advance_to(&self, now: Nanos) {
        match self {
            Self::Real { .. } | Self::Counted(_) => {}
            Self::Virtual { now: time, .. } => {
                time.fetch_max(now, Ordering::AcqRel);
            }
        }
    }

    /// Sets virtual time, also to an earlier instant: a replay repeats the simultaneous actions of
    /// several threads one after the other, each at its own time.
    pub(crate) fn set_exactly(&self, now: Nanos) {
        match self {
            Self::Real { .. } | Self::Counted(_) => {}
            Self::Virtual { now: time, .. } => time.store(now, Ordering::Release),
        }
    }

    /// Returns how long to wait on this machine until the application's time is `time`.
    pub(crate) fn duration_until(&self, time: Nanos) -> Duration {
        match self {
            Self::Real { speed, .. } => {
                let remaining = time.saturating_sub(self.now());
                Duration::from_nanos(if *speed == 1.0 {
                    remaining
                } else {
                    (remaining as f64 / speed).ceil() as u64
                })
            }
            Self::Counted(counted) => Duration::from_nanos(time.saturating_sub(counted.now())),
            Self::Virtual { .. } => Duration::ZERO,
        }
    }

    /// Waits for a notification, or until the application's time is `until`. May return earlier, as a
    /// condition variable may.
    pub(crate) fn wait<'a, T>(
        &self,
        condition: &Condvar,
        guard: MutexGuard<'a, T>,
        until: Option<Nanos>,
    ) -> MutexGuard<'a, T> {
        if let Self::Counted(counted) = self {
            return counted.wait(condition, guard, until);
        }
        let Some(until) = until else {
            return condition.wait(guard).unwrap_or_else(PoisonError::into_inner);
        };
        let result = condition.wait_timeout(guard, self.duration_until(until));
        result.unwrap_or_else(PoisonError::into_inner).0
    }

    /// Registers a thread that waits by this clock. Only counted time needs it.
    pub(crate) fn register_thread(&self) {
        if let Self::Counted(counted) = self {
            counted.register_thread();
        }
    }

    /// Removes a registered thread.
    pub(crate) fn unregister_thread(&self) {
        if let Self::Counted(counted) = self {
            counted.unregister_thread();
        }
    }

    /// Marks this thread as busy: counted time does not advance by itself before the thread waits again.
    pub(crate) fn mark_busy(&self) {
        if let Self::Counted(counted) = self {
            counted.mark_busy();
        }
    }

    /// Lets `time` pass in the middle of a call, if time is counted.
    pub(crate) fn spend(&self, time: Nanos) {
        if let Self::Counted(counted) = self {
            counted.spend(time);
        }
    }

    /// Converts a duration on this machine into the application's time, ns.
    pub(crate) fn scale_machine_time(&self, time: Duration) -> Nanos {
        match self {
            Self::Real { speed, .. } => scaled(time, *speed),
            Self::Counted(_) => scaled(time, 1.0),
            Self::Virtual { .. } => 0,
        }
    }

    /// Returns the seconds of the application in a second of the machine; 0 if calls take no time.
    pub(crate) fn speed(&self) -> f64 {
        match self {
            Self::Real { speed, .. } => *speed,
            Self::Counted(_) => 1.0,
            Self::Virtual { .. } => 0.0,
        }
    }

    /// Whether a second of the application is a second of wall-clock time.
    pub(crate) fn has_wall_clock_speed(&self) -> bool {
        match self {
            Self::Real { speed, .. } => *speed == 1.0,
            Self::Counted(_) => false,
            Self::Virtual {
                recorded_real_time, ..
            } => recorded_real_time.unwrap_or(false),
        }
    }

    /// Whether the clock repeats a recorded time, in which no turn is late.
    pub(crate) fn is_replayed(&self) -> bool {
        matches!(
            self,
            Self::Virtual {
                recorded_real_time: Some(_),
                ..
            }
        )
    }

    /// Whether calls take time. In lockstep they do not.
    pub(crate) fn is_real(&self) -> bool {
        matches!(self, Self::Real { .. } | Self::Counted(_))
    }
}

/// Converts time of the machine into the application's. Exact at speed 1, the speed on a robot.
fn scaled(time: Duration, speed: f64) -> Nanos {
    if speed == 1.0 {
        time.as_nanos() as Nanos
    } else {
        (time.as_nanos() as f64 * speed) as Nanos
    }
}
