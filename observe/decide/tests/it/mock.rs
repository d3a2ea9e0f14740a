//! A recording that takes the place of a robot.

use jde_decide::{ReplayError, ReplayedDrive};
use jde_host::{Lockstep, Mock, Options};
use jde_types::{LaserScan, Twist, Value};

use crate::drives::{RecordedDrive, SECOND};

/// Runs the application for ten seconds, and returns the last scan and the last command.
fn run(recorded: &RecordedDrive, mocks: Vec<(String, Mock)>) -> (LaserScan, Twist) {
    let options = Options {
        mocks,
        ..Options::default()
    };
    let application = recorded.application(&[]);
    let mut running = Lockstep::start(application, recorded.plugins(), options).unwrap();
    running.run_until(10 * SECOND);
    let handle = running.handle();
    let scan = handle.value("pioneer.laser").unwrap().expect("it is published");
    let command = handle
        .value("pioneer.velocity")
        .unwrap()
        .expect("it is commanded");
    (scan, command)
}

#[test]
fn a_recorded_robot_gives_its_schemas_the_recorded_values_at_their_times() {
    let recorded = RecordedDrive::lockstep("robot.mcap", 12 * SECOND, &[]);
    let drive = ReplayedDrive::open(recorded.file()).unwrap();
    let application = recorded.application(&[]);
    let pioneer = &application.instances[application.instance("pioneer").unwrap()];
    let mock = jde_decide::mock(&drive, "pioneer", pioneer).unwrap();
    let (real, mocked) = (
        run(&recorded, Vec::new()),
        run(&recorded, vec![("pioneer".to_owned(), mock)]),
    );
    assert_eq!(real.0.as_bytes(), mocked.0.as_bytes());
    assert_ne!(real.1, Twist::ZERO);
    assert_eq!(
        real.1, mocked.1,
        "the others decide and command as with the robot"
    );
}

#[test]
fn a_recording_without_the_exports_is_refused() {
    let recorded = RecordedDrive::lockstep("other.mcap", SECOND, &["pioneer.odometry"]);
    let drive = ReplayedDrive::open(recorded.file()).unwrap();
    let application = recorded.application(&[]);
    let pioneer = &application.instances[application.instance("pioneer").unwrap()];
    assert!(
        jde_decide::mock(&drive, "pioneer", pioneer).is_ok(),
        "one export is enough"
    );
    let error = jde_decide::mock(&drive, "robot", pioneer).unwrap_err();
    assert!(matches!(error, ReplayError::Incomplete { .. }), "{error}");
    assert!(error.to_string().contains("none of robot.battery"), "{error}");
}
