//! The suite, run on the simulator in the process, and on the Pioneer driver against the served simulator
//! over TCP and over a serial line.

mod served;

use std::any::Any;
use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use jde_driver_suite::{DriverConfig, Fixture, ROOM, START, build};
use jde_p2os_server::EventKind;
use jde_schema::prelude::{Connection, LaserScan, RangeRing};
use served::{Line, ServedRoom};

jde_driver_suite::suite!(in_process, crate::in_process);
jde_driver_suite::suite!(over_tcp, crate::over_tcp);
jde_driver_suite::suite!(over_a_serial_line, crate::over_a_serial_line);

fn plugins() -> PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| build(&["sim", "p2os"])).clone()
}

fn in_process() -> DriverConfig {
    let folder = tempfile::tempdir().expect("a folder");
    let world = folder.path().join("room.toml");
    fs::write(&world, ROOM).expect("a file");
    DriverConfig {
        driver_toml: format!(
            "type = \"sim/pioneer\"\nworld = {:?}",
            world.display().to_string()
        ),
        plugins: plugins(),
        head: true,
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
        plugins: plugins(),
        head: true,
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
