//! The models of the library, the errors of invalid model files, and the odometer with wrapping positions.

use core::f64::consts::FRAC_PI_2;
use core::time::Duration;

use jde_p2os::*;

#[test]
fn every_model_that_comes_along_is_whole() {
    for name in Model::names() {
        let model = Model::named(name).unwrap();
        assert_eq!(model.name, name);
        for subclass in &model.subclasses {
            assert_eq!(Model::of_subclass(subclass).unwrap(), model);
        }
    }
    let p3dx = Model::named("P3DX").unwrap();
    assert_eq!(
        (p3dx.sonar.mounts.len(), p3dx.sonar.mounts[0]),
        (16, [69.0, 136.0, 90.0])
    );
    assert_eq!((p3dx.units.distance_mm, p3dx.angle(1024)), (0.485, FRAC_PI_2));
    assert_eq!(Model::of_subclass("p3dx-sh").unwrap().units.distance_mm, 1.0);
    assert!(Model::named("p4").unwrap_err().to_string().contains("`amigo`"));
}

#[test]
fn what_is_wrong_in_a_file_is_said_with_file_line_and_key() {
    let text = include_str!("../../models/p3dx.toml");
    let said = |from: &str, to: &str| {
        Model::parse(&text.replacen(from, to, 1), "mine.toml")
            .unwrap_err()
            .to_string()
    };
    let line = |key: &str| 1 + text.lines().position(|line| line.starts_with(key)).unwrap();
    let place = |key| format!("mine.toml:{}: ", line(key));
    let words = said("distance_mm = 0.485", "distance_mm = -1");
    assert!(
        words.starts_with(&place("distance_mm")) && words.contains("greater than 0"),
        "{words}"
    );
    let words = said("distance_mm = 0.485", "distance_mm = \"far\"");
    assert!(
        words.starts_with(&place("distance_mm")) && words.contains("`distance_mm = \"far\"`"),
        "{words}"
    );
    let words = said("cone_deg", "cone");
    assert!(
        words.starts_with(&place("cone_deg")) && words.contains("cone"),
        "{words}"
    );
    let words = said("front = 5", "front = 8");
    assert!(
        words.starts_with(&place("front")) && words.contains("0 to 7"),
        "{words}"
    );
    let words = said("full_v = 13", "full_v = 9");
    assert!(
        words.starts_with(&place("full_v")) && words.contains("`empty_v`"),
        "{words}"
    );
}

/// Feeds an odometer with positions 100 ms apart.
fn follow(positions: &[(u16, u16, i16)]) -> (Pose, u64) {
    let model = Model::named("p3dx-sh").unwrap();
    let mut odometer = Odometer::new(Pose {
        x: 1.0,
        y: 2.0,
        heading: FRAC_PI_2,
    });
    for (step, (x, y, th)) in positions.iter().enumerate() {
        let sip = Sip {
            x: *x,
            y: *y,
            th: *th,
            ..Sip::default()
        };
        odometer.update(&model, &sip, Duration::from_millis(100 * step as u64));
    }
    (odometer.pose(), odometer.jumps())
}

fn assert_near(pose: Pose, x: f64, y: f64, heading: f64) {
    let far = (pose.x - x).hypot(pose.y - y) + (pose.heading - heading).abs();
    assert!(far < 1e-9, "{pose:?} is not {x} {y} {heading}");
}

#[test]
fn positions_go_on_where_they_wrap_forwards_and_backwards() {
    for wrap in [32768u32, 65536] {
        // A counter of 15 or of 16 bits.
        let count = |millimetres: i32| (millimetres.rem_euclid(wrap as i32)) as u16;
        let forth: Vec<_> = (0..2000).map(|step| (count(100 * step), 0, 0)).collect();
        assert_near(follow(&forth).0, 1.0, 2.0 + 199.9, FRAC_PI_2);
        let back: Vec<_> = (0..2000).map(|step| (0, count(-100 * step), 0)).collect();
        assert_near(follow(&back).0, 1.0 + 199.9, 2.0, FRAC_PI_2);
    }
}

#[test]
fn another_origin_is_no_motion() {
    let (pose, jumps) = follow(&[(0, 0, 0), (100, 0, 0), (5000, 0, 1024), (5000, 100, 1024)]);
    assert_eq!(jumps, 1);
    // It drove 100 ahead, its origin changed, and it drove 100 ahead again.
    assert_near(pose, 1.0, 2.2, FRAC_PI_2);
}

#[test]
fn headings_go_on_where_they_wrap() {
    let turns: Vec<_> = (0..100i32)
        .map(|step| (0, 0, ((step * 200 + 2048).rem_euclid(4096) - 2048) as i16))
        .collect();
    let turned = 99.0 * 200.0 / 4096.0;
    let heading =
        (FRAC_PI_2 + (turned - f64::floor(turned)) * core::f64::consts::TAU + core::f64::consts::PI)
            .rem_euclid(core::f64::consts::TAU)
            - core::f64::consts::PI;
    assert_near(follow(&turns).0, 1.0, 2.0, heading);
}
