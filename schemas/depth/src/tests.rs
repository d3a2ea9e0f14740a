//! Pictures of a floor with a box, in both encodings, and pictures that are none.

use jde_schema::bench::Bench;
use jde_schema::prelude::*;
use jde_schema::types::CameraInfo;

use crate::Scan;
use crate::picture::Depths;

const SIZE: [u32; 2] = [64, 48];
const FIELD_OF_VIEW: f64 = 1.0;
const HEIGHT: f64 = 0.4;
const PITCH: f64 = 0.35;

/// The depth of each pixel of a camera that looks down at a floor, with a wall `wall` m ahead.
fn depths(wall: f64) -> Vec<f64> {
    let focal = f64::from(SIZE[0]) / 2.0 / (FIELD_OF_VIEW / 2.0).tan();
    let depth = |row: u32| {
        let down = (f64::from(row) + 0.5 - f64::from(SIZE[1]) / 2.0) / focal;
        let (sin, cos) = PITCH.sin_cos();
        let (ahead, up) = (cos - sin * down, -sin - cos * down);
        let floor = if up < 0.0 { -HEIGHT / up } else { f64::INFINITY };
        floor.min(if ahead > 0.0 { wall / ahead } else { f64::INFINITY })
    };
    (0..SIZE[1])
        .flat_map(|row| (0..SIZE[0]).map(move |_| depth(row)))
        .collect()
}

fn picture(encoding: &str, depths: &[f64], is_big: bool) -> Box<Image> {
    let mut image = Image::boxed();
    image.header.frame_id = Text::new("camera_optical");
    [image.width, image.height] = SIZE;
    image.encoding = Text::truncated(encoding);
    image.is_bigendian = u8::from(is_big);
    let bytes = if encoding == "16UC1" { 2 } else { 4 };
    image.step = SIZE[0] * bytes;
    for depth in depths {
        let mut number = if encoding == "16UC1" {
            let whole = if depth.is_finite() {
                (depth * 1000.0) as u16
            } else {
                0
            };
            whole.to_le_bytes().to_vec()
        } else {
            (*depth as f32).to_le_bytes().to_vec()
        };
        if is_big {
            number.reverse();
        }
        image.data.extend_from_slice(&number).expect("a small picture");
    }
    image
}

fn bench() -> Bench<Scan> {
    let mut bench = Bench::new();
    bench.unbind("camera_info");
    for (key, value) in [
        ("field_of_view", FIELD_OF_VIEW),
        ("height", HEIGHT),
        ("pitch", PITCH),
        ("range_max", 2.5),
        ("angle_min", -0.3),
        ("angle_max", 0.3),
        ("angle_increment", 0.05),
    ] {
        bench.set(key, value);
    }
    bench.awake().expect("it wakes");
    bench
}

fn seen(bench: &mut Bench<Scan>, image: &Image) -> Option<LaserScan> {
    bench.import("depth", image);
    bench.iterate().expect("it iterates");
    bench.exported("scan")
}

#[test]
fn a_wall_is_where_it_is_in_both_encodings_and_both_orders_of_bytes() {
    for (encoding, is_big) in [
        ("32FC1", false),
        ("32FC1", true),
        ("16UC1", false),
        ("16UC1", true),
    ] {
        let mut bench = bench();
        let scan = seen(&mut bench, &picture(encoding, &depths(1.5), is_big)).expect("a scan");
        let middle = scan.ranges[scan.ranges.len() / 2];
        assert!((middle - 1.5).abs() < 0.02, "{encoding}: {middle}");
        scan.measured().expect("it is a scan");
        let free = seen(&mut bench, &picture(encoding, &depths(f64::INFINITY), is_big)).expect("a scan");
        assert!(
            free.ranges.iter().all(|range| *range == f32::INFINITY),
            "{:?}",
            free.ranges
        );
    }
}

#[test]
fn pixels_without_a_depth_are_unknown_and_not_free() {
    for none in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut some = depths(f64::INFINITY);
        // The columns of the left half.
        for (at, depth) in some.iter_mut().enumerate() {
            if at as u32 % SIZE[0] < SIZE[0] / 2 {
                *depth = none;
            }
        }
        let scan = seen(&mut bench(), &picture("32FC1", &some, false)).expect("a scan");
        let (left, right) = (scan.ranges[scan.ranges.len() - 1], scan.ranges[0]);
        assert!(left.is_nan() && right == f32::INFINITY, "{none}: {left} {right}");
        let mut blind = bench();
        let nothing = vec![none; some.len()];
        assert_eq!(seen(&mut blind, &picture("32FC1", &nothing, false)), None);
        assert!(blind.schema().lacks.words().is_some());
    }
}

