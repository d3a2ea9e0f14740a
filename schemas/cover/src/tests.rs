//! A robot that follows the paths over small maps, what it leaves out, and the words.

use jde_schema::bench::Bench;
use jde_schema::panel::Touch;

use super::*;

fn map(rows: &[&str]) -> Box<OccupancyGrid> {
    OccupancyGrid::drawn(0.1, rows)
}

/// A room of 1.8 × 1 m with a box.
const ROOM: [&str; 12] = [
    "####################",
    "#..................#",
    "#..................#",
    "#..................#",
    "#..................#",
    "#........###.......#",
    "#........###.......#",
    "#..................#",
    "#..................#",
    "#..................#",
    "#..................#",
    "####################",
];

/// A robot of 0.1 m radius with a tool of 0.3 m.
fn bench(rows: &[&str]) -> Bench<Cover> {
    let mut bench = Bench::new();
    bench.set("inscribed_radius", 0.1);
    bench.set("tolerance", 0.05);
    bench.import("map", &*map(rows));
    stand(&mut bench, (0.45, 0.45));
    bench
}

fn stand(bench: &mut Bench<Cover>, (x, y): (f64, f64)) {
    let pose = Pose2D::new(x, y, 0.0);
    bench.import("pose", &Odometry::planar(Time::default(), pose, Twist::ZERO));
}

fn mission(bench: &Bench<Cover>) -> Mission {
    bench.exported("mission").expect("a mission")
}

/// Lets the robot follow the paths until the mission is done. Returns the way, m.
fn follow(bench: &mut Bench<Cover>) -> f64 {
    follow_until(bench, |_| false)
}

/// Lets the robot follow the paths until it is at such a place or the mission is done. Returns the way, m.
fn follow_until(bench: &mut Bench<Cover>, is_there: impl Fn((f64, f64)) -> bool) -> f64 {
    let (mut robot, mut way) = ((0.45, 0.45), 0.0);
    for iteration in 0..3000 {
        bench.set_now(Duration::from_millis(200 * iteration));
        bench.iterate().expect("the iteration succeeds");
        if mission(bench).state == Mission::DONE {
            return way;
        }
        let Some(path) = bench.exported::<Path>("path") else {
            continue;
        };
        for pose in &path.poses {
            let to = (pose.pose.position.x, pose.pose.position.y);
            while (to.0 - robot.0).hypot(to.1 - robot.1) > 1e-9 {
                let left: f64 = (to.0 - robot.0).hypot(to.1 - robot.1);
                let share = (0.05 / left).min(1.0);
                robot = (
                    robot.0 + share * (to.0 - robot.0),
                    robot.1 + share * (to.1 - robot.1),
                );
                way += share * left;
                stand(bench, robot);
                bench.iterate().expect("the iteration succeeds");
                if is_there(robot) {
                    return way;
                }
            }
        }
    }
    panic!("it comes to no end: {}", mission(bench).note.as_str());
}

#[test]
fn a_robot_that_follows_the_paths_covers_the_floor_once() {
    let mut bench = bench(&ROOM);
    let way = follow(&mut bench);
    let covered: f64 = bench.exported("covered").expect("a share");
    let area: f64 = bench.exported("area").expect("an area");
    assert!(covered > 0.98, "{covered}");
    assert!((1.5..1.8).contains(&area), "{area} m2 of 1.71");
    assert!(way * 0.3 < 2.5 * area, "{way} m for {area} m2");
    assert!(
        mission(&bench).note.as_str().ends_with("m2 covered"),
        "{}",
        mission(&bench).note.as_str()
    );
    assert!(bench.exported::<Path>("path").is_none());
}

#[test]
fn a_map_that_grows_is_covered_as_far_as_it_is_known() {
    let unknown: Vec<String> = ROOM
        .iter()
        .map(|row| format!("{}??????????", &row[..10]))
        .collect();
    let mut bench = bench(&unknown.iter().map(String::as_str).collect::<Vec<_>>());
    follow(&mut bench);
    let half: f64 = bench.exported("area").expect("an area");
    bench.import("map", &*map(&ROOM));
    bench.iterate().expect("the iteration succeeds");
    assert_eq!(mission(&bench).state, Mission::RUNNING, "there is more");
    let covered: f64 = bench.exported("covered").expect("a share");
    assert!(half > 0.6 && covered < 0.8, "{half} m2, {covered}");
}

