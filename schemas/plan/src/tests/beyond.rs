//! Targets off the map: on the way there while the map may grow, and given up in words where nothing leads nearer.

use super::*;

/// A hall of 3.1 × 1.1 m with a door to the east, in a map that knows nothing else.
const HALL: [&str; 11] = [
    "##########################?????",
    "#........................#?????",
    "#........................#?????",
    "#........................#?????",
    "#.........................?????",
    "#.........................?????",
    "#.........................?????",
    "#........................#?????",
    "#........................#?????",
    "#........................#?????",
    "##########################?????",
];

const WEST: (f64, f64) = (0.55, 0.55);
const FAR_EAST: (f64, f64) = (60.0, 0.55);

fn hall(target: (f64, f64)) -> Bench<Plan> {
    let mut bench = bench(&map(&HALL), WEST, target);
    bench.set("allow_unknown", true);
    bench
}

/// The hall without its door.
fn closed_hall() -> [&'static str; 11] {
    let mut closed = HALL;
    closed[4..7].fill(HALL[1]);
    closed
}

fn failure(words: &str) -> Option<(u8, String)> {
    Some((Mission::FAILED, words.to_owned()))
}

const RUNNING: u8 = Mission::RUNNING;

#[test]
fn the_path_leads_to_the_edge_and_on_when_the_map_grows() {
    for planner in [Planner::Gradient, Planner::Grid, Planner::AnyAngle] {
        let mut bench = hall(FAR_EAST);
        bench.set("planner", planner);
        let said = state(&mut bench);
        assert_eq!(
            said, "a path of 2.50 m to the edge of the map, 57 m before the goal",
            "{planner:?}"
        );
        let path = poses(&bench).expect("a path");
        let (first, last) = (path[0], path[path.len() - 1]);
        assert_eq!((first.x, first.y), WEST);
        assert!(
            (last.x - 3.05).abs() < 1e-6 && (last.y - FAR_EAST.1).abs() < 0.06,
            "{last:?}"
        );
        assert_eq!(verdict(&bench), Some((RUNNING, String::new())));
        bench.set("target", Target::at(Pose2D::new(5.5, 0.55, 0.0)));
        assert!(state(&mut bench).ends_with(" 2 m before the goal"), "{planner:?}");
        let mut grown = map(&HALL);
        grown.info.resolution = 0.2;
        bench.import("map", &*grown);
        assert!(state(&mut bench).ends_with(" m"), "on the map");
        let end = *poses(&bench).expect("a path").last().expect("poses");
        assert_eq!((end.x, end.y), (5.5, 0.55), "{planner:?}");
    }
}

#[test]
fn a_target_off_the_map_beside_a_closed_room_is_given_up_within_half_a_minute() {
    let mut bench = hall((90.0, 90.0));
    bench.import("map", &*map(&closed_hall()));
    let words = "the goal is outside the map, and no way leads off the map";
    assert_eq!(state(&mut bench), words);
    assert_eq!(
        (poses(&bench), verdict(&bench)),
        (None, Some((RUNNING, String::new())))
    );
    state_at(&mut bench, 28);
    assert_eq!(verdict(&bench), failure(words));
    bench.import("map", &*map(&HALL));
    assert!(
        state_at(&mut bench, 29).starts_with("a path of "),
        "the door has opened"
    );
    assert_eq!(verdict(&bench), Some((RUNNING, String::new())));
}

#[test]
fn at_the_edge_of_a_map_that_does_not_grow_the_target_is_given_up() {
    let mut bench = hall(FAR_EAST);
    state(&mut bench);
    stand(&mut bench, (2.2, 0.55));
    let words = "the goal is outside the map, which does not grow";
    assert_eq!((state_at(&mut bench, 5).as_str(), poses(&bench)), (words, None));
    state_at(&mut bench, 32);
    assert_eq!(verdict(&bench), Some((RUNNING, String::new())));
    state_at(&mut bench, 33);
    assert_eq!(verdict(&bench), failure(words));
}

#[test]
fn a_target_that_no_map_reaches_is_given_up_at_once() {
    let mut bench = hall((1000.0, 1000.0));
    let words = "the goal is 1413 m away, farther than a map can reach: 410 m";
    assert_eq!((state(&mut bench).as_str(), poses(&bench)), (words, None));
    state_at(&mut bench, 2);
    assert_eq!(verdict(&bench), failure(words));
    bench.set("target", Target::at(Pose2D::new(400.0, 400.0, 0.0)));
    assert!(state_at(&mut bench, 3).starts_with("a path of "));
}

#[test]
fn a_map_whose_unknown_cells_are_walls_does_not_count_as_growing() {
    let mut bench = hall(FAR_EAST);
    bench.set("allow_unknown", false);
    let words = "the goal is outside the map";
    assert_eq!(state(&mut bench), words);
    state_at(&mut bench, 2);
    assert_eq!(verdict(&bench), failure(words));
}

#[test]
fn the_place_on_the_edge_stays_while_no_other_way_is_much_cheaper() {
    let rows = ["???????????"; 11];
    let mut bench = bench(&map(&rows), (0.55, 0.55), (0.55, 30.0));
    bench.set("allow_unknown", true);
    let end = |bench: &mut Bench<Plan>| {
        state(bench);
        poses(bench).map(|path| path.last().expect("poses").x)
    };
    // Too near to the edge to drive there, before the map has grown.
    assert_eq!(end(&mut bench), None);
    let rows = ["?????????????????????????????????????????"; 41];
    bench.import("map", &*map(&rows));
    stand(&mut bench, (2.05, 2.05));
    let place = end(&mut bench).expect("a path");
    for x in [1.95, 2.15, 1.75] {
        stand(&mut bench, (x, 2.05));
        assert_eq!(end(&mut bench), Some(place), "from {x} m");
    }
    let mut walled = rows;
    walled[10] = "#########################################";
    bench.import("map", &*map(&walled));
    let around = end(&mut bench).expect("a path beside the wall");
    assert!(around < 0.1, "over the side of the map: {around} m");
}
