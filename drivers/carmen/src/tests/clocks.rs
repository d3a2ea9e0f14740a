//! Logs with faulty clocks, and what is between their records.

use super::*;

#[test]
fn a_clock_that_does_not_advance_is_replaced_by_a_rate() {
    let scan = |x| flaser(&[1.0], (x, 0.0, 0.0), 7.0);
    let mut player = Player::new([scan(0.0), scan(1.0), scan(2.0)].concat());
    player.bench.set("interval", 0.5);
    let mut player = player.awake();
    player.assert_warned(
        "its clock stands still at 7 s; the scans are played 0.5 s apart, or more where the robot went far",
    );
    assert_eq!(player.at(0.0).reached, 1);
    assert_eq!(player.at(0.99).reached, 2);
    let mission = player.at(1.0);
    assert_eq!((mission.state, mission.reached), (Mission::DONE, 3));
}

#[test]
fn a_clock_that_goes_back_is_ignored() {
    let scan = |x, clock| flaser(&[1.0], (x, 0.0, 0.0), clock);
    let mut player = Player::new(
        [
            scan(0.0, 100.0),
            scan(1.0, 102.0),
            scan(2.0, 90.0),
            scan(3.0, 103.0),
        ]
        .concat(),
    )
    .awake();
    assert_eq!(player.at(2.4).reached, 2);
    assert_eq!(player.at(2.5).reached, 3, "between the scans around it");
    assert_eq!(player.at(3.0).state, Mission::DONE);
    player
        .assert_warned("the times of 1 scans contradict those around them, first 90 s after 102 s (line 3)");
}

#[test]
fn a_line_before_the_clock_was_set_does_not_count_from_the_epoch() {
    let scan = |x, clock| flaser(&[1.0], (x, 0.0, 0.0), clock);
    let mut player = Player::new([scan(0.0, 0.0), scan(1.0, 1.1e9), scan(2.0, 1.1e9 + 0.5)].concat()).awake();
    assert_eq!(player.at(0.0).reached, 1);
    assert_eq!(player.at(1.0).state, Mission::DONE);
}

#[test]
fn a_clock_that_leaps_does_not_end_the_log_in_a_century() {
    let clocks = [10.0, 11.0, 12.0, 4.29e9, 4.29e9 + 1.0, 4.29e9 + 2.0];
    let log: String = (clocks.iter().enumerate())
        .map(|(x, clock)| flaser(&[1.0], (x as f64 / 10.0, 0.0, 0.0), *clock))
        .collect();
    let mut player = Player::new(log).awake();
    assert_eq!(player.at(5.0).state, Mission::DONE);
    player.assert_warned("its clock jumps 1 times, first from 12 s to 4290000000 s (line 4)");
}

#[test]
fn the_clock_that_tells_more_counts() {
    let line =
        |x: u32, [sent, logged]: [f64; 2]| format!("FLASER 1 1 0 {x} 0 0 {x} 0 {sent} host {logged}\n");
    for stands_still in [0, 1] {
        let log: String = (0..9)
            .map(|x| {
                let mut clocks = [f64::from(x) / 2.0 + 9.76e8; 2];
                clocks[stands_still] = 0.0;
                line(x, clocks)
            })
            .collect();
        let mut player = Player::new(log).awake();
        assert_eq!(player.at(3.9).reached, 8);
        assert_eq!(player.at(4.0).state, Mission::DONE);
        assert_eq!(player.warnings(), [""; 0]);
    }
}

#[test]
fn odometry_never_belongs_to_the_instant_of_another_scan() {
    // The clock stands still, and after each scan a line repeats its pose, as GMapping writes logs.
    let log: String = (0..5)
        .map(|scan| {
            let x = f64::from(scan) / 10.0;
            let odom = |x: f64| format!("ODOM {x} 0 0 0 0 0 7 host 7\n");
            [flaser(&[1.0], (x, 0.0, 0.0), 7.0), odom(x), odom(x + 0.05)].concat()
        })
        .collect();
    let mut player = Player::new(log).awake();
    for scan in 0..5 {
        let now = f64::from(scan) * 0.2;
        assert_eq!(player.at(now + 1e-6).reached, scan + 1);
        assert_eq!(player.pose().x, f64::from(scan) / 10.0);
        assert_eq!(
            player.bench.exported_at("odometry"),
            player.bench.exported_at("laser")
        );
    }
    player.assert_warned("its clock stands still at 7 s; the scans are played 0.2 s apart");
}

#[test]
fn a_way_that_would_look_like_a_jump_is_interpolated() {
    let log = |seconds| {
        [
            flaser(&[1.0], (0.0, 0.0, 0.0), 1.0),
            flaser(&[1.0], (2.0, 1.0, 2.0), 1.0 + seconds),
        ]
        .concat()
    };
    let mut player = Player::new(log(1.0)).awake();
    player.at(0.5);
    assert!(
        player.pose().distance_to(&Pose2D::new(1.0, 0.5, 1.0)) < 1e-6,
        "{:?}",
        player.pose()
    );
    assert!((player.pose().theta - 1.0).abs() < 1e-6);
    // No robot is so fast: it was carried.
    let mut player = Player::new(log(0.2)).awake();
    player.at(0.1);
    assert_eq!(player.pose().x, 0.0);
}