#[test]
fn a_robot_that_is_driven_to_another_room_covers_it_too() {
    // No way leads to the room on the right.
    let rows = ROOM.map(|row| format!("{row}{row}"));
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    let mut bench = bench(&rows);
    follow(&mut bench);
    assert_eq!(mission(&bench).state, Mission::DONE);
    for step in 0..10 {
        stand(&mut bench, (0.45 + 0.2 * f64::from(step), 0.45));
        bench.iterate().expect("the iteration succeeds");
    }
    assert!(bench.exported::<Path>("path").is_some());
    assert_eq!(mission(&bench).state, Mission::RUNNING);
}

#[test]
fn another_build_goes_on_where_the_last_one_was() {
    let mut old = bench(&ROOM);
    follow_until(&mut old, |robot| robot.0 > 1.5);
    let (strokes, area) = (mission(&old).reached, old.exported::<f64>("area"));
    assert!(strokes > 0 && area > Some(0.3));
    let restored = |old: &mut Bench<Cover>| {
        let mut new = bench(&ROOM);
        stand(&mut new, (1.55, 0.45));
        new.restore(&old.save().expect("it saves")).expect("it restores");
        new.iterate().expect("the iteration succeeds");
        new
    };
    let mut new = restored(&mut old);
    assert_eq!(mission(&new).reached, strokes);
    assert!(new.exported::<f64>("area") >= area);
    follow(&mut new);
    let done = mission(&new);
    assert_eq!(mission(&restored(&mut new)), done);
    assert_eq!(done.state, Mission::DONE);
    let fresh = bench(&ROOM).save().expect("it saves");
    bench(&ROOM).restore(&fresh).expect("nothing is covered yet");
}

#[test]
fn no_path_is_left_while_it_sleeps() {
    let mut bench = bench(&ROOM);
    bench.iterate().expect("the iteration succeeds");
    assert!(bench.exported::<Path>("path").is_some());
    bench.sleep().expect("it sleeps");
    assert!(bench.exported::<Path>("path").is_none());
}

#[test]
fn an_obstacle_that_appears_on_the_path_changes_it_at_once() {
    let mut bench = bench(&ROOM);
    let path = |bench: &mut Bench<Cover>| {
        bench.iterate().expect("the iteration succeeds");
        bench.exported::<Path>("path").expect("a path")
    };
    let before = path(&mut bench);
    assert_eq!(path(&mut bench).poses, before.poses, "it stays");
    let end = before.poses.last().expect("poses").pose.position;
    let mut changed = map(&ROOM);
    changed.data[(end.y / 0.1) as usize * 20 + (end.x / 0.1) as usize] = 100;
    bench.import("map", &*changed);
    assert_ne!(path(&mut bench).poses, before.poses);
    assert_eq!(mission(&bench).reached, 0, "it is not driven along");
}

#[test]
fn a_robot_that_stands_where_a_closed_contour_begins_has_not_driven_it() {
    let mut bench = bench(&ROOM);
    bench.set("tolerance", 0.3);
    let robot = Pose2D::new(0.15, 0.15, 0.0);
    stand(&mut bench, (robot.x, robot.y));
    for _ in 0..2 {
        bench.iterate().expect("the iteration succeeds");
    }
    let path = bench.exported::<Path>("path").expect("a path");
    let end = Pose2D::from(path.poses.last().expect("poses").pose);
    assert!(path.poses.len() > 4, "it leads around the room");
    assert!(end.distance_to(&robot) < 0.3, "it is closed");
    for second in 0..19 {
        bench.set_now(Duration::from_secs(second));
        bench.iterate().expect("the iteration succeeds");
    }
    assert_eq!(mission(&bench).reached, 0);
}

