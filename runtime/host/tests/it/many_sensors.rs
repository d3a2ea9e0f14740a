//! Robots among low boxes, in lockstep: with a laser that looks over them and other sensors, or with a depth camera.

use std::path::Path;

use jde_app::Application;
use jde_host::{Handle, Lockstep, Options};
use jde_loader::Plugins;
use jde_types::{Bumpers, Truth};

use crate::delivered::{self, ROOT, SECOND};

fn truth(handle: &Handle) -> Truth {
    let truth: Option<Truth> = handle.value("pioneer.truth").expect("it is an export");
    truth.expect("it was published")
}

fn is_pressed(handle: &Handle) -> bool {
    let bumpers: Option<Bumpers> = handle.value("pioneer.bumpers").expect("it is an export");
    bumpers.is_some_and(|bumpers| bumpers.any())
}

/// A delivered application.
fn application(name: &str, plugins: &Plugins) -> Application {
    let file = Path::new(ROOT).join("apps").join(name);
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

/// Lets the robot of a delivered application wander for some seconds. Returns its way, m.
fn wander(name: &str, seconds: u64) -> f64 {
    let plugins = delivered::plugins();
    let mut running = Lockstep::start(application(name, &plugins), &plugins, Options::default())
        .unwrap_or_else(|error| panic!("{error}"));
    let handle = running.handle();
    running.run_until(SECOND);
    let (mut way, mut last) = (0.0, truth(&handle).pose);
    for second in 2..=seconds {
        running.run_until(second * SECOND);
        let at = truth(&handle).pose;
        way += last.distance_to(&at);
        last = at;
    }
    assert_eq!(truth(&handle).collisions, 0);
    way
}

#[test]
fn a_robot_wanders_for_40_s_among_boxes_that_its_laser_does_not_see() {
    let way = wander("sensors.toml", 40);
    assert!(way > 3.0, "{way} m");
}

#[test]
fn a_robot_wanders_for_20_s_by_a_depth_camera_alone() {
    let way = wander("depth.toml", 20);
    assert!(way > 1.5, "{way} m");
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
