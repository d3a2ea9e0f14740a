//! One test suite for every driver of a robot's base: the behaviour that an application may rely on with any
//! driver. It runs the driver's real plugin in a real application, in real time, and waits for conditions of
//! the robot or of the application's clock.
//!
//! The drivers are the simulator in the process, and the Pioneer driver against the served simulator over TCP
//! and over a serial line. Each has a room of 5 x 4 m, a start at x 2.5, y 1.5 with heading along x, the sonars
//! of a P3-DX, a laser and a head.

mod fixture;
mod pilot;
mod served;
mod suite;

use std::any::Any;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use fixture::{DriverConfig, Fixture, ROOM, START};
use jde_p2os_server::EventKind;
use jde_schema::prelude::{Connection, LaserScan, RangeRing};
use served::{Line, ServedRoom};

/// Defines a module with the tests of the suite for a driver.
macro_rules! suite {
    ($name:ident) => {
        suite!(@ $name,
            the_driver_connects_drives_and_stops_the_robot_at_the_end,
            a_robot_without_commands_does_not_move,
            the_robot_drives_ahead_in_metres_and_reports_its_speed,
            a_positive_turn_is_to_the_left_and_on_the_spot,
            a_square_ends_at_its_start_and_the_scans_agree_with_the_odometry,
            sonars_measure_the_distances_of_the_walls,
            odometry_arrives_at_a_steady_rate_with_increasing_stamps,
            r7_a_schema_without_authority_moves_nothing,
            r7_the_robot_brakes_when_the_commands_stop,
            the_driver_exports_battery_and_wheels,
            a_head_turns_to_the_commanded_angles,
            a_collision_with_a_wall_is_detected,
        );
    };
    (@ $name:ident, $($test:ident,)+) => {
        mod $name {
            $(#[test]
            fn $test() {
                crate::suite::$test(crate::$name());
            })+
        }
    };
}

suite!(in_process);
suite!(over_tcp);
suite!(over_a_serial_line);

/// Returns the folder of the drivers' plugins.
fn plugins() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| jde_test_plugins::folder(&["sim", "p2os"]))
}

fn in_process() -> DriverConfig {
    let folder = tempfile::tempdir().expect("a folder");
    let world = folder.path().join("room.toml");
    fs::write(&world, ROOM).expect("a file");
    DriverConfig {
        driver_toml: format!("type = \"sim/robot\"\nworld = {:?}", world.display().to_string()),
        resources: Box::new(folder),
    }
}

fn over_tcp() -> DriverConfig {
    pioneer(ServedRoom::start(Line::Tcp(0)))
}

fn over_a_serial_line() -> DriverConfig {
    pioneer(ServedRoom::start(Line::Terminal))
}

fn pioneer(served: ServedRoom) -> DriverConfig {
    DriverConfig {
        driver_toml: format!(
            "type = \"p2os/pioneer\"\nport = \"{}\"\nstart = [{}, {}, {}]\nhead_kind = \"vc-c4\"",
            served.address(),
            START.x,
            START.y,
            START.theta
        ),
        resources: Box::new(served),
    }
}

fn served_room(resources: Box<dyn Any>) -> ServedRoom {
    *resources.downcast().expect("the resources are a served room")
}

#[test]
fn an_application_that_ends_stops_the_robot_and_its_motors() {
    for config in [over_tcp(), over_a_serial_line()] {
        let fixture = Fixture::start(config);
        fixture.drive(0.3, 0.0);
        fixture.wait_until(|fixture| fixture.pose().x > START.x + 0.1);
        let (_, resources) = fixture.stop();
        let room = served_room(resources);
        room.until_event(|event| *event == EventKind::Closed);
        room.until_standing();
    }
}

#[test]
fn a_lost_robot_is_reported_and_driven_on_when_it_returns() {
    for config in [over_tcp(), over_a_serial_line()] {
        let mut fixture = Fixture::start(config);
        fixture.drive_distance(0.3);
        let before = fixture.pose();
        let resources = std::mem::replace(&mut fixture.resources, Box::new(()));
        let stopped = served_room(resources).stop();
        fixture.wait_until(|fixture| {
            fixture
                .read::<Connection>("pioneer.connection")
                .is_some_and(|connection| connection.state == Connection::LOST)
        });
        assert!(fixture.odometry().is_none(), "old odometry is retracted");
        assert!(fixture.read::<LaserScan>("pioneer.laser").is_none());
        assert!(fixture.read::<RangeRing>("pioneer.sonars").is_none());
        fixture.resources = Box::new(stopped.restart());
        fixture.wait_until(|fixture| fixture.is_up() && fixture.laser().is_some());
        // The new robot is at its start, and the odometry continues from the old pose.
        let after = fixture.pose();
        assert!(
            (after.x - before.x).abs() < 0.05 && (after.y - before.y).abs() < 0.05,
            "{before:?} {after:?}"
        );
        fixture.drive_distance(0.3);
        assert!(fixture.pose().x > after.x + 0.2);
    }
}
