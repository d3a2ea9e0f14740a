//! The models of the library, the errors of invalid model files, and the odometer with wrapping positions.

use core::f64::consts::FRAC_PI_2;
use core::time::Duration;

use jde_p2os::*;

#[test]
fn every_model_of_the_library_is_valid() {
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
fn an_error_in_a_model_file_names_file_line_and_key() {
    let text = include_str!("../../models/p3dx.toml");
    let error = |from: &str, to: &str| {
        Model::parse(&text.replacen(from, to, 1), "mine.toml")
            .unwrap_err()
            .to_string()
    };
    let line = |key: &str| 1 + text.lines().position(|line| line.starts_with(key)).unwrap();
    let location = |key| format!("mine.toml:{}: ", line(key));
    let message = error("distance_mm = 0.485", "distance_mm = -1");
    assert!(
        message.starts_with(&location("distance_mm")) && message.contains("greater than 0"),
        "{message}"
    );
    let message = error("distance_mm = 0.485", "distance_mm = \"far\"");
    assert!(
        message.starts_with(&location("distance_mm")) && message.contains("`distance_mm = \"far\"`"),
        "{message}"
    );
    let message = error("cone_deg", "cone");
    assert!(
        message.starts_with(&location("cone_deg")) && message.contains("cone"),
        "{message}"
    );
    let message = error("front = 5", "front = 8");
    assert!(
        message.starts_with(&location("front")) && message.contains("0 to 7"),
        "{message}"
    );
    let message = error("full_v = 13", "full_v = 9");
    assert!(
        message.starts_with(&location("full_v")) && message.contains("`empty_v`"),
        "{message}"
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
    let error = (pose.x - x).hypot(pose.y - y) + (pose.heading - heading).abs();
    assert!(error < 1e-9, "{pose:?} is not {x} {y} {heading}");
}

#[test]
fn positions_are_continuous_across_wrapping_in_both_directions() {
    for wrap in [32768u32, 65536] {
        // A counter of 15 or of 16 bits.
        let count = |millimetres: i32| (millimetres.rem_euclid(wrap as i32)) as u16;
        let forwards: Vec<_> = (0..2000).map(|step| (count(100 * step), 0, 0)).collect();
        assert_near(follow(&forwards).0, 1.0, 2.0 + 199.9, FRAC_PI_2);
        let backwards: Vec<_> = (0..2000).map(|step| (0, count(-100 * step), 0)).collect();
        assert_near(follow(&backwards).0, 1.0 + 199.9, 2.0, FRAC_PI_2);
    }
}

#[test]
fn a_changed_origin_is_not_a_motion() {
    let (pose, jumps) = follow(&[(0, 0, 0), (100, 0, 0), (5000, 0, 1024), (5000, 100, 1024)]);
    assert_eq!(jumps, 1);
    // It drove 100 ahead, its origin changed, and it drove 100 ahead again.
    assert_near(pose, 1.0, 2.2, FRAC_PI_2);
}

#[test]
fn headings_are_continuous_across_wrapping() {
    let positions: Vec<_> = (0..100i32)
        .map(|step| (0, 0, ((step * 200 + 2048).rem_euclid(4096) - 2048) as i16))
        .collect();
    let turned = 99.0 * 200.0 / 4096.0;
    let heading =
        (FRAC_PI_2 + (turned - f64::floor(turned)) * core::f64::consts::TAU + core::f64::consts::PI)
            .rem_euclid(core::f64::consts::TAU)
            - core::f64::consts::PI;
    assert_near(follow(&positions).0, 1.0, 2.0, heading);
}
