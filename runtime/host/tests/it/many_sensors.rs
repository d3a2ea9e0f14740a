//! Robots with several sensors, in lockstep: each has a laser that looks over low boxes.

use std::path::Path;

use jde_app::Application;
use jde_host::{Handle, Lockstep, Options};
use jde_loader::Plugins;
use jde_types::{Bumpers, Point2D, Truth};

use crate::delivered::{self, ROOT, SECOND};

fn truth(handle: &Handle) -> Truth {
    let truth: Option<Truth> = handle.value("pioneer.truth").expect("it is an export");
    truth.expect("it was published")
}

fn is_pressed(handle: &Handle) -> bool {
    let bumpers: Option<Bumpers> = handle.value("pioneer.bumpers").expect("it is an export");
    bumpers.is_some_and(|bumpers| bumpers.any())
}

/// The delivered application of a robot with sonars and bumpers.
fn application(plugins: &Plugins) -> Application {
    let file = Path::new(ROOT).join("apps/sensors.toml");
    jde_app::load(&file, &[], plugins).unwrap_or_else(|faults| panic!("{faults}"))
}

/// The same robot without sonars: a schema that reads the laser alone follows a path into a box.
fn against_a_box(plugins: &Plugins) -> Application {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("box.toml");
    let world = Path::new(ROOT).join("worlds/low-boxes.toml");
    let text = format!(
        r#"
        name  = "box"
        roots = ["path"]
        root  = {{ guard = "guard" }}

        [schemas.pioneer]
        type         = "sim/robot"
        world        = "{}"
        start        = [[4.4, 1.3, 0]]
        laser_height = 0.3

        [schemas.merge]
        type            = "scan/merge"
        imports         = {{ pose = "pioneer.odometry" }}
        footprint       = {{ radius = 0.25 }}
        sensors.laser   = {{ from = "pioneer.laser", mount = {{ x = 0.018 }} }}
        sensors.bumpers = {{ from = "pioneer.bumpers", field_of_view = "137 deg" }}

        [schemas.path]
        type      = "drive/path"
        imports   = {{ laser = "pioneer.laser", pose = "pioneer.odometry" }}
        mount     = {{ x = 0.018 }}
        actuators = {{ base = "pioneer.velocity" }}
        footprint = {{ radius = 0.25 }}
        route     = {{ poses = [[4.4, 1.3, 0], [6.8, 1.3, 0]] }}

        [schemas.guard]
        type      = "guard/footprint"
        imports   = {{ laser = "merge.scan", pose = "pioneer.odometry" }}
        footprint = {{ radius = 0.25 }}
        margin    = 0.02
        "#,
        world.display()
    );
    std::fs::write(&file, text).expect("it is written");
    jde_app::load(&file, &[], plugins).unwrap_or_else(|faults| panic!("{faults}"))
}

#[test]
fn a_robot_wanders_for_40_s_among_boxes_that_its_laser_does_not_see() {
    let plugins = delivered::plugins();
    let mut running = Lockstep::start(application(&plugins), &plugins, Options::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let handle = running.handle();
    let mut way = 0.0;
    let mut last = Point2D::default();
    for second in 1..=40 {
        running.run_until(second * SECOND);
        let at = truth(&handle).pose;
        way += if second == 1 {
            0.0
        } else {
            (at.x - last.x).hypot(at.y - last.y)
        };
        last = Point2D { x: at.x, y: at.y };
    }
    assert_eq!(truth(&handle).collisions, 0);
    assert!(way > 3.0, "{way} m");
}

#[test]
fn a_pressed_bumper_stops_the_robot_by_the_guard_within_one_period() {
    let plugins = delivered::plugins();
    let mut running = Lockstep::start(against_a_box(&plugins), &plugins, Options::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let handle = running.handle();
    let mut now = 0;
    while !is_pressed(&handle) {
        now += SECOND / 100;
        assert!(now < 30 * SECOND, "it reaches the box");
        running.run_until(now);
    }
    let at = truth(&handle).pose;
    assert!((at.x - 5.5).abs() < 0.02, "before the box: {at:?}");
    running.run_until(now + SECOND / 20);
    let refused = || {
        let snapshot = handle.snapshot();
        let path = snapshot.schemas.iter().find(|schema| schema.name == "path");
        format!("{:?}", path.expect("it runs").state)
    };
    assert_eq!(refused(), "Checking");
    running.run_until(now + 5 * SECOND);
    assert_eq!(truth(&handle).collisions, 1, "it does not push on");
}
