//! A robot of one's own, from `jde new robot` to its target, as docs/robot-evening.md has it: the sketch's own board and an
//! emulated LD06 behind pseudo-terminals, in a room.

use std::fs::File;
use std::path::Path;
use std::process::{Child, Stdio};

use jde_device::emulate::{EmulatedDevice, Emulator};
use jde_watchdog::Watchdog;
use parking_lot::Mutex;

use crate::support::{jde, jde_with_plugins, output_of};

#[expect(dead_code, reason = "the driver's own tests use the rest")]
#[path = "../../../../drivers/base/src/tests/board.rs"]
mod board;

#[expect(dead_code, reason = "the driver's own tests use the rest")]
#[path = "../../../../drivers/lidar/src/ld"]
mod ld {
    pub(crate) mod emulator;
    pub(crate) mod frame;
}

use board::{Board, Wired};
use ld::emulator::EmulatedLd;

/// Where the robot is: the lidar's distances are those of its place in the room.
static POSE: Mutex<[f64; 3]> = Mutex::new([0.0; 3]);

/// The base, which tells the lidar where it is.
struct Base(Wired);

impl Base {
    fn told(&self, output: Vec<u8>) -> Vec<u8> {
        *POSE.lock() = self.0.board.truth.pose;
        output
    }
}

impl Emulator for Base {
    fn receive(&mut self, bytes: &[u8], baud: u32) -> Vec<u8> {
        let output = self.0.receive(bytes, baud);
        self.told(output)
    }

    fn poll_output(&mut self) -> Vec<u8> {
        let output = self.0.poll_output();
        self.told(output)
    }
}

/// The distance of the walls, mm, at an angle clockwise from ahead, degrees. The room has 6 m by 5 m, and a corner of 1 m
/// by 1 m is missing.
fn room(degrees: f64) -> u16 {
    let [x, y, heading] = *POSE.lock();
    let angle = heading - degrees.to_radians();
    let (step_y, step_x) = angle.sin_cos();
    // Walls across x, and along it: their place, and from where to where they are.
    let across = [(-1.5, -2.0, 3.0), (4.5, -2.0, 2.0), (3.5, 2.0, 3.0)];
    let along = [(-2.0, -1.5, 4.5), (3.0, -1.5, 3.5), (2.0, 3.5, 4.5)];
    let meet = |place: f64, own: f64, step: f64, other: f64, other_step: f64, from: f64, to: f64| {
        let way = (place - own) / step;
        let there = other + way * other_step;
        (way > 0.0 && (from..=to).contains(&there)).then_some(way)
    };
    let ways = across
        .into_iter()
        .filter_map(|(place, from, to)| meet(place, x, step_x, y, step_y, from, to))
        .chain(
            along
                .into_iter()
                .filter_map(|(place, from, to)| meet(place, y, step_y, x, step_x, from, to)),
        );
    (ways.fold(f64::INFINITY, f64::min) * 1000.0).round() as u16
}

fn pose(base: &EmulatedDevice<Base>) -> [f64; 3] {
    base.with(|base| base.0.board.truth.pose)
}

fn speed(base: &EmulatedDevice<Base>) -> f64 {
    let [ahead, _, turn] = base.with(|base| base.0.board.truth.speeds);
    ahead.abs() + turn.abs()
}

/// A process that is killed when dropped.
struct Driving(Child);

