//! Relates the scanner's clock to the application's, to stamp a scan with the time of its measurement rather
//! than that of its arrival.

use core::time::Duration;

/// The scanner's clock has 24 bits of milliseconds and wraps after about four and a half hours.
const WRAP: u32 = 1 << 24;
/// Assumed limit of the drift between the clocks: 200 ppm, twice that of a cheap crystal.
const DRIFT: f64 = 200e-6;

/// The estimated offset of the scanner's clock.
///
/// A scan is never read before it was measured, so the smallest difference of the clocks so far is the best
/// estimate. It grows by the drift, so that the estimate follows a scanner's clock that runs slow.
#[derive(Debug, Default)]
pub(crate) struct Clock {
    last: Option<Reference>,
}

#[derive(Clone, Copy, Debug)]
struct Reference {
    stamp: u32,
    /// The scanner's time without wraps, s.
    device: f64,
    /// The application's time minus the scanner's, s.
    offset: f64,
    measured: Duration,
}

impl Clock {
    /// Returns the time at which a scan with this stamp, read now, was measured. Never decreases, and never
    /// exceeds `now` unless `now` decreases.
    pub(crate) fn measured(&mut self, stamp: u32, now: Duration) -> Duration {
        let seconds = now.as_secs_f64();
        let last = match self.last {
            None => Reference {
                stamp,
                device: 0.0,
                offset: seconds,
                measured: now,
            },
            Some(last) => {
                let passed = f64::from(stamp.wrapping_sub(last.stamp) % WRAP) / 1000.0;
                let device = last.device + passed;
                let offset = (last.offset + passed * DRIFT).min(seconds - device);
                let measured = Duration::try_from_secs_f64(device + offset).unwrap_or_default();
                Reference {
                    stamp,
                    device,
                    offset,
                    measured: measured.clamp(last.measured, now.max(last.measured)),
                }
            }
        };
        self.last = Some(last);
        last.measured
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn milliseconds(count: u64) -> Duration {
        Duration::from_millis(count)
    }

    #[test]
    fn late_reads_do_not_change_the_measured_time() {
        let mut clock = Clock::default();
        assert_eq!(clock.measured(1000, milliseconds(50)), milliseconds(50));
        for scan in 1..100_u32 {
            let delay = u64::from(scan % 7);
            let measured = clock.measured(
                1000 + scan * 100,
                milliseconds(50 + u64::from(scan) * 100 + delay),
            );
            let error = measured.as_secs_f64() - (0.05 + f64::from(scan) * 0.1);
            assert!(error.abs() < 0.001, "scan {scan} is {error} s off");
        }
    }

    #[test]
    fn time_continues_when_the_clock_of_the_scanner_wraps() {
        let mut clock = Clock::default();
        clock.measured(WRAP - 50, milliseconds(1000));
        let measured = clock.measured(50, milliseconds(1100)).as_secs_f64();
        assert!((measured - 1.1).abs() < 0.001, "{measured}");
    }

    #[test]
    fn measured_times_never_decrease_and_are_never_in_the_future() {
        let mut clock = Clock::default();
        let mut last = Duration::ZERO;
        let stamps = [5, 5, 4, 9_000_000, 0, 100, 90, 16_777_215, 3];
        for (index, stamp) in stamps.into_iter().enumerate() {
            let now = milliseconds(index as u64 * 25);
            let measured = clock.measured(stamp, now);
            assert!(last <= measured && measured <= now);
            last = measured;
        }
    }
}