#[test]
fn the_floor_behind_a_place_that_is_left_out_is_covered_last() {
    // A room and another one, with a passage between them in which the robot is stuck.
    let mut rows: Vec<String> = (0..12).map(|_| format!("#{}#", ".".repeat(30))).collect();
    rows[0] = "#".repeat(32);
    rows[11] = "#".repeat(32);
    for (number, row) in rows.iter_mut().enumerate() {
        if number != 5 {
            row.replace_range(10..22, "############");
        }
    }
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    let mut bench = bench(&rows);
    bench.set("patience", 1.0);
    follow_until(&mut bench, |robot| robot.0 > 1.3);
    assert_eq!(mission(&bench).state, Mission::RUNNING, "it is in the passage");
    for second in 1000..1002 {
        bench.set_now(Duration::from_secs(second));
        bench.iterate().expect("the iteration succeeds");
    }
    assert!(mission(&bench).note.as_str().ends_with("1 place is left out"));
    stand(&mut bench, (0.45, 0.45));
    follow_until(&mut bench, |robot| robot.0 > 1.3);
    let covered = |bench: &Bench<Cover>| bench.exported::<f64>("covered").expect("a share");
    let first = covered(&bench);
    assert!((0.4..0.6).contains(&first), "{first} of both rooms");
    follow_until(&mut bench, |_| false);
    assert!(covered(&bench) > 0.95);
    assert_eq!(mission(&bench).state, Mission::DONE);
    assert!(mission(&bench).note.as_str().ends_with("covered"));
}

#[test]
fn a_robot_that_comes_no_nearer_leaves_the_place_out_and_says_so() {
    let mut bench = bench(&ROOM);
    for second in 0..22 {
        bench.set_now(Duration::from_secs(second));
        bench.iterate().expect("the iteration succeeds");
    }
    assert!(mission(&bench).note.as_str().ends_with("1 place is left out"));
    assert!(
        bench
            .log()
            .iter()
            .any(|(_, line)| line.contains("the robot comes no nearer"))
    );
    bench
        .touch("again", Touch::Pressed)
        .expect("the gesture is handled");
    bench.iterate().expect("the iteration succeeds");
    assert!(mission(&bench).note.as_str().ends_with("so far"));
    stand(&mut bench, (1.45, 0.45));
    bench.iterate().expect("the iteration succeeds");
    assert!(
        bench.exported::<f64>("area") < Some(0.3),
        "a jump covers nothing between"
    );
    stand(&mut bench, (0.45, 0.45));
    follow(&mut bench);
    assert!(mission(&bench).reached > 0);
    bench
        .touch("anew", Touch::Pressed)
        .expect("the gesture is handled");
    bench.iterate().expect("the iteration succeeds");
    assert_eq!(mission(&bench).reached, 0);
    assert!(bench.exported::<f64>("area") < Some(0.1), "only where it stands");
    assert_eq!(mission(&bench).state, Mission::RUNNING);
}

#[test]
fn what_is_missing_or_wrong_is_said_and_there_is_no_path() {
    type Spoil = fn(&mut Bench<Cover>);
    let cases: [(Spoil, &str); 6] = [
        (|bench| bench.retract("map"), "there is no map"),
        (
            |bench| bench.retract("pose"),
            "the place of the robot is not known",
        ),
        (
            |bench| stand(bench, (f64::NAN, 0.3)),
            "the place of the robot is not known",
        ),
        (|bench| stand(bench, (9.0, 0.3)), "the robot is outside the map"),
        (
            |bench| stand(bench, (0.05, 0.05)),
            "the robot is in an obstacle of the map",
        ),
        (
            |bench| {
                let mut map = map(&ROOM);
                map.info.height = 9;
                bench.import("map", &*map);
            },
            "the map has 240 of 180 cells",
        ),
    ];
    for (spoil, words) in cases {
        let mut bench = bench(&ROOM);
        spoil(&mut bench);
        bench.iterate().expect("the iteration succeeds");
        let state = bench.exported::<Text<160>>("state").expect("a state");
        assert_eq!(state.as_str(), words);
        assert!(bench.exported::<Path>("path").is_none(), "{words}");
        assert_eq!(mission(&bench).state, Mission::RUNNING);
        bench.draw().expect("the panel is drawn");
    }
}

#[test]
fn the_panel_shows_the_covered_floor_and_the_path() {
    let mut bench = bench(&ROOM);
    bench.iterate().expect("the iteration succeeds");
    assert!(bench.draw().expect("the panel is drawn").shapes("map").len() >= 4);
}

