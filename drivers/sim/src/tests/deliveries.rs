//! When measurements arrive: late, or never; and what a turning laser states of the times of its beams.

use std::collections::BTreeSet;

use super::robots::{awake, drive};
use super::*;

/// A copy of a shipped robot with changed lines, in a folder that lives as long as the value.
fn changed(model: &str, changes: &[(&str, &str)]) -> (TempDir, String) {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("robot.toml");
    let mut text = model.to_owned();
    for (old, new) in changes {
        assert!(text.contains(old), "{old}");
        text = text.replace(old, new);
    }
    fs::write(&path, text).expect("a file");
    let path = path.to_str().expect("a path in UTF-8").to_owned();
    (folder, path)
}

const BURGER: &str = include_str!("../../../../robots/turtlebot3-burger.toml");

#[test]
fn a_late_scan_states_when_it_was_measured_and_shows_the_world_of_then() {
    let (_folder, path) = file(ROOM);
    let (_second, same) = file(ROOM);
    let (_model, late) = changed(
        BURGER,
        &[
            ("rate      = 5\n", "rate = 10\nlatency = 0.12\n"),
            ("ticks_per_mm", "latency = 0.07\nticks_per_mm"),
        ],
    );
    let (_other, prompt) = changed(BURGER, &[("rate      = 5\n", "rate = 10\n")]);
    let (mut late, mut prompt) = (awake(&late, &path), awake(&prompt, &same));
    let (mut scans, mut odometries) = (Vec::new(), Vec::new());
    let mut now = Duration::ZERO;
    for _ in 0..40 {
        for bench in [&mut late, &mut prompt] {
            drive(bench, now, Twist::planar(0.2, 1.0), 1);
        }
        now += PERIOD;
        scans.push(
            prompt
                .exported::<LaserScan>("laser")
                .expect("it measures at once"),
        );
        odometries.push(
            prompt
                .exported::<Odometry>("odometry")
                .expect("it measures at once"),
        );
        match late.exported::<LaserScan>("laser") {
            // 0.12 s after the first one the driver has had its third iteration.
            None => assert!(now < PERIOD + Duration::from_millis(150), "{now:?}"),
            Some(scan) => {
                let measured = Duration::from(scan.header.stamp);
                assert!(
                    now - measured >= Duration::from_millis(120),
                    "{now:?} {measured:?}"
                );
                assert!(
                    now - measured <= Duration::from_millis(250),
                    "{now:?} {measured:?}"
                );
                assert_eq!(late.exported_at("laser"), Some(measured));
                assert!(scans.contains(&scan), "{measured:?}");
            }
        }
        if let Some(odometry) = late.exported::<Odometry>("odometry") {
            let measured = Duration::from(odometry.header.stamp);
            assert_eq!(
                now - measured,
                Duration::from_millis(100),
                "the second iteration after 70 ms"
            );
            assert!(odometries.contains(&odometry));
        }
    }
    assert!(late.exported_at("laser").is_some() && late.exported_at("odometry").is_some());
}

#[test]
fn what_is_on_its_way_to_a_driver_that_sleeps_does_not_arrive() {
    let (_folder, path) = file(ROOM);
    let (_model, late) = changed(BURGER, &[("rate      = 5\n", "latency = 1\n")]);
    let mut bench = awake(&late, &path);
    let now = drive(&mut bench, Duration::ZERO, Twist::ZERO, 10);
    bench.sleep().expect("it stops");
    bench.awake().expect("it is in its world");
    bench.set_now(now + Duration::from_secs(2));
    bench.iterate().expect("it senses");
    assert_eq!(bench.exported_at("laser"), None);
}

#[test]
fn lost_scans_never_arrive() {
    let (_folder, path) = file(ROOM);
    let (_model, model) = changed(BURGER, &[("rate      = 5\n", "dropped = 0.5\n")]);
    let mut bench = awake(&model, &path);
    let mut times = BTreeSet::new();
    let mut now = Duration::ZERO;
    for _ in 0..200 {
        now = drive(&mut bench, now, Twist::ZERO, 1);
        times.extend(bench.exported_at("laser"));
    }
    assert!((70..130).contains(&times.len()), "{}", times.len());
}

#[test]
fn a_turning_laser_states_the_times_of_its_beams() {
    let (_folder, path) = file(ROOM);
    for (direction, sign) in [("counterclockwise", 1.0_f32), ("clockwise", -1.0)] {
        let turning = format!("rate = 5\nturning = '{direction}'\n");
        let (_model, model) = changed(BURGER, &[("rate      = 5\n", &turning)]);
        let mut bench = awake(&model, &path);
        let mut now = Duration::ZERO;
        while bench.exported_at("laser").is_none() {
            now = drive(&mut bench, now, Twist::ZERO, 1);
            assert!(now < Duration::from_secs(1), "no scan");
        }
        let scan: LaserScan = bench.exported("laser").expect("a scan");
        near(f64::from(scan.time_increment), 0.2 / 360.0, 1e-9);
        near(f64::from(scan.scan_time), 0.2, 1e-7);
        assert_eq!(scan.angle_increment.signum(), sign, "{direction}");
        near(
            f64::from(scan.angle_max - scan.angle_min),
            f64::from(sign) * 359.0_f64.to_radians(),
            1e-4,
        );
        let first = Duration::from(scan.header.stamp);
        near((now - first).as_secs_f64(), 0.2 * 359.0 / 360.0, 1e-6);
        assert_eq!(bench.exported_at("laser"), Some(first));
        assert!(scan.points().count() > 200);
    }
}
