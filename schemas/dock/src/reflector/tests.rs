//! The schema on made-up scans of a wall with strips: what it finds, where that is, and what it refuses.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_schema::types::PoseStamped;

use super::{Reflector, ReflectorStrips};

const OFFSETS: [f64; 3] = [-0.2, 0.08, 0.2];
const WIDTH: f64 = 0.05;
const DULL_INTENSITY: f32 = 10.0;
const BRIGHT_INTENSITY: f32 = 200.0;

/// A wall through a place of the laser's frame, in the direction of the y of that pose, with strips and bright things
/// along it: where each begins and ends.
struct Wall {
    pose: Pose2D,
    bright: Vec<(f64, f64)>,
}

impl Wall {
    /// A reflector that faces the laser, `x` m ahead, `y` m to the left and turned by `turn`.
    fn at(x: f64, y: f64, turn: f64) -> Self {
        let mut wall = Self {
            pose: Pose2D::new(x, y, PI + turn),
            bright: Vec::new(),
        };
        OFFSETS.iter().for_each(|offset| wall.add(*offset, WIDTH));
        wall
    }

    fn add(&mut self, middle: f64, width: f64) {
        self.bright.push((middle - width / 2.0, middle + width / 2.0));
    }

    /// Returns the range and the intensity along a direction of the laser; the wall ends 2 m beside its middle.
    fn cast(&self, angle: f64) -> (f32, f32) {
        let laser = self.pose.localize(&Pose2D::new(0.0, 0.0, angle));
        let range = -laser.x / laser.theta.cos();
        let y = laser.y + range * laser.theta.sin();
        if range.is_nan() || range <= 0.0 || y.abs() > 2.0 {
            return (f32::INFINITY, 0.0);
        }
        let is_bright = self.bright.iter().any(|(from, to)| (*from..=*to).contains(&y));
        (
            range as f32,
            if is_bright {
                BRIGHT_INTENSITY
            } else {
                DULL_INTENSITY
            },
        )
    }
}

/// A scan of the nearest of some walls, 0.5 degrees from beam to beam, whose first beam points to `first`.
fn scan(walls: &[Wall], first: f64) -> LaserScan {
    let step = TAU / 720.0;
    let beams = (0..720).map(|beam| {
        let angle = first + f64::from(beam) * step;
        let hits = walls.iter().map(|wall| wall.cast(angle));
        hits.min_by(|a, b| a.0.total_cmp(&b.0)).expect("there is a wall")
    });
    let (ranges, intensities): (Vec<f32>, Vec<f32>) = beams.unzip();
    LaserScan {
        header: Header::new(Duration::from_millis(50), "laser"),
        angle_min: first as f32,
        angle_max: (first + 719.0 * step) as f32,
        angle_increment: step as f32,
        range_max: 12.0,
        ranges: Seq::from_slice(&ranges).expect("720 beams fit"),
        intensities: Seq::from_slice(&intensities).expect("720 beams fit"),
        ..LaserScan::default()
    }
}

fn bench() -> Bench<Reflector> {
    let mut bench = Bench::new();
    let offsets = Seq::from_slice(&OFFSETS).expect("they fit");
    bench.set("strips", ReflectorStrips { offsets });
    bench.set("bright", 100.0);
    bench
}

/// Returns the reflector in a scan, or the words.
fn find(bench: &mut Bench<Reflector>, scan: &LaserScan) -> Result<Pose2D, String> {
    bench.import("laser", scan);
    bench.iterate().expect("it iterates");
    let found: Option<PoseStamped> = bench.exported("reflector");
    let state: Text<160> = bench.exported("state").expect("it says something");
    found.map(|found| found.pose.into()).ok_or(state.as_str().into())
}

#[test]
fn a_reflector_is_found_where_it_is() {
    for (x, y, turn) in [
        (0.5, 0.0, 0.0),
        (1.0, 0.3, 0.2),
        (2.0, -0.8, 0.6),
        (3.0, 0.5, -0.3),
        (-0.6, 0.1, PI),
    ] {
        let wall = Wall::at(x, y, turn);
        for first in [-PI, 0.0, FRAC_PI_2] {
            let found = find(&mut bench(), &scan(&[Wall::at(x, y, turn)], first)).expect("it is found");
            let shown = format!("{x}, {y}, {turn} from {first}: {found:?}");
            // Within half of the distance from beam to beam.
            let off = wall.pose.localize(&found);
            assert!(off.x.hypot(off.y) < 0.005 * x.hypot(y), "{shown}");
            assert!(off.theta.abs() < 0.002, "{shown}");
        }
    }
}

#[test]
fn a_scan_is_stamped_with_its_time_and_frame() {
    let mut bench = bench();
    find(&mut bench, &scan(&[Wall::at(1.0, 0.0, 0.0)], -PI)).expect("it is found");
    let found: PoseStamped = bench.exported("reflector").expect("it is exported");
    assert_eq!(found.header, Header::new(Duration::from_millis(50), "laser"));
}

#[test]
fn a_dull_beam_does_not_divide_a_strip() {
    let mut holed = scan(&[Wall::at(0.5, 0.0, 0.0)], -PI);
    let bright = holed
        .intensities
        .iter()
        .position(|bright| *bright == BRIGHT_INTENSITY);
    holed.intensities[bright.expect("a strip is seen") + 2] = DULL_INTENSITY;
    find(&mut bench(), &holed).expect("it is found");
}

#[test]
fn too_many_bright_things_are_refused_in_words() {
    let mut noise = scan(&[Wall::at(0.5, 0.0, 0.0)], -PI);
    for beam in (0..720).step_by(3) {
        noise.ranges[beam] = 3.0;
        noise.intensities[beam] = BRIGHT_INTENSITY;
    }
    let words = find(&mut bench(), &noise).expect_err("it is noise");
    assert!(words.ends_with("as strips: raise `bright`"), "{words}");
}

