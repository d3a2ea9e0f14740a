//! Bases that stand below some speed, or do not move at all, and what is no fault of the base.

use super::*;

#[test]
fn a_base_that_stands_below_a_speed_docks_at_its_least_one() {
    for (band, least) in [((0.04, 0.08), None), ((0.09, 0.28), Some((0.1, 0.3)))] {
        let mut drive = Drive::from(3.0, 2.6, 0.3);
        drive.dead_band = band;
        if let Some((speed, turn)) = least {
            drive.bench.set("min_speed", speed);
            drive.bench.set("min_turn", turn);
        }
        drive.run();
        assert_eq!(drive.mission().state, Mission::DONE, "{:?}", drive.mission());
        assert!((drive.base.x - 4.5).abs() < 0.01, "{:?}", drive.base);
        assert!(drive.base.theta.abs() < 1_f64.to_radians(), "{:?}", drive.base);
    }
}

#[test]
fn it_gives_up_in_words_what_the_base_does_not_do_until_it_is_brought_elsewhere() {
    for (band, words) in [
        (
            (0.01, 0.2),
            "the base does not turn for 60 s: raise `min_turn`, or free it",
        ),
        (
            (9.0, 9.0),
            "the base does not move for 60 s: raise `min_speed`, or free it",
        ),
    ] {
        let mut drive = Drive::from(4.2, 2.0, 0.05);
        drive.dead_band = band;
        let is_turning = band.0 < 1.0;
        if is_turning {
            drive.base = Pose2D::new(4.5, 2.0, 0.03);
        }
        drive.run();
        let mission = drive.mission();
        assert_eq!((mission.state, mission.note.as_str()), (Mission::FAILED, words));
        let place = drive.base;
        assert!(!drive.step() && drive.base == place, "it stands");
        drive.dead_band = (0.0, 0.0);
        drive.base = Pose2D::new(3.5, 2.0, 0.0);
        drive.run();
        assert_eq!(drive.mission().state, Mission::DONE);
    }
}

#[test]
fn each_time_that_it_docks_its_effort_begins_anew() {
    let mut drive = Drive::from(3.0, 2.0, 0.0);
    drive.bench.set("movement_time_allowance", 10.0);
    for time in 0..6 {
        drive.run();
        assert_eq!(
            drive.mission().state,
            Mission::DONE,
            "{time}: {:?}",
            drive.mission()
        );
        drive.base.x -= 0.3;
    }
}

#[test]
fn while_a_guard_refuses_its_commands_no_time_counts() {
    let mut drive = Drive::from(3.5, 2.0, 0.0);
    (0..20).for_each(|_| assert!(drive.step()));
    // A person stands in the way for 90 s: each half a second it tries again.
    drive.dead_band = (9.0, 9.0);
    for _ in 0..180 {
        drive.now += Duration::from_millis(450);
        assert!(drive.step(), "{:?}", drive.mission());
    }
    drive.dead_band = (0.0, 0.0);
    drive.run();
    assert_eq!(drive.mission().state, Mission::DONE);
}
