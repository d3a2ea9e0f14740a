//! The two clocks of R16: real time, at any speed, and virtual time that moves only when it is told to; and for tests of promises
//! about time a third, which is virtual and goes on while calls last.

mod counted;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use jde_core::Nanos;

use counted::Counted;

/// Tells the application's time, ns since its start.
#[derive(Debug)]
pub(crate) enum Clock {
    /// Follows the machine's monotonic clock.
    Real {
        /// When it was 0.
        start: Instant,
        /// Seconds of the application in a second of the machine.
        speed: f64,
    },
    /// Goes on when all threads wait.
    Counted(Counted),
    /// Stands still until it is set.
    Virtual {
        /// What it shows.
        now: AtomicU64,
        /// What it shows has been, and was everybody's time or not.
        past: Option<bool>,
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

    pub(crate) fn standing() -> Self {
        Self::Virtual {
            now: AtomicU64::new(0),
            past: None,
        }
    }

    /// Shows again what a clock has shown once, everybody's or not.
    pub(crate) fn again(everybodys: bool) -> Self {
        Self::Virtual {
            now: AtomicU64::new(0),
            past: Some(everybodys),
        }
    }

    pub(crate) fn now(&self) -> Nanos {
        match self {
            Self::Real { start, speed } => scaled(start.elapsed(), *speed),
            Self::Counted(counted) => counted.now(),
            Self::Virtual { now, .. } => now.load(Ordering::Acquire),
        }
    }

    /// Moves virtual time forward; real time moves by itself.
    pub(crate) fn set(&self, now: Nanos) {
        match self {
            Self::Real { .. } | Self::Counted(_) => {}
            Self::Virtual { now: time, .. } => {
                time.fetch_max(now, Ordering::AcqRel);
            }
        }
    }

    /// Puts virtual time to an instant, also one before the present: what happened to several threads at once is taken again in a
    /// row, each with its own time.
    pub(crate) fn put(&self, now: Nanos) {
        match self {
            Self::Real { .. } | Self::Counted(_) => {}
            Self::Virtual { now: time, .. } => time.store(now, Ordering::Release),
        }
    }

    /// How long to wait on this machine until the application's time is `then`.
    pub(crate) fn until(&self, then: Nanos) -> Duration {
        match self {
            Self::Real { speed, .. } => {
                let time = then.saturating_sub(self.now());
                Duration::from_nanos(if *speed == 1.0 {
                    time
                } else {
                    (time as f64 / speed).ceil() as u64
                })
            }
            Self::Counted(counted) => Duration::from_nanos(then.saturating_sub(counted.now())),
            Self::Virtual { .. } => Duration::ZERO,
        }
    }

    /// Waits for news, or until the application's time is `until`; may come back earlier, as a condition variable may.
    pub(crate) fn wait<'a, T>(
        &self,
        news: &Condvar,
        guard: MutexGuard<'a, T>,
        until: Option<Nanos>,
    ) -> MutexGuard<'a, T> {
        if let Self::Counted(counted) = self {
            return counted.wait(news, guard, until);
        }
        let Some(until) = until else {
            return news.wait(guard).unwrap_or_else(PoisonError::into_inner);
        };
        let waited = news.wait_timeout(guard, self.until(until));
        waited.unwrap_or_else(PoisonError::into_inner).0
    }

    /// A thread that waits by this clock begins. Most clocks need not know.
    pub(crate) fn hire(&self) {
        if let Self::Counted(counted) = self {
            counted.hire();
        }
    }

    /// One ends.
    pub(crate) fn dismiss(&self) {
        if let Self::Counted(counted) = self {
            counted.dismiss();
        }
    }

    /// This thread has something to do: time does not go on by itself before it waits again.
    pub(crate) fn works(&self) {
        if let Self::Counted(counted) = self {
            counted.works();
        }
    }

    /// Lets that much time pass in the middle of a call, where time is counted.
    pub(crate) fn spend(&self, time: Nanos) {
        if let Self::Counted(counted) = self {
            counted.spend(time);
        }
    }

    /// The application's time in which that much passes on this machine.
    pub(crate) fn of_machine(&self, time: Duration) -> Nanos {
        match self {
            Self::Real { speed, .. } => scaled(time, *speed),
            Self::Counted(_) => scaled(time, 1.0),
            Self::Virtual { .. } => 0,
        }
    }

    /// Seconds of the application in a second of the machine; 0 where time stands still during calls.
    pub(crate) fn speed(&self) -> f64 {
        match self {
            Self::Real { speed, .. } => *speed,
            Self::Counted(_) => 1.0,
            Self::Virtual { .. } => 0.0,
        }
    }

    /// Whether a second of the application is one of everybody.
    pub(crate) fn is_everybodys(&self) -> bool {
        match self {
            Self::Real { speed, .. } => *speed == 1.0,
            Self::Counted(_) => false,
            Self::Virtual { past, .. } => past.unwrap_or(false),
        }
    }

    /// Whether what it shows has been before: nobody is late in a replay.
    pub(crate) fn is_past(&self) -> bool {
        matches!(self, Self::Virtual { past: Some(_), .. })
    }

    /// Whether calls take time: in lockstep they do not.
    pub(crate) fn is_real(&self) -> bool {
        matches!(self, Self::Real { .. } | Self::Counted(_))
    }
}

/// That much of the machine's time, in the application's. Exact where both are the same, as they are on a robot.
fn scaled(time: Duration, speed: f64) -> Nanos {
    if speed == 1.0 {
        time.as_nanos() as Nanos
    } else {
        (time.as_nanos() as f64 * speed) as Nanos
    }
}
