//! Rendered scenes: a floor with a box, a wall, a step down and a lintel, seen by inclined cameras.

use jde_schema::types::LaserScan;
use proptest::prelude::*;

use crate::{FloorScan, Level, Limits, LimitsError};

const LIMITS: Limits = Limits {
    height: 0.5,
    min_height: 0.05,
    max_height: 1.0,
    max_drop: 0.05,
    range_min: 0.8,
    range_max: 3.0,
    angle_min: -0.4,
    angle_max: 0.4,
    angle_increment: 0.01,
};

/// What is on the floor: a box that begins `near` m ahead, `half` m to each side, `deep` m long and `top` m high; the floor
/// ends at `end` m ahead and goes on `drop` m lower. A black box has no depths.
#[derive(Clone, Copy, Debug)]
struct Scene {
    is_black: bool,
    near: f64,
    half: f64,
    deep: f64,
    top: f64,
    end: f64,
    drop: f64,
}

const FREE: Scene = Scene {
    is_black: false,
    near: f64::INFINITY,
    half: 0.2,
    deep: f64::INFINITY,
    top: 0.3,
    end: f64::INFINITY,
    drop: 0.3,
};

impl Scene {
    /// Returns where a ray from the camera meets the scene first, in the level frame.
    fn meet(&self, height: f64, [x, y, z]: [f64; 3]) -> Option<[f64; 3]> {
        let at = |t: f64| [t * x, t * y, height + t * z];
        let front = (self.near / x > 0.0 && x > 0.0).then(|| at(self.near / x));
        let front = front.filter(|[_, y, z]| y.abs() <= self.half && (0.0..=self.top).contains(z));
        let top = at((self.top - height) / z);
        let is_along = top[0] >= self.near && top[0] - self.near <= self.deep;
        let is_top = z < 0.0 && self.top < height && is_along && top[1].abs() <= self.half;
        let floor = (z < 0.0)
            .then(|| at(-height / z))
            .filter(|[x, ..]| *x <= self.end);
        let below = (z < 0.0)
            .then(|| at((-self.drop - height) / z))
            .filter(|[x, ..]| *x > self.end);
        // The wall of the step faces away from the camera.
        let on_box = front.or(is_top.then_some(top));
        if self.is_black && on_box.is_some() {
            return None;
        }
        on_box.or(floor).or(below)
    }

    /// Returns the scan of a camera of 160 x 120 pixels.
    fn scan(&self, level: &Level, limits: Limits) -> LaserScan {
        let height = level.height;
        let mut seen = FloorScan::new(Limits { height, ..limits }).expect("valid limits");
        for row in 0..120 {
            for column in 0..160 {
                let ray = [
                    (f64::from(column) - 79.5) / 150.0,
                    (f64::from(row) - 59.5) / 150.0,
                    1.0,
                ];
                let [x, y, z] = level.optical(ray);
                if let Some(point) = self.meet(level.height, [x, y, z - level.height]) {
                    seen.add(point);
                }
            }
        }
        let mut scan = LaserScan::default();
        seen.write(&mut scan);
        scan
    }
}

fn level(pitch: f64, roll: f64) -> Level {
    Level {
        height: 0.5,
        pitch,
        roll,
    }
}

fn ahead(scan: &LaserScan) -> f32 {
    scan.ranges[scan.ranges.len() / 2]
}

#[test]
fn an_axis_ahead_of_a_camera_that_looks_down_meets_the_floor() {
    let level = level(0.5, 0.0);
    let [x, y, z] = level.optical([0.0, 0.0, 1.0]);
    assert!((z - (0.5 - 0.5_f64.sin())).abs() < 1e-12 && (x - 0.5_f64.cos()).abs() < 1e-12 && y == 0.0);
    let right = Level { roll: 0.1, ..level }.optical([1.0, 0.0, 0.0]);
    assert!(right[2] < 0.5, "leaning to the right, the right side is low");
}

#[test]
fn a_free_floor_is_free_and_where_it_is_not_seen_it_is_unknown() {
    let scan = FREE.scan(&level(0.35, 0.0), LIMITS);
    assert!(
        scan.ranges.iter().all(|range| *range == f32::INFINITY),
        "{:?}",
        scan.ranges
    );
    // A level camera of this height sees the floor from 1.3 m on.
    let scan = FREE.scan(&level(0.0, 0.0), LIMITS);
    assert!(scan.ranges.iter().all(|range| range.is_nan()));
    let mut nothing = LaserScan::default();
    assert!(!FloorScan::new(LIMITS).expect("valid").write(&mut nothing));
}

#[test]
fn what_the_robot_passes_below_is_no_obstacle_and_no_floor() {
    let mut seen = FloorScan::new(LIMITS).expect("valid");
    seen.add([2.0, 0.0, 1.2]);
    for bad in [
        [f64::NAN, 0.0, 0.1],
        [2.0, f64::INFINITY, 0.1],
        [2.0, 0.0, f64::NAN],
    ] {
        seen.add(bad);
    }
    let mut scan = LaserScan::default();
    assert!(!seen.write(&mut scan));
}

#[test]
fn limits_that_contradict_each_other_are_refused() {
    let new = |change: fn(&mut Limits)| {
        let mut limits = LIMITS;
        change(&mut limits);
        FloorScan::new(limits).map(drop)
    };
    assert_eq!(new(|limits| limits.max_height = 0.05), Err(LimitsError::Heights));
    assert_eq!(new(|limits| limits.range_max = 0.5), Err(LimitsError::Ranges));
    assert_eq!(new(|limits| limits.angle_max = -0.4), Err(LimitsError::Angles));
    let many = new(|limits| limits.angle_increment = 1e-4).expect_err("8001 beams");
    assert!(many.to_string().contains("raise `angle_increment`"), "{many}");
}

