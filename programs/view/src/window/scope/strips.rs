//! Searches events by columns of the screen: only the first and the last event of each column are examined.

use std::collections::VecDeque;

use super::axis::Scale;

/// Maximum distance of the pointer from an event, in points.
const HIT_DISTANCE: f32 = 7.0;

/// Calls `each` with the first and last index in each column of `width` points that has visible entries.
pub(super) fn by_column<T>(
    list: &VecDeque<T>,
    time: impl Fn(&T) -> f64,
    scale: &Scale,
    width: f32,
    mut each: impl FnMut(usize, usize),
) {
    let column = f64::from(width) * scale.per_point();
    let mut first = list.partition_point(|item| time(item) <= scale.from);
    while let Some(item) = list.get(first).filter(|item| time(item) <= scale.to) {
        let end = scale.from + (((time(item) - scale.from) / column).floor() + 1.0) * column;
        let before = |place: usize| list.get(place).is_some_and(|item| time(item) < end);
        let (mut last, mut step) = (first, 1);
        while before(last + step) {
            last += step;
            step *= 2;
        }
        while step > 0 {
            if before(last + step) {
                last += step;
            }
            step /= 2;
        }
        each(first, last);
        first = last + 1;
    }
}

/// The index of the entry nearest to a position of the screen, if it is near.
pub(super) fn nearest<T>(
    list: &VecDeque<T>,
    time: impl Fn(&T) -> f64,
    scale: &Scale,
    x: f32,
) -> Option<usize> {
    let after = list.partition_point(|item| time(item) <= scale.time(x));
    let distance = |place: usize| {
        Some((
            list.get(place).map(|item| (scale.x(time(item)) - x).abs())?,
            place,
        ))
    };
    let both = [after.checked_sub(1).and_then(distance), distance(after)];
    let nearest = both.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0))?;
    (nearest.0 <= HIT_DISTANCE).then_some(nearest.1)
}

#[cfg(test)]
mod tests {
    use eframe::egui::Rangef;

    use super::*;

    fn scale(from: f64, to: f64) -> Scale {
        let x = Rangef::new(0.0, 100.0);
        Scale { from, to, x }
    }

    #[test]
    fn entries_of_one_column_are_reported_together() {
        let times: VecDeque<f64> = [-1.0, 0.1, 0.2, 0.3, 5.0, 9.9, 12.0].into();
        let mut found = Vec::new();
        by_column(
            &times,
            |time| *time,
            &scale(0.0, 10.0),
            10.0,
            |first, last| found.push((first, last)),
        );
        assert_eq!(found, [(1, 3), (4, 4), (5, 5)]);
    }

    #[test]
    fn only_an_entry_near_the_position_is_found() {
        let times: VecDeque<f64> = [1.0, 2.0].into();
        let at = |x| nearest(&times, |time| *time, &scale(0.0, 10.0), x);
        assert_eq!(
            [at(4.0), at(14.0), at(16.0), at(26.0), at(28.0)],
            [Some(0), Some(0), Some(1), Some(1), None]
        );
    }
}
