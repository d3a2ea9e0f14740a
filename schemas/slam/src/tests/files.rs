//! The map in files.

use std::path::PathBuf;

use jde_map_file::{MapCell, MapFile};
use jde_schema::bench::Bench;
use jde_schema::panel::Touch;
use jde_schema::prelude::*;
use jde_watchdog::Watchdog;
use tempfile::TempDir;

use super::{Robot, START, driven};
use crate::{Slam, begun};

/// A folder, and a file that is not there yet.
fn place() -> (TempDir, PathBuf, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("room.yaml");
    let text = path.to_str().expect("a path in Unicode").to_owned();
    (folder, path, text)
}

fn map() -> MapFile {
    driven().bench.schema().drawn.file().expect("a map")
}

fn has_failed(robot: &Robot) -> bool {
    let log = robot.bench.log().iter();
    log.into_iter()
        .any(|(_, line)| line.contains("cannot save the map"))
}

/// Iterates until something holds.
fn until(robot: &mut Robot, holds: impl Fn(&Robot) -> bool) {
    let _watchdog = Watchdog::new(Duration::from_secs(600), || "the map is not saved".into());
    while !holds(robot) {
        robot.iterate();
        std::thread::yield_now();
    }
}

#[test]
fn the_map_is_saved_in_the_form_of_a_map_server() {
    let (folder, path, text) = place();
    let mut robot = Robot::with(|bench| {
        bench.set("map_file_name", Text::<1024>::truncated(&text));
        bench.set("save_every", 1.0);
    });
    robot.drive(70);
    // A thread writes it.
    let is_saved = || {
        let Ok(map) = MapFile::load(&path) else {
            return false;
        };
        let count = |state| map.cells.iter().filter(|&&cell| cell == state).count();
        count(MapCell::Occupied) > 150 && count(MapCell::Free) > 5000
    };
    until(&mut robot, |robot| {
        is_saved() && !robot.bench.schema().saving.is_busy()
    });
    // By the button, to a folder that is there no longer.
    drop(folder);
    robot.bench.draw().expect("the panel is drawn");
    let touched = robot.bench.touch("save", Touch::Pressed);
    touched.expect("the gesture is handled");
    until(&mut robot, has_failed);
    robot.drive(1);
    robot.is_right();
}

#[test]
fn a_map_that_cannot_be_saved_is_saved_when_it_can_be() {
    let (folder, _, _) = place();
    let path = folder.path().join("later/room.yaml");
    let text = path.to_str().expect("a path in Unicode").to_owned();
    let mut robot = Robot::with(|bench| {
        bench.set("map_file_name", Text::<1024>::truncated(&text));
        bench.set("save_every", 1.0);
    });
    robot.drive(70);
    until(&mut robot, has_failed);
    // It stands, and all that it has seen is drawn.
    (0..40).for_each(|_| robot.iterate());
    std::fs::create_dir(folder.path().join("later")).expect("a folder");
    until(&mut robot, |_| path.exists());
}

#[test]
fn what_was_seen_since_is_saved_when_it_falls_asleep() {
    let (_folder, path, text) = place();
    let mut robot = Robot::with(|bench| {
        bench.set("map_file_name", Text::<1024>::truncated(&text));
        bench.set("save_every", 86400.0);
    });
    robot.drive(0);
    until(&mut robot, |robot| {
        path.exists() && !robot.bench.schema().saving.is_busy()
    });
    let first = MapFile::load(&path).expect("a map");
    robot.drive(70);
    robot.bench.sleep().expect("it sleeps");
    // No iteration sees that it is written.
    let _watchdog = Watchdog::new(Duration::from_secs(600), || "the map is not saved".into());
    while !MapFile::load(&path).is_ok_and(|map| map != first) {
        std::thread::yield_now();
    }
}

#[test]
fn a_saved_map_is_continued() {
    let (_folder, path, text) = place();
    map().save(&path).expect("it is saved");
    // The robot starts elsewhere, 0.1 m from where it is said to be, with another odometry.
    let elsewhere = Pose2D::new(2.1, 1.9, 1.0);
    let mut robot = Robot::with(|bench| {
        bench.set("map_file_name", Text::<1024>::truncated(&text));
        bench.set("map_start_pose", elsewhere);
    });
    robot.truth = Pose2D::new(2.15, 1.8, 1.05);
    robot.odometry = Pose2D::new(3.0, 4.0, -2.0);
    robot.bench.import("odometry", &robot.measured());
    robot.iterate();
    robot.says_nothing("reads the map, 8 of ");
    assert_eq!(robot.bench.schema().slam.scans().len(), 0);
    // It drives meanwhile, and its odometry jumps.
    let start = robot.truth;
    while robot.words().contains("reads the map") {
        robot.step(0.4, 0.0);
        robot.odometry = Pose2D::new(30.0 - robot.odometry.x, 4.0, 0.5);
        robot.bench.import("odometry", &robot.measured());
        robot.iterate();
    }
    let way = start.distance_to(&robot.truth);
    assert!(way > 0.7, "{way} m");
    robot.step(0.0, 0.0);
    let pose = robot.pose().expect("it fits").pose2d();
    assert!(pose.distance_to(&robot.truth) < 0.1, "{pose:?}");
    let keyframes = robot.bench.schema().slam.scans().len();
    assert!(keyframes > 16);
    robot.drive(70);
    robot.is_right();
    let more = robot.bench.schema().slam.scans().len();
    assert!(more < keyframes + 4, "{keyframes} became {more} keyframes");
}

