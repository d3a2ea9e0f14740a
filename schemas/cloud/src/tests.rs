//! Clouds of a floor with a box and an edge, in both frames, and clouds that are none.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_schema::types::{PointCloud2, PointField};

use crate::Scan;

const HEIGHT: f64 = 0.4;

/// A cloud of points in the frame of a level sensor, x ahead; in the optical frame if that is asked for.
fn cloud(points: &[[f64; 3]], is_optical: bool) -> Box<PointCloud2> {
    let mut cloud = PointCloud2::boxed();
    cloud.header.frame_id = Text::new("lidar");
    (cloud.height, cloud.width, cloud.point_step) = (1, points.len() as u32, 12);
    cloud.row_step = 12 * points.len() as u32;
    for (name, offset) in [("x", 0), ("y", 4), ("z", 8)] {
        let field = PointField {
            name: Text::truncated(name),
            offset,
            datatype: PointField::FLOAT32,
            count: 1,
            ..PointField::default()
        };
        cloud.fields.push(field).expect("three");
    }
    for &[x, y, z] in points {
        let point = if is_optical { [-y, -z, x] } else { [x, y, z] };
        for axis in point {
            cloud
                .data
                .extend_from_slice(&(axis as f32).to_le_bytes())
                .expect("a small cloud");
        }
    }
    cloud
}

/// A floor ahead up to `end` m, with a post at `post` m in its middle.
fn scene(end: f64, post: f64) -> Vec<[f64; 3]> {
    let along = |from: f64, to: f64| {
        (0..)
            .map(move |step| from + 0.02 * f64::from(step))
            .take_while(move |at| *at < to)
    };
    let across = || (-10..=10).map(|step| f64::from(step) * 0.05);
    let ground = along(0.5, end).flat_map(|range| across().map(move |angle| (range, angle, -HEIGHT)));
    let below = along(end + 0.02, 4.0)
        .flat_map(|range| across().map(move |angle| (range * (HEIGHT + 0.5) / HEIGHT, angle, -HEIGHT - 0.5)));
    let seen = ground
        .chain(below)
        .map(|(range, angle, z)| [range * angle.cos(), range * angle.sin(), z]);
    let tall = along(0.0, 0.5).map(|z| [post, 0.0, z - HEIGHT + 0.06]);
    seen.chain(tall).collect()
}

/// The same cloud in two rows: z, a number of a byte, x and y in double precision, the most significant byte first, bytes
/// between the points and behind the rows, and points that are none.
fn unusual(points: &[[f64; 3]]) -> Box<PointCloud2> {
    let mut cloud = PointCloud2::boxed();
    let width = points.len().div_ceil(2);
    (cloud.height, cloud.width, cloud.point_step) = (2, width as u32, 32);
    cloud.row_step = cloud.point_step * cloud.width + 7;
    cloud.is_bigendian = Flag::TRUE;
    for (name, offset, datatype) in [("z", 1, 8), ("ring", 9, 2), ("x", 11, 8), ("y", 20, 8)] {
        let field = PointField {
            name: Text::truncated(name),
            offset,
            datatype,
            count: 1,
            ..PointField::default()
        };
        cloud.fields.push(field).expect("four");
    }
    for row in points.chunks(width) {
        let row = row.iter().chain(core::iter::repeat(&[f64::NAN; 3])).take(width);
        for [x, y, z] in row {
            let mut point = [0xff; 32];
            for (offset, axis) in [(1, z), (11, x), (20, y)] {
                point[offset..][..8].copy_from_slice(&axis.to_be_bytes());
            }
            cloud.data.extend_from_slice(&point).expect("a small cloud");
        }
        cloud.data.extend_from_slice(&[0xff; 7]).expect("a small cloud");
    }
    cloud
}

fn seen(points: &[[f64; 3]], is_optical: bool) -> Bench<Scan> {
    let mut bench = Bench::new();
    bench.set("height", HEIGHT);
    bench.set("optical", Flag::from(is_optical));
    bench.set("angle_increment", 0.05);
    bench.awake().expect("it wakes");
    bench.import("cloud", cloud(points, is_optical).as_ref());
    bench.iterate().expect("it iterates");
    bench
}

