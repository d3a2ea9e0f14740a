//! Converts between the application's time, which starts with it, and that of ROS 2, which is wall-clock
//! time or that of a simulation. It reads no clock: both are arguments.

use core::time::Duration;

use jde_types::Time;

/// Drift, ns, beyond which the offset is updated. Below it the stamps of one instant stay equal; an adjusted
/// clock exceeds it.
const MAX_DRIFT: i128 = 1_000_000;
/// Difference, ns, beyond which the clocks of the two machines are not the same, or the other side uses
/// simulated time.
const MAX_DIFFERENCE: i128 = 10_000_000_000;
/// What stands for times before the application's start, ns: a stamp of 0 is none.
const EARLIEST_STAMP: i128 = 1;

/// The time of ROS 2 at the application's start, ns, and the newest that was compared.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock {
    offset: Option<i128>,
    newest: Duration,
}

/// The time at which a message was measured, in the application's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measured {
    /// From its stamp.
    At(Duration),
    /// From its arrival, because its stamp differs by this many seconds; negative if the stamp is earlier.
    OnArrival(Duration, f64),
}

impl Clock {
    /// Compares the two clocks. Called regularly, such as once per iteration. Returns whether the time of ROS 2 has
    /// gone back.
    pub fn compare(&mut self, now: Duration, time: Duration) -> bool {
        let offset = nanos(time) - nanos(now);
        if self
            .offset
            .is_none_or(|previous| (previous - offset).abs() > MAX_DRIFT)
        {
            self.offset = Some(offset);
        }
        core::mem::replace(&mut self.newest, time) > time
    }

    /// Whether the clocks were compared.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.offset.is_some()
    }

    /// Converts a stamp of ROS 2 to the application's time; one before its start to
    /// 1 ns.
    #[must_use]
    pub fn time(&self, stamp: Time) -> Duration {
        let time = stamp_nanos(stamp) - self.offset.unwrap_or(0);
        Duration::from_nanos(u64::try_from(time.max(EARLIEST_STAMP)).unwrap_or(u64::MAX))
    }

    /// Converts the application's time to a stamp of ROS 2.
    pub fn stamp(&self, time: Duration) -> Time {
        let wall = nanos(time) + self.offset.unwrap_or(0);
        Time::from(Duration::from_nanos(u64::try_from(wall).unwrap_or(0)))
    }

    /// Returns when a message with this stamp and arrival was measured; never after its arrival.
    pub fn measured(&self, stamp: Time, arrived: Duration) -> Measured {
        let difference = stamp_nanos(stamp) - self.offset.unwrap_or(0) - nanos(arrived);
        if difference.abs() > MAX_DIFFERENCE {
            return Measured::OnArrival(arrived, difference as f64 / 1e9);
        }
        let time = (nanos(arrived) + difference.min(0)).max(EARLIEST_STAMP);
        Measured::At(Duration::from_nanos(u64::try_from(time).unwrap_or(0)))
    }
}

fn stamp_nanos(stamp: Time) -> i128 {
    i128::from(stamp.sec) * 1_000_000_000 + i128::from(stamp.nanosec)
}

fn nanos(time: Duration) -> i128 {
    i128::try_from(time.as_nanos()).unwrap_or(i128::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALL: Duration = Duration::from_secs(1_700_000_000);

    fn clock() -> Clock {
        let mut clock = Clock::default();
        clock.compare(Duration::from_secs(10), WALL + Duration::from_secs(10));
        clock
    }

    #[test]
    fn a_stamp_converts_back_to_the_same_time() {
        let time = Duration::from_millis(12_345);
        let stamp = clock().stamp(time);
        assert_eq!((stamp.sec, stamp.nanosec), (1_700_000_012, 345_000_000));
        assert_eq!(
            clock().measured(stamp, Duration::from_secs(13)),
            Measured::At(time)
        );
    }

    #[test]
    fn time_that_goes_back_is_noticed_once() {
        let mut clock = Clock::default();
        assert!(!clock.is_known());
        let at = Duration::from_secs;
        let back: Vec<bool> = [(1, 50), (2, 51), (3, 2), (4, 3)]
            .into_iter()
            .map(|(now, time)| clock.compare(at(now), at(time)))
            .collect();
        assert_eq!(back, [false, false, true, false]);
        assert_eq!(clock.time(Time { sec: 5, nanosec: 0 }), at(6));
        assert_eq!(clock.time(Time { sec: -5, nanosec: 0 }), Duration::from_nanos(1));
    }

    #[test]
    fn measurement_times_are_limited_to_the_start_and_the_arrival() {
        let stamp = clock().stamp(Duration::from_secs(15));
        assert_eq!(
            clock().measured(stamp, Duration::from_secs(14)),
            Measured::At(Duration::from_secs(14))
        );
        let before = Time {
            sec: 1_699_999_999,
            nanosec: 0,
        };
        assert_eq!(
            clock().measured(before, Duration::from_secs(1)),
            Measured::At(Duration::from_nanos(1))
        );
    }

    #[test]
    fn a_stamp_of_another_clock_is_replaced_by_the_arrival() {
        let arrived = Duration::from_secs(20);
        let Measured::OnArrival(time, difference) = clock().measured(Time { sec: 5, nanosec: 0 }, arrived)
        else {
            panic!("simulated time must not be used");
        };
        assert_eq!(time, arrived);
        assert!((difference + 1_700_000_015.0).abs() < 1e-3, "{difference}");
        let extreme = Time {
            sec: i32::MIN,
            nanosec: u32::MAX,
        };
        assert!(matches!(
            clock().measured(extreme, arrived),
            Measured::OnArrival(..)
        ));
    }

    #[test]
    fn small_differences_leave_stamps_equal_and_an_adjusted_clock_is_followed() {
        let mut clock = clock();
        let stamp = clock.stamp(Duration::from_secs(11));
        clock.compare(Duration::from_secs(12), WALL + Duration::from_micros(12_000_300));
        assert_eq!(clock.stamp(Duration::from_secs(11)), stamp);
        clock.compare(Duration::from_secs(13), WALL + Duration::from_secs(14));
        assert_eq!(clock.stamp(Duration::from_secs(11)).sec, stamp.sec + 1);
    }
}