impl Drop for Driving {
    fn drop(&mut self) {
        // It may have ended already.
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

/// Writes a robot as `jde new robot` does, and returns its application.
fn new_robot(folder: &Path, more: &[&str]) -> std::path::PathBuf {
    let words = [
        "new",
        "robot",
        "kit",
        "--driver",
        "base/serial",
        "--laser",
        "lidar/ld",
        "--path",
    ];
    let created = output_of(jde(&words).arg(folder).args(more));
    assert_eq!(created.status, Some(0), "{}", created.err);
    assert!(
        created.out.contains("sketch/sketch.ino") && created.out.contains("MEASURE"),
        "{}",
        created.out
    );
    folder.join("kit/app.toml")
}

#[test]
fn a_new_real_robot_has_its_sketch_and_a_check_names_the_devices_that_it_lacks() {
    let folder = tempfile::tempdir().expect("a folder");
    let app = new_robot(folder.path(), &[]);
    for file in ["sketch.ino", "board.h", "command.h", "drive.h", "line.h"] {
        assert!(
            folder.path().join("kit/sketch").join(file).is_file(),
            "{file} is missing"
        );
    }
    let sketch = std::fs::read_to_string(folder.path().join("kit/sketch/sketch.ino")).expect("a file");
    let text = std::fs::read_to_string(&app).expect("a file");
    assert!(sketch.contains("s.serial = \"kit\";") && text.contains("serial_number = \"kit\""));
    // Names that no machine has.
    std::fs::write(&app, text.replace("/dev/ttyUSB", "/dev/none-")).expect("a file");
    let checked = output_of(jde_with_plugins(&["check"]).arg(&app));
    assert_eq!(checked.status, Some(2));
    for device in ["robot`: /dev/none-0", "lidar`: /dev/none-1"] {
        assert!(checked.err.contains(device), "{}", checked.err);
    }
    assert!(
        !checked.out.contains("line "),
        "nothing disagrees: {}",
        checked.out
    );

    let alone =
        output_of(jde(&["new", "robot", "other", "--driver", "base/serial", "--path"]).arg(folder.path()));
    assert_eq!(alone.status, Some(2));
    assert!(alone.err.contains("--laser"), "{}", alone.err);
}

#[test]
fn a_new_real_robot_may_have_a_gamepad_before_all_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let app = new_robot(folder.path(), &["--teleop", "gamepad"]);
    let text = std::fs::read_to_string(&app).expect("a file");
    assert!(
        text.contains(r#"roots   = ["gamepad", "teleop", "navigate"]"#),
        "{text}"
    );
    // A pad that no machine has.
    let text = text.replace("# device_name = \"...\"", "device_name = \"no such pad\"");
    std::fs::write(&app, text).expect("a file");
    let checked = output_of(jde_with_plugins(&["check"]).arg(&app));
    assert!(checked.err.contains("gamepad"), "{}", checked.err);
    assert!(
        !checked.out.contains("line "),
        "nothing disagrees: {}",
        checked.out
    );
}

#[test]
fn a_new_real_robot_drives_to_its_target_and_stands_when_its_process_is_killed() {
    let _watchdog = Watchdog::for_test();
    let folder = tempfile::tempdir().expect("a folder");
    let app = new_robot(folder.path(), &[]);
    let (base, base_path) = EmulatedDevice::at_pty(Base(Wired::new(Board::new("differential", "kit"))));
    let (_lidar, lidar_path) = EmulatedDevice::at_pty(EmulatedLd::new(room));
    // The lines stay open between the runs.
    let _lines = [&base_path, &lidar_path].map(|path| File::open(path).expect("a line"));
    let text = std::fs::read_to_string(&app).expect("a file");
    let text = text
        .replace("/dev/ttyUSB0", &base_path.display().to_string())
        .replace("/dev/ttyUSB1", &lidar_path.display().to_string());
    std::fs::write(&app, text).expect("a file");
    let checked = output_of(jde_with_plugins(&["check"]).arg(&app));
    assert_eq!(checked.status, Some(0), "{}", checked.err);

    let run = |target: &str| {
        let mut command = jde_with_plugins(&["run", "--plain", "--set"]);
        command
            .arg(format!("navigate.route={{poses=[{target}]}}"))
            .arg(&app);
        command
    };
    let driven = output_of(&mut run("[1.5, 0.5, 0]"));
    let [x, y, _] = pose(&base);
    assert!(
        (x - 1.5).hypot(y - 0.5) < 0.3,
        "at {x:.2} {y:.2}: {}{}",
        driven.out,
        driven.err
    );
    assert_eq!(driven.status, Some(0), "{}", driven.err);

    // The new run starts where the robot is now, as the origin of its map.
    let mut process = run("[-1.5, 0, 0]");
    let mut process = Driving(
        process
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the executable starts"),
    );
    while speed(&base) < 0.2 {
        assert!(process.0.try_wait().expect("a process").is_none(), "it has ended");
        std::thread::yield_now();
    }
    drop(process);
    while speed(&base) > 0.001 {
        std::thread::yield_now();
    }
}
