//! Keep-out zones: stated, drawn on the panel, around the robot and around the target.

use jde_schema::types::{Point2D, Zone};

use super::*;

/// A room of 2 × 1 m without walls.
pub(super) const OPEN_ROOM: [&str; 10] = ["...................."; 10];

/// From the lower edge to 0.6 m, in the middle between `LEFT_POINT` and `RIGHT_POINT`.
const MIDDLE: [(f64, f64); 4] = [(0.9, -0.1), (1.2, -0.1), (1.2, 0.6), (0.9, 0.6)];

fn zones(zones: &[&[(f64, f64)]]) -> Zones {
    let zone = |corners: &&[(f64, f64)]| Zone {
        corners: corners.iter().map(|&(x, y)| Point2D { x, y }).collect(),
    };
    Zones {
        zones: zones.iter().map(zone).collect(),
    }
}

pub(super) fn click(bench: &mut Bench<Plan>, corners: &[(f64, f64)]) {
    for &(x, y) in corners {
        let at = [x, y, 0.0];
        let button = Button::Primary;
        bench
            .touch("map", Touch::Clicked { at, button })
            .expect("a click");
    }
}

pub(super) fn press(bench: &mut Bench<Plan>, button: &str) {
    bench.touch(button, Touch::Pressed).expect("a press");
}

/// How many points of the path, at most 1 cm apart, are within a rectangle that is `margin` wider on each side.
fn within(poses: &[Pose2D], (least, most): ((f64, f64), (f64, f64)), margin: f64) -> usize {
    let along = |pair: &[Pose2D]| {
        let (a, b) = (pair[0], pair[1]);
        let steps = (a.distance_to(&b) / 0.01).ceil() as usize + 1;
        (0..=steps).map(move |step| {
            let share = step as f64 / steps as f64;
            (a.x + share * (b.x - a.x), a.y + share * (b.y - a.y))
        })
    };
    let inside = |&(x, y): &(f64, f64)| {
        least.0 - margin < x && x < most.0 + margin && least.1 - margin < y && y < most.1 + margin
    };
    poses.windows(2).flat_map(along).filter(inside).count()
}

#[test]
fn every_planner_leads_around_a_zone_at_the_inscribed_radius() {
    for planner in [Planner::Gradient, Planner::Grid, Planner::AnyAngle] {
        let mut bench = bench(&map(&OPEN_ROOM), LEFT_POINT, RIGHT_POINT);
        bench.set("planner", planner);
        bench.set("keep_out", zones(&[&MIDDLE]));
        assert!(state(&mut bench).starts_with("a path of "), "{planner:?}");
        let poses = poses(&bench).expect("a path");
        // Half a cell less, because cells are in the zone or not.
        assert_eq!(within(&poses, (MIDDLE[0], MIDDLE[2]), 0.05), 0, "{poses:?}");
    }
}

#[test]
fn a_zone_that_is_stated_later_changes_the_path_and_one_that_goes_restores_it() {
    let mut bench = bench(&map(&OPEN_ROOM), LEFT_POINT, RIGHT_POINT);
    let straight = state(&mut bench);
    bench.set("keep_out", zones(&[&MIDDLE]));
    assert_ne!(state(&mut bench), straight);
    let across = [(0.9, -0.1), (1.2, -0.1), (1.2, 1.1), (0.9, 1.1)];
    bench.set("keep_out", zones(&[&MIDDLE, &across]));
    assert_eq!(
        state(&mut bench),
        "no way leads to the goal outside the keep-out zones"
    );
    assert_eq!(poses(&bench), None, "the path is retracted");
    bench.set("keep_out", Zones::EMPTY);
    assert_eq!(state(&mut bench), straight);
}

