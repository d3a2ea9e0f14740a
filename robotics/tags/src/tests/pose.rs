//! Poses from corners.

use core::f64::consts::TAU;

use proptest::prelude::*;

use super::scene::{Placed, SIZE, camera};
use crate::Family;

fn placed() -> impl Strategy<Value = Placed> {
    (-0.4..0.4, -0.3..0.3, 0.3..2.0, 0.0..TAU, -1.2..1.2, -1.2..1.2).prop_map(
        |(x, y, distance, roll, pitch, yaw)| Placed {
            family: Family::Tag36h11,
            id: 0,
            position: [x * distance, y * distance, distance],
            turns: [roll, pitch, yaw],
        },
    )
}

/// Returns whether a tag shows its front.
fn is_visible(placed: &Placed) -> bool {
    let z = placed.axes()[2];
    (0..3).map(|index| z[index] * placed.position[index]).sum::<f64>() > 0.2 * placed.position[2]
}

proptest! {
    #[test]
    fn exact_corners_give_the_exact_pose(placed in placed().prop_filter("visible", is_visible)) {
        let pose = camera().pose(&placed.corners(), SIZE).expect("the corners have a pose");
        for (found, is) in pose.position.iter().zip(placed.position) {
            prop_assert!((found - is).abs() < 1e-4, "{:?} is not {:?}", pose, placed.position);
        }
        for (found, is) in pose.axes.as_flattened().iter().zip(placed.axes().as_flattened()) {
            prop_assert!((found - is).abs() < 2e-3, "{:?} is not {:?}", pose, placed.axes());
        }
    }
}

#[test]
fn corners_without_a_pose_have_none() {
    let camera = camera();
    assert_eq!(camera.pose(&[[5.0, 5.0]; 4], SIZE), None);
    assert_eq!(
        camera.pose(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]], SIZE),
        None
    );
    assert_eq!(camera.pose(&[[f64::NAN; 2]; 4], SIZE), None);
    let square = [[100.0, 200.0], [200.0, 200.0], [200.0, 100.0], [100.0, 100.0]];
    assert_eq!(camera.pose(&square, 0.0), None, "without a size");
    assert_eq!(camera.pose(&square, f64::NAN), None);
    assert!(camera.pose(&square, SIZE).is_some());
}

#[test]
fn a_small_tag_is_ambiguous_and_a_large_one_is_not() {
    let tilted = |distance: f64| Placed {
        family: Family::Tag36h11,
        id: 0,
        position: [0.0, 0.0, distance],
        turns: [0.0, 0.6, 0.0],
    };
    // A quarter of a pixel at one corner, as a detector errs.
    let ambiguity = |distance: f64| {
        let mut corners = tilted(distance).corners();
        corners[0][0] += 0.25;
        camera()
            .pose(&corners, SIZE)
            .expect("the corners have a pose")
            .ambiguity
    };
    assert!(ambiguity(0.4) < 0.1, "{}", ambiguity(0.4));
    assert!(ambiguity(6.0) > 0.5, "{}", ambiguity(6.0));
}
