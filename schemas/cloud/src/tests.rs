//! Clouds of a floor with a box and an edge, in both frames, and clouds that are none.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_schema::types::{PointCloud2, PointField};

use crate::Scan;

const HEIGHT: f64 = 0.4;

/// A cloud of points in the frame of a level sensor, x ahead; in the optical frame if that is asked for.
fn cloud(points: &[[f64; 3]], is_optical: bool) -> Box<PointCloud2> {
    let mut cloud = PointCloud2::boxed();
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
    let mut bad = cloud(&scene(4.0, 1.7), false);
    bad.fields.clear();
    bench.import("cloud", bad.as_ref());
    bench.iterate().expect("it iterates");
    assert_eq!(bench.exported::<LaserScan>("scan"), None);
    assert_eq!(
        said(&bench).last().map(String::as_str),
        Some("no scan: there is no cloud")
    );
    bench.retract("cloud");
    bench.iterate().expect("it iterates");
    assert_eq!(bench.exported::<LaserScan>("scan"), None);
}
