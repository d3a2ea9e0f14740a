//! Which frontier is chosen, what makes it seen or given up, and the words at the end.

use jde_schema::bench::Bench;
use jde_schema::panel::Touch;

use super::*;

/// A map of a time, with sides of 0.1 m.
fn map(rows: &[&str], second: u64) -> Box<OccupancyGrid> {
    let mut map = OccupancyGrid::drawn(0.1, rows);
    map.header.stamp = Duration::from_secs(second).into();
    map
}

/// A room with an opening of 0.3 m on the left and one of 0.5 m on the right.
const ROOM: [&str; 7] = [
    "#####################",
    "#...................?",
    "?...................?",
    "?...................?",
    "?...................?",
    "#...................?",
    "#####################",
];
const LEFT_POSE: Pose2D = Pose2D::new(0.15, 0.35, 0.0);
const RIGHT_POSE: Pose2D = Pose2D::new(1.95, 0.35, 0.0);

/// A robot of 0.1 m radius that sees frontiers of 0.2 m.
fn bench(x: f64) -> Bench<Explore> {
    let mut bench = Bench::new();
    bench.set("inscribed_radius", 0.05);
    bench.set("min_frontier_size", 0.2);
    bench.set("apart", 0.5);
    stand(&mut bench, x, 0.35);
    bench
}

fn stand(bench: &mut Bench<Explore>, x: f64, y: f64) {
    bench.import(
        "pose",
        &Odometry::planar(Time::default(), Pose2D::new(x, y, 0.0), Twist::ZERO),
    );
}

/// The target after an iteration at this second, with a map of then. What follows is later.
fn target(bench: &mut Bench<Explore>, rows: &[&str], second: u64) -> Option<Pose2D> {
    bench.set_now(Duration::from_secs(second));
    bench.import("map", &*map(rows, second));
    bench.iterate().expect("the iteration succeeds");
    bench.set_now(Duration::from_millis(1000 * second + 100));
    rounded(bench)
}

/// The target, in whole centimetres.
fn rounded(bench: &Bench<Explore>) -> Option<Pose2D> {
    let target = bench.exported::<Target>("target").expect("a target");
    target.get().map(|pose| {
        Pose2D::new(
            (pose.x * 100.0).round() / 100.0,
            (pose.y * 100.0).round() / 100.0,
            0.0,
        )
    })
}

fn drive(bench: &mut Bench<Explore>, state: u8, words: &str) {
    let target = bench.exported::<Target>("target").expect("a target").pose;
    let note = Text::new(words);
    bench.import(
        "drive",
        &Mission {
            state,
            target,
            note,
            ..Mission::default()
        },
    );
}

fn mission(bench: &Bench<Explore>) -> Mission {
    bench.exported("mission").expect("a mission")
}

/// The room with its right side closed.
fn half_closed() -> Vec<String> {
    ROOM.iter().map(|row| format!("{}#", &row[..20])).collect()
}

fn rows(rows: &[String]) -> Vec<&str> {
    rows.iter().map(String::as_str).collect()
}

#[test]
fn the_nearest_frontier_is_chosen_unless_a_longer_one_is_worth_the_way() {
    assert_eq!(target(&mut bench(0.95), &ROOM, 0), Some(LEFT_POSE));
    for (gain, chosen) in [(0.0, LEFT_POSE), (5.0, RIGHT_POSE)] {
        let mut bench = bench(0.95);
        bench.set("gain_scale", gain);
        assert_eq!(target(&mut bench, &ROOM, 0), Some(chosen), "{gain}");
    }
}

#[test]
fn a_target_stays_until_its_frontier_is_seen() {
    let mut bench = bench(1.25);
    assert_eq!(target(&mut bench, &ROOM, 0), Some(RIGHT_POSE));
    stand(&mut bench, 0.35, 0.35);
    assert_eq!(
        target(&mut bench, &ROOM, 1),
        Some(RIGHT_POSE),
        "the other one is nearer now"
    );
    assert_eq!(mission(&bench).reached, 0);
    assert_eq!(target(&mut bench, &rows(&half_closed()), 2), Some(LEFT_POSE));
    assert_eq!(mission(&bench).reached, 1);
}

