//! Paths over small maps, and the words for all that has none.

mod beyond;
mod kept;
mod lanes;
mod zones;

use jde_schema::bench::Bench;
use jde_schema::panel::{Button, Shape, Touch};

use super::*;

fn map(rows: &[&str]) -> Box<OccupancyGrid> {
    OccupancyGrid::drawn(0.1, rows)
}

/// A room of 2 × 1 m with a wall that leaves a gap at the top.
const ROOM: [&str; 10] = [
    "....................",
    "....................",
    "....................",
    "..........#.........",
    "..........#.........",
    "..........#.........",
    "..........#.........",
    "..........#.........",
    "..........#.........",
    "..........#.........",
];

/// A robot of 0.1 m radius on a map.
fn bench(map: &OccupancyGrid, robot: (f64, f64), target: (f64, f64)) -> Bench<Plan> {
    let mut bench = Bench::new();
    bench.import("map", map);
    stand(&mut bench, robot);
    bench.set("target", Target::at(Pose2D::new(target.0, target.1, 0.0)));
    bench.set("inscribed_radius", 0.1);
    bench.set("circumscribed_radius", 0.1);
    bench.set("inflation_radius", 0.3);
    bench
}

fn stand(bench: &mut Bench<Plan>, (x, y): (f64, f64)) {
    let pose = Pose2D::new(x, y, 0.0);
    bench.import("pose", &Odometry::planar(Time::default(), pose, Twist::ZERO));
}

fn state(bench: &mut Bench<Plan>) -> String {
    bench.iterate().expect("the iteration succeeds");
    bench
        .exported::<Text<160>>("state")
        .expect("a state")
        .as_str()
        .to_owned()
}

fn poses(bench: &Bench<Plan>) -> Option<Vec<Pose2D>> {
    let path = bench.exported_in_place::<Path>("path")?;
    Some(path.poses.iter().map(|stamped| stamped.pose.into()).collect())
}

const LEFT_POINT: (f64, f64) = (0.53, 0.21);
const RIGHT_POINT: (f64, f64) = (1.57, 0.22);

#[test]
fn every_planner_leads_around_the_wall_from_the_robot_to_the_target() {
    for planner in [Planner::Gradient, Planner::Grid, Planner::AnyAngle] {
        let mut bench = bench(&map(&ROOM), LEFT_POINT, RIGHT_POINT);
        bench.set("planner", planner);
        assert!(state(&mut bench).starts_with("a path of "), "{planner:?}");
        let poses = poses(&bench).expect("a path");
        let (first, last) = (poses[0], poses[poses.len() - 1]);
        assert_eq!(((first.x, first.y), (last.x, last.y)), (LEFT_POINT, RIGHT_POINT));
        let over = poses.iter().filter(|pose| pose.y > 0.75).count();
        assert!(over >= 1, "{planner:?} passes above the wall: {poses:?}");
        for pair in poses.windows(2) {
            let error = normalize_angle(pair[0].theta - (pair[1].y - pair[0].y).atan2(pair[1].x - pair[0].x));
            assert!(error.abs() < 1e-9, "each pose faces the next one");
        }
    }
}

#[test]
fn a_wall_that_appears_changes_the_path_and_one_that_goes_restores_it() {
    let mut open = ROOM;
    open[3..].fill("....................");
    let mut bench = bench(&map(&open), LEFT_POINT, RIGHT_POINT);
    let straight = state(&mut bench);
    bench.import("map", &*map(&ROOM));
    let around = state(&mut bench);
    assert_ne!(straight, around);
    let mut closed = ROOM;
    closed[..3].fill("..........#.........");
    bench.import("map", &*map(&closed));
    assert_eq!(state(&mut bench), "no way leads to the goal");
    assert_eq!(poses(&bench), None, "the path is retracted");
    bench.import("map", &*map(&open));
    assert_eq!(state(&mut bench), straight);
}

