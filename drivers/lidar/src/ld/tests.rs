//! The driver on a test bench, with emulated lidars at a real pseudo-terminal and a real TCP connection.

use std::fs;
use std::os::unix::fs::symlink;

use jde_device::emulate::{DriverTest, EmulatedDevice, refusal};

use super::emulator::{EmulatedLd, Fault};
use super::*;

fn driver(port: &str) -> DriverTest<Ld> {
    let mut driver = DriverTest::with_port(port);
    driver.awake();
    driver
}

/// Returns the first scan.
fn scan(driver: &mut DriverTest<Ld>) -> &LaserScan {
    driver.run_until(|bench| bench.exported_at("laser").is_some());
    driver.bench.exported_in_place("laser").expect("it is exported")
}

#[test]
fn a_scan_is_stamped_by_its_first_beam_and_as_old_as_its_oldest() {
    let (_lidar, path) = EmulatedDevice::at_pty(EmulatedLd::new(|_| 1500));
    for inverted in [false, true] {
        let mut driver = DriverTest::<Ld>::with_port(&format!("serial:{}@230400", path.display()));
        driver.bench.set("beams", 360_u32);
        driver.bench.set("inverted", inverted);
        driver.awake();
        let scan = scan(&mut driver);
        assert_eq!(scan.ranges.as_slice(), [1.5; 360]);
        assert_eq!(scan.intensities.len(), 360);
        assert!(scan.measured().is_ok());
        assert!((scan.angle(180)).abs() < 1e-6, "a beam straight ahead");
        assert_eq!((scan.range_min, scan.range_max), (0.02, 12.0));
        assert!((scan.scan_time - 0.1).abs() < 0.01, "{}", scan.scan_time);
        // The lidar rotates clockwise, so its last point is the first beam, unless it hangs upside down.
        let sign = if inverted { 1.0 } else { -1.0 };
        assert!((scan.time_increment * 359.0 - sign * scan.scan_time).abs() < 1e-5);
        let first = core::time::Duration::from(scan.header.stamp);
        let (turn, forward) = (scan.scan_time, scan.time_increment > 0.0);
        let oldest = driver.bench.exported_at("laser").expect("it is exported");
        let later = (first - oldest).as_secs_f32();
        assert!((later - if forward { 0.0 } else { turn }).abs() < 1e-3, "{later}");
        let (up, name) = driver.connection();
        assert_eq!((up, &*name), (Connection::CONNECTED, "LD06, LD19 or STL-19P"));
        driver.bench.sleep().expect("it sleeps");
        assert_eq!(driver.bench.exported::<LaserScan>("laser"), None);
    }
}

#[test]
fn a_lidar_behind_a_serial_server_is_found_again_after_every_fault() {
    let (lidar, address) = EmulatedDevice::at_tcp(EmulatedLd::new(|_| 1500), 230_400);
    let mut driver = driver(&address);
    scan(&mut driver);
    for (fault, words) in [
        (Fault::Silent, "nothing comes"),
        (Fault::OtherBaud, "no frames"),
        (Fault::Repeats, "contradict"),
    ] {
        lidar.with(|lidar| lidar.fault = fault);
        let reason = driver.wait_lost();
        assert!(reason.contains(words), "{reason}");
        assert_eq!(driver.bench.exported::<LaserScan>("laser"), None);
        lidar.with(|lidar| lidar.fault = Fault::None);
        scan(&mut driver);
    }
}

#[test]
fn the_driver_reconnects_when_the_plug_is_pulled_and_put_back() {
    let name = std::env::temp_dir().join(format!("jde-ld-{}", std::process::id()));
    let mut driver = driver(&format!("serial:{}@230400", name.display()));
    assert!(driver.wait_lost().contains("there is no such device"));
    for _ in 0..2 {
        let (lidar, path) = EmulatedDevice::at_pty(EmulatedLd::new(|_| 1500));
        symlink(path, &name).expect("a symbolic link");
        scan(&mut driver);
        fs::remove_file(&name).expect("the link exists");
        drop(lidar);
        driver.wait_lost();
        assert_eq!(driver.bench.exported::<LaserScan>("laser"), None);
    }
}

#[test]
fn invalid_settings_are_refused_before_the_port_is_opened() {
    let refused = |port: &str| refusal::<Ld>(|bench| bench.set("port", Text::<256>::new(port)));
    assert!(refused("").contains("serial:/dev/ttyUSB0@230400"));
    assert!(refused("/dev/ttyUSB0").contains("serial:PATH@BAUD"));
}
