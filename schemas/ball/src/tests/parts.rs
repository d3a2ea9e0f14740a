//! Unit tests of colours, masses and directions.

use core::f32::consts::TAU;

use crate::blob::Blobs;
use crate::camera_model::Observation;
use crate::color::Limits;
use crate::tests::near;

fn limits(from_deg: f32, to_deg: f32) -> Limits {
    Limits {
        hue: [from_deg.to_radians(), to_deg.to_radians()],
        saturation: 0.5..=1.0,
        value: 0.25..=1.0,
    }
}

#[test]
fn a_colour_is_within_limits_of_hue_saturation_and_value() {
    let orange = limits(14.0, 36.0);
    assert!(orange.contain([240, 124, 24]));
    assert!(
        orange.contain([120, 62, 12]),
        "half the light does not change the hue"
    );
    assert!(!orange.contain([60, 31, 6]), "too dark");
    assert!(!orange.contain([240, 190, 150]), "too pale");
    assert!(!orange.contain([242, 201, 32]), "yellow");
    assert!(!orange.contain([204, 41, 36]), "red");
}

#[test]
fn each_pure_colour_has_its_hue() {
    let colours = [
        ([255, 0, 0], 0.0),
        ([255, 255, 0], 60.0),
        ([0, 255, 0], 120.0),
        ([0, 255, 255], 180.0),
        ([0, 0, 255], 240.0),
        ([255, 0, 255], 300.0),
    ];
    for (color, hue) in colours {
        for (other, _) in colours {
            let around = limits(hue - 5.0, hue + 5.0);
            assert_eq!(around.contain(other), other == color, "{other:?} at {hue}");
        }
    }
}

#[test]
fn a_range_of_hues_may_go_through_red() {
    let red = limits(350.0, 10.0);
    assert!(red.contain([204, 10, 36]) && red.contain([204, 36, 10]));
    assert!(!red.contain([10, 204, 36]) && !red.contain([204, 204, 10]));
}

#[test]
fn limits_of_the_full_range_contain_all_colours_and_grey_needs_no_hue() {
    let all = Limits {
        hue: [0.0, TAU],
        saturation: 0.0..=1.0,
        value: 0.0..=1.0,
    };
    for color in [[0, 0, 0], [255, 255, 255], [10, 200, 30], [200, 10, 12]] {
        assert!(all.contain(color), "{color:?}");
    }
    let white = Limits {
        saturation: 0.0..=0.1,
        value: 0.8..=1.0,
        ..limits(0.0, 1.0)
    };
    assert!(white.contain([250, 250, 250]));
    assert!(!white.contain([250, 150, 150]));
}

/// Number of pixels of the largest mass in a drawing that is round enough.
fn largest(drawing: &[&str], roundness: f64) -> Option<usize> {
    let size = [drawing[0].len(), drawing.len()];
    let selected = |row: usize, column: usize| drawing[row].as_bytes()[column] == b'#';
    let mut blobs = Blobs::default();
    let (mass, runs) = blobs.largest(size, selected, |mass| mass.roundness() >= roundness)?;
    let sum: usize = runs.map(|run| run.columns[1] - run.columns[0]).sum();
    assert_eq!(sum, mass.count, "the runs contain all pixels of the mass");
    Some(mass.count)
}

#[test]
fn pixels_that_touch_at_an_edge_or_corner_are_one_mass() {
    assert_eq!(largest(&["##..", "..##", "...."], 0.0), Some(4));
    assert_eq!(largest(&["..##", "##..", "...."], 0.0), Some(4));
    assert_eq!(largest(&["##.##", "....."], 0.0), Some(2));
    assert_eq!(largest(&["##.", "...", "###"], 0.0), Some(3));
    assert_eq!(largest(&["...", "..."], 0.0), None);
}

#[test]
fn branches_that_join_in_a_later_row_are_one_mass() {
    let comb = ["#.#.#.#", "#.#.#.#", "#######", "......."];
    assert_eq!(largest(&comb, 0.0), Some(15));
    let spiral = ["#####", "....#", "###.#", "#...#", "#####"];
    assert_eq!(largest(&spiral, 0.0), Some(17));
}