#[test]
fn a_post_is_an_obstacle_and_the_floor_beside_it_is_free_in_both_frames() {
    for is_optical in [false, true] {
        let bench = seen(&scene(4.0, 1.7), is_optical);
        let scan = bench.exported::<LaserScan>("scan").expect("a scan");
        let middle = scan.ranges.len() / 2;
        assert!((scan.ranges[middle] - 1.7).abs() < 0.01);
        let free = scan.ranges.iter().filter(|range| **range == f32::INFINITY);
        assert_eq!(free.count(), scan.ranges.len() - 1);
    }
}

#[test]
fn the_edge_of_the_floor_is_an_obstacle() {
    let bench = seen(&scene(1.5, 9.0), false);
    let scan = bench.exported::<LaserScan>("scan").expect("a scan");
    assert!(
        scan.ranges.iter().all(|range| (1.3..=1.51).contains(range)),
        "{:?}",
        scan.ranges
    );
}

#[test]
fn a_cloud_without_floor_or_without_places_gives_no_scan_and_the_log_says_why() {
    let said = |bench: &Bench<Scan>| {
        bench
            .log()
            .iter()
            .map(|(_, text)| text.clone())
            .collect::<Vec<_>>()
    };
    let high = seen(&[[1.0, 0.0, 3.0]], false);
    assert_eq!(high.exported::<LaserScan>("scan"), None);
    assert_eq!(
        said(&high),
        ["no scan: the cloud has neither floor nor anything on it"]
    );
    let mut bench = seen(&scene(4.0, 1.7), false);
    bench.retract("cloud");
    bench.iterate().expect("it iterates");
    assert_eq!(bench.exported::<LaserScan>("scan"), None);
    assert_eq!(said(&bench), ["no scan: there is no cloud"]);
}

#[test]
fn a_reason_stays_until_the_next_cloud_and_the_log_says_it_once() {
    let high = [[1.0, 0.0, 3.0]];
    let mut bench = seen(&high, false);
    let words = "No scan: the cloud has neither floor nor anything on it";
    for _ in 0..3 {
        bench.iterate().expect("it iterates");
        assert_eq!(bench.draw().expect("it draws").texts(), [words]);
        bench.import("cloud", cloud(&high, false).as_ref());
        bench.iterate().expect("it iterates");
    }
    assert_eq!(bench.log().len(), 1);
    bench.import("cloud", cloud(&scene(4.0, 1.7), false).as_ref());
    bench.iterate().expect("it iterates");
    assert_eq!(bench.draw().expect("it draws").texts(), ["It sees"]);
}

#[test]
fn any_order_and_size_of_the_fields_gives_the_same_scan() {
    let points = scene(4.0, 1.7);
    let mut odd = points.clone();
    odd.push([f64::NAN; 3]);
    let mut bench = seen(&points, false);
    let expected = bench.exported::<LaserScan>("scan").expect("a scan");
    for points in [points, odd] {
        bench.awake().expect("it wakes");
        bench.import("cloud", unusual(&points).as_ref());
        bench.iterate().expect("it iterates");
        let scan = bench.exported::<LaserScan>("scan").expect("a scan");
        let mut pairs = scan.ranges.iter().zip(&expected.ranges);
        assert!(pairs.all(|(a, b)| a == b || (a - b).abs() < 1e-5));
    }
}

#[test]
fn a_scan_is_in_a_level_frame_and_clouds_of_two_sensors_are_refused() {
    let points = scene(4.0, 1.7);
    let mut bench = seen(&points, false);
    let scan = bench.exported::<LaserScan>("scan").expect("a scan");
    assert_eq!(scan.header.frame_id, "bench");
    let mut other = cloud(&points, false);
    other.header.frame_id = Text::new("camera");
    bench.import("cloud", other.as_ref());
    bench.iterate().expect("it iterates");
    assert_eq!(bench.exported::<LaserScan>("scan"), None);
    let words = "No scan: the cloud is in `camera`, and the first one was in `lidar`";
    assert_eq!(bench.draw().expect("it draws").texts(), [words]);
}

#[test]
#[should_panic(expected = "angle_increment")]
fn a_direction_is_no_wider_than_a_thing_in_it() {
    Bench::<Scan>::new().set("angle_increment", 0.06);
}