#[test]
fn a_moved_target_and_another_clearance_are_followed() {
    let mut bench = bench(&map(&ROOM), LEFT_POINT, RIGHT_POINT);
    state(&mut bench);
    let target = Pose2D::new(1.85, 0.85, 0.0);
    bench.set("target", Target::at(target));
    state(&mut bench);
    let last = *poses(&bench).expect("a path").last().expect("poses");
    assert_eq!((last.x, last.y), (target.x, target.y));
    bench.set("inscribed_radius", 0.4);
    bench.set("circumscribed_radius", 0.4);
    assert_eq!(state(&mut bench), "no way leads to the goal");
}

#[test]
fn what_is_missing_is_said() {
    let mut bench = Bench::<Plan>::new();
    assert_eq!(state(&mut bench), "there is no target");
    bench.set("target", Target::at(Pose2D::ORIGIN));
    assert_eq!(state(&mut bench), "there is no map");
    bench.import("map", &*map(&ROOM));
    assert_eq!(state(&mut bench), "the place of the robot is not known");
    assert_eq!(poses(&bench), None);
}

#[test]
fn ends_in_walls_and_off_the_map_are_said() {
    let wall = (1.05, 0.35);
    for (robot, target, words) in [
        (LEFT_POINT, wall, "the goal is in an obstacle of the map"),
        (LEFT_POINT, (5.0, 0.0), "the goal is outside the map"),
        (wall, RIGHT_POINT, "the robot is in an obstacle of the map"),
        ((-0.1, 0.5), RIGHT_POINT, "the robot is outside the map"),
        (
            (f64::NAN, 0.5),
            RIGHT_POINT,
            "the place of the robot is not known",
        ),
    ] {
        let mut bench = bench(&map(&ROOM), robot, target);
        for planner in [Planner::Gradient, Planner::Grid, Planner::AnyAngle] {
            bench.set("planner", planner);
            assert_eq!(state(&mut bench), words);
            assert_eq!(poses(&bench), None);
        }
    }
}

#[test]
fn a_robot_that_is_too_close_to_an_obstacle_is_led_away_from_it() {
    let wider = |map: &OccupancyGrid, robot| {
        let mut bench = bench(map, robot, RIGHT_POINT);
        bench.set("inscribed_radius", 0.15);
        bench.set("circumscribed_radius", 0.15);
        bench
    };
    // Its centre is one cell beside the wall.
    let robot = (0.95, 0.35);
    for planner in [Planner::Gradient, Planner::Grid, Planner::AnyAngle] {
        let mut bench = wider(&map(&ROOM), robot);
        bench.set("planner", planner);
        assert!(state(&mut bench).starts_with("a path of "), "{planner:?}");
        let poses = poses(&bench).expect("a path");
        assert_eq!((poses[0].x, poses[0].y), robot);
        assert!(poses[1].x < robot.0, "away from the wall: {poses:?}");
    }
    let mut boxed = ROOM;
    boxed[2..].fill(".#######..#.........");
    let mut bench = wider(&map(&boxed), (0.85, 0.35));
    assert_eq!(
        state(&mut bench),
        "the robot is in an obstacle of the map",
        "too far"
    );
}

#[test]
fn a_path_may_end_before_a_target_in_an_obstacle() {
    let wall = (1.05, 0.35);
    let mut bench = bench(&map(&ROOM), LEFT_POINT, wall);
    bench.set("tolerance", 0.12);
    assert!(state(&mut bench).starts_with("a path of "));
    let last = *poses(&bench).expect("a path").last().expect("poses");
    let distance = last.distance_to(&Pose2D::new(wall.0, wall.1, 0.0));
    assert!((0.05..0.12).contains(&distance), "{distance} m");
    bench.set("tolerance", 0.05);
    assert_eq!(state(&mut bench), "the goal is in an obstacle of the map");
}