#[test]
fn a_scan_has_the_time_of_its_picture_and_ends_with_it() {
    let mut bench = bench();
    bench.set_now(Duration::from_secs(3));
    let scan = seen(&mut bench, &picture("32FC1", &depths(1.5), false));
    assert!(scan.is_some());
    assert_eq!(bench.exported_at("scan"), Some(Duration::from_secs(3)));
    bench.retract("depth");
    bench.iterate().expect("it iterates");
    assert_eq!(bench.exported::<LaserScan>("scan"), None);
    assert_eq!(
        bench.schema().lacks.words(),
        Some("there is no picture of depths")
    );
}

#[test]
fn pictures_that_are_none_and_cameras_of_another_size_are_refused_in_words() {
    let refused = |change: fn(&mut Image)| {
        let mut image = picture("16UC1", &depths(1.5), false);
        change(&mut image);
        let mut bench = bench();
        assert_eq!(seen(&mut bench, &image), None);
        bench.schema().lacks.words().expect("words").to_owned()
    };
    assert!(refused(|image| image.encoding = Text::new("rgb8")).contains("expected 32FC1 or 16UC1"));
    assert!(refused(|image| image.step = 10).contains("do not fit"));
    let mut stated = Bench::<Scan>::new();
    stated.awake().expect("it wakes");
    let image = picture("32FC1", &depths(1.5), false);
    assert_eq!(seen(&mut stated, &image), None);
    let words = |bench: &Bench<Scan>| bench.schema().lacks.words().map(str::to_owned);
    assert_eq!(
        words(&stated).as_deref(),
        Some("the camera states no calibration")
    );
    stated.import("camera_info", &CameraInfo::pinhole([32, 24], FIELD_OF_VIEW));
    assert_eq!(seen(&mut stated, &image), None);
    assert!(words(&stated).expect("words").contains("32 x 24"));
    stated.set("min_height", 2.0);
    let problems = stated.inspect().expect("it inspects");
    assert!(
        problems[0].words.contains("`min_height`"),
        "{}",
        problems[0].words
    );
}

#[test]
fn a_picture_with_bytes_missing_is_none() {
    let some = depths(1.5);
    assert!(Depths::of(&picture("16UC1", &some, false)).is_ok());
    let image = picture("16UC1", &some[1..], false);
    assert!(Depths::of(&image).expect_err("too few").contains("do not fit"));
}

#[test]
fn bytes_behind_the_pixels_of_a_row_are_no_depths() {
    let image = picture("16UC1", &depths(1.5), false);
    let row = SIZE[0] as usize * 2;
    let mut wide = picture("16UC1", &[], false);
    wide.step = image.step + 6;
    for pixels in image.data.chunks_exact(row) {
        wide.data.extend_from_slice(pixels).expect("a small picture");
        wide.data.extend_from_slice(&[1; 6]).expect("a small picture");
    }
    assert_eq!(seen(&mut bench(), &wide), seen(&mut bench(), &image));
}

#[test]
fn a_scan_is_in_the_frame_that_is_stated_or_that_of_the_schema_and_never_in_that_of_the_picture() {
    let image = picture("32FC1", &depths(1.5), false);
    let mut bench = bench();
    assert_eq!(seen(&mut bench, &image).expect("a scan").header.frame_id, "bench");
    bench.set("frame_id", Text::<52>::new("camera_level"));
    bench.awake().expect("it wakes");
    assert_eq!(
        seen(&mut bench, &image).expect("a scan").header.frame_id,
        "camera_level"
    );
}

#[test]
fn a_reason_stays_until_the_next_picture_and_the_log_says_it_once() {
    let mut bench = bench();
    // One depth, beside the directions of the scan.
    let mut nothing = vec![f64::NAN; depths(1.5).len()];
    nothing[0] = 1.0;
    let nothing = picture("32FC1", &nothing, false);
    let words = "No scan: the camera sees neither the floor nor anything on it";
    for _ in 0..3 {
        assert_eq!(seen(&mut bench, &nothing), None);
        bench.iterate().expect("it iterates");
        assert_eq!(bench.draw().expect("it draws").texts(), [words]);
    }
    assert_eq!(bench.log().len(), 1);
    assert!(seen(&mut bench, &picture("32FC1", &depths(1.5), false)).is_some());
    assert_eq!(bench.draw().expect("it draws").texts(), ["It sees"]);
}

#[test]
fn a_camera_that_sees_the_floor_only_beyond_the_least_range_is_told_of() {
    let mut bench = bench();
    bench.set("range_min", 0.3);
    let image = picture("32FC1", &depths(f64::INFINITY), false);
    assert_eq!(seen(&mut bench, &image), None);
    let words = "the floor is seen from 0.4";
    let draws = |bench: &mut Bench<Scan>| {
        bench
            .draw()
            .expect("it draws")
            .texts()
            .last()
            .map(|text| (*text).to_owned())
    };
    assert!(draws(&mut bench).expect("a text").starts_with(words));
    assert!(bench.log()[0].1.starts_with(words), "{:?}", bench.log());
    bench.set("pitch", -1.0);
    seen(&mut bench, &image);
    assert_eq!(
        draws(&mut bench).as_deref(),
        Some("no floor is in view up to `range_max`")
    );
}