/// Number of pixels of the largest mass, found by visiting neighbours one by one.
fn largest_by_flood_fill(selected: &[bool], width: usize) -> usize {
    let height = selected.len() / width;
    let mut remaining = selected.to_vec();
    let mut largest = 0;
    for start in 0..remaining.len() {
        let (mut count, mut next) = (0, vec![start]);
        while let Some(place) = next.pop() {
            if !core::mem::take(&mut remaining[place]) {
                continue;
            }
            count += 1;
            let (row, column) = (place / width, place % width);
            for row in row.saturating_sub(1)..=(row + 1).min(height - 1) {
                let columns = column.saturating_sub(1)..=(column + 1).min(width - 1);
                next.extend(columns.map(|column| row * width + column));
            }
        }
        largest = largest.max(count);
    }
    largest
}

#[test]
fn in_noise_of_any_density_the_largest_mass_equals_that_of_a_flood_fill() {
    let mut random = 88_172_645_463_325_252_u64;
    let mut blobs = Blobs::default();
    for percent in (5..100).step_by(5) {
        for (width, height) in [(1, 40), (40, 1), (37, 23), (64, 48)] {
            let selected: Vec<bool> = (0..width * height)
                .map(|_| {
                    random ^= random << 13;
                    random ^= random >> 7;
                    random ^= random << 17;
                    random % 100 < percent
                })
                .collect();
            let found = blobs.largest(
                [width, height],
                |row, column| selected[row * width + column],
                |_| true,
            );
            let found = found.map(|(mass, runs)| {
                let pixels: usize = runs.map(|run| run.columns[1] - run.columns[0]).sum();
                assert_eq!(pixels, mass.count, "the runs contain all pixels of the mass");
                pixels
            });
            assert_eq!(
                found.unwrap_or(0),
                largest_by_flood_fill(&selected, width),
                "{percent} % of {width} x {height}"
            );
        }
    }
}

#[test]
fn the_last_column_does_not_touch_the_next_row() {
    assert_eq!(largest(&["...#", "#...", "...."], 0.0), Some(1));
}

#[test]
fn long_and_hollow_masses_are_not_round() {
    let square = ["....", ".##.", ".##.", "...."];
    assert_eq!(largest(&square, 0.9), Some(4));
    assert_eq!(largest(&["########", "........"], 0.4), None);
    let ring = ["######", "#....#", "#....#", "#....#", "#....#", "######"];
    assert_eq!(largest(&ring, 0.8), None);
    assert_eq!(
        largest(&["########", "........", "##......", "##......"], 0.9),
        Some(4),
        "the round mass, although the other is larger"
    );
}

#[test]
fn left_and_up_are_positive_and_the_angles_of_the_head_are_added() {
    let angles = |toward: [f64; 3], pan: f64, tilt: f64| {
        let observation = Observation {
            direction: toward,
            solid_angle: 1.0,
        };
        observation.angles(pan, tilt)
    };
    let check = |[bearing, elevation]: [f64; 2], expected: [f64; 2]| {
        near(bearing, expected[0], 1e-9);
        near(elevation, expected[1], 1e-9);
    };
    check(angles([0.0, 0.0, 1.0], 0.0, 0.0), [0.0, 0.0]);
    check(angles([-1.0, 0.0, 1.0], 0.0, 0.0), [45_f64.to_radians(), 0.0]);
    check(angles([0.0, 1.0, 1.0], 0.0, 0.0), [0.0, -45_f64.to_radians()]);
    check(angles([0.0, 0.0, 1.0], 0.7, 0.3), [0.7, -0.3]);
    check(angles([0.0, 1.0, 1.0], -0.7, -45_f64.to_radians()), [-0.7, 0.0]);
    // When the camera looks down, an object to the side has a greater bearing than its column suggests.
    let [bearing, _] = angles([-1.0, 0.0, 1.0], 0.0, 60_f64.to_radians());
    near(bearing, 2_f64.atan(), 1e-9);
}
