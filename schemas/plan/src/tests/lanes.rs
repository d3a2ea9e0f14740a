//! Preferred lanes: stated and drawn on the panel.

use jde_schema::types::{Point2D, Strip};

use super::zones::{OPEN_ROOM, click, press};
use super::*;

/// From `LEFT_POINT` up to 0.8 m, across, and down to `RIGHT_POINT`.
const LANE_POINTS: [(f64, f64); 4] = [(0.55, 0.25), (0.55, 0.85), (1.55, 0.85), (1.55, 0.25)];

fn lanes(width: f64, points: &[(f64, f64)]) -> Lanes {
    let points = points.iter().map(|&(x, y)| Point2D { x, y }).collect();
    Lanes {
        lanes: [Strip { width, points }].into_iter().collect(),
    }
}

fn highest(bench: &Bench<Plan>) -> f64 {
    let poses = poses(bench).expect("a path");
    poses.iter().fold(0.0, |y: f64, pose| y.max(pose.y))
}

#[test]
fn every_planner_takes_a_lane_that_is_worth_the_detour_and_no_other() {
    for planner in [Planner::Gradient, Planner::Grid, Planner::AnyAngle] {
        let mut bench = bench(&map(&OPEN_ROOM), LEFT_POINT, RIGHT_POINT);
        bench.set("planner", planner);
        bench.set("lanes", lanes(0.2, &LANE_POINTS));
        bench.set("off_lanes", 4.0);
        assert!(state(&mut bench).starts_with("a path of "));
        assert!(highest(&bench) > 0.7, "{planner:?} takes it");
        bench.set("off_lanes", 0.2);
        assert!(state(&mut bench).starts_with("a path of "));
        assert!(highest(&bench) < 0.4, "{planner:?} does not take it");
    }
}

#[test]
fn off_the_lanes_the_unknown_is_no_better_than_what_is_free() {
    let mut rows = OPEN_ROOM;
    rows[..5].fill("????????????????????");
    let mut bench = bench(&map(&rows), LEFT_POINT, RIGHT_POINT);
    bench.set("allow_unknown", true);
    bench.set("cost_travel_multiplier", 0.0);
    let straight = state(&mut bench);
    bench.set("lanes", lanes(0.2, &[(-3.0, -3.0), (-2.0, -3.0)]));
    bench.set("off_lanes", 20.0);
    assert_eq!(state(&mut bench), straight);
}

#[test]
fn an_operator_draws_lanes_by_clicks_and_clears_them() {
    let mut bench = bench(&map(&OPEN_ROOM), LEFT_POINT, RIGHT_POINT);
    bench.set("off_lanes", 4.0);
    let straight = state(&mut bench);
    bench.touch("width", Touch::Moved(0.2)).expect("the slider moves");
    click(&mut bench, &LANE_POINTS);
    press(&mut bench, "lane");
    let drawn = bench.log().last().expect("a message").1.clone();
    let in_a_file = "{ width = 0.20, points = [[0.55, 0.25], [0.55, 0.85], [1.55, 0.85], [1.55, 0.25]] }";
    assert!(drawn.ends_with(in_a_file), "{drawn}");
    state(&mut bench);
    assert!(highest(&bench) > 0.7);
    let saved = bench.save().expect("it saves");
    press(&mut bench, "clear");
    assert_eq!(state(&mut bench), straight);
    bench.restore(&saved).expect("it restores");
    state(&mut bench);
    assert!(highest(&bench) > 0.7, "a reload keeps it");
}

#[test]
fn lanes_that_lead_nowhere_are_refused_before_the_start_and_while_it_runs() {
    let mut bench = bench(&map(&OPEN_ROOM), LEFT_POINT, RIGHT_POINT);
    for (wrong, words) in [
        (
            lanes(0.2, &LANE_POINTS[..1]),
            "lane 1 has 1 points: give it 2 or more",
        ),
        (lanes(0.0, &LANE_POINTS), "lane 1 is 0 m wide"),
        (
            lanes(0.2, &[(0.0, 0.0), (1e300, 0.0)]),
            "lane 1 has a point at (1",
        ),
    ] {
        bench.set("lanes", wrong);
        let problems = bench.inspect().expect("it inspects");
        assert_eq!(problems[0].modulation, "lanes");
        assert!(problems[0].words.starts_with(words), "{}", problems[0].words);
        assert!(state(&mut bench).starts_with(words));
        assert_eq!(poses(&bench), None);
    }
}
