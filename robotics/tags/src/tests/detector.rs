//! Tags in pictures.

use core::f64::consts::TAU;

use proptest::prelude::*;

use super::scene::{PICTURE, Picture, Placed, draw};
use crate::{Detection, Detector, Family, Gray};

const STRAIGHT: Placed = Placed {
    family: Family::Tag36h11,
    id: 42,
    position: [0.0, 0.0, 0.8],
    turns: [0.0; 3],
};

fn dark(_: usize, _: usize) -> f64 {
    0.0
}

fn detect(picture: &Picture) -> Vec<Detection> {
    Detector::default().detect(&picture.gray())
}

/// Returns the greatest distance of a corner from where it is, px.
fn deviation(tag: &Detection, placed: &Placed) -> f64 {
    let pairs = tag.corners.iter().zip(placed.corners());
    pairs
        .map(|(found, is)| (found[0] - is[0]).hypot(found[1] - is[1]))
        .fold(0.0, f64::max)
}

/// Returns the least height of a cell in the picture, px: 2 are needed.
fn cell(placed: &Placed) -> f64 {
    let corners = placed.corners();
    let sides = [0, 1, 2, 3].map(|from| {
        let (a, b) = (corners[from], corners[(from + 1) % 4]);
        (a[0] * b[1] - a[1] * b[0], (a[0] - b[0]).hypot(a[1] - b[1]))
    });
    let area = sides.iter().map(|side| side.0).sum::<f64>().abs() / 2.0;
    let longest = sides.iter().map(|side| side.1).fold(0.0, f64::max);
    area / longest / placed.family.width() as f64
}

/// A number from 0 to 1 that looks random: SplitMix64.
fn noise(index: usize) -> f64 {
    let mut bits = (index as u64)
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(0x1234_5678_9abc_def1);
    bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    (bits >> 11) as f64 / (1_u64 << 53) as f64
}

fn placed() -> impl Strategy<Value = Placed> {
    let tag = (0..3_usize).prop_flat_map(|family| {
        let family = Family::ALL[family];
        (Just(family), 0..family.count() as u32)
    });
    (
        tag,
        -0.3..0.3,
        -0.2..0.2,
        0.5..1.4,
        0.0..TAU,
        -0.9..0.9,
        -0.9..0.9,
    )
        .prop_map(|((family, id), x, y, distance, roll, pitch, yaw)| Placed {
            family,
            id,
            position: [x * distance, y * distance, distance],
            turns: [roll, pitch, yaw],
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn a_tag_is_found_wherever_it_is(placed in placed().prop_filter("cells below 2 px", |placed| cell(placed) >= 2.0)) {
        let picture = draw(&[placed], dark);
        let mut detector = Detector::new(Family::ALL.to_vec());
        let tags = detector.detect(&picture.gray());
        let tag = tags.iter().find(|tag| (tag.family, tag.id) == (placed.family, placed.id));
        prop_assert!(tag.is_some(), "{tags:?}");
        let tag = tag.unwrap();
        prop_assert_eq!(tag.hamming, 0);
        prop_assert!(deviation(tag, &placed) < 1.5, "{} px: {:?} is not {:?}", deviation(tag, &placed), tag.corners, placed.corners());
    }

    #[test]
    fn no_picture_makes_it_panic(
        width in 0..40_usize,
        height in 0..40_usize,
        seed in any::<u16>(),
        levels in 1..4_usize,
        step in 0..10_usize,
    ) {
        let value = |index: usize| ((noise(index + 4000 * usize::from(seed)) * levels as f64) as usize * 85) as u8;
        let pixels: Vec<u8> = (0..width * height).map(value).collect();
        let mut detector = Detector::new(Family::ALL.to_vec());
        detector.step = step;
        detector.detect(&Gray::new([width, height], &pixels).unwrap());
    }
}

#[test]
fn uneven_light_and_noise_hide_no_tag() {
    let light = |column: usize, row: usize| {
        column as f64 / PICTURE[0] as f64 * 40.0 - 20.0 + 12.0 * (noise(column * 999 + row) - 0.5)
    };
    let tags = detect(&draw(&[STRAIGHT], light));
    assert_eq!(tags.len(), 1);
    assert_eq!((tags[0].id, tags[0].hamming), (42, 0));
    assert!(deviation(&tags[0], &STRAIGHT) < 0.5, "{:?}", tags[0].corners);
}

#[test]
fn the_same_tag_twice_is_two_detections() {
    let pair = [-0.2, 0.2].map(|x| Placed {
        position: [x, 0.0, 1.0],
        ..STRAIGHT
    });
    let tags = detect(&draw(&pair, dark));
    assert_eq!(tags.iter().map(|tag| tag.id).collect::<Vec<_>>(), [42, 42]);
    let corner = |tag: &Detection| tag.corners[0][0];
    assert!((corner(&tags[0]) - corner(&tags[1])).abs() > 100.0);
}

#[test]
fn a_tag_that_is_cut_off_is_not_found() {
    for x in [0.33, 0.45, -0.45] {
        let placed = Placed {
            position: [x, 0.0, 0.8],
            ..STRAIGHT
        };
        let outside = placed
            .corners()
            .iter()
            .filter(|corner| !(0.0..PICTURE[0] as f64).contains(&corner[0]))
            .count();
        let found = detect(&draw(&[placed], dark)).len();
        assert_eq!(
            found,
            usize::from(outside == 0),
            "{x} m: {outside} corners are outside"
        );
    }
}

#[test]
fn every_second_pixel_finds_a_large_tag_in_the_same_place() {
    let picture = draw(&[STRAIGHT], dark);
    let mut detector = Detector::new(vec![Family::Tag36h11]);
    detector.step = 2;
    let tags = detector.detect(&picture.gray());
    assert_eq!(tags.len(), 1);
    assert!(deviation(&tags[0], &STRAIGHT) < 0.25, "{:?}", tags[0].corners);
}

#[test]
fn nothing_is_in_noise_and_in_pictures_without_content() {
    let noisy = (0..PICTURE[0] * PICTURE[1])
        .map(|index| (256.0 * noise(index)) as u8)
        .collect();
    assert_eq!(detect(&Picture(noisy)), []);
    assert_eq!(detect(&Picture(vec![77; PICTURE[0] * PICTURE[1]])), []);
    for size in [[0, 0], [1, 1], [3, 3], [4, 4], [0, 9], [9, 0]] {
        let pixels = vec![200; size[0] * size[1]];
        let picture = Gray::new(size, &pixels).expect("the sizes agree");
        assert_eq!(Detector::default().detect(&picture), [], "{size:?}");
    }
    assert!(Gray::new([2, 2], &[0; 3]).is_none());
    assert!(Gray::new([usize::MAX, 2], &[]).is_none());
}

#[test]
fn only_the_families_that_are_asked_for_are_found() {
    let picture = draw(&[STRAIGHT], dark);
    let mut detector = Detector::new(vec![Family::Tag25h9]);
    assert_eq!(detector.detect(&picture.gray()), []);
    detector.families.clear();
    assert_eq!(detector.detect(&picture.gray()), []);
}

#[test]
fn a_faint_tag_has_a_small_margin() {
    let margin = |contrast: f64| {
        let faint = draw(&[STRAIGHT], dark)
            .0
            .iter()
            .map(|&value| (100.0 + contrast * f64::from(value)) as u8)
            .collect();
        detect(&Picture(faint))[0].margin
    };
    let ratio = margin(0.5) / margin(0.1);
    assert!((4.0..6.0).contains(&ratio), "{ratio}");
}