#[test]
fn a_path_ends_as_near_as_it_can_to_a_target_that_no_way_reaches() {
    let rows = ["............", "....######..", "....##...#..", "....######.."];
    for planner in [Planner::Gradient, Planner::Grid, Planner::AnyAngle] {
        let mut bench = bench(&map(&rows), (0.05, 0.05), (0.65, 0.15));
        bench.set("planner", planner);
        assert_eq!(state(&mut bench), "no way leads to the goal");
        bench.set("tolerance", 0.15);
        assert_eq!(state(&mut bench), "no way leads to the goal", "too far");
        bench.set("tolerance", 0.3);
        for _ in 0..2 {
            let state = state(&mut bench);
            assert!(state.starts_with("a path of"), "{state}");
            let last = *poses(&bench).expect("a path").last().expect("poses");
            assert!(
                last.distance_to(&Pose2D::new(0.65, 0.35, 0.0)) < 1e-6,
                "behind the wall: {last:?}"
            );
        }
        bench.import("map", &*map(&[rows[0]; 4]));
        state(&mut bench);
        let last = *poses(&bench).expect("a path").last().expect("poses");
        assert_eq!((last.x, last.y), (0.65, 0.15), "the way is open");
    }
}

#[test]
fn the_place_before_a_target_in_a_wall_stays_while_a_way_leads_there() {
    let rows = ["...........", ".....#.....", ".....#.....", ".....#....."];
    let mut bench = bench(&map(&rows), (0.45, 0.05), (0.55, 0.15));
    bench.set("tolerance", 0.15);
    let end = |bench: &mut Bench<Plan>| {
        state(bench);
        poses(bench).expect("a path").last().expect("poses").x
    };
    let side = end(&mut bench);
    for x in [0.05, 1.05, 0.45, 0.65] {
        bench.import(
            "pose",
            &Odometry::planar(Time::default(), Pose2D::new(x, 0.05, 0.0), Twist::ZERO),
        );
        assert_eq!(end(&mut bench), side, "from {x} m");
    }
    let [mut left, mut right] = [rows; 2];
    for row in [&mut left, &mut right] {
        row[1] = "....###....";
    }
    left[2] = "....##.....";
    left[3] = "....##.....";
    right[2] = ".....##....";
    right[3] = ".....##....";
    let closed = if side < 0.55 { left } else { right };
    bench.import("map", &*map(&closed));
    assert!(
        (end(&mut bench) - 0.55) * (side - 0.55) < 0.0,
        "the other side, when this one is closed"
    );
}

#[test]
fn unknown_cells_are_walls_unless_permitted() {
    let mut bench = bench(&map(&[".....?....."]), (0.05, 0.05), (1.05, 0.05));
    assert_eq!(state(&mut bench), "no way leads to the goal");
    bench.set("allow_unknown", true);
    assert_eq!(state(&mut bench), "a path of 1.00 m");
}

#[test]
fn a_map_of_one_cell_has_a_path_within_it() {
    let mut bench = bench(&map(&["."]), (0.02, 0.05), (0.08, 0.05));
    assert_eq!(state(&mut bench), "a path of 0.06 m");
    assert_eq!(poses(&bench).expect("a path").len(), 2);
}

#[test]
fn a_map_of_sixteen_million_cells_has_paths_and_is_drawn_in_part() {
    let side: u32 = 4000;
    let mut large = map(&["."]);
    (large.info.width, large.info.height) = (side, side);
    let columns = large
        .data
        .resize((side * side) as usize)
        .chunks_exact_mut(side as usize);
    // A wall of 0.6 m across the map, with a gap of 1.5 m at the top.
    columns.take(3985).for_each(|row| row[1997..2003].fill(100));
    for planner in [Planner::Gradient, Planner::Grid, Planner::AnyAngle] {
        let mut bench = bench(&large, (199.0, 398.0), (201.0, 398.0));
        bench.set("planner", planner);
        assert!(state(&mut bench).starts_with("a path of "), "{planner:?}");
        let top = poses(&bench)
            .expect("a path")
            .iter()
            .map(|pose| pose.y)
            .fold(0.0, f64::max);
        assert!(top > 398.5, "{planner:?} passes above the wall: {top} m");
        let panel = bench.draw().expect("the panel is drawn");
        let points = panel.shapes("map").iter().find_map(|shape| match shape {
            Shape::Points { points, .. } => Some(points.len()),
            _ => None,
        });
        assert_eq!(points, Some(6 * 3985 / 2));
    }
}

