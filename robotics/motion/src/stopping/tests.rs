//! Stops compared with the formula of the braking distance, and as a property with a simulation in steps of
//! 1 ms.

use jde_types::{Footprint, Pose2D, Seq};
use proptest::prelude::*;

use super::*;

const LIMITS: Limits = Limits {
    acceleration: 0.5,
    deceleration: 0.5,
    turn_acceleration: 2.0,
    turn_deceleration: 2.0,
};

fn circle() -> Outline {
    Outline::try_from(&Footprint::circle(0.25)).expect("a valid footprint")
}

fn long_box() -> Outline {
    let points = [(0.5, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.5, -0.2)].map(|(x, y)| Point2D { x, y });
    let footprint = Footprint {
        radius: 0.0,
        points: Seq::from_slice(&points).expect("four points"),
    };
    Outline::try_from(&footprint).expect("a valid footprint")
}

fn cruise(speed: f64, turn: f64) -> Maneuver {
    Maneuver {
        velocity: Twist::planar(speed, turn),
        command: Twist::planar(speed, turn),
        hold: 0.2,
        limits: LIMITS,
    }
}

#[test]
fn a_robot_stops_within_the_distance_of_the_formula_and_not_much_less() {
    // 0.2 s at 0.5 m/s, and 0.5² / (2 · 0.5) m of braking, after the radius.
    let needed = 0.25 + 0.1 + 0.25;
    for (excess, free) in [(0.02, true), (-0.005, false)] {
        let wall = [Point2D {
            x: needed + excess,
            y: 0.0,
        }];
        assert_eq!(
            cruise(0.5, 0.0).stopping(&circle(), &wall, 0.0).is_free(),
            free,
            "{excess} m more"
        );
        assert!(
            !cruise(0.5, 0.0).stopping(&circle(), &wall, 0.05).is_free(),
            "with a margin"
        );
    }
}

#[test]
fn a_touch_names_its_point_and_its_time() {
    let points = [Point2D { x: 0.0, y: 3.0 }, Point2D { x: 0.45, y: 0.0 }];
    let Stopping::Touches { after, point } = cruise(0.5, 0.0).stopping(&circle(), &points, 0.0) else {
        panic!("it touches");
    };
    assert_eq!(point, points[1]);
    assert!((0.3..0.5).contains(&after), "{after} s");
}

#[test]
fn a_circle_may_turn_on_the_spot_beside_a_wall_and_a_box_may_not() {
    let wall = [Point2D { x: 0.0, y: 0.26 }, Point2D { x: 0.4, y: 0.3 }];
    assert!(cruise(0.0, 1.0).stopping(&circle(), &wall, 0.0).is_free());
    assert!(!cruise(0.0, 1.0).stopping(&long_box(), &wall, 0.0).is_free());
}

#[test]
fn a_robot_that_stands_still_is_free_even_where_it_touches() {
    let inside = [Point2D::default()];
    assert_eq!(cruise(0.0, 0.0).stopping(&circle(), &inside, 0.0), Stopping::Free);
    assert!(!cruise(0.1, 0.0).stopping(&circle(), &inside, 0.0).is_free());
    assert_eq!(cruise(1.0, 1.0).stopping(&circle(), &[], 0.0), Stopping::Free);
}

#[test]
fn a_command_that_the_base_cannot_follow_yet_counts_with_its_present_speed() {
    let braking = Maneuver {
        command: Twist::ZERO,
        ..cruise(1.0, 0.0)
    };
    let wall = [Point2D { x: 0.9, y: 0.0 }];
    assert!(!braking.stopping(&circle(), &wall, 0.0).is_free());
}

#[test]
fn numbers_that_are_not_finite_and_stops_without_end_are_unknown() {
    let wall = [Point2D { x: 50.0, y: 0.0 }];
    let still = Limits {
        deceleration: 0.0,
        ..LIMITS
    };
    let slow = Limits {
        deceleration: 1e-3,
        ..LIMITS
    };
    for maneuver in [
        cruise(f64::NAN, 0.0),
        cruise(0.1, f64::INFINITY),
        Maneuver {
            hold: f64::INFINITY,
            ..cruise(0.1, 0.0)
        },
        Maneuver {
            limits: still,
            ..cruise(0.1, 0.0)
        },
        Maneuver {
            limits: slow,
            ..cruise(0.1, 0.0)
        },
    ] {
        assert_eq!(
            maneuver.stopping(&circle(), &wall, 0.0),
            Stopping::Unknown,
            "{maneuver:?}"
        );
    }
    assert_eq!(
        cruise(0.1, 0.0).stopping(&circle(), &wall, f64::NAN),
        Stopping::Unknown
    );
}

/// Whether the outline touches a point in a simulation in steps of 1 ms.
fn touches(maneuver: &Maneuver, outline: &Outline, points: &[Point2D]) -> bool {
    let mut travel = Travel {
        velocity: maneuver.velocity,
        ..Travel::default()
    };
    (0..10_000).any(|step| {
        let goal = if f64::from(step) * 1e-3 < maneuver.hold {
            maneuver.command
        } else {
            Twist::ZERO
        };
        travel = travel.after(1e-3, &goal, &maneuver.limits);
        outline.clearance(&travel.pose, points) <= 0.0
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_stop_that_is_declared_free_never_touches_a_point(
        places in prop::collection::vec((-1.5..2.0, -1.5..1.5), 1..12),
        now in (-0.6..1.0, -0.4..0.4, -1.5..1.5),
        wanted in (-0.6..1.0, -0.4..0.4, -1.5..1.5),
        hold in 0.0..0.6,
        boxed in any::<bool>(),
    ) {
        let twist = |(x, y, turn): (f64, f64, f64)| {
            let mut twist = Twist::planar(x, turn);
            twist.linear.y = y;
            twist
        };
        let points: Vec<Point2D> = places.iter().map(|&(x, y)| Point2D { x, y }).collect();
        let outline = if boxed { long_box() } else { circle() };
        prop_assume!(outline.clearance(&Pose2D::ORIGIN, &points) > 0.0);
        let maneuver = Maneuver { velocity: twist(now), command: twist(wanted), hold, limits: LIMITS };
        if maneuver.stopping(&outline, &points, 0.0).is_free() {
            prop_assert!(!touches(&maneuver, &outline, &points), "{:?}", maneuver);
        }
    }

    #[test]
    fn a_stop_with_three_centimetres_to_spare_is_declared_free(
        places in prop::collection::vec((-1.5..2.0, -1.5..1.5), 1..6), speed in -0.5..0.5, turn in -0.5..0.5,
    ) {
        let points: Vec<Point2D> = places.iter().map(|&(x, y)| Point2D { x, y }).collect();
        let wide = Outline::try_from(&Footprint::circle(0.28)).expect("a valid footprint");
        let maneuver = cruise(speed, turn);
        if !touches(&maneuver, &wide, &points) {
            prop_assert!(maneuver.stopping(&circle(), &points, 0.0).is_free(), "{:?}", maneuver);
        }
    }
}
