//! At which rates something was asked for lately. It knows neither who asked nor what it was.

use std::time::{Duration, Instant};

use jde_link::Rate;

/// What nobody asks for any more is let go after so long.
pub(super) const PATIENCE: Duration = Duration::from_secs(2);

/// The rates, each with when it was asked for last.
#[derive(Debug, Default)]
pub(super) struct Wishes(Vec<(Rate, Instant)>);

impl Wishes {
    /// It is wanted so often.
    pub(super) fn ask(&mut self, rate: Rate, now: Instant) {
        match self.0.iter_mut().find(|(wanted, _)| *wanted == rate) {
            Some((_, asked)) => *asked = now,
            None => self.0.push((rate, now)),
        }
    }

    /// Forgets what was not asked for lately; answers with the greatest rate that was. None: nobody wants it any more.
    pub(super) fn greatest(&mut self, now: Instant) -> Option<Rate> {
        self.0
            .retain(|(_, asked)| now.saturating_duration_since(*asked) < PATIENCE);
        self.0.iter().map(|(rate, _)| *rate).max()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_greatest_rate_counts_for_as_long_as_somebody_asks_for_it() {
        let start = Instant::now();
        let mut wishes = Wishes::default();
        wishes.ask(Rate::Hz(5), start);
        wishes.ask(Rate::Hz(50), start);
        assert_eq!(wishes.greatest(start), Some(Rate::Hz(50)));
        let later = start + PATIENCE;
        wishes.ask(Rate::Hz(5), later);
        assert_eq!(wishes.greatest(later), Some(Rate::Hz(5)));
        assert_eq!(wishes.greatest(later + PATIENCE), None);
    }
}