#[test]
fn a_frontier_that_stays_open_after_the_robot_came_is_given_up() {
    let mut bench = bench(1.25);
    target(&mut bench, &ROOM, 0);
    drive(&mut bench, Mission::RUNNING, "");
    assert_eq!(target(&mut bench, &ROOM, 9), Some(RIGHT_POSE));
    drive(&mut bench, Mission::DONE, "");
    for second in [10, 11] {
        assert_eq!(target(&mut bench, &ROOM, second), Some(RIGHT_POSE), "it looks");
    }
    assert_eq!(target(&mut bench, &ROOM, 12), None);
    assert_eq!(target(&mut bench, &ROOM, 13), Some(LEFT_POSE));
    assert!(mission(&bench).note.as_str().ends_with("1 place is left out"));
    assert!(
        bench
            .log()
            .iter()
            .any(|(_, line)| line.contains("1.95, 0.35: it stays open"))
    );
}

#[test]
fn a_frontier_that_stays_open_on_a_map_that_does_not_change_is_given_up() {
    let mut bench = bench(1.25);
    assert_eq!(target(&mut bench, &ROOM, 0), Some(RIGHT_POSE));
    drive(&mut bench, Mission::DONE, "");
    for second in 1..5 {
        bench.set_now(Duration::from_secs(second));
        bench.iterate().expect("the iteration succeeds");
    }
    assert!(mission(&bench).note.as_str().ends_with("1 place is left out"));
}

#[test]
fn a_frontier_behind_a_wall_changes_nothing_of_the_target_beside_it() {
    // No way leads to the second room.
    let rows = [&ROOM[..], &["#...................?"; 2], &ROOM[6..]].concat();
    let mut bench = bench(1.25);
    stand(&mut bench, 1.25, 0.65);
    let chosen = target(&mut bench, &rows, 0).expect("a target");
    assert_eq!(chosen.x, RIGHT_POSE.x);
    stand(&mut bench, 0.35, 0.65);
    assert_eq!(target(&mut bench, &rows, 1), Some(chosen), "it stays");
    drive(&mut bench, Mission::DONE, "");
    for second in 2..4 {
        assert_eq!(target(&mut bench, &rows, second), Some(chosen), "it looks");
    }
    assert_eq!(target(&mut bench, &rows, 4), None, "it stays open");
}

#[test]
fn a_robot_that_awakes_before_a_frontier_looks_anew() {
    let mut bench = bench(1.25);
    target(&mut bench, &ROOM, 0);
    drive(&mut bench, Mission::DONE, "");
    assert_eq!(target(&mut bench, &ROOM, 1), Some(RIGHT_POSE));
    bench.sleep().expect("it sleeps");
    bench.set_now(Duration::from_secs(100));
    bench.awake().expect("it awakes");
    for second in 100..104 {
        assert_eq!(target(&mut bench, &ROOM, second), Some(RIGHT_POSE));
    }
    drive(&mut bench, Mission::DONE, "");
    for second in 104..106 {
        assert_eq!(target(&mut bench, &ROOM, second), Some(RIGHT_POSE), "it looks");
    }
    assert_eq!(target(&mut bench, &ROOM, 106), None);
}

#[test]
fn no_target_is_left_while_it_sleeps() {
    let mut bench = bench(1.25);
    assert_eq!(target(&mut bench, &ROOM, 0), Some(RIGHT_POSE));
    bench.sleep().expect("it sleeps");
    assert!(bench.exported::<Target>("target").is_none());
}

#[test]
fn what_was_given_up_and_is_seen_later_is_not_left_out() {
    let mut bench = bench(1.25);
    target(&mut bench, &ROOM, 0);
    drive(&mut bench, Mission::FAILED, "in vain");
    target(&mut bench, &ROOM, 1);
    assert!(mission(&bench).note.as_str().ends_with("1 place is left out"));
    let cut: Vec<String> = ROOM.iter().map(|row| row[..13].to_owned()).collect();
    target(&mut bench, &rows(&cut), 2);
    assert!(
        mission(&bench).note.as_str().ends_with("1 place is left out"),
        "a map that ends before it says nothing of it"
    );
    target(&mut bench, &rows(&half_closed()), 3);
    assert_eq!(mission(&bench).note.as_str(), "to 0.15, 0.35; 1 open");
}

#[test]
fn a_target_that_the_father_gives_up_is_not_chosen_again_until_an_operator_asks() {
    let mut bench = bench(1.25);
    target(&mut bench, &ROOM, 0);
    drive(&mut bench, Mission::FAILED, "in vain: turned");
    assert_eq!(target(&mut bench, &ROOM, 1), Some(LEFT_POSE));
    let saved = bench.save().expect("it saves");
    let mut reloaded = self::bench(1.25);
    reloaded.restore(&saved).expect("it restores");
    assert_eq!(
        target(&mut reloaded, &ROOM, 1),
        Some(LEFT_POSE),
        "kept across a reload"
    );
    assert!(
        bench
            .draw()
            .expect("a panel")
            .texts()
            .iter()
            .any(|text| text.contains("in vain: turned"))
    );
    bench
        .touch("again", Touch::Pressed)
        .expect("the gesture is handled");
    assert_eq!(target(&mut bench, &ROOM, 2), Some(LEFT_POSE), "it stays");
    let left_seen: Vec<String> = ROOM.iter().map(|row| format!("#{}", &row[1..])).collect();
    for second in 3..6 {
        assert_eq!(
            target(&mut bench, &rows(&left_seen), second),
            Some(RIGHT_POSE),
            "the father has said nothing since"
        );
    }
}

