//! The driver on a test bench, with emulated lidars at a real pseudo-terminal and a real TCP connection.

use std::fs;
use std::os::unix::fs::symlink;
use std::thread;

use jde_device::emulate::{DriverTest, EmulatedDevice, refusal};

use super::emulator::{EmulatedRplidar, Fault};
use super::*;

fn driver(port: &str) -> DriverTest<Rplidar> {
    let mut driver = DriverTest::with_port(port);
    driver.awake();
    driver
}

/// Returns the first scan.
fn scan(driver: &mut DriverTest<Rplidar>) -> &LaserScan {
    driver.run_until(|bench| bench.exported_at("laser").is_some());
    driver.bench.exported_in_place("laser").expect("it is exported")
}

#[test]
fn a_lidar_is_found_at_its_speed_and_stopped_when_the_driver_sleeps() {
    let (lidar, path) = EmulatedDevice::at_pty(EmulatedRplidar::s2(|_| 1500));
    let mut driver = driver(&format!("serial:{}@115200", path.display()));
    let scan = scan(&mut driver);
    assert!(scan.ranges.iter().all(|range| *range == 1.5 || range.is_nan()));
    assert!(scan.measured().is_ok());
    assert_eq!((scan.range_min, scan.range_max), (0.05, 30.0));
    let (up, name) = driver.connection();
    assert_eq!(up, Connection::CONNECTED);
    assert!(name.starts_with("RPLIDAR S2M1"), "{name}");
    driver.bench.sleep().expect("it sleeps");
    assert_eq!(driver.bench.exported::<LaserScan>("laser"), None);
    while lidar.with(|lidar| lidar.scanning.is_some()) {
        thread::yield_now();
    }
}

#[test]
fn a_lidar_behind_a_serial_server_is_found_again_after_silence_and_an_error() {
    let (lidar, address) = EmulatedDevice::at_tcp(EmulatedRplidar::a1(|_| 1500), 115_200);
    let mut driver = driver(&address);
    scan(&mut driver);
    lidar.with(|lidar| lidar.fault = Fault::Silent);
    driver.wait_lost();
    assert_eq!(driver.bench.exported::<LaserScan>("laser"), None);
    lidar.with(|lidar| (lidar.fault, lidar.health) = (Fault::None, (2, 1)));
    driver.run_until(|bench| {
        let connection: Connection = bench.exported("connection").unwrap_or_default();
        connection.note.as_str().contains("it stopped to protect itself")
    });
    lidar.with(|lidar| lidar.health = (0, 0));
    scan(&mut driver);
}

#[test]
fn a_lidar_that_returns_at_another_adapter_is_not_taken_for_the_first() {
    let name = std::env::temp_dir().join(format!("jde-rplidar-{}", std::process::id()));
    let mut driver = DriverTest::<Rplidar>::with_port(&format!("serial:{}@115200", name.display()));
    driver
        .bench
        .set("serial_number", Text::<64>::new(&"A0".repeat(16)));
    driver.awake();
    assert!(driver.wait_lost().contains("there is no such device"));
    for serial_number in [0xa0, 0xb0, 0xa0] {
        let (lidar, path) = EmulatedDevice::at_pty(EmulatedRplidar {
            serial_number,
            ..EmulatedRplidar::a1(|_| 1500)
        });
        symlink(path, &name).expect("a symbolic link");
        if serial_number == 0xa0 {
            scan(&mut driver);
        } else {
            driver.run_until(|bench| {
                let connection: Connection = bench.exported("connection").unwrap_or_default();
                connection.note.as_str().contains("its serial number is B0B0")
            });
        }
        fs::remove_file(&name).expect("the link exists");
        drop(lidar);
        driver.wait_lost();
        assert_eq!(driver.bench.exported::<LaserScan>("laser"), None);
    }
}

#[test]
fn invalid_settings_are_refused_before_the_port_is_opened() {
    let refused = |settings: &[(&str, &str)]| {
        refusal::<Rplidar>(|bench| {
            bench.set("port", Text::<256>::new("tcp:192.168.0.10:4001"));
            for (name, value) in settings {
                match *name {
                    "serial_number" => bench.set(name, Text::<64>::new(value)),
                    "scan_mode" => bench.set(name, Text::<16>::new(value)),
                    _ => bench.set(name, Text::<256>::new(value)),
                }
            }
        })
    };
    assert!(refused(&[("port", "")]).contains("serial:/dev/ttyUSB0@115200"));
    assert!(refused(&[("port", "/dev/ttyUSB0")]).contains("serial:PATH@BAUD"));
    assert!(refused(&[("serial_number", "D195")]).contains("32 hexadecimal digits"));
    assert!(refused(&[("scan_mode", "Boost")]).contains("`Standard` or empty"));
}
