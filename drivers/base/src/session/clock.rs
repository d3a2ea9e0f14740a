//! The clock of a board beside that of this machine.

use core::time::Duration;

/// How much the two may differ: cheap boards have resonators.
const DRIFT: f64 = 0.01;

/// Relates them.
#[derive(Debug, Default)]
pub(super) struct Clock {
    /// The board's last time, and the same without wraps.
    last: Option<(u32, Duration)>,
    /// The time of this machine at which the board's was 0, s: by the line that came soonest, because lines wait for each
    /// other where they are late.
    origin: Option<f64>,
}

/// The time of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LineTime {
    /// By the board's clock, without wraps.
    pub(super) board: Duration,
    /// How long ago it was, at least.
    pub(super) age: Duration,
}

impl Clock {
    /// Takes the time of a line that has arrived by `now`. `None` if the board's clock went back: it has started anew.
    pub(super) fn read(&mut self, milliseconds: u32, now: Duration) -> Option<LineTime> {
        let (last, board) = self.last.unwrap_or((milliseconds, Duration::ZERO));
        let passed = milliseconds.wrapping_sub(last);
        if passed > u32::MAX / 2 {
            return None;
        }
        let passed = Duration::from_millis(passed.into());
        let board = board + passed;
        self.last = Some((milliseconds, board));
        let origin = now.as_secs_f64() - board.as_secs_f64();
        let known = self.origin.map(|known| known + passed.as_secs_f64() * DRIFT);
        let first = known.map_or(origin, |known| known.min(origin));
        self.origin = Some(first);
        let age = Duration::try_from_secs_f64(origin - first).unwrap_or_default();
        Some(LineTime { board, age })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_waited_is_as_old_as_its_wait_and_the_clock_wraps() {
        let mut clock = Clock::default();
        let ms = Duration::from_millis;
        let first = u32::MAX - 20;
        assert_eq!(clock.read(first, ms(1000)).map(|time| time.age), Some(ms(0)));
        let late = clock.read(first.wrapping_add(100), ms(1350)).expect("it goes on");
        assert_eq!(late.board, ms(100));
        assert!(late.age > ms(240) && late.age < ms(251), "{late:?}");
        assert_eq!(clock.read(first, ms(1400)), None);
    }
}
