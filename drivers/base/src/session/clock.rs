//! The clock of a board beside that of this machine.

use core::time::Duration;

/// How much the two may differ: cheap boards have resonators.
const DRIFT: f64 = 0.01;
/// How much sooner than all lines before a line can come, s.
const SOONER: f64 = 2.0;

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
    /// Takes the time of a line that has arrived by `now`, and when the command was sent that it acknowledges first.
    /// `None` if the board's clock went back or leapt ahead: it has started anew.
    pub(super) fn read(
        &mut self,
        milliseconds: u32,
        now: Duration,
        sent: Option<Duration>,
    ) -> Option<LineTime> {
        let (last, board) = self.last.unwrap_or((milliseconds, Duration::ZERO));
        let passed = milliseconds.wrapping_sub(last);
        if passed > u32::MAX / 2 {
            return None;
        }
        let passed = Duration::from_millis(passed.into());
        let board = board + passed;
        let origin = now.as_secs_f64() - board.as_secs_f64();
        let drift = passed.as_secs_f64() * DRIFT;
        if self.origin.is_some_and(|known| known - origin > SOONER + drift) {
            return None;
        }
        self.last = Some((milliseconds, board));
        let first = self.origin.map_or(origin, |known| origin.min(known + drift));
        // It was made after that command was sent: it is no older.
        let first = sent.map_or(first, |sent| first.max(sent.as_secs_f64() - board.as_secs_f64()));
        self.origin = Some(first);
        let age = Duration::try_from_secs_f64(origin - first).unwrap_or_default();
        Some(LineTime { board, age })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_that_starts_anew_after_a_month_is_not_taken_for_one_whose_clock_wraps() {
        let mut clock = Clock::default();
        let ms = Duration::from_millis;
        assert!(clock.read(3_000_000_000, ms(1000), None).is_some());
        assert_eq!(clock.read(20, ms(1020), None), None);
    }

    #[test]
    fn a_line_is_no_older_than_the_command_that_it_acknowledges() {
        let mut clock = Clock::default();
        let ms = Duration::from_millis;
        let mut age =
            |board, now, sent: Option<u64>| clock.read(board, ms(now), sent.map(ms)).map(|time| time.age);
        assert_eq!(age(0, 1000, None), Some(ms(0)));
        // Its clock is slow by a tenth.
        let late = age(900, 2000, None).expect("it goes on");
        assert!(late > ms(85), "{late:?}");
        let known = age(918, 2020, Some(1990)).expect("it goes on");
        assert!(known <= ms(31), "{known:?}");
    }

    #[test]
    fn a_line_that_waited_is_as_old_as_its_wait_and_the_clock_wraps() {
        let mut clock = Clock::default();
        let ms = Duration::from_millis;
        let first = u32::MAX - 20;
        assert_eq!(
            clock.read(first, ms(1000), None).map(|time| time.age),
            Some(ms(0))
        );
        let late = clock
            .read(first.wrapping_add(100), ms(1350), None)
            .expect("it goes on");
        assert_eq!(late.board, ms(100));
        assert!(late.age > ms(240) && late.age < ms(251), "{late:?}");
        assert_eq!(clock.read(first, ms(1400), None), None);
    }
}
