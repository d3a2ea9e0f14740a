//! The driver on a test bench, with an emulated unit at a real pseudo-terminal and a real TCP connection; and any bytes.

use jde_device::Protocol;
use jde_device::emulate::{DriverTest, EmulatedDevice, refusal};
use proptest::prelude::*;

use super::*;
use crate::checks;
use crate::emulator::{EmulatedWit, Fault};

/// Returns the first value.
fn imu(driver: &mut DriverTest<Wit>) -> Imu {
    driver.run_until(|bench| bench.exported_at("imu").is_some());
    driver.bench.exported("imu").expect("it is exported")
}

#[test]
fn a_unit_at_a_serial_line_is_exported_as_ros_has_it() {
    let unit = EmulatedWit {
        rates: [0.0, 0.0, 45.0],
        angles: [0.0, 0.0, 30.0],
        ..EmulatedWit::new()
    };
    let (_unit, path) = EmulatedDevice::at_pty(unit);
    for compass in [false, true] {
        let mut driver = DriverTest::<Wit>::with_port(&format!("serial:{}@115200", path.display()));
        driver.bench.set("compass", compass);
        driver.awake();
        let imu = imu(&mut driver);
        assert!((imu.angular_velocity.z - 45_f64.to_radians()).abs() < 0.002);
        assert!((imu.linear_acceleration.z - 9.81).abs() < 0.05);
        assert!((imu.orientation.yaw() - 30_f64.to_radians()).abs() < 0.001);
        assert_eq!(
            imu.orientation_covariance[8] < 0.1,
            compass,
            "a heading of 6 axes is unknown"
        );
        assert_eq!(imu.header.frame_id.as_str(), "imu");
        assert_eq!(
            driver.connection(),
            (Connection::CONNECTED, "WIT-Motion".to_owned())
        );
        driver.bench.sleep().expect("it sleeps");
        assert_eq!(driver.bench.exported::<Imu>("imu"), None);
    }
}

#[test]
fn a_unit_behind_a_serial_server_is_found_again_after_every_fault() {
    let (unit, address) = EmulatedDevice::at_tcp(EmulatedWit::new(), 115_200);
    let mut driver = DriverTest::<Wit>::with_port(&address);
    driver.awake();
    imu(&mut driver);
    for (fault, words) in [
        (Fault::Silent, "nothing comes"),
        (Fault::OtherBaud, "no frames"),
        (Fault::NoRates, "no turn rates"),
    ] {
        unit.with(|unit| unit.fault = fault);
        let reason = driver.wait_lost();
        assert!(reason.contains(words), "{reason}");
        assert_eq!(driver.bench.exported::<Imu>("imu"), None);
        unit.with(|unit| unit.fault = Fault::None);
        imu(&mut driver);
    }
}

#[test]
fn invalid_settings_are_refused_before_the_port_is_opened() {
    let refused = |port: &str| refusal::<Wit>(|bench| bench.set("port", Text::<256>::new(port)));
    assert!(refused("").contains("serial:/dev/ttyUSB0@115200"));
    assert!(refused("/dev/ttyUSB0").contains("serial:PATH@BAUD"));
}

proptest! {
    #[test]
    fn no_bytes_break_a_reader_or_a_session(pieces in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..400), 0..8)) {
        checks::wit(&pieces.concat());
        let mut events = Vec::new();
        let mut session = WitSession::start(WitConfig { rate: 100.0 }, Duration::ZERO, &mut events);
        for (tenth, piece) in (1..).zip(&pieces) {
            session.receive(piece, Duration::from_millis(tenth * 100), &mut events);
        }
    }

    #[test]
    fn mutations_of_good_bytes_break_no_reader(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..20)) {
        let mut unit = EmulatedWit { has_quaternion: true, ..EmulatedWit::new() };
        let mut bytes: Vec<u8> = (0..20).flat_map(|_| unit.next_output()).collect();
        for (index, byte) in changes {
            let index = index.index(bytes.len());
            bytes[index] = byte;
        }
        checks::wit(&bytes);
    }
}
