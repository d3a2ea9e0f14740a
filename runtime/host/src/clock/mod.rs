//! The two clocks of R16: real time, at any speed, and virtual time, which advances only when it is set. A
//! third is for tests of timing guarantees: it is virtual and advances while calls last.

mod counted;
mod standstill;

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use jde_core::Nanos;
use parking_lot::{Condvar, MutexGuard};

use counted::Counted;
use standstill::Standstill;

/// The application's time, ns since its start.
#[derive(Debug)]
pub(crate) enum Clock {
    /// Follows the machine's monotonic clock, which also counts while the machine is suspended: what was measured before
    /// is old after it.
    Real {
        /// The time of that clock at time 0.
        start: Duration,
        /// Seconds of the application in a second of the machine.
        speed: f64,
        /// Present if time may stand still.
        standstill: Option<Standstill>,
    },
    /// Advances when all threads wait.
    Counted(Counted),
    /// Advances only when it is set.
    Virtual {
        /// The current time.
        now: AtomicU64,
        /// Whether it repeats a recorded clock.
        is_replayed: bool,
        /// Present if time may stand still.
        standstill: Option<Standstill>,
    },
}

/// The time that passes in one step of an application whose time stands still, in real time, ns: that of a
/// step of the simulator.
const STANDSTILL_STEP: Nanos = 10_000_000;

impl Clock {
    pub(crate) fn real(speed: f64) -> Self {
        Self::Real {
            start: boot_time(),
            speed,
            standstill: None,
        }
    }

    /// Permits time to stand still.
    pub(crate) fn with_standstill(mut self) -> Self {
        match &mut self {
            Self::Real { standstill, .. } | Self::Virtual { standstill, .. } => {
                *standstill = Some(Standstill::default())
            }
            Self::Counted(_) => {}
        }
        self
    }

    pub(crate) fn counted() -> Self {
        Self::Counted(Counted::default())
    }

    pub(crate) fn new_virtual() -> Self {
        Self::Virtual {
            now: AtomicU64::new(0),
            is_replayed: false,
            standstill: None,
        }
    }

    /// Repeats the times of a recorded clock.
    pub(crate) fn replayed() -> Self {
        Self::Virtual {
            now: AtomicU64::new(0),
            is_replayed: true,
            standstill: None,
        }
    }

    pub(crate) fn now(&self) -> Nanos {
        match self {
            Self::Real {
                start,
                speed,
                standstill,
            } => {
                let running = || scaled(boot_time().saturating_sub(*start), *speed);
                match standstill {
                    Some(standstill) => standstill.now(running),
                    None => running(),
                }
            }
            Self::Counted(counted) => counted.now(),
            Self::Virtual { now, .. } => now.load(Ordering::Acquire),
        }
    }

    /// Lets time stand still, for this reason, if that is permitted. Nothing becomes due meanwhile. Returns
    /// whether time passed until now.
    pub(crate) fn stand_still(&self, reason: &str) -> bool {
        self.standstill()
            .is_some_and(|standstill| standstill.stop(|| self.now(), reason))
    }

    /// Returns why time stands still; `None` while it passes.
    pub(crate) fn standstill_reason(&self) -> Option<String> {
        self.standstill()?.reason()
    }

    /// Whether time stands still.
    pub(crate) fn is_still(&self) -> bool {
        self.standstill().is_some_and(Standstill::is_still)
    }

    /// Lets time pass again.
    pub(crate) fn go_on(&self) {
        match self {
            Self::Real {
                start,
                speed,
                standstill: Some(standstill),
            } => standstill.go_on(|| scaled(boot_time().saturating_sub(*start), *speed)),
            Self::Virtual {
                now,
                standstill: Some(standstill),
                ..
            } => standstill.go_on(|| now.load(Ordering::Acquire)),
            Self::Real { .. } | Self::Virtual { .. } | Self::Counted(_) => {}
        }
    }

    /// Lets a little time pass while it stands still otherwise. Virtual time is advanced by its executor,
    /// which waits for this in [`Self::wait_while_still`].
    pub(crate) fn step(&self) {
        match self {
            Self::Real {
                standstill: Some(standstill),
                ..
            } => standstill.step(STANDSTILL_STEP),
            Self::Virtual {
                standstill: Some(standstill),
                ..
            } => standstill.request_step(),
            Self::Real { .. } | Self::Virtual { .. } | Self::Counted(_) => {}
        }
    }

    /// Waits while time stands still, at most for `timeout` on this machine. Returns whether a step of
    /// virtual time is requested.
    pub(crate) fn wait_while_still(&self, timeout: Duration) -> bool {
        self.standstill()
            .is_some_and(|standstill| standstill.wait(timeout))
    }

    fn standstill(&self) -> Option<&Standstill> {
        match self {
            Self::Real { standstill, .. } | Self::Virtual { standstill, .. } => standstill.as_ref(),
            Self::Counted(_) => None,
        }
    }

    /// Advances virtual time; real time advances by itself.
    pub(crate) fn advance_to(&self, now: Nanos) {
        match self {
            Self::Real { .. } | Self::Counted(_) => {}
            // One thread at a time sets it.
            Self::Virtual { now: time, .. } if time.load(Ordering::Relaxed) < now => {
                time.store(now, Ordering::Release);
            }
            Self::Virtual { .. } => {}
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
    pub(crate) fn wait<T>(&self, condition: &Condvar, guard: &mut MutexGuard<'_, T>, until: Option<Nanos>) {
        if let Self::Counted(counted) = self {
            return counted.wait(condition, guard, until);
        }
        let Some(until) = until else {
            return condition.wait(guard);
        };
        condition.wait_for(guard, self.duration_until(until));
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

    /// Returns how much of the application's time has passed on this machine since an instant; 0 where its time does not
    /// follow the machine's.
    pub(crate) fn since(&self, instant: Instant) -> Nanos {
        match self {
            Self::Real { speed, .. } => scaled(instant.elapsed(), *speed),
            Self::Counted(_) | Self::Virtual { .. } => 0,
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

    /// Whether a second of the application is always a second of wall-clock time, as devices need it. Not in a replay.
    pub(crate) fn has_wall_clock_speed(&self) -> bool {
        match self {
            Self::Real {
                speed, standstill, ..
            } => *speed == 1.0 && standstill.is_none(),
            Self::Counted(_) | Self::Virtual { .. } => false,
        }
    }

    /// Whether the clock repeats a recorded time, in which no turn is late.
    pub(crate) fn is_replayed(&self) -> bool {
        matches!(
            self,
            Self::Virtual {
                is_replayed: true,
                ..
            }
        )
    }

    /// Whether calls take time. In lockstep they do not.
    pub(crate) fn is_real(&self) -> bool {
        matches!(self, Self::Real { .. } | Self::Counted(_))
    }
}

/// The time since the machine started, suspended or not.
fn boot_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::Boottime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// Converts time of the machine into the application's. Exact at speed 1, the speed on a robot.
fn scaled(time: Duration, speed: f64) -> Nanos {
    if speed == 1.0 {
        time.as_nanos() as Nanos
    } else {
        (time.as_nanos() as f64 * speed) as Nanos
    }
}