#[test]
fn a_closed_map_ends_the_mission_and_says_what_was_left_out() {
    let mut bench = bench(0.95);
    // The robot fits neither on the left, where its way is closed, nor is there anything else.
    let mut closed = half_closed();
    for row in &mut closed {
        row.replace_range(3..4, "#");
    }
    assert_eq!(target(&mut bench, &rows(&closed), 0), None);
    assert_eq!(mission(&bench).state, Mission::RUNNING, "not at once");
    target(&mut bench, &rows(&closed), 2);
    assert_eq!(mission(&bench).state, Mission::DONE);
    assert_eq!(
        mission(&bench).note.as_str(),
        "the map is closed, 1 place is left out"
    );
    assert_eq!(bench.exported("left_out"), Some(1_u32));
    assert!(
        bench
            .log()
            .iter()
            .any(|(_, line)| line.contains("no way leads there"))
    );
    assert_eq!(
        target(&mut bench, &rows(&half_closed()), 3),
        Some(LEFT_POSE),
        "the way has opened"
    );
    assert_eq!(mission(&bench).state, Mission::RUNNING);
}

#[test]
fn a_large_map_takes_several_iterations() {
    let large: Vec<String> = (0..60).map(|_| ".".repeat(60)).collect();
    let mut bench = bench(0.95);
    bench.set("cells", 1000_u32);
    let chosen = (1..20).find(|_| target(&mut bench, &rows(&large), 0).is_some());
    assert!(chosen.is_some_and(|iterations| iterations > 3), "{chosen:?}");
}

#[test]
fn a_map_that_was_surveyed_is_not_surveyed_again_on_the_way_to_a_target() {
    let large: Vec<String> = (0..60).map(|_| ".".repeat(60)).collect();
    let mut bench = bench(0.95);
    assert!(target(&mut bench, &rows(&large), 0).is_some());
    // A survey would now take several iterations.
    bench.set("cells", 1000_u32);
    for x in [1.05, 1.15, 1.25] {
        stand(&mut bench, x, 0.35);
        bench.iterate().expect("the iteration succeeds");
        assert!(bench.schema().survey.is_none(), "at {x} m");
    }
    bench.import("map", &*map(&rows(&large), 1));
    bench.iterate().expect("the iteration succeeds");
    assert!(bench.schema().survey.is_some(), "the map is a new one");
}

#[test]
fn what_is_missing_or_wrong_is_said_and_no_other_target_is_chosen() {
    type Spoil = fn(&mut Bench<Explore>);
    let cases: [(Spoil, &str, Option<Pose2D>); 6] = [
        (|bench| bench.retract("map"), "there is no map", None),
        (
            |bench| bench.retract("pose"),
            "the place of the robot is not known",
            None,
        ),
        (
            |bench| stand(bench, f64::NAN, 0.35),
            "the place of the robot is not known",
            None,
        ),
        (
            |bench| stand(bench, 0.05, 0.05),
            "the robot is in an obstacle of the map",
            Some(LEFT_POSE),
        ),
        (
            |bench| {
                let mut map = map(&ROOM, 0);
                map.info.height = 9;
                bench.import("map", &*map);
            },
            "the map has 147 of 189 cells",
            None,
        ),
        (
            |bench| {
                let mut map = map(&ROOM, 0);
                map.info.resolution = f32::NAN;
                bench.import("map", &*map);
            },
            "resolution",
            None,
        ),
    ];
    for (spoil, words, kept) in cases {
        let mut bench = bench(0.95);
        assert_eq!(target(&mut bench, &ROOM, 0), Some(LEFT_POSE));
        spoil(&mut bench);
        bench.iterate().expect("the iteration succeeds");
        let state = bench.exported::<Text<160>>("state").expect("a state");
        assert!(state.as_str().contains(words), "{}", state.as_str());
        assert_eq!(rounded(&bench), kept, "{words}");
        assert_eq!(mission(&bench).state, Mission::RUNNING);
        bench.draw().expect("the panel is drawn");
    }
}
