//! The driver on a test bench, with the sketch's board at a real pseudo-terminal.

pub(crate) mod board;

use std::fs;
use std::os::unix::fs::symlink;

use jde_device::emulate::{DriverTest, EmulatedDevice, refusal};
use jde_schema::bench::Bench;

use super::*;
use board::{Board, Fault, Wired};

fn wired(kind: &str, serial_number: &str) -> (EmulatedDevice<Wired>, String) {
    let (device, path) = EmulatedDevice::at_pty(Wired::new(Board::new(kind, serial_number)));
    (device, format!("serial:{}@115200", path.display()))
}

fn driver(port: &str) -> DriverTest<Serial> {
    let mut driver = DriverTest::with_port(port);
    driver.awake();
    driver
}

fn until_connected(driver: &mut DriverTest<Serial>) {
    driver.run_until(|bench| bench.exported::<Odometry>("odometry").is_some());
    assert_eq!(driver.connection().0, Connection::CONNECTED);
}

/// Drives until a condition holds. A command is given again and again, as a schema does.
fn drive(driver: &mut DriverTest<Serial>, twist: Twist, mut condition: impl FnMut(&Bench<Serial>) -> bool) {
    while !condition(&driver.bench) {
        driver.bench.command("velocity", &twist);
        driver.step();
    }
}

fn x(bench: &Bench<Serial>) -> f64 {
    let odometry: Option<Odometry> = bench.exported("odometry");
    odometry.map_or(f64::NAN, |odometry| odometry.pose2d().x)
}

const EXPORTS: [&str; 7] = [
    "odometry", "encoders", "bumpers", "battery", "imu", "dynamics", "setpoint",
];

#[test]
fn what_a_board_has_is_exported_in_the_standard_units() {
    let (device, port) = wired("differential", "kit-07");
    let mut driver = DriverTest::<Serial>::with_port(&port);
    driver.bench.set("start", Pose2D::new(2.0, 0.0, 0.0));
    driver.awake();
    until_connected(&mut driver);
    assert_eq!(x(&driver.bench), 2.0);
    drive(&mut driver, Twist::planar(0.3, 0.0), |bench| x(bench) > 2.2);
    let bench = &driver.bench;
    let encoders: WheelEncoders = bench.exported("encoders").expect("it counts");
    assert_eq!(encoders.ticks_per_meter, 5200.0);
    assert!((encoders.left as f64 / 5200.0 - 0.2).abs() < 0.02, "{encoders:?}");
    let battery: BatteryState = bench.exported("battery").expect("it measures");
    assert!((battery.voltage - 11.7).abs() < 1e-3 && (battery.percentage - 0.667).abs() < 1e-3);
    let imu: Imu = bench.exported("imu").expect("it measures");
    assert_eq!(
        (imu.linear_acceleration.z, imu.orientation_covariance[0]),
        (9.81, -1.0)
    );
    let dynamics: BaseDynamics = bench.exported("dynamics").expect("it states them");
    assert_eq!((dynamics.deceleration, dynamics.lag), (1.2, 0.08));
    let setpoint: Twist = bench.exported("setpoint").expect("its accelerations are known");
    assert!((setpoint.linear.x - 0.3).abs() < 1e-9, "{setpoint:?}");
    let bumpers: Bumpers = bench.exported("bumpers").expect("it has them");
    assert_eq!(
        (bumpers.front.len(), bumpers.rear.len(), bumpers.any()),
        (2, 0, false)
    );
    device.with(|wired| wired.board.change("bump"));
    driver.run_until(|bench| {
        let bumpers: Option<Bumpers> = bench.exported("bumpers");
        bumpers.is_some_and(|bumpers| bumpers.front[0].get() && !bumpers.front[1].get())
    });
}

#[test]
fn a_board_that_has_stopped_its_motors_has_no_odometry_until_a_command_to_stand() {
    let (device, port) = wired("differential", "kit-07");
    let mut driver = driver(&port);
    until_connected(&mut driver);
    device.with(|wired| wired.board.change("block"));
    drive(&mut driver, Twist::planar(0.3, 0.0), |bench| {
        let bumpers: Option<Bumpers> = bench.exported("bumpers");
        bumpers.is_some_and(|bumpers| bumpers.stalled.get())
    });
    for export in ["odometry", "setpoint"] {
        assert_eq!(driver.bench.exported_at(export), None, "{export}");
    }
    let connection: Connection = driver.bench.exported("connection").expect("it says");
    assert!(
        connection.note.as_str().contains("a wheel is blocked"),
        "{connection:?}"
    );
    device.with(|wired| wired.board.change("block"));
    drive(&mut driver, Twist::ZERO, |bench| {
        bench.exported::<Odometry>("odometry").is_some() && bench.exported::<Twist>("setpoint").is_some()
    });
}

