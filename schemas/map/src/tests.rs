//! What scans make of the map, and what makes none of it.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_schema::types::Point2D;

use super::{File, Local};

/// Four beams, each a quarter of a turn from the last: ahead, left, back, right.
fn scan(ranges: [f32; 4]) -> LaserScan {
    let mut scan = LaserScan {
        angle_increment: core::f32::consts::FRAC_PI_2,
        range_min: 0.1,
        range_max: 3.0,
        ..LaserScan::default()
    };
    scan.ranges.extend_from_slice(&ranges).expect("it fits");
    scan.state_last_angle();
    scan
}

fn bench(ranges: [f32; 4], pose: Pose2D) -> Bench<Local> {
    let mut bench = Bench::new();
    bench.set("side", 4.0);
    bench.set("resolution", 0.1);
    see(&mut bench, ranges, pose);
    bench.awake().expect("it awakes");
    bench
}

fn see(bench: &mut Bench<Local>, ranges: [f32; 4], pose: Pose2D) {
    bench.import("laser", &scan(ranges));
    bench.import("pose", &Odometry::planar(Time::default(), pose, Twist::ZERO));
}

/// The number of the map at a place, after an iteration.
fn at(bench: &Bench<Local>, x: f64, y: f64) -> Option<i8> {
    let map = bench.exported_in_place::<OccupancyGrid>("map")?;
    let (info, origin) = (&map.info, &map.info.origin.position);
    let resolution = f64::from(info.resolution);
    let (column, row) = ((x - origin.x) / resolution, (y - origin.y) / resolution);
    map.data
        .get(row as usize * info.width as usize + column as usize)
        .copied()
}

const NAN: f32 = f32::NAN;

#[test]
fn returns_are_occupied_and_what_lies_before_them_is_free() {
    let mut bench = bench(
        [1.0, f32::INFINITY, NAN, f32::NEG_INFINITY],
        Pose2D::new(0.05, 0.05, 0.0),
    );
    bench.iterate().expect("the iteration succeeds");
    for (x, y, number) in [
        (1.05, 0.05, 100),
        (0.55, 0.05, 0),
        (1.25, 0.05, -1),
        (0.05, 1.55, 0),
        (-0.55, 0.05, -1),
        (0.05, -0.55, -1),
    ] {
        assert_eq!(at(&bench, x, y), Some(number), "{x}, {y}");
    }
}

#[test]
fn the_pose_and_the_mount_place_the_rays() {
    let pose = Pose2D::new(0.05, 0.05, core::f64::consts::FRAC_PI_2);
    let mut bench = bench([1.0, NAN, NAN, NAN], pose);
    bench.set("mount", Pose2D::new(0.2, 0.0, 0.0));
    bench.iterate().expect("the iteration succeeds");
    assert_eq!(at(&bench, 0.05, 1.25), Some(100));
    assert_eq!(at(&bench, 0.05, 0.05), Some(-1), "behind the laser");
}

#[test]
fn the_map_moves_with_the_robot_and_keeps_what_it_saw() {
    let mut bench = bench([1.0, NAN, NAN, NAN], Pose2D::new(0.05, 0.05, 0.0));
    bench.iterate().expect("the iteration succeeds");
    for x in [0.25, 0.45, 0.65, 0.85, 1.05, 1.25, 1.45, 1.55] {
        see(&mut bench, [NAN, 0.5, NAN, NAN], Pose2D::new(x, 0.05, 0.0));
        bench.iterate().expect("the iteration succeeds");
    }
    assert_eq!(at(&bench, 1.05, 0.05), Some(100));
    assert_eq!(at(&bench, 3.05, 0.05), Some(-1));
}

#[test]
fn what_was_seen_before_a_jump_of_the_pose_is_dropped() {
    for (jumped, kept) in [
        (Pose2D::new(0.25, 0.05, 0.0), true),
        (Pose2D::new(0.35, 0.05, 0.0), false),
        (Pose2D::new(0.05, 0.05, 0.6), false),
    ] {
        let mut bench = bench([1.0, NAN, NAN, NAN], Pose2D::new(0.05, 0.05, 0.0));
        bench.iterate().expect("the iteration succeeds");
        see(&mut bench, [NAN, NAN, 0.5, NAN], jumped);
        bench.iterate().expect("the iteration succeeds");
        let expected = if kept { 100 } else { -1 };
        assert_eq!(at(&bench, 1.05, 0.05), Some(expected), "{jumped:?}");
    }
}

#[test]
fn a_request_clears_what_is_occupied_around_a_place_once() {
    let pose = Pose2D::new(0.05, 0.05, 0.0);
    let mut bench = bench([1.0, NAN, NAN, NAN], pose);
    bench.iterate().expect("the iteration succeeds");
    bench.import("clear", &Point2D { x: 0.55, y: 0.05 });
    bench.iterate().expect("the iteration succeeds");
    assert_eq!(at(&bench, 1.05, 0.05), Some(-1));
    see(&mut bench, [1.0, NAN, NAN, NAN], pose);
    bench.iterate().expect("the iteration succeeds");
    bench.iterate().expect("the iteration succeeds");
    assert_eq!(at(&bench, 1.05, 0.05), Some(100), "it is seen again");
}

