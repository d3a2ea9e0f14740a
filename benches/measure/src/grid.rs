//! The deadlines of schemas of one kind that are woken at the same time (R11). The delays of schemas are
//! measured against these deadlines, and the threads beside them use them too. They follow from the product's
//! rules, not from its code.

use std::time::Duration;

/// The greatest time between the deadlines of two schemas that follow each other.
const STEP: Duration = Duration::from_millis(1);

/// The deadlines of one schema: the first, and then one every period.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// The time of the first deadline since all were woken, ns.
    pub first: u64,
    /// The period, ns.
    pub period: u64,
}

impl Grid {
    /// Returns the grids of schemas with these periods, in the same order.
    pub fn all(periods: &[Duration]) -> Vec<Self> {
        let shortest = periods.iter().min().copied().unwrap_or_default();
        let step = (shortest / periods.len() as u32).min(STEP);
        let grids = periods.iter().zip((0..periods.len() as u32).rev());
        let grid = |(period, after): (&Duration, u32)| Self {
            first: (*period - step * after).as_nanos() as u64,
            period: period.as_nanos() as u64,
        };
        grids.map(grid).collect()
    }

    /// Returns the delays of turns after their deadlines, ns. `woken` is when all schemas were woken, `times`
    /// is when the turns began. The deadline of a turn is the first one after the turn before it. Turns that
    /// follow one before `from` are omitted.
    pub fn late(self, woken: u64, times: &[u64], from: u64) -> Vec<u64> {
        let first = woken + self.first;
        let due = |before: u64| match before.checked_sub(first) {
            Some(since) => first + (since / self.period + 1) * self.period,
            None => first,
        };
        let turns = times.windows(2).filter(|turn| turn[0] >= from);
        // A turn before its deadline had another cause, and is skipped.
        turns
            .filter_map(|turn| turn[1].checked_sub(due(turn[0])))
            .collect()
    }
}

/// Returns how much later than the earliest each event was within its period, ns. The earliest one shows
/// where the grid lies.
pub fn after_the_earliest(times: &[u64], period: u64) -> Vec<f64> {
    let mut places: Vec<u64> = times.iter().map(|time| time % period).collect();
    places.sort_unstable();
    let (Some(first), Some(last)) = (places.first(), places.last()) else {
        return Vec::new();
    };
    // The events lie close together somewhere on the circle of a period: the widest gap precedes the
    // earliest.
    let gaps = places.windows(2).map(|two| (two[1] - two[0], two[1]));
    let around = (first + period - last, *first);
    let (_, earliest) = gaps.fold(around, |widest, gap| if gap.0 > widest.0 { gap } else { widest });
    let late = places.iter().map(|place| (place + period - earliest) % period);
    late.map(|late| late as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_late_by_more_than_a_period_skips_deadlines() {
        let grid = Grid {
            first: 90,
            period: 100,
        };
        // Woken at 1000, so the deadlines are 1090, 1190, 1290 and so on.
        let times = [1001, 1095, 1390, 1391, 1491];
        assert_eq!(grid.late(1000, &times, 0), [5, 200, 1]);
        assert_eq!(grid.late(1000, &times, 1391), [1]);
    }

    #[test]
    fn first_deadlines_are_a_step_apart_and_the_last_is_after_one_period() {
        let ms = Duration::from_millis;
        let firsts = |periods: &[Duration]| {
            Grid::all(periods)
                .iter()
                .map(|grid| grid.first)
                .collect::<Vec<_>>()
        };
        assert_eq!(firsts(&[ms(50), ms(50)]), [49_000_000, 50_000_000]);
        assert_eq!(firsts(&[ms(1), ms(1)]), [500_000, 1_000_000]);
        assert_eq!(firsts(&[ms(1), ms(50)]), [500_000, 50_000_000]);
    }

    #[test]
    fn delays_do_not_depend_on_the_position_of_the_grid() {
        for first in [0, 3, 97] {
            let times = [0, 102, 201, 340, 400].map(|time| first + time);
            let late: Vec<f64> = after_the_earliest(&times, 100);
            assert_eq!(late.iter().sum::<f64>(), 43.0, "{late:?}");
            assert_eq!(late.iter().copied().fold(0.0, f64::max), 40.0);
        }
    }
}