#[test]
fn a_covered_strip_a_mirror_and_other_bright_things_are_no_reflector() {
    let wall = |strips: &[f64]| {
        let mut wall = Wall::at(1.0, 0.0, 0.0);
        wall.bright.clear();
        strips.iter().for_each(|offset| wall.add(*offset, WIDTH));
        wall
    };
    let mut pane = Wall::at(1.0, 0.0, 0.0);
    pane.bright = vec![(-0.6, 0.3)];
    let mut covered = wall(&OFFSETS);
    covered.add(-0.05, 0.03);
    for (seen, words) in [
        (
            wall(&OFFSETS[..2]),
            "no reflector of 3 strips among 2 bright ones and 0 other things",
        ),
        // As a mirror shows it.
        (
            wall(&[-0.2, -0.08, 0.2]),
            "no reflector of 3 strips among 3 bright ones and 0 other things",
        ),
        (
            pane,
            "no reflector of 3 strips among 0 bright ones and 1 other things",
        ),
        (
            wall(&[]),
            "no reflector of 3 strips among 0 bright ones and 0 other things",
        ),
        // A reflector of another shape that has all of these strips.
        (
            covered,
            "no reflector of 3 strips among 4 bright ones and 0 other things",
        ),
    ] {
        assert_eq!(find(&mut bench(), &scan(&[seen], -PI)), Err(words.into()));
    }
}

#[test]
fn of_two_reflectors_none_is_exported() {
    let walls = || [Wall::at(1.0, 0.0, 0.0), Wall::at(-2.0, 0.5, PI)];
    let mut bench = bench();
    let refused = find(&mut bench, &scan(&walls(), -PI)).expect_err("there are two");
    assert_eq!(refused, "two reflectors of this shape, 3.04 m apart");
    bench.set("range", 1.5);
    let found = find(&mut bench, &scan(&walls(), -PI)).expect("the other one is too far away");
    assert!((found.x - 1.0).abs() < 0.01, "{found:?}");
}

#[test]
fn a_wall_and_legs_beside_the_reflector_do_not_hide_it() {
    let mut wall = Wall::at(1.5, 0.0, 0.0);
    wall.add(0.9, 0.7);
    wall.add(-0.7, WIDTH);
    wall.add(-1.1, 0.03);
    let found = find(&mut bench(), &scan(&[wall], -PI)).expect("it is found");
    assert!((found.x - 1.5).abs() < 0.01 && found.y.abs() < 0.01, "{found:?}");
}

#[test]
fn a_scan_without_intensities_says_so() {
    let mut dull = scan(&[Wall::at(1.0, 0.0, 0.0)], -PI);
    let _ = dull.intensities.resize(100);
    let refused = "the scan has 100 intensities for 720 ranges";
    assert_eq!(find(&mut bench(), &dull), Err(refused.into()));
    dull.intensities.clear();
    let refused = "the laser measures no intensities";
    assert_eq!(find(&mut bench(), &dull), Err(refused.into()));
}

#[test]
fn numbers_that_are_not_finite_are_not_bright() {
    let mut broken = scan(&[Wall::at(1.0, 0.0, 0.0)], -PI);
    for beam in 0..720 {
        match beam % 3 {
            0 => broken.intensities[beam] = f32::NAN,
            1 => broken.ranges[beam] = f32::NAN,
            _ => broken.ranges[beam] = f32::NEG_INFINITY,
        }
    }
    let refused = find(&mut bench(), &broken).expect_err("nothing is seen");
    assert_eq!(
        refused,
        "no reflector of 3 strips among 0 bright ones and 0 other things"
    );
    broken.intensities.fill(f32::INFINITY);
    broken.ranges.fill(1.0);
    broken.angle_increment = f32::NAN;
    assert!(find(&mut bench(), &broken).is_err());
}

#[test]
fn a_laser_that_ends_and_a_sleep_retract_it() {
    let mut bench = bench();
    let seen = scan(&[Wall::at(1.0, 0.0, 0.0)], -PI);
    find(&mut bench, &seen).expect("it is found");
    bench.retract("laser");
    bench.iterate().expect("it iterates");
    let state: Text<160> = bench.exported("state").expect("it says something");
    assert_eq!(state.as_str(), "there is no scan");
    assert_eq!(bench.exported::<PoseStamped>("reflector"), None);
    find(&mut bench, &seen).expect("it is found again");
    bench.sleep().expect("it sleeps");
    assert_eq!(bench.exported::<PoseStamped>("reflector"), None);
}

#[test]
fn a_shape_that_cannot_be_found_is_refused_before_the_start() {
    let mut bench = Bench::<Reflector>::new();
    let wrong = |bench: &mut Bench<Reflector>| format!("{:?}", bench.inspect());
    assert!(wrong(&mut bench).contains("fewer than two strips"));
    assert!(wrong(&mut bench).contains("is 0"));
    bench.set("bright", 100.0);
    for offsets in [[0.2, -0.2], [0.0, 0.06]] {
        let offsets = Seq::from_slice(&offsets).expect("they fit");
        bench.set("strips", ReflectorStrips { offsets });
        assert!(wrong(&mut bench).contains("two widths"), "{:?}", bench.inspect());
    }
}

#[test]
fn the_panel_shows_the_intensities_and_the_reflector() {
    let mut bench = bench();
    find(&mut bench, &scan(&[Wall::at(1.0, 0.0, 0.0)], -PI)).expect("it is found");
    let shown = format!("{:?}", bench.draw().expect("it draws"));
    assert!(shown.contains("a reflector, 1.00 m away"), "{shown}");
    assert!(shown.contains("intensity of each beam"), "{shown}");
}
