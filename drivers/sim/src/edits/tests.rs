//! Changes of a running world by the driver's modulation, and starts that the application gives.

use jde_schema::Severity;
use jde_schema::types::{Scenery, Start, Truth};
use jde_sim::EditQueue;

use super::*;
use crate::tests::{Robot, file};

const ROOM: &str = r#"
walls  = [{ name = "room", points = [[0, 0], [6, 0], [6, 5], [0, 5]], closed = true }]
people = [{ name = "eva", way = [[5, 4], [5, 2]], speed = 0.5 }]

[robots.bench]
start = { x = 2, y = 3 }

[robots.other]
start = { x = 4, y = 1, heading_deg = 180 }
"#;
const DOOR: &str = "{ add = { name = 'door', center = [3, 3], size = [0.1, 1] } }";

fn write(robot: &mut Robot, text: &str) {
    robot.bench.set("edit", Text::<4096>::new(text));
    robot.idle(0.05);
}

fn count(robot: &Robot) -> EditCount {
    robot.bench.exported("edits").expect("it has iterated")
}

fn truth(robot: &Robot) -> Truth {
    robot.bench.exported("truth").expect("it has iterated")
}

fn standing(robot: &Robot) -> usize {
    let scenery: &Scenery = robot.bench.exported_in_place("scenery").expect("it is exported");
    scenery.things.len()
}

#[test]
fn each_write_takes_effect_once_and_all_its_edits_do() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::awake(&path, "bench");
    robot.idle(0.05);
    assert_eq!(count(&robot), EditCount::default());
    write(&mut robot, "[{ halt = 'eva' }, { place = { x = 1, y = 1 } }]");
    assert_eq!((truth(&robot).pose.x, count(&robot).done), (1.0, 2));
    robot.drive(0.25, 0.0, 2.0);
    assert!(truth(&robot).pose.x > 1.3, "it is placed only once");
    write(&mut robot, "[{ halt = 'eva' }, { place = { x = 1, y = 1 } }]");
    assert_eq!(
        (truth(&robot).pose.x, count(&robot).done),
        (1.0, 4),
        "the same value again"
    );
}

#[test]
fn the_scenery_is_published_again_by_every_robot_of_the_world() {
    let (_folder, path) = file(ROOM);
    let (mut robot, mut other) = (Robot::awake(&path, "bench"), Robot::awake(&path, "other"));
    robot.idle(0.05);
    other.idle(0.05);
    assert_eq!((standing(&robot), standing(&other)), (4, 4));
    write(&mut robot, DOOR);
    other.idle(0.05);
    assert_eq!((standing(&robot), standing(&other)), (5, 5));
    write(&mut other, "{ remove = 'door' }");
    robot.idle(0.05);
    assert_eq!((standing(&robot), standing(&other)), (4, 4));
    assert_eq!(
        (count(&robot).done, count(&other).done),
        (1, 1),
        "each driver counts its own"
    );
}

#[test]
fn a_refused_edit_is_logged_and_counted_and_the_others_take_effect() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::awake(&path, "bench");
    write(&mut robot, "[{ remove = 'dor' }, { place = { x = 1, y = 1 } }]");
    let EditCount { done, refused, note } = count(&robot);
    assert_eq!((done, refused, truth(&robot).pose.x), (1, 1, 1.0));
    assert!(note.as_str().contains("no thing `dor`"), "{note}");
    let logged = robot.bench.log();
    let expected = format!("the world stays as it is: {note}");
    assert_eq!(logged, [(Severity::Warn, expected)]);
    write(&mut robot, "close the door");
    assert_eq!((count(&robot).done, count(&robot).refused), (1, 2));
}

#[test]
fn edits_that_a_writer_repeats_take_effect_once() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::awake(&path, "bench");
    robot.idle(0.05);
    let mut queue = EditQueue::default();
    let mut push = |text: &str| queue.push(&Edits::parse(text).expect("edits")).expect("it fits");
    let first = push(DOOR);
    robot.bench.set("edit", Text::<4096>::new(&first));
    // Overwritten before the driver has read it.
    let second = push("{ place = { x = 1, y = 1 } }");
    write(&mut robot, &second);
    assert_eq!((count(&robot).done, standing(&robot)), (2, 5));
    let third = push("{ remove = 'door' }");
    write(&mut robot, &third);
    assert_eq!(
        (count(&robot).done, count(&robot).refused, standing(&robot)),
        (3, 0, 4)
    );
}

#[test]
fn a_driver_that_restarts_in_an_open_world_does_not_repeat_an_edit() {
    let (_folder, path) = file(ROOM);
    let (mut robot, _other) = (Robot::awake(&path, "bench"), Robot::awake(&path, "other"));
    write(&mut robot, DOOR);
    let now = robot.now;
    drop(robot);
    let mut again = Robot::asleep(&path, "bench");
    again.bench.set("edit", Text::<4096>::new(DOOR));
    again.bench.awake().expect("it enters the world");
    again.now = now;
    again.idle(0.05);
    assert_eq!((count(&again).done, count(&again).refused), (1, 0));
}

#[test]
fn a_robot_starts_where_the_application_says() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::asleep(&path, "bench");
    let start = Pose2D::new(3.0, 1.0, 1.5);
    robot.bench.set("start", Start::at(start));
    assert_eq!(robot.bench.inspect(), Ok(vec![]));
    robot.bench.awake().expect("it enters the world");
    robot.idle(0.05);
    assert_eq!(truth(&robot).pose, start);
    let odometry: Odometry = robot.bench.exported("odometry").expect("it has iterated");
    assert!(odometry.pose2d().distance_to(&start) < 1e-9);
}

#[test]
fn an_inspection_reports_a_start_that_is_not_free() {
    let (_folder, path) = file(ROOM);
    let mut robot = Robot::asleep(&path, "bench");
    for (x, expected) in [(5.9, "`room` is there"), (60.0, "within the world")] {
        let start = Pose2D::new(x, 1.0, 0.0);
        robot.bench.set("start", Start::at(start));
        let problems = robot.bench.inspect().expect("it inspects");
        assert_eq!(problems.len(), 1, "{problems:?}");
        assert_eq!(problems[0].modulation, "start");
        assert!(problems[0].words.contains(expected), "{problems:?}");
        assert!(robot.bench.awake().is_err());
    }
}