#[test]
fn an_operator_draws_zones_by_clicks_and_clears_them() {
    let mut bench = bench(&map(&OPEN_ROOM), LEFT_POINT, RIGHT_POINT);
    let straight = state(&mut bench);
    click(&mut bench, &MIDDLE[..2]);
    press(&mut bench, "zone");
    click(&mut bench, &MIDDLE[2..]);
    assert_eq!(state(&mut bench), straight, "it is not complete");
    press(&mut bench, "zone");
    let drawn = bench.log().last().expect("a message").1.clone();
    let in_a_file = "{ corners = [[0.90, -0.10], [1.20, -0.10], [1.20, 0.60], [0.90, 0.60]] }";
    assert!(drawn.ends_with(in_a_file), "{drawn}");
    let around = state(&mut bench);
    assert_ne!(around, straight);
    click(&mut bench, &[(0.1, 0.1), (0.2, 0.1), (0.2, 0.2)]);
    press(&mut bench, "discard");
    press(&mut bench, "zone");
    assert_eq!(state(&mut bench), around, "the discarded corners are no zone");
    press(&mut bench, "clear");
    assert_eq!(state(&mut bench), straight);
}

#[test]
fn more_corners_and_zones_than_fit_are_refused_in_words() {
    let mut bench = bench(&map(&OPEN_ROOM), LEFT_POINT, RIGHT_POINT);
    bench.set("keep_out", zones(&[&MIDDLE]));
    for _ in 0..16 {
        click(&mut bench, &MIDDLE);
        press(&mut bench, "zone");
    }
    let full = |bench: &Bench<Plan>, words: &str| {
        bench
            .log()
            .last()
            .is_some_and(|(_, text)| text.starts_with(words))
    };
    assert!(full(&bench, "there is no room for another keep-out zone"));
    assert!(state(&mut bench).starts_with("a path of "), "16 count");
    bench.set("keep_out", zones(&[&MIDDLE, &MIDDLE]));
    assert_eq!(
        state(&mut bench),
        "there are more than 16 keep-out zones: clear what is drawn, or state fewer"
    );
    click(&mut bench, &[(0.5, 0.5); 33]);
    assert!(full(&bench, "there is no room for another point"));
}

#[test]
fn a_reload_keeps_what_is_drawn() {
    let mut first = bench(&map(&OPEN_ROOM), LEFT_POINT, RIGHT_POINT);
    click(&mut first, &MIDDLE);
    press(&mut first, "zone");
    click(&mut first, &MIDDLE[..2]);
    let saved = first.save().expect("it saves");
    let mut second = bench(&map(&OPEN_ROOM), LEFT_POINT, RIGHT_POINT);
    second.restore(&saved).expect("it restores");
    assert_eq!(state(&mut second), state(&mut first));
    assert_eq!(second.schema().drawn.points.corners.len(), 2);
}

#[test]
fn a_robot_in_a_zone_is_led_out_around_the_walls_in_it() {
    let around = [(0.3, -0.1), (2.1, -0.1), (2.1, 0.9), (0.3, 0.9)];
    for planner in [Planner::Gradient, Planner::Grid, Planner::AnyAngle] {
        let mut bench = bench(&map(&ROOM), (1.35, 0.25), (0.15, 0.15));
        bench.set("inscribed_radius", 0.0);
        bench.set("circumscribed_radius", 0.05);
        bench.set("planner", planner);
        bench.set("keep_out", zones(&[&around]));
        let words = state(&mut bench);
        assert!(words.starts_with("a path of "), "{words}");
        let poses = poses(&bench).expect("a path");
        assert_eq!((poses[0].x, poses[0].y), (1.35, 0.25));
        assert_eq!(within(&poses, ((1.0, 0.0), (1.1, 0.7)), 0.0), 0, "{poses:?}");
        // It leaves the zone over its upper edge, which is the nearest by way.
        assert!(poses.iter().any(|pose| pose.y > 0.9), "{poses:?}");
    }
}

#[test]
fn a_robot_at_the_edge_of_a_zone_goes_on_outside() {
    let mut bench = bench(&map(&OPEN_ROOM), (0.95, 0.55), RIGHT_POINT);
    bench.set("keep_out", zones(&[&MIDDLE]));
    assert!(state(&mut bench).starts_with("a path of "));
    let poses = poses(&bench).expect("a path");
    assert!(poses[1].distance_to(&poses[0]) < 0.3, "out first: {poses:?}");
}