/// Returns the scan of floor straight ahead between these places, and of a wall.
fn floor_and_wall(limits: Limits, parts: &[[f64; 2]], wall: f64) -> LaserScan {
    let mut seen = FloorScan::new(limits).expect("valid");
    for [from, to] in parts {
        let steps = ((to - from) / 0.01).round() as u32;
        (0..=steps).for_each(|step| seen.add([from + 0.01 * f64::from(step), 0.0, 0.0]));
    }
    seen.add([wall, 0.0, 0.4]);
    let mut scan = LaserScan::default();
    seen.write(&mut scan);
    scan
}

#[test]
fn a_wall_behind_a_hole_without_depths_does_not_make_the_hole_free() {
    let scan = floor_and_wall(LIMITS, &[[0.7, 1.2], [1.7, 2.0]], 2.0);
    assert!((1.15..=1.2).contains(&ahead(&scan)), "{}", ahead(&scan));
    // Nothing is known from the start on.
    let scan = floor_and_wall(LIMITS, &[[1.2, 2.0]], 2.0);
    assert_eq!(ahead(&scan), f32::NEG_INFINITY);
    let scan = floor_and_wall(LIMITS, &[[0.7, 2.0]], 2.0);
    assert_eq!(ahead(&scan), 2.0);
}

#[test]
fn floor_nearer_than_the_least_range_is_not_the_floor_behind_it() {
    let all = floor_and_wall(LIMITS, &[[0.3, 3.0]], f64::NAN);
    assert_eq!((ahead(&all), all.range_min), (f32::INFINITY, 0.8));
    let parts = floor_and_wall(LIMITS, &[[0.3, 0.5], [1.0, 3.0]], f64::NAN);
    assert!(ahead(&parts).is_nan());
}

#[test]
fn an_obstacle_nearer_than_the_least_range_is_where_it_is_and_the_scan_says_nothing_of_what_is_nearer() {
    let mut seen = FloorScan::new(LIMITS).expect("valid");
    for step in 75..305 {
        seen.add([0.01 * f64::from(step), 0.0, 0.0]);
    }
    seen.add([0.4, 0.1, 0.2]);
    let mut scan = LaserScan::default();
    assert!(seen.write(&mut scan));
    let (left, near) = (scan.ranges[64], 0.4_f32.hypot(0.1));
    assert!((left - near).abs() < 1e-6 && (scan.range_min - near).abs() < 1e-6);
    assert!(
        scan.points()
            .any(|point| (point.range - f64::from(near)).abs() < 1e-6)
    );
    assert!(ahead(&scan).is_nan(), "from there on the floor is not seen");
}

proptest! {
    #[test]
    fn what_has_no_depth_is_never_free(
        near in 0.85..2.5f64, top in 0.06..0.45f64, pitch in 0.3..0.45f64, height in 0.4..0.6f64,
    ) {
        let level = Level { height, pitch, roll: 0.0 };
        let limits = Limits { range_max: 2.6, angle_increment: 0.02, ..LIMITS };
        let scan = Scene { near, top, deep: 0.02, is_black: true, ..FREE }.scan(&level, limits);
        for (beam, range) in scan.ranges.iter().enumerate() {
            let angle = scan.angle(beam);
            if (near * angle.tan()).abs() < 0.15 {
                let most = (near / angle.cos() + 0.02) as f32;
                prop_assert!(range.is_nan() || *range <= most, "{range}");
            }
        }
    }

    #[test]
    fn a_box_is_where_it_begins_and_what_is_behind_it_is_not_free(
        near in 1.0..2.5f64, top in 0.1..0.45f64, pitch in 0.25..0.45f64, roll in -0.1..0.1f64,
    ) {
        let scan = Scene { near, top, ..FREE }.scan(&level(pitch, roll), LIMITS);
        prop_assert!((f64::from(ahead(&scan)) - near).abs() < 0.02, "{}", ahead(&scan));
        for (beam, range) in scan.ranges.iter().enumerate() {
            let angle = scan.angle(beam);
            if (near * angle.tan()).abs() < 0.18 {
                prop_assert!(range.is_finite() && *range < (near / angle.cos() + 0.3) as f32);
            }
        }
    }

    #[test]
    fn a_step_down_is_an_obstacle_at_its_edge_or_a_little_before(
        end in 1.2..2.4f64, drop in 0.08..1.0f64, pitch in 0.3..0.4f64, roll in -0.05..0.05f64,
    ) {
        let scan = Scene { end, drop, ..FREE }.scan(&level(pitch, roll), LIMITS);
        let range = f64::from(ahead(&scan));
        prop_assert!(range <= end + 0.01 && range > end - 0.15, "{range}");
        prop_assert!(scan.ranges.iter().all(|range| range.is_finite()));
    }

    #[test]
    fn a_shallow_step_is_floor(end in 1.2..2.4f64) {
        let scan = Scene { end, drop: 0.02, ..FREE }.scan(&level(0.35, 0.0), LIMITS);
        prop_assert!(scan.ranges.iter().all(|range| *range == f32::INFINITY));
    }

    #[test]
    fn any_points_make_a_scan_or_nothing(
        points in prop::collection::vec(prop::array::uniform3(prop::num::f64::ANY), 0..50), height in 0.02..10.0f64,
    ) {
        let mut seen = FloorScan::new(Limits { height, ..LIMITS }).expect("valid");
        points.into_iter().for_each(|point| seen.add(point));
        let mut scan = LaserScan::default();
        if seen.write(&mut scan) {
            prop_assert_eq!(scan.measured(), Ok(()));
        }
    }
}
