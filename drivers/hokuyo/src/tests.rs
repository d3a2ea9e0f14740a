//! The driver on a test bench, with emulated scanners at a real pseudo-terminal and a real TCP connection.

use std::fs;
use std::os::unix::fs::symlink;
use std::thread;

use jde_device::emulate::{DriverTest, EmulatedDevice, refusal};
use jde_schema::bench::Bench;

use super::*;
use crate::emulator::EmulatedScanner;

fn driver(port: &str) -> DriverTest<Scip2> {
    let mut driver = DriverTest::with_port(port);
    driver.awake();
    driver
}

/// Returns the first scan.
fn scan(driver: &mut DriverTest<Scip2>) -> &LaserScan {
    driver.run_until(|bench| bench.exported_at("laser").is_some());
    driver.bench.exported_in_place("laser").expect("it is exported")
}

#[test]
fn a_scanner_at_a_serial_line_sends_scans_at_the_speed_of_its_address() {
    let (scanner, path) = EmulatedDevice::at_pty(EmulatedScanner::urg());
    let mut driver = driver(&format!("serial:{}@115200", path.display()));
    let scan = scan(&mut driver);
    assert_eq!(scan.ranges.as_slice(), [1.5; 682]);
    assert!((scan.angle(340)).abs() < 1e-6, "the step straight ahead");
    assert!(scan.angle(0) < -2.0 && scan.angle(681) > 2.0);
    assert_eq!((scan.range_min, scan.range_max, scan.scan_time), (0.02, 5.6, 0.1));
    let (up, name) = driver.connection();
    assert_eq!(up, Connection::CONNECTED);
    assert!(name.starts_with("URG-04LX"), "{name}");
    scanner.with(|scanner| assert_eq!(scanner.baud, 115_200));
    let first = driver.bench.exported_at("laser");
    driver.run_until(|bench| bench.exported_at("laser") > first);
}

#[test]
fn a_scanner_over_ethernet_is_reconnected_after_silence_noise_and_a_restart() {
    let (scanner, address) = EmulatedDevice::at_tcp(
        EmulatedScanner {
            noisy: true,
            ..EmulatedScanner::utm()
        },
        19_200,
    );
    let mut driver = driver(&address);
    assert_eq!(scan(&mut driver).ranges.as_slice(), [12.345; 1081]);
    scanner.with(|scanner| scanner.silent = true);
    assert!(driver.wait_lost().contains("no scan came for 3 s"));
    assert_eq!(
        driver.bench.exported::<LaserScan>("laser"),
        None,
        "the scan of a lost scanner is retracted"
    );
    scanner.with(|scanner| {
        *scanner = EmulatedScanner {
            distance: 2500,
            ..EmulatedScanner::utm()
        }
    });
    assert_eq!(scan(&mut driver).ranges[540], 2.5);
}

#[test]
fn the_driver_reconnects_when_the_plug_is_pulled_and_put_back() {
    let name = std::env::temp_dir().join(format!("jde-hokuyo-{}", std::process::id()));
    let mut driver = driver(&format!("serial:{}@19200", name.display()));
    assert!(driver.wait_lost().contains("there is no such device"));
    for _ in 0..2 {
        let (scanner, path) = EmulatedDevice::at_pty(EmulatedScanner::urg());
        symlink(path, &name).expect("a symbolic link");
        scan(&mut driver);
        fs::remove_file(&name).expect("the link exists");
        drop(scanner);
        driver.wait_lost();
        assert_eq!(driver.bench.exported::<LaserScan>("laser"), None);
    }
}

#[test]
fn the_same_error_is_logged_once_over_many_attempts() {
    let mut driver = driver("serial:/dev/no-such-line@9600");
    while driver.attempts() < 3 {
        driver.step();
    }
    let log = driver.bench.log();
    assert_eq!(log.len(), 1, "{log:?}");
}

#[test]
fn the_laser_is_off_while_the_driver_sleeps() {
    let (scanner, path) = EmulatedDevice::at_pty(EmulatedScanner::urg());
    let mut driver = driver(&format!("serial:{}@19200", path.display()));
    scan(&mut driver);
    driver.bench.sleep().expect("it sleeps");
    assert_eq!(driver.bench.exported::<LaserScan>("laser"), None);
    while scanner.with(|scanner| scanner.laser) {
        thread::yield_now();
    }
}

#[test]
fn invalid_settings_are_refused_before_the_port_is_opened() {
    let refused = |port: &str| refusal::<Scip2>(|bench| bench.set("port", Text::<256>::new(port)));
    assert!(refused("").contains("give it one"));
    assert!(refused("/dev/ttyACM0").contains("serial:PATH@BAUD"));
    assert!(refused("serial:/dev/ttyACM0@1000000").contains("750000 baud at most"));
    let mut bench = Bench::<Scip2>::new();
    bench.set("port", Text::<256>::new("tcp:192.168.0.10:10940"));
    bench.set_real_time(false);
    assert!(
        bench
            .awake()
            .expect_err("it needs real time")
            .reason
            .contains("--lockstep")
    );
}

#[test]
fn a_missing_line_is_reported_as_unavailable() {
    let mut bench = Bench::<Scip2>::new();
    bench.set("port", Text::<256>::new("serial:/dev/no-such-line@19200"));
    let problems = bench.inspect().expect("it inspects");
    assert!(
        problems[0].unavailable && problems[0].modulation == "port",
        "{problems:?}"
    );
    assert!(problems[0].words.contains("is it plugged in"), "{problems:?}");
}
