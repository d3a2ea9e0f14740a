//! What must hold of each reader for any bytes. The fuzz targets run these functions, and so does the test of this
//! package, with the corpus. Readers that are private to a plugin are included by their paths.

use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use jde_abi::describe::{Plugin, Type};
use jde_app::{Catalogue, Unusable};
use jde_ros::cdr;

mod carmen;
mod files;
#[path = "../../../drivers/imu/src/frame.rs"]
mod frame;
#[path = "../../../drivers/imu/src/checks.rs"]
mod imu;
#[path = "../../../drivers/lidar/src/checks.rs"]
mod lidar;
#[path = "../../../observe/link/tests/link/checks.rs"]
mod link;
#[path = "../../../drivers/carmen/src/log/mod.rs"]
mod log;
mod p2os;
#[path = "../../../plugin/panel/tests/it/checks.rs"]
mod panel;
#[path = "../../../devices/player/tests/it/checks.rs"]
mod player;
mod recordings;
#[path = "../../../drivers/lidar/src/turn.rs"]
mod turn;
mod vision;

/// The readers of LDRobot's lidars.
#[path = "../../../drivers/lidar/src/ld"]
mod ld {
    pub(crate) mod frame;
}

/// The readers of SLAMTEC's lidars.
#[expect(dead_code, reason = "the driver also writes")]
#[path = "../../../drivers/lidar/src/rplidar"]
mod rplidar {
    pub(crate) mod message;
    pub(crate) mod samples;
}

/// Checks the reader of calibrations of cameras with a file.
pub fn calibration(data: &[u8]) {
    vision::calibration(data);
}

/// Checks the readers of the link's messages with arbitrary bytes.
pub fn link(data: &[u8]) {
    link::messages(data);
}

/// Checks the reader of recordings with the bytes of a file.
pub fn recording(data: &[u8]) {
    recordings::recording(data);
}

/// Checks the receiver of packets with a stream of bytes.
pub fn receiver(data: &[u8]) {
    p2os::receiver(data);
}

/// Checks the reader of commands with a payload.
pub fn command(data: &[u8]) {
    p2os::command(data);
}

/// Checks every reader of a robot's packets with a payload.
pub fn answer(data: &[u8]) {
    p2os::answer(data);
}

/// Checks the client's session with a robot that sends arbitrary bytes.
pub fn session(data: &[u8]) {
    p2os::session(data);
}

/// Checks the reader of the camera's frames with a stream of bytes.
pub fn head(data: &[u8]) {
    p2os::head(data);
}

/// Checks the reader of panels with arbitrary bytes.
pub fn list(data: &[u8]) {
    panel::list(data);
}

/// Checks the reader of operators' gestures on panels with arbitrary bytes.
pub fn gesture(data: &[u8]) {
    panel::gesture(data);
}

/// Checks the receiver of Player's messages with a stream of bytes.
pub fn player_stream(data: &[u8]) {
    player::stream(data);
}

/// Checks the client's session with a Player server that sends arbitrary bytes.
pub fn player_session(data: &[u8]) {
    player::session(data);
}

/// Checks the reader of ROS maps with a YAML file and, after a byte 0, its image `m`.
pub fn map_file(data: &[u8]) {
    files::map(data);
}

/// Checks the readers of worlds of other programs with a file and, after a byte 0, the image `m` beside it.
pub fn import(data: &[u8]) {
    files::import(data);
}

/// Checks the reader of CARMEN's logs with arbitrary bytes.
pub fn carmen_log(data: &[u8]) {
    carmen::log(data);
}

/// Checks the reader of serial inertial units with a stream of bytes.
pub fn imu(data: &[u8]) {
    imu::wit(data);
}

/// Checks the readers of serial lidars with a stream of bytes.
pub fn lidar(data: &[u8]) {
    lidar::ld(data);
    lidar::rplidar(data);
}

/// No plugins.
struct NoPlugins;

impl Catalogue for NoPlugins {
    fn plugin(&self, _: &str, _: &[PathBuf]) -> Result<Arc<Plugin>, Unusable> {
        Err(Unusable {
            reason: String::from("there are none"),
            is_missing: true,
        })
    }

    fn type_names(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Checks the reader of application files. Without plugins none is accepted, and the faults are few.
pub fn application(data: &[u8]) {
    if let Ok(text) = std::str::from_utf8(data) {
        let faults = jde_app::parse(text, Path::new("app.toml"), &[], &NoPlugins).expect_err("no plugins");
        assert!(faults.count() > 0 && faults.list().len() <= 200);
    }
}

/// Checks the readers of definitions of ROS 2.
pub fn definition(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    if let Ok(value_type) = jde_ros::definition::read_interface("a_msgs/msg/A", text, |_| 16, |_| None) {
        assert!(value_type.bytes <= 256 << 20);
    }
    let parts = jde_ros::definition::split("a_msgs/msg/A", text);
    let find = |name: &str| Ok(parts.get(name).cloned());
    let _ = jde_ros::definition::gather("a_msgs/msg/A", find, |_| false);
}

/// Checks the reader of messages of ROS 2 for each standard type: what is decoded, fits into its extent.
pub fn cdr(data: &[u8]) {
    static TYPES: LazyLock<Vec<Type>> = LazyLock::new(jde_types::standard);
    for value_type in TYPES.iter() {
        let decoded = cdr::decode(value_type, data);
        let mut extent = cdr::Extent::new(value_type);
        let included = extent.include(data);
        if decoded.is_ok() {
            assert_eq!(included, Ok(()));
            assert!(cdr::decode(&extent.into_type(), data).is_ok());
        }
    }
}
