//! Measurements in any order and of any numbers.

use core::time::Duration;

use jde_fuse::{Heading, Measurement, Outcome, Place, Position, TimeError, Turn, Wheels};
use proptest::prelude::*;

use crate::drive::{Drive, NOISE, THRESHOLDS, take, timeline};

#[test]
fn a_measurement_that_comes_late_gives_the_same_estimate_as_one_in_time() {
    let mut drive = Drive::new(3);
    drive.around();
    let mut in_time = timeline();
    take(&mut in_time, &drive.log);
    for late_by in [0.02, 0.13, 0.4] {
        let by = Duration::from_secs_f64(late_by);
        let delay = |measurement: &Measurement| match measurement {
            Measurement::Position(_) => by,
            Measurement::Wheels(_) => by / 3,
            _ => Duration::ZERO,
        };
        let end = drive.log.last().expect("measurements").0;
        let mut arriving = drive.log.clone();
        arriving.sort_by_key(|(time, measurement)| (*time + delay(measurement)).min(end));
        assert_ne!(arriving, drive.log);
        let mut late = timeline();
        take(&mut late, &arriving);
        assert_eq!(late.newest(), in_time.newest(), "{late_by} s late");
    }
}

#[test]
fn wheels_that_come_at_the_end_of_the_history_are_compared_with_the_gyro_before_them() {
    let mut drive = Drive::new(12);
    drive.has_fixes = false;
    drive.go(3.0, 0.3, 0.0);
    let end = drive.log.last().expect("measurements").0;
    // All others have gone from the history.
    let first = end - Duration::from_secs(1);
    drive.log.retain(|(time, measurement)| {
        *time < first || *time > first && matches!(measurement, Measurement::Turn(_))
    });
    let mut late = timeline();
    take(&mut late, &drive.log);
    let wheels = Wheels {
        velocity: [0.3, 0.0],
        rate: 1.0,
        covariance: [[1e-4, 0.0, 0.0], [0.0, 1e-6, 0.0], [0.0, 0.0, 4e-4]],
        lasts: Duration::ZERO,
        is_standing: false,
    };
    let outcome = late.add(first, Measurement::Wheels(wheels), &NOISE, &THRESHOLDS);
    assert!(matches!(outcome, Ok(Outcome::Slips(_))), "{outcome:?}");
}

#[test]
fn what_is_older_than_the_history_is_refused_and_changes_nothing() {
    let mut drive = Drive::new(4);
    drive.go(3.0, 0.3, 0.0);
    let mut timeline = timeline();
    take(&mut timeline, &drive.log);
    let before = *timeline.newest().1;
    let (time, oldest) = drive.log[0];
    let refused = timeline.add(time, oldest, &NOISE, &THRESHOLDS);
    assert!(
        matches!(refused, Err(TimeError::TooOld(by)) if by > Duration::from_secs(1)),
        "{refused:?}"
    );
    assert_eq!(*timeline.newest().1, before);
}

fn variance() -> impl Strategy<Value = f64> {
    (-12.0..4.0_f64).prop_map(|power| 10_f64.powf(power))
}

fn measurement() -> impl Strategy<Value = Measurement> {
    let number = || -3.0..3.0;
    prop_oneof![
        (number(), variance()).prop_map(|(rate, variance)| Measurement::Turn(Turn { rate, variance })),
        (number(), variance()).prop_map(|(yaw, variance)| Measurement::Heading(Heading { yaw, variance })),
        (number(), number(), variance(), any::<bool>()).prop_map(|(vx, rate, variance, is_standing)| {
            let covariance = [[variance, 0.0, 0.0], [0.0, variance, 0.0], [0.0, 0.0, variance]];
            let lasts = Duration::from_millis(30);
            Measurement::Wheels(Wheels {
                velocity: [vx, 0.0],
                rate,
                covariance,
                lasts,
                is_standing,
            })
        }),
        (number(), number(), variance(), -0.99..0.99).prop_map(|(x, y, variance, share)| {
            let covariance = [[variance, share * variance], [share * variance, variance]];
            Measurement::Position(Position {
                position: [x, y],
                covariance,
                antenna: [0.3, -0.1],
            })
        }),
        (number(), number(), variance()).prop_map(|(x, yaw, variance)| {
            let covariance = [[variance, 0.0, 0.0], [0.0, variance, 0.0], [0.0, 0.0, variance]];
            Measurement::Place(Place {
                pose: [x, 0.0, yaw],
                covariance,
            })
        }),
    ]
}

proptest! {
    #[test]
    fn the_covariance_stays_symmetric_and_positive(
        steps in proptest::collection::vec((0_u64..400, measurement()), 1..200)
    ) {
        let mut timeline = timeline();
        let mut time = Duration::ZERO;
        for (step, measurement) in steps {
            time += Duration::from_millis(step);
            timeline.add(time, measurement, &NOISE, &THRESHOLDS).expect("in time");
            let filter = timeline.newest().1;
            let covariance = filter.covariance();
            for (row, numbers) in covariance.iter().enumerate() {
                prop_assert!(numbers[row] > 0.0, "{covariance:?}");
                for (column, number) in numbers.iter().enumerate() {
                    prop_assert_eq!(*number, covariance[column][row]);
                    // No correlation is more than 1, but for rounding.
                    let most = covariance[row][row] * covariance[column][column];
                    prop_assert!(number * number <= most * (1.0 + 1e-6), "{:?}", covariance);
                }
            }
        }
    }
}
