//! The suite, run on the simulator in the process, and on the Pioneer driver against the served simulator
//! over TCP and over a serial line.

mod served;

use std::any::Any;
use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use jde_driver_suite::{ROOM, Rig, RigConfig, START, build};
use jde_p2os_server::EventKind;
use jde_schema::prelude::{Connection, LaserScan, RangeRing};
use served::{Over, Served};

jde_driver_suite::suite!(in_process, crate::in_process);
jde_driver_suite::suite!(over_tcp, crate::over_tcp);
jde_driver_suite::suite!(over_a_serial_line, crate::over_a_serial_line);

fn plugins() -> PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| build(&["sim", "p2os"])).clone()
}

fn in_process() -> RigConfig {
    let folder = tempfile::tempdir().expect("a folder");
    let world = folder.path().join("room.toml");
    fs::write(&world, ROOM).expect("a file");
    RigConfig {
        driver_toml: format!(
            "type = \"sim/pioneer\"\nworld = {:?}",
            world.display().to_string()
        ),
        plugins: plugins(),
        head: true,
        resources: Box::new(folder),
    }
}

fn over_tcp() -> RigConfig {
    pioneer(Served::start(Over::Tcp(0)))
}

fn over_a_serial_line() -> RigConfig {
    pioneer(Served::start(Over::Terminal))
}

fn pioneer(served: Served) -> RigConfig {
    RigConfig {
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

fn served(kept: Box<dyn Any>) -> Served {
    *kept.downcast().expect("a served world was kept")
}

#[test]
fn an_application_that_ends_leaves_the_robot_stopped_and_its_motors_off() {
    for setting in [over_tcp(), over_a_serial_line()] {
        let rig = Rig::start(setting);
        rig.drive(0.3, 0.0);
        rig.wait_until(|rig| rig.pose().x > START.x + 0.1);
        let (_, kept) = rig.stop();
        let served = served(kept);
        served.until(|what| *what == EventKind::Closed);
        served.until_it_stands();
    }
}

#[test]
fn a_robot_that_goes_is_told_of_and_one_that_comes_back_is_driven_on() {
    for setting in [over_tcp(), over_a_serial_line()] {
        let mut rig = Rig::start(setting);
        rig.drive_distance(0.3);
        let before = rig.pose();
        let kept = std::mem::replace(&mut rig.resources, Box::new(()));
        let gone = served(kept).go();
        rig.wait_until(|rig| {
            rig.read::<Connection>("pioneer.connection")
                .is_some_and(|connection| connection.state == Connection::LOST)
        });
        assert!(rig.odometry().is_none(), "nobody steers by what was");
        assert!(rig.read::<LaserScan>("pioneer.laser").is_none());
        assert!(rig.read::<RangeRing>("pioneer.sonars").is_none());
        rig.resources = Box::new(gone.come_back());
        rig.wait_until(|rig| rig.is_up() && rig.laser().is_some());
        // The new robot is at its start, and the odometry continues from the old pose.
        let after = rig.pose();
        assert!(
            (after.x - before.x).abs() < 0.05 && (after.y - before.y).abs() < 0.05,
            "{before:?} {after:?}"
        );
        rig.drive_distance(0.3);
        assert!(rig.pose().x > after.x + 0.2);
    }
}
