//! Sensors that err, slip or are silent.

use jde_fuse::{Heading, Measurement, Outcome, Place, Position, Turn};

use crate::drive::{Drive, FIX, NOISE, THRESHOLDS, take, timeline};

#[test]
fn an_outlier_and_numbers_that_are_none_change_nothing() {
    let mut drive = Drive::new(5);
    drive.around();
    let mut clean = timeline();
    take(&mut clean, &drive.log);
    let now = clean.newest().0;
    let far = drive.truth.x + 20.0;
    let fix = |x: f64, variance: f64| {
        let covariance = [[variance, 0.0], [0.0, variance]];
        Measurement::Position(Position {
            position: [x, drive.truth.y],
            covariance,
            antenna: [0.0; 2],
        })
    };
    let variance = FIX * FIX;
    let same = [[variance, 0.0, 0.0], [0.0, variance, 0.0], [0.0, 0.0, variance]];
    for (bad, refused) in [
        (fix(far, variance), true),
        (
            Measurement::Turn(Turn {
                rate: 30.0,
                variance: 1e-4,
            }),
            true,
        ),
        (
            Measurement::Heading(Heading {
                yaw: drive.truth.yaw + 2.0,
                variance: 1e-4,
            }),
            true,
        ),
        (
            Measurement::Place(Place {
                pose: [far, 0.0, 0.0],
                covariance: same,
            }),
            true,
        ),
        (fix(f64::NAN, variance), false),
        (fix(f64::INFINITY, variance), false),
        (fix(1e300, variance), false),
        (fix(0.0, -1.0), false),
        // The covariance of the state is larger than this lacks to be positive.
        (fix(drive.truth.x, -1e-9), false),
        (fix(0.0, f64::NAN), false),
        (
            Measurement::Turn(Turn {
                rate: f64::NAN,
                variance: 1e-4,
            }),
            false,
        ),
    ] {
        let mut timeline = clean.clone();
        let outcome = timeline.add(now, bad, &NOISE, &THRESHOLDS).expect("in time");
        assert_eq!(
            matches!(outcome, Outcome::Refused(_)),
            refused,
            "{outcome:?} of {bad:?}"
        );
        assert_eq!(refused, outcome != Outcome::Invalid, "{bad:?}");
        assert_eq!(timeline.newest(), clean.newest(), "{bad:?}");
    }
}

#[test]
fn wheels_that_slip_turn_nothing_while_a_gyro_measures_and_it_is_said() {
    let mut drive = Drive::new(6);
    drive.has_fixes = false;
    drive.go(3.0, 0.0, 0.0);
    drive.go(2.0, 0.3, 0.0);
    drive.slip = 0.6;
    let from = drive.log.len();
    drive.go(4.0, 0.3, 0.0);
    let mut timeline = timeline();
    take(&mut timeline, &drive.log[..from]);
    let outcomes = take(&mut timeline, &drive.log[from..]);
    let slips = outcomes
        .iter()
        .filter(|outcome| matches!(outcome, Outcome::Slips(by) if (by - 0.6).abs() < 0.2));
    assert!(slips.count() > 70);
    let state = timeline.newest().1.state();
    assert!(
        (state.yaw - drive.truth.yaw).abs() < 0.03,
        "{state:?} is not {:?}",
        drive.truth
    );
}

#[test]
fn the_wheels_of_a_base_that_is_turned_by_hand_are_no_standstill() {
    let mut drive = Drive::new(8);
    drive.has_fixes = false;
    drive.go(3.0, 0.0, 0.0);
    let mut timeline = timeline();
    take(&mut timeline, &drive.log);
    let before = *timeline.newest().1;
    drive.log.clear();
    drive.go(4.0, 0.0, 0.5);
    // What the wheels said as they stood.
    let standing = drive
        .log
        .iter_mut()
        .filter_map(|(_, measurement)| match measurement {
            Measurement::Wheels(wheels) => Some(wheels),
            _ => None,
        });
    for wheels in standing {
        (wheels.velocity, wheels.rate, wheels.is_standing) = ([0.0; 2], 0.0, true);
    }
    let outcomes = take(&mut timeline, &drive.log);
    let pushes = outcomes
        .iter()
        .filter(|outcome| matches!(outcome, Outcome::Slips(_) | Outcome::Pushed(_)));
    let pushes = pushes.count();
    assert!(pushes > 70, "{pushes} of 80");
    let state = timeline.newest().1.state();
    assert!((state.bias - before.state().bias).abs() < 0.003, "{state:?}");
    assert!(
        (state.yaw - drive.truth.yaw).abs() < 0.05,
        "{state:?} is not {:?}",
        drive.truth
    );
}

#[test]
fn without_a_gyro_or_without_wheels_the_rest_goes_on_and_the_covariance_grows() {
    let spread = |dead: fn(&Measurement) -> bool| {
        let mut drive = Drive::new(9);
        drive.has_fixes = false;
        drive.around();
        drive
            .log
            .retain(|(time, measurement)| time.as_secs_f64() < 20.0 || !dead(measurement));
        let mut timeline = timeline();
        take(&mut timeline, &drive.log);
        let filter = timeline.newest().1;
        let nees = drive.nees(filter);
        assert!(nees < 16.3, "it knows how much it errs: {nees}");
        let covariance = filter.pose_covariance();
        [covariance[0][0], covariance[2][2]].map(f64::sqrt)
    };
    let all = spread(|_| false);
    let no_gyro = spread(|measurement| matches!(measurement, Measurement::Turn(_)));
    let no_wheels = spread(|measurement| matches!(measurement, Measurement::Wheels(_)));
    assert!(no_gyro[1] > 1.5 * all[1], "{no_gyro:?} {all:?}");
    assert!(no_wheels[0] > 10.0 * all[0], "{no_wheels:?} {all:?}");
}

#[test]
fn a_base_whose_wheels_fell_silent_at_standstill_is_not_known_to_stand() {
    let mut drive = Drive::new(10);
    drive.has_fixes = false;
    drive.go(3.0, 0.0, 0.0);
    let from = drive.log.len();
    drive.go(2.0, 0.0, 0.0);
    let mut timeline = timeline();
    take(&mut timeline, &drive.log[..from]);
    let before = timeline.newest().1.twist_covariance()[0][0].sqrt();
    let mut rest = drive.log.split_off(from);
    rest.retain(|(_, measurement)| matches!(measurement, Measurement::Turn(_)));
    take(&mut timeline, &rest);
    let after = timeline.newest().1.twist_covariance()[0][0].sqrt();
    assert!(before < 0.01 && after > 0.3, "{before} {after}");
}

#[test]
fn wheels_beside_a_gyro_that_measures_too_seldom_count_less() {
    let after = |is_seen: fn(u128) -> bool| {
        let mut drive = Drive::new(11);
        drive.has_fixes = false;
        drive.go(3.0, 0.3, 0.0);
        (drive.log).retain(|(time, measurement)| {
            !matches!(measurement, Measurement::Turn(_)) || is_seen(time.as_millis())
        });
        let mut timeline = timeline();
        take(&mut timeline, &drive.log);
        timeline.newest().1.twist_covariance()[0][0].sqrt()
    };
    let [often, seldom, never] = [
        after(|_| true),
        after(|millis| (millis + 150).is_multiple_of(300)),
        after(|_| false),
    ];
    assert!(
        seldom > 1.5 * often && (never - often).abs() < 0.01,
        "{often} {seldom} {never}"
    );
}