#[test]
fn a_scan_is_of_its_own_time_however_far_the_robot_has_gone_since() {
    let drive = |x: f64| {
        Odometry::planar(
            Time::default(),
            Pose2D::new(x, 0.05, 0.0),
            Twist::planar(0.5, 0.0),
        )
    };
    let mut bench = bench([1.0, NAN, NAN, NAN], Pose2D::ORIGIN);
    bench.import("pose", &drive(0.05));
    for (now, x) in [(200, 0.15), (400, 0.25)] {
        bench.set_now(Duration::from_millis(now));
        bench.import("pose", &drive(x));
        bench.iterate().expect("the iteration succeeds");
        assert_eq!(at(&bench, 1.05, 0.05), Some(100), "after {now} ms");
        assert_eq!(at(&bench, 1.25, 0.05), Some(-1), "after {now} ms");
    }
    bench.set_now(Duration::from_secs(3));
    bench.import("pose", &drive(1.5));
    bench.iterate().expect("the iteration succeeds");
    assert_eq!(at(&bench, 1.05, 0.05), None, "nobody knows what is there now");
    let (_, words) = bench.log().last().expect("a warning");
    assert_eq!(words, "no map: the scans are 3.0 s old");
}

#[test]
fn without_a_scan_or_a_pose_there_is_no_map() {
    let mut bench = bench([1.0; 4], Pose2D::ORIGIN);
    bench.iterate().expect("the iteration succeeds");
    assert!(at(&bench, 0.0, 0.0).is_some());
    for (name, spoil) in [
        (
            "the scan is retracted",
            (|bench| bench.retract("laser")) as fn(&mut Bench<Local>),
        ),
        ("the pose is no place", |bench| {
            see(bench, [1.0; 4], Pose2D::new(f64::NAN, 0.0, 0.0))
        }),
        ("the pose is too far", |bench| {
            see(bench, [1.0; 4], Pose2D::new(1e12, 0.0, 0.0))
        }),
    ] {
        see(&mut bench, [1.0; 4], Pose2D::ORIGIN);
        spoil(&mut bench);
        bench.iterate().expect("the iteration succeeds");
        assert_eq!(at(&bench, 0.0, 0.0), None, "{name}");
    }
}

#[test]
fn a_map_of_too_many_cells_is_refused() {
    let mut bench = Bench::<Local>::new();
    bench.set("side", 205.0);
    let error = bench.awake().expect_err("refused").to_string();
    assert!(
        error.contains("4100 cells of 0.05 m a side: expected at most 4096"),
        "{error}"
    );
}

#[test]
fn a_map_of_200_m_has_every_cell() {
    let mut bench = bench([1.0; 4], Pose2D::new(0.025, 0.025, 0.0));
    bench.set("side", 200.0);
    bench.set("resolution", 0.05);
    bench.awake().expect("it awakes");
    bench.iterate().expect("the iteration succeeds");
    let map = bench.exported_in_place::<OccupancyGrid>("map").expect("a map");
    assert_eq!((map.info.width, map.data.len()), (4000, 4000 * 4000));
    assert_eq!(at(&bench, 1.025, 0.025), Some(100));
    assert_eq!(at(&bench, 99.0, 99.0), Some(-1));
}

/// A folder with a map of these rows of shades, and its file.
fn map_file(width: usize, shades: &[u8]) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut image = format!("P5 {width} {} 255\n", shades.len() / width).into_bytes();
    image.extend_from_slice(shades);
    std::fs::write(folder.path().join("map.pgm"), image).expect("it writes");
    let text = "image: map.pgm\nresolution: 0.1\norigin: [-1.0, 2.0, 0.0]\n";
    let file = folder.path().join("map.yaml");
    std::fs::write(&file, text).expect("it writes");
    let file = file.to_str().expect("UTF-8").to_owned();
    (folder, file)
}

fn file_bench(file: &str) -> Bench<File> {
    let mut bench = Bench::new();
    bench.set("file", Text::<1024>::truncated(file));
    bench
}

#[test]
fn a_map_is_exported_as_its_files_state_it() {
    let (_folder, file) = map_file(3, &[0, 205, 254, 254, 254, 0]);
    let mut bench = file_bench(&file);
    bench.awake().expect("it awakes");
    bench.iterate().expect("the iteration succeeds");
    bench.iterate().expect("the iteration succeeds");
    let map = bench.exported_in_place::<OccupancyGrid>("map").expect("a map");
    assert_eq!((map.info.width, map.info.height), (3, 2));
    assert_eq!(
        (map.info.origin.position.x, map.info.origin.position.y),
        (-1.0, 2.0)
    );
    // The image begins at the top, the map at the bottom.
    assert_eq!(map.data.as_slice(), [0, 0, 100, 100, -1, 0]);
}

#[test]
fn a_map_may_have_one_cell_or_sixteen_million() {
    for side in [1, 4000] {
        let mut shades = vec![254; side * side];
        shades[0] = 0;
        let (_folder, file) = map_file(side, &shades);
        let mut bench = file_bench(&file);
        bench.awake().expect("it awakes");
        bench.iterate().expect("the iteration succeeds");
        let map = bench.exported_in_place::<OccupancyGrid>("map").expect("a map");
        assert_eq!((map.info.width, map.info.height), (side as u32, side as u32));
        let occupied = map.data.iter().position(|&cell| cell == 100);
        assert_eq!((map.data.len(), occupied), (side * side, Some(side * (side - 1))));
    }
}

#[test]
fn files_that_are_no_map_are_refused() {
    let (_folder, large) = map_file(4100, &vec![254; 4100 * 4100]);
    for (file, words) in [
        ("", "`file` names no map"),
        ("/nowhere/map.yaml", "/nowhere/map.yaml: there is no such file"),
        (large.as_str(), "has 4100 x 4100 cells: expected at most 16777216"),
    ] {
        let error = file_bench(file).awake().expect_err("refused").to_string();
        assert!(error.contains(words), "{error}");
    }
}