#[test]
fn maps_and_footprints_that_cannot_be_are_said() {
    type Spoil = fn(&mut OccupancyGrid);
    let spoils: [(Spoil, &str); 5] = [
        (|map| map.info.width = 0, "the grid has 0 x 10 cells"),
        (
            |map| map.info.width = u32::MAX,
            "the grid has 4294967295 x 10 cells",
        ),
        (|map| map.info.resolution = f32::NAN, "the resolution is NaN m"),
        (
            |map| map.info.origin.position.x = f64::INFINITY,
            "the origin is (inf, 0) m",
        ),
        (|map| map.info.height = 4000, "the map has 200 of 80000 cells"),
    ];
    for (spoil, words) in spoils {
        let mut spoilt = map(&ROOM);
        let mut bench = bench(&spoilt, LEFT_POINT, RIGHT_POINT);
        assert!(state(&mut bench).starts_with("a path of "));
        spoil(&mut spoilt);
        bench.import("map", &*spoilt);
        let said = state(&mut bench);
        assert!(said.starts_with(words), "{said}");
        assert_eq!(poses(&bench), None);
        bench.import("map", &*map(&ROOM));
        assert!(state(&mut bench).starts_with("a path of "), "it recovers");
    }
    let mut bench = bench(&map(&ROOM), LEFT_POINT, RIGHT_POINT);
    bench.set("inscribed_radius", 0.3);
    assert!(state(&mut bench).contains("expected 0 <= inscribed <= circumscribed"));
}

#[test]
fn the_panel_shows_the_situation_and_the_path() {
    let mut bench = bench(&map(&ROOM), LEFT_POINT, RIGHT_POINT);
    state(&mut bench);
    let panel = bench.draw().expect("the panel is drawn");
    assert_eq!(panel.value("columns"), 20.0);
    assert!(panel.shapes("map").len() >= 4, "outline, path, target and robot");
}

/// The room without its wall.
fn open_room() -> [&'static str; 10] {
    let mut open = ROOM;
    open[3..].fill("....................");
    open
}

/// The room with its wall up to the top.
fn closed_room() -> [&'static str; 10] {
    let mut closed = ROOM;
    closed[..3].fill("..........#.........");
    closed
}

/// What sensors see, in the frame of the pose.
fn see(bench: &mut Bench<Plan>, rows: &[&str]) {
    let mut view = map(rows);
    view.header.frame_id = Header::new(Time::default(), "odom").frame_id;
    bench.import("seen", &*view);
}

/// What the planner says of the target.
fn verdict(bench: &Bench<Plan>) -> Option<(u8, String)> {
    let mission = bench.exported::<Mission>("planning")?;
    Some((mission.state, mission.note.as_str().to_owned()))
}

fn state_at(bench: &mut Bench<Plan>, seconds: u64) -> String {
    bench.set_now(Duration::from_secs(seconds));
    state(bench)
}

const NOTHING_IN_VIEW: [&str; 4] = ["????"; 4];
const PAST: &str = "no way leads to the goal past what the robot has seen";

#[test]
fn what_is_seen_is_led_around_until_it_is_seen_to_be_gone_or_is_too_old() {
    let mut bench = bench(&map(&open_room()), LEFT_POINT, RIGHT_POINT);
    let straight = state(&mut bench);
    see(&mut bench, &ROOM);
    let around = state(&mut bench);
    assert_ne!(around, straight);
    see(&mut bench, &NOTHING_IN_VIEW);
    assert_eq!(state(&mut bench), around, "out of sight");
    bench.set("observation_persistence", 60.0);
    assert_eq!(state_at(&mut bench, 50), around);
    assert_eq!(state_at(&mut bench, 70), straight, "too old");
    see(&mut bench, &ROOM);
    assert_eq!(state(&mut bench), around);
    see(&mut bench, &open_room());
    assert_eq!(state(&mut bench), straight, "seen to be gone");
}