#[test]
fn a_reload_waits_for_the_map_that_is_written() {
    let (folder, path, text) = place();
    map().save(&path).expect("it is saved");
    let mut robot = Robot::with(|bench| {
        bench.set("map_file_name", Text::<1024>::truncated(&text));
        bench.set("save_every", 86400.0);
    });
    (0..10).for_each(|_| robot.step(0.0, 0.0));
    robot.drive(70);
    let saved = robot.bench.save().expect("it saves");
    // The map that the previous build has is not written yet.
    let held = std::fs::File::open(folder.path()).expect("a folder");
    held.lock_shared().expect("it is locked");
    let mut reloaded = Robot::with(|bench| {
        bench.set("map_file_name", Text::<1024>::truncated(&text));
        bench.set("map_start_pose", START);
    });
    let given = robot.bench.schema().slam.given();
    assert!(given > 16);
    reloaded.bench.restore(&saved).expect("it restores");
    (reloaded.truth, reloaded.odometry) = (robot.truth, robot.odometry);
    (0..5).for_each(|_| reloaded.step(0.05, 0.0));
    reloaded.says_nothing("waits for the file of the map");
    let mut part = MapFile::load(&path).expect("a map");
    // All but what is above 3 m.
    part.cells[part.height * 4 / 7 * part.width..].fill(MapCell::Unknown);
    part.save(&path).expect("it is saved");
    drop(held);
    until(&mut reloaded, |robot| robot.bench.schema().slam.given() > 0);
    let read = reloaded.bench.schema().slam.given();
    assert!(
        read < given,
        "the newer one has {read} keyframes, the older {given}"
    );
    (0..3).for_each(|_| reloaded.step(0.0, 0.1));
    reloaded.is_right();
}

#[test]
fn a_map_that_cannot_be_read_after_a_reload_is_a_fault() {
    let (_folder, path, text) = place();
    let saved = driven().bench.save().expect("it saves");
    let mut robot = Robot::with(|bench| {
        bench.set("map_file_name", Text::<1024>::truncated(&text));
    });
    std::fs::write(&path, "image: room.pgm\nresolution: -1\n").expect("it is written");
    robot.bench.restore(&saved).expect("it restores");
    let _watchdog = Watchdog::new(Duration::from_secs(600), || "there is no fault".into());
    let failure = loop {
        match robot.bench.iterate() {
            Ok(()) => std::thread::yield_now(),
            Err(failure) => break failure.to_string(),
        }
    };
    assert!(failure.contains("resolution"), "{failure}");
}

#[test]
fn what_was_seen_while_a_map_was_written_is_saved_as_it_falls_asleep() {
    let (_folder, path, text) = place();
    let mut robot = Robot::with(|bench| {
        bench.set("map_file_name", Text::<1024>::truncated(&text));
        bench.set("save_every", 1.0);
    });
    robot.drive(70);
    robot.bench.draw().expect("the panel is drawn");
    let touched = robot.bench.touch("save", Touch::Pressed);
    touched.expect("the gesture is handled");
    robot.bench.sleep().expect("it sleeps");
    let last = robot.bench.schema().drawn.file();
    let _watchdog = Watchdog::new(Duration::from_secs(600), || "the map is not saved".into());
    while MapFile::load(&path).ok() != last {
        std::thread::yield_now();
    }
}

#[test]
fn a_file_that_is_no_map_or_has_none_there_is_refused_in_words() {
    let (_folder, path, text) = place();
    let awake = |initial: Pose2D| {
        let mut bench = Bench::<Slam>::new();
        bench.set("map_file_name", Text::<1024>::truncated(&text));
        bench.set("map_start_pose", initial);
        let problems = bench.inspect().expect("it inspects");
        (
            problems.len(),
            bench.awake().map_err(|failure| failure.to_string()),
        )
    };
    assert!(matches!(awake(START), (0, Ok(()))), "there is no file yet");
    map().save(&path).expect("it is saved");
    for name in ["room.pgm", "room", ".yaml"] {
        assert!(begun(name, &START, 100).is_err(), "{name}");
    }
    let (problems, refused) = awake(Pose2D::new(-3.0, 0.0, 0.0));
    assert_eq!(problems, 1);
    assert!(refused.is_err_and(|words| words.contains("no free cells around the robot at -3.00, 0.00")));
    let few = begun(&text, &START, 10).map(drop);
    assert!(few.is_err_and(|words| words.contains("raise `keyframes`, which is 10")));
    std::fs::write(&path, "image: room.pgm\nresolution: -1\n").expect("it is written");
    let (problems, refused) = awake(START);
    assert_eq!(problems, 1);
    assert!(refused.is_err_and(|words| words.contains("resolution")));
}

#[test]
fn a_map_that_is_continued_is_written_only_when_it_has_grown() {
    let (_folder, path, text) = place();
    map().save(&path).expect("it is saved");
    let mut robot = Robot::with(|bench| {
        bench.set("map_file_name", Text::<1024>::truncated(&text));
        bench.set("save_every", 1.0);
    });
    (0..40).for_each(|_| robot.step(0.0, 0.0));
    robot.is_right();
    robot.bench.sleep().expect("it sleeps");
    assert!(!robot.bench.schema().saving.is_busy() && robot.bench.schema().saving.last.is_none());
}