#[test]
fn limits_of_a_board_below_those_of_the_driver_are_said() {
    for (limit, warns) in [(0.5, false), (0.8, true)] {
        let (_device, port) = wired("differential", "kit-07");
        let mut driver = DriverTest::<Serial>::with_port(&port);
        driver.bench.set("velocity_limits", Twist::planar(limit, 2.0));
        driver.awake();
        until_connected(&mut driver);
        let mut log = driver.bench.log().iter();
        let is_said = log.any(|(_, words)| words.contains("are below `velocity_limits`"));
        assert_eq!(is_said, warns, "{limit}");
    }
}

#[test]
fn an_omnidirectional_board_has_no_encoders_and_drives_to_the_side() {
    let (_device, port) = wired("mecanum", "kit-09");
    let mut driver = driver(&port);
    until_connected(&mut driver);
    let mut twist = Twist::ZERO;
    twist.linear.y = 0.3;
    drive(&mut driver, twist, |bench| {
        let odometry: Option<Odometry> = bench.exported("odometry");
        odometry.is_some_and(|odometry| odometry.pose2d().y > 0.1)
    });
    assert!(x(&driver.bench).abs() < 0.02);
    assert_eq!(driver.bench.exported_at("encoders"), None);
}

#[test]
fn the_exports_of_a_board_lost_behind_a_serial_server_are_retracted_and_its_odometry_goes_on() {
    let board = Wired::new(Board::new("differential", "kit-07"));
    let (device, port) = EmulatedDevice::at_tcp(board, 115_200);
    let mut driver = driver(&port);
    until_connected(&mut driver);
    drive(&mut driver, Twist::planar(0.3, 0.0), |bench| x(bench) > 0.1);
    for (fault, words) in [
        (Fault::Silent, "it sends nothing"),
        (Fault::Deaf, "does not acknowledge"),
        (Fault::OtherBaud, "the speed of the line"),
    ] {
        device.with(|wired| wired.fault = fault);
        let reason = driver.wait_lost();
        assert!(reason.contains(words), "{reason}");
        for export in EXPORTS {
            assert_eq!(driver.bench.exported_at(export), None, "{export}");
        }
        device.with(|wired| wired.fault = Fault::None);
        until_connected(&mut driver);
        assert!(x(&driver.bench) > 0.1);
    }
}

#[test]
fn a_driver_that_sleeps_or_is_dropped_leaves_a_base_that_stands() {
    for sleeps in [true, false] {
        let (device, port) = wired("differential", "kit-07");
        // The line stays open, so that the board goes on.
        let path = port.trim_start_matches("serial:").trim_end_matches("@115200");
        let line = fs::File::open(path).expect("a line");
        let mut driver = driver(&port);
        until_connected(&mut driver);
        drive(&mut driver, Twist::planar(0.4, 0.0), |bench| x(bench) > 0.2);
        if sleeps {
            driver.bench.sleep().expect("it sleeps");
            assert_eq!(driver.bench.exported_at("odometry"), None);
        }
        // Without a driver, nothing is sent any more: the watchdog stops the base.
        drop(driver);
        while device.with(|wired| wired.board.truth.speeds[0]) > 0.001 {
            std::thread::yield_now();
        }
        drop(line);
    }
}

#[test]
fn the_driver_reconnects_when_the_plug_is_pulled_and_refuses_another_board_at_it() {
    let name = std::env::temp_dir().join(format!("jde-base-{}", std::process::id()));
    let mut driver = DriverTest::<Serial>::with_port(&format!("serial:{}@115200", name.display()));
    driver.bench.set("serial_number", Text::<64>::new("kit-07"));
    driver.awake();
    assert!(driver.wait_lost().contains("there is no such device"));
    for serial_number in ["kit-07", "kit-08", "kit-07"] {
        let (device, path) = EmulatedDevice::at_pty(Wired::new(Board::new("differential", serial_number)));
        symlink(path, &name).expect("a symbolic link");
        if serial_number == "kit-07" {
            until_connected(&mut driver);
        } else {
            driver.run_until(|bench| {
                let connection: Connection = bench.exported("connection").unwrap_or_default();
                connection.note.as_str().contains("is kit-08, not kit-07")
            });
            assert_eq!(driver.bench.exported::<Odometry>("odometry"), None);
        }
        fs::remove_file(&name).expect("the link exists");
        drop(device);
        driver.wait_lost();
    }
}

#[test]
fn invalid_settings_are_refused_before_the_port_is_opened() {
    let refused = |port: &str| refusal::<Serial>(|bench| bench.set("port", Text::<256>::new(port)));
    assert!(refused("").contains("serial:/dev/ttyUSB0@115200"));
    assert!(refused("/dev/ttyUSB0").contains("serial:PATH@BAUD"));
}
