//! Stops compared with the formula of the braking distance, and as a property with a simulation in steps of
//! 1 ms.

use core::time::Duration;

use jde_types::{Footprint, Pose2D, Seq};
use proptest::prelude::*;

use super::*;
use crate::Surroundings;

const DYNAMICS: BaseDynamics = BaseDynamics {
    acceleration: 0.5,
    deceleration: 0.5,
    turn_acceleration: 2.0,
    turn_deceleration: 2.0,
    lag: 0.0,
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
        lead: Twist::ZERO,
        wait: 0.0,
        command: Twist::planar(speed, turn),
        hold: 0.2,
        dynamics: DYNAMICS,
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
    let still = BaseDynamics {
        deceleration: 0.0,
        ..DYNAMICS
    };
    let slow = BaseDynamics {
        deceleration: 1e-3,
        ..DYNAMICS
    };
    let unknown = BaseDynamics {
        lag: f64::NAN,
        ..DYNAMICS
    };
    for maneuver in [
        cruise(f64::NAN, 0.0),
        cruise(0.1, f64::INFINITY),
        Maneuver {
            hold: f64::INFINITY,
            ..cruise(0.1, 0.0)
        },
        Maneuver {
            wait: f64::INFINITY,
            ..cruise(0.1, 0.0)
        },
        Maneuver {
            dynamics: still,
            ..cruise(0.1, 0.0)
        },
        Maneuver {
            dynamics: slow,
            ..cruise(0.1, 0.0)
        },
        Maneuver {
            dynamics: unknown,
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

#[test]
fn a_lagging_base_needs_its_lag_times_its_speed_more() {
    let lagging = Maneuver {
        dynamics: BaseDynamics { lag: 0.2, ..DYNAMICS },
        ..cruise(0.5, 0.0)
    };
    let needed = 0.25 + 0.1 + 0.25 + 0.2 * 0.5;
    for (excess, free) in [(0.02, true), (-0.005, false)] {
        let wall = [Point2D {
            x: needed + excess,
            y: 0.0,
        }];
        assert_eq!(
            lagging.stopping(&circle(), &wall, 0.0).is_free(),
            free,
            "{excess} m more"
        );
    }
}

#[test]
fn a_turn_away_is_no_remedy_for_a_base_that_has_not_turned_yet() {
    let wall = [Point2D { x: 0.45, y: 0.15 }];
    let away = |lag| Maneuver {
        command: Twist::planar(1.0, -3.0),
        hold: 0.5,
        dynamics: BaseDynamics {
            turn_acceleration: 25.0,
            turn_deceleration: 25.0,
            deceleration: 4.0,
            lag,
            ..DYNAMICS
        },
        ..cruise(1.0, 0.0)
    };
    assert!(away(0.0).stopping(&circle(), &wall, 0.0).is_free());
    assert!(!away(0.3).stopping(&circle(), &wall, 0.0).is_free());
    let late = Maneuver {
        wait: 0.3,
        ..away(0.0)
    };
    assert!(!late.stopping(&circle(), &wall, 0.0).is_free());
}

#[test]
fn a_robot_that_is_too_close_may_leave_whatever_the_noise_of_its_odometry_is() {
    let judge = |clearance, noise, lag, speed| {
        let mut around = Surroundings {
            velocity: Twist::planar(noise, 0.0),
            footprint: Footprint::circle(0.25),
            reaction: 0.15,
            margin: 0.05,
            dynamics: BaseDynamics { lag, ..DYNAMICS },
            ..Surroundings::default()
        };
        around
            .points
            .push(Point2D {
                x: 0.25 + clearance,
                y: 0.0,
            })
            .expect("a point");
        around.judge(Duration::from_millis(100), &Twist::planar(speed, 0.0))
    };
    for lag in [0.0, 0.2] {
        for noise in [-0.02, 0.0, 0.002, 0.02] {
            assert_eq!(judge(0.02, noise, lag, -0.1), Ok(()), "{noise} m/s, {lag} s");
            assert!(judge(0.02, noise, lag, 0.1).is_err(), "{noise} m/s, {lag} s");
        }
        assert!(judge(0.02, 0.002, lag, 0.02).is_err(), "{lag} s");
        assert_eq!(judge(-0.01, 0.002, lag, -0.1), Ok(()), "{lag} s, in touch");
        assert!(
            judge(0.02, 0.3, lag, -0.1).is_err(),
            "{lag} s: it touches before it leaves"
        );
    }
}

#[test]
fn what_is_touched_permits_no_approach_to_what_is_not() {
    // An edge under the robot, which it leaves by backing toward a wall.
    let judge = |behind: f64| {
        let mut around = Surroundings {
            footprint: Footprint::circle(0.25),
            reaction: 0.15,
            margin: 0.05,
            dynamics: DYNAMICS,
            ..Surroundings::default()
        };
        for x in [0.18, -0.25 - behind] {
            around.points.push(Point2D { x, y: 0.0 }).expect("a point");
        }
        around.judge(Duration::from_millis(50), &Twist::planar(-0.1, 0.0))
    };
    assert!(judge(0.03).is_err(), "nearer than the margin");
    assert!(judge(0.07).is_err(), "it would stop within the margin");
    assert_eq!(judge(0.2), Ok(()), "there is room");
}

/// Whether the outline touches a point in a simulation in steps of 1 ms, with motors as those of the simulator.
fn touches(maneuver: &Maneuver, outline: &Outline, points: &[Point2D]) -> bool {
    const DT: f64 = 1e-3;
    let Maneuver {
        wait, hold, dynamics, ..
    } = *maneuver;
    let linear = (dynamics.acceleration * DT, dynamics.deceleration * DT);
    let limits = [
        linear,
        linear,
        (dynamics.turn_acceleration * DT, dynamics.turn_deceleration * DT),
    ];
    let mut velocity = parts(&maneuver.velocity);
    let strives = core::array::from_fn(|part| velocity[part] + parts(&maneuver.lead)[part]);
    let (mut target, mut pose): ([f64; 3], Pose2D) = (strives, Pose2D::ORIGIN);
    (0..10_000).any(|step| {
        let time = f64::from(step) * DT;
        let goal = if time < wait {
            strives
        } else if time < wait + hold {
            parts(&maneuver.command)
        } else {
            [0.0; 3]
        };
        for part in 0..3 {
            let (gain, loss) = limits[part];
            let (now, goal) = (target[part], goal[part]);
            // A reversal stops at zero.
            let goal = if now * goal < 0.0 { 0.0 } else { goal };
            let most = if goal.abs() < now.abs() { loss } else { gain };
            target[part] = now + (goal - now).clamp(-most, most);
            let kept = if dynamics.lag > 0.0 {
                (-DT / dynamics.lag).exp()
            } else {
                0.0
            };
            velocity[part] = target[part] + (velocity[part] - target[part]) * kept;
        }
        let [x, y, turn] = velocity.map(|part| part * DT);
        let (sin, cos) = (pose.theta + turn / 2.0).sin_cos();
        pose = Pose2D::new(
            pose.x + cos * x - sin * y,
            pose.y + sin * x + cos * y,
            pose.theta + turn,
        );
        outline.clearance(&pose, points) <= 0.0
    })
}

fn twist((x, y, turn): (f64, f64, f64)) -> Twist {
    let mut twist = Twist::planar(x, turn);
    twist.linear.y = y;
    twist
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_stop_that_is_declared_free_never_touches_a_point(
        places in prop::collection::vec((-1.5..2.0, -1.5..1.5), 1..12),
        now in (-0.6..1.0, -0.4..0.4, -1.5..1.5),
        strives in (-0.3..0.3, -0.2..0.2, -0.5..0.5),
        wanted in (-0.6..1.0, -0.4..0.4, -1.5..1.5),
        (wait, hold) in (0.0..0.3, 0.0..0.6),
        lag in prop_oneof![Just(0.0), 0.01..0.5],
        boxed in any::<bool>(),
    ) {
        let points: Vec<Point2D> = places.iter().map(|&(x, y)| Point2D { x, y }).collect();
        let outline = if boxed { long_box() } else { circle() };
        prop_assume!(outline.clearance(&Pose2D::ORIGIN, &points) > 0.0);
        let lead = if lag > 0.0 { twist(strives) } else { Twist::ZERO };
        let dynamics = BaseDynamics { lag, ..DYNAMICS };
        let maneuver = Maneuver { velocity: twist(now), lead, wait, command: twist(wanted), hold, dynamics };
        if maneuver.stopping(&outline, &points, 0.0).is_free() {
            prop_assert!(!touches(&maneuver, &outline, &points), "{:?}", maneuver);
        }
    }

    #[test]
    fn what_the_surroundings_permit_stops_without_contact_whenever_the_command_began(
        places in prop::collection::vec((-1.5..2.0, -1.5..1.5), 1..12),
        now in (-0.6..1.0, -0.4..0.4, -1.5..1.5),
        wanted in (-0.6..1.0, -0.4..0.4, -1.5..1.5),
        (age, lag) in (0.0..0.3, 0.0..0.4),
        began in any::<bool>(),
    ) {
        let dynamics = BaseDynamics { lag, ..DYNAMICS };
        let mut around = Surroundings {
            velocity: twist(now),
            footprint: Footprint::circle(0.25),
            reaction: 0.1,
            dynamics,
            ..Surroundings::default()
        };
        around.points = places.iter().map(|&(x, y)| Point2D { x, y }).collect();
        let points = around.points.as_slice();
        prop_assume!(circle().clearance(&Pose2D::ORIGIN, points) > 0.0);
        let command = twist(wanted);
        if around.judge(Duration::from_secs_f64(age), &command).is_ok() {
            let wait = if began { 0.0 } else { age };
            let hold = around.reaction + age - wait;
            let maneuver = Maneuver { velocity: around.velocity, lead: Twist::ZERO, wait, command, hold, dynamics };
            prop_assert!(!touches(&maneuver, &circle(), points), "{:?}", maneuver);
        }
    }

    #[test]
    fn a_stop_with_three_centimetres_to_spare_is_declared_free(
        places in prop::collection::vec((-1.5..2.0, -1.5..1.5), 1..6), speed in -0.5..0.5, turn in -0.5..0.5,
        lag in 0.0..0.3,
    ) {
        let points: Vec<Point2D> = places.iter().map(|&(x, y)| Point2D { x, y }).collect();
        let wide = Outline::try_from(&Footprint::circle(0.28)).expect("a valid footprint");
        let maneuver = Maneuver { dynamics: BaseDynamics { lag, ..DYNAMICS }, ..cruise(speed, turn) };
        if !touches(&maneuver, &wide, &points) {
            prop_assert!(maneuver.stopping(&circle(), &points, 0.0).is_free(), "{:?}", maneuver);
        }
    }

    #[test]
    fn what_is_touched_permits_no_contact_with_anything_else(
        places in prop::collection::vec((-0.8..0.8, -0.8..0.8), 1..12), depth in 0.0..0.25,
        wanted in (-0.6..0.6, -0.4..0.4, -1.5..1.5), boxed in any::<bool>(),
    ) {
        let outline = if boxed { long_box() } else { circle() };
        let points: Vec<Point2D> = places.iter().map(|&(x, y)| Point2D { x, y }).collect();
        let is_apart = |point: &Point2D| outline.clearance(&Pose2D::ORIGIN, core::slice::from_ref(point)) > SKIN;
        let others: Vec<Point2D> = points.into_iter().filter(is_apart).collect();
        let mut all = others.clone();
        all.push(Point2D { x: 0.25 - depth, y: 0.0 });
        let maneuver = Maneuver { command: twist(wanted), ..cruise(0.0, 0.0) };
        if maneuver.keeps_clear(&outline, &all, 0.05) {
            prop_assert!(!touches(&maneuver, &outline, &others), "{:?}", maneuver);
        }
    }
}
