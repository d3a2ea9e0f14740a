//! The driver on a test bench, with emulated scanners at a real pseudo-terminal and a real TCP connection.

use std::fs;
use std::os::unix::fs::symlink;
use std::thread;

use jde_device::emulate::{DriverTest, EmulatedDevice, refusal};
use jde_schema::bench::Bench;

use super::*;
use crate::emulator::EmulatedScanner;

fn driver(port: &str) -> DriverTest<Lms2xx> {
    let mut driver = DriverTest::with_port(port);
    driver.bench.set("baud", 9600_u32);
    driver.awake();
    driver
}

/// Returns the first scan.
fn scan(driver: &mut DriverTest<Lms2xx>) -> &LaserScan {
    driver.run_until(|bench| bench.exported_at("laser").is_some());
    driver.bench.exported_in_place("laser").expect("it is exported")
}

#[test]
fn a_scanner_at_a_serial_line_sends_scans() {
    let (_scanner, path) = EmulatedDevice::at_pty(EmulatedScanner::new());
    let mut driver = driver(&format!("serial:{}@9600", path.display()));
    let scan = scan(&mut driver);
    assert_eq!(scan.ranges.as_slice(), [1.5; 181]);
    assert!((scan.angle(0) + core::f64::consts::FRAC_PI_2).abs() < 1e-6);
    assert!((scan.angle(180) - core::f64::consts::FRAC_PI_2).abs() < 1e-5);
    assert_eq!(scan.range_max, 8.182);
    assert_eq!(
        driver.connection(),
        (Connection::CONNECTED, "LMS200;30106;V02.10, 9600 baud".to_owned())
    );
    let first = driver.bench.exported_at("laser");
    driver.run_until(|bench| bench.exported_at("laser") > first);
}

#[test]
fn a_scanner_behind_a_serial_server_is_reconnected_after_silence_noise_and_a_restart() {
    let (scanner, address) = EmulatedDevice::at_tcp(
        EmulatedScanner {
            noisy: true,
            ..EmulatedScanner::new()
        },
        9600,
    );
    let mut driver = driver(&address);
    scan(&mut driver);
    scanner.with(|scanner| scanner.silent = true);
    assert!(driver.wait_lost().contains("no scan came for 3 s"));
    assert_eq!(
        driver.bench.exported::<LaserScan>("laser"),
        None,
        "the scan of a lost scanner is retracted"
    );
    scanner.with(|scanner| {
        scanner.silent = false;
        scanner.value = 2500;
        scanner.restart();
    });
    assert_eq!(scan(&mut driver).ranges[90], 2.5);
}

#[test]
fn the_driver_reconnects_when_the_plug_is_pulled_and_put_back() {
    let name = std::env::temp_dir().join(format!("jde-sick-{}", std::process::id()));
    let mut driver = driver(&format!("serial:{}@9600", name.display()));
    assert!(driver.wait_lost().contains("there is no such device"));
    for _ in 0..2 {
        let (scanner, path) = EmulatedDevice::at_pty(EmulatedScanner::new());
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
fn the_scanner_stops_while_the_driver_sleeps() {
    let (scanner, path) = EmulatedDevice::at_pty(EmulatedScanner::new());
    let mut driver = driver(&format!("serial:{}@9600", path.display()));
    scan(&mut driver);
    driver.bench.sleep().expect("it sleeps");
    assert_eq!(driver.bench.exported::<LaserScan>("laser"), None);
    while scanner.with(|scanner| scanner.streaming) {
        thread::yield_now();
    }
}

#[test]
fn invalid_settings_are_refused_before_the_port_is_opened() {
    let refused = |set: fn(&mut Bench<Lms2xx>)| {
        refusal(|bench| {
            bench.set("port", Text::<256>::new("serial:/dev/no-such-line@9600"));
            set(bench);
        })
    };
    assert!(refused(|bench| bench.set("port", Text::<256>::EMPTY)).contains("give it one"));
    assert!(
        refused(|bench| bench.set("port", Text::<256>::new("/dev/ttyUSB0"))).contains("serial:PATH@BAUD")
    );
    assert_eq!(
        refused(|bench| bench.set("baud", 57_600_u32)),
        "baud = 57600: it can be 9600, 19200, 38400 or 500000"
    );
    assert_eq!(
        refused(|bench| bench.set("beams", 180_u32)),
        "beams = 180: it can be 101, 181, 201, 361 or 401"
    );
    assert_eq!(
        refused(|bench| bench.set("reach", 10_u32)),
        "reach = 10: it can be 8, 16, 32 or 80"
    );
    let mut bench = Bench::<Lms2xx>::new();
    bench.set_real_time(false);
    assert!(
        bench
            .awake()
            .expect_err("it needs real time")
            .reason
            .contains("--lockstep")
    );
}
