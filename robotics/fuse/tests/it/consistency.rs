//! Whether the estimate errs as it says.

use core::time::Duration;

use jde_fuse::{Filter, Initial, ProcessNoise, State, Timeline};

use crate::drive::{Drive, INITIAL, NOISE, angle, take, take_with, timeline};

/// What `fuse/ekf` has as its defaults.
const SHIPPED_INITIAL: Initial = Initial {
    position: 0.01,
    yaw: 0.01,
    bias: 0.02,
    way_scale: 0.02,
    turn_scale: 0.1,
    drift: 0.05,
};
const SHIPPED_NOISE: ProcessNoise = ProcessNoise {
    position: 1e-6,
    yaw: 1e-7,
    vx: 0.5,
    vy: 0.01,
    rate: 0.2,
    bias: 1e-7,
    standstill: 0.5,
};

#[test]
fn the_error_of_the_pose_is_what_the_covariance_says_over_a_hundred_drives() {
    for (initial, noise) in [(INITIAL, NOISE), (SHIPPED_INITIAL, SHIPPED_NOISE)] {
        for (has_fixes, least) in [(false, 1.7), (true, 1.9)] {
            let (mut sum, mut bias_sum) = (0.0, 0.0);
            for seed in 0..100 {
                let mut drive = Drive::with(seed, &initial);
                (drive.has_fixes, drive.bias_growth) = (has_fixes, noise.bias);
                drive.around();
                let start = Filter::new(State::default(), &initial);
                let mut timeline = Timeline::new(Duration::ZERO, start, Duration::from_secs(1));
                take_with(&mut timeline, &drive.log, &noise);
                let filter = timeline.newest().1;
                sum += drive.nees(filter);
                bias_sum += ((filter.state().bias - drive.truth.bias) / filter.bias_deviation()).powi(2);
            }
            let (pose, bias) = (sum / 100.0, bias_sum / 100.0);
            // 3 and 1 in the mean; 99.9 % of such means of a hundred are below these bounds. What the base does is smoother
            // than the filter assumes.
            assert!((least..3.9).contains(&pose), "{pose} with fixes: {has_fixes}");
            assert!(bias < 1.55, "{bias} with fixes: {has_fixes}");
        }
    }
}

#[test]
fn the_bias_is_learned_at_standstill_and_the_drift_of_the_wheels_after_it() {
    let mut drive = Drive::new(7);
    (drive.truth.bias, drive.truth.drift, drive.has_fixes) = (0.08, 0.06, false);
    drive.go(3.0, 0.0, 0.0);
    let mut timeline = timeline();
    take(&mut timeline, &drive.log);
    let learned = *timeline.newest().1;
    assert!(
        (learned.state().bias - 0.08).abs() < 0.001,
        "{:?}",
        learned.state()
    );
    assert!(learned.bias_deviation() < 0.001);
    drive.log.clear();
    drive.go(20.0, 0.5, 0.0);
    take(&mut timeline, &drive.log);
    let state = timeline.newest().1.state();
    assert!((state.drift - 0.06).abs() < 0.01, "{state:?}");
    assert!(
        (state.bias - 0.08).abs() < 0.001,
        "wheels that drift do not change it: {state:?}"
    );
    assert!(angle(state.yaw - drive.truth.yaw).abs() < 0.03, "{state:?}");
}