#[test]
fn it_covers_what_lies_around_a_box_that_the_map_does_not_have() {
    let empty: Vec<String> = ROOM
        .iter()
        .map(|row| row[..9].to_owned() + &row[9..].replace("###.", "...."))
        .collect();
    let mut rows: Vec<&str> = empty.iter().map(String::as_str).collect();
    (rows[0], rows[11]) = (ROOM[0], ROOM[11]);
    let mut bench = bench(&rows);
    let mut seen = map(&ROOM);
    seen.header.frame_id = Text::truncated("odom");
    bench.import("seen", &*seen);
    let is_in_box = |(x, y): (f64, f64)| (0.9..1.2).contains(&x) && (0.5..0.7).contains(&y);
    follow_until(&mut bench, is_in_box);
    let mission = mission(&bench);
    assert_eq!(mission.state, Mission::DONE, "{}", mission.note.as_str());
    assert!(
        mission.note.as_str().ends_with("covered"),
        "{}",
        mission.note.as_str()
    );
    assert!(bench.exported::<f64>("covered") > Some(0.9));
}

#[test]
fn what_is_seen_in_another_frame_leads_nowhere() {
    let mut bench = bench(&ROOM);
    bench.import("seen", &*map(&ROOM));
    bench.iterate().expect("the iteration succeeds");
    assert_eq!(bench.exported::<Path>("path"), None);
    let words = mission(&bench).note;
    assert!(words.as_str().contains("another frame"), "{}", words.as_str());
}

#[test]
fn a_robot_that_is_closed_in_by_what_it_sees_and_left_out_has_no_path() {
    let mut bench = bench(&ROOM);
    for second in 0..22 {
        bench.set_now(Duration::from_secs(second));
        bench.iterate().expect("the iteration succeeds");
    }
    assert!(bench.exported::<Path>("path").is_some());
    let mut seen = map(&ROOM);
    seen.header.frame_id = Text::truncated("odom");
    seen.data.as_mut_slice().fill(100);
    bench.import("seen", &*seen);
    bench.iterate().expect("the iteration succeeds");
    assert_eq!(bench.exported::<Path>("path"), None);
    assert_eq!(mission(&bench).state, Mission::RUNNING);
}

/// Lets the robot stand for these seconds.
fn wait(bench: &mut Bench<Cover>, seconds: core::ops::Range<u64>) {
    for second in seconds {
        bench.set_now(Duration::from_secs(second));
        bench.iterate().expect("the iteration succeeds");
    }
}

#[test]
fn a_robot_that_does_not_move_is_said_to_stand_and_goes_on_when_it_is_free() {
    let mut bench = bench(&ROOM);
    wait(&mut bench, 0..50);
    assert_eq!(
        mission(&bench).state,
        Mission::RUNNING,
        "two places may be out of reach"
    );
    wait(&mut bench, 50..90);
    let held = mission(&bench);
    assert_eq!(held.state, Mission::FAILED);
    let words = held.note.as_str();
    assert!(
        words.starts_with("the robot does not move: ") && words.ends_with(" so far"),
        "{words}"
    );
    assert_eq!(bench.exported::<Path>("path"), None);
    let warnings = |bench: &Bench<Cover>| {
        bench
            .log()
            .iter()
            .filter(|(_, line)| line.contains("leaves out"))
            .count()
    };
    assert_eq!(warnings(&bench), 3);
    wait(&mut bench, 90..400);
    assert_eq!(
        (mission(&bench), warnings(&bench)),
        (held, 3),
        "nothing else is left out"
    );
    stand(&mut bench, (0.65, 0.45));
    follow(&mut bench);
    assert_eq!(mission(&bench).state, Mission::DONE);
    assert!(mission(&bench).note.as_str().ends_with("m2 covered"), "all of it");
}

#[test]
fn a_robot_that_does_not_move_is_tried_again_by_an_operator_and_after_a_sleep() {
    let mut bench = bench(&ROOM);
    wait(&mut bench, 0..90);
    bench
        .touch("again", Touch::Pressed)
        .expect("the gesture is handled");
    wait(&mut bench, 90..92);
    assert_eq!(mission(&bench).state, Mission::RUNNING);
    assert!(bench.exported::<Path>("path").is_some());
    wait(&mut bench, 92..200);
    assert_eq!(mission(&bench).state, Mission::FAILED, "it is still held");
    bench.sleep().expect("it sleeps");
    bench.awake().expect("it awakes");
    wait(&mut bench, 200..202);
    assert_eq!(mission(&bench).state, Mission::RUNNING);
    assert!(bench.exported::<Path>("path").is_some());
}