#[test]
fn a_zone_without_a_way_out_and_a_target_in_a_zone_are_said() {
    let all = [(-1.0, -1.0), (3.0, -1.0), (3.0, 2.0), (-1.0, 2.0)];
    let right = [(1.3, -0.1), (2.1, -0.1), (2.1, 0.5), (1.3, 0.5)];
    let left = [(-0.1, -0.1), (0.8, -0.1), (0.8, 1.1), (-0.1, 1.1)];
    let mut bench = bench(&map(&OPEN_ROOM), LEFT_POINT, RIGHT_POINT);
    bench.set("keep_out", zones(&[&right]));
    assert_eq!(state(&mut bench), "the goal is in a keep-out zone");
    bench.set("tolerance", 0.5);
    assert!(state(&mut bench).starts_with("a path of "), "it may end before");
    bench.set("tolerance", 0.0);
    bench.set("keep_out", zones(&[&all]));
    assert_eq!(state(&mut bench), "the goal is in a keep-out zone");
    let mut bench = super::bench(
        &map(&[
            "....................",
            "####################",
            "....................",
        ]),
        (0.55, 0.25),
        RIGHT_POINT,
    );
    bench.set("inscribed_radius", 0.0);
    bench.set("target", Target::at(Pose2D::new(1.55, 0.05, 0.0)));
    bench.set(
        "keep_out",
        zones(&[&[(-1.0, 0.2), (3.0, 0.2), (3.0, 1.0), (-1.0, 1.0)], &left]),
    );
    assert_eq!(
        state(&mut bench),
        "no way leads the robot out of the keep-out zone"
    );
}

#[test]
fn zones_that_enclose_nothing_are_refused_before_the_start_and_while_it_runs() {
    let mut bench = bench(&map(&OPEN_ROOM), LEFT_POINT, RIGHT_POINT);
    for (wrong, words) in [
        (
            zones(&[&MIDDLE, &MIDDLE[..2]]),
            "keep-out zone 2 has 2 points: give it 3 or more",
        ),
        (
            zones(&[&[(0.0, 0.0), (1.0, 0.0), (0.0, 1e300)]]),
            "keep-out zone 1 has a point at (0, 1",
        ),
    ] {
        bench.set("keep_out", wrong);
        let problems = bench.inspect().expect("it inspects");
        assert_eq!(problems[0].modulation, "keep_out");
        assert!(problems[0].words.starts_with(words), "{}", problems[0].words);
        assert!(state(&mut bench).starts_with(words));
        assert_eq!(poses(&bench), None);
    }
    bench.set("keep_out", zones(&[&MIDDLE]));
    assert!(bench.inspect().expect("it inspects").is_empty());
    assert!(state(&mut bench).starts_with("a path of "), "it recovers");
}

#[test]
fn the_panel_shows_zones_and_the_corners_of_the_next() {
    let mut bench = bench(&map(&ROOM), LEFT_POINT, RIGHT_POINT);
    state(&mut bench);
    let before = bench.draw().expect("the panel is drawn").shapes("map").len();
    bench.set("keep_out", zones(&[&MIDDLE]));
    click(&mut bench, &MIDDLE);
    press(&mut bench, "zone");
    state(&mut bench);
    let after = bench.draw().expect("the panel is drawn");
    assert_eq!(after.shapes("map").len(), before + 2);
}

#[test]
fn what_is_in_force_is_exported_without_a_target_too() {
    let mut bench = bench(&map(&OPEN_ROOM), LEFT_POINT, RIGHT_POINT);
    bench.set("target", Target::NONE);
    bench.set("keep_out", zones(&[&MIDDLE]));
    click(&mut bench, &[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]);
    press(&mut bench, "zone");
    assert_eq!(state(&mut bench), "there is no target");
    let both = zones(&[&MIDDLE, &[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]]);
    assert_eq!(bench.exported("zones_in_force"), Some(both));
    assert_eq!(bench.exported("lanes_in_force"), Some(Lanes::EMPTY));
}