#[test]
fn obstacles_out_of_sight_are_forgotten_where_that_gives_a_way_and_nowhere_else() {
    let mut bench = bench(&map(&open_room()), LEFT_POINT, RIGHT_POINT);
    let straight = state(&mut bench);
    see(&mut bench, &closed_room());
    assert_eq!(state(&mut bench), PAST);
    see(&mut bench, &NOTHING_IN_VIEW);
    bench.set("target", Target::at(Pose2D::new(5.0, 0.0, 0.0)));
    assert_eq!(state_at(&mut bench, 1), "the goal is outside the map");
    let remembered = bench.schema().remembered.as_ref().expect("a map");
    let map = bench.schema().followed.as_ref().expect("a map");
    assert!(remembered.cells(map.known().geometry()).count() > 0);
    bench.set(
        "target",
        Target::at(Pose2D::new(RIGHT_POINT.0, RIGHT_POINT.1, 0.0)),
    );
    assert_eq!(state_at(&mut bench, 3), straight);
}

#[test]
fn what_was_seen_from_a_place_where_the_robot_was_not_is_forgotten() {
    let mut bench = bench(&map(&open_room()), LEFT_POINT, RIGHT_POINT);
    state(&mut bench);
    see(&mut bench, &closed_room());
    assert_eq!(state(&mut bench), PAST);
    stand(&mut bench, (1.8, 0.21));
    assert!(state(&mut bench).starts_with("a path of "));
    stand(&mut bench, LEFT_POINT);
    assert_eq!(state(&mut bench), "a path of 1.04 m");
}

#[test]
fn what_is_seen_where_the_robot_stands_is_no_obstacle_and_in_another_frame_it_is_a_fault() {
    let mut bench = bench(&map(&open_room()), (1.05, 0.21), RIGHT_POINT);
    see(&mut bench, &closed_room());
    assert!(state(&mut bench).starts_with("a path of "));
    bench.import("seen", &*map(&closed_room()));
    assert_eq!(
        state(&mut bench),
        "the obstacles of `seen` are in another frame than the pose"
    );
    assert_eq!(poses(&bench), None);
}

#[test]
fn a_target_without_a_way_fails_soon_by_the_map_and_later_by_what_is_seen() {
    let mut bench = bench(&map(&open_room()), LEFT_POINT, (5.0, 0.0));
    state(&mut bench);
    assert_eq!(verdict(&bench), Some((Mission::RUNNING, String::new())));
    state_at(&mut bench, 2);
    let outside = String::from("the goal is outside the map");
    assert_eq!(verdict(&bench), Some((Mission::FAILED, outside)));
    // What is unknown may turn out to be a way.
    bench.set("allow_unknown", true);
    bench.set("target", Target::at(Pose2D::new(1.05, 0.35, 0.0)));
    bench.import("map", &*map(&ROOM));
    state_at(&mut bench, 4);
    state_at(&mut bench, 10);
    assert_eq!(verdict(&bench), Some((Mission::RUNNING, String::new())));
    state_at(&mut bench, 32);
    assert_eq!(verdict(&bench).map(|(state, _)| state), Some(Mission::FAILED));
    bench.import("map", &*map(&open_room()));
    bench.set(
        "target",
        Target::at(Pose2D::new(RIGHT_POINT.0, RIGHT_POINT.1, 0.0)),
    );
    state_at(&mut bench, 33);
    assert_eq!(
        verdict(&bench),
        Some((Mission::RUNNING, String::new())),
        "another target"
    );
    see(&mut bench, &closed_room());
    state_at(&mut bench, 34);
    assert_eq!(
        verdict(&bench).map(|(state, _)| state),
        Some(Mission::RUNNING),
        "it may go away"
    );
    state_at(&mut bench, 62);
    assert_eq!(verdict(&bench), Some((Mission::FAILED, String::from(PAST))));
    bench.set("target", Target::NONE);
    state(&mut bench);
    assert_eq!(verdict(&bench), None);
}

#[test]
fn a_failure_is_said_once_in_each_patience() {
    let mut verdict = Verdict::default();
    let patience = Duration::from_secs(28);
    let judgements = (0..=60).filter_map(|second| {
        let situation = Situation::NoWay(PlanError::Unreachable);
        let state = verdict.judge(Pose2D::ORIGIN, &situation, Duration::from_secs(second), patience)?;
        Some((second, state))
    });
    let said: Vec<_> = judgements.collect();
    let failed = Mission::FAILED;
    assert_eq!(said, [(0, Mission::RUNNING), (28, failed), (56, failed)]);
}
