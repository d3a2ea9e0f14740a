//! New applications for robots of one's own: a driver of a base, one of a lidar, and what drives with them.

use std::fs;
use std::io::Write;
use std::path::Path;

use jde_terminal::{self as terminal, FAINT, TITLE};

use super::{checked, create_folder, is_taken, program};
use crate::failure::{self, Failure};

/// A driver, and where its device may be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Driver {
    /// Its type of schema.
    pub(crate) name: &'static str,
    port: &'static str,
    /// What schemas import of it to know how the base follows commands.
    dynamics: &'static str,
}

/// The drivers of bases.
pub(crate) const BASES: [Driver; 2] = [
    Driver {
        name: "base/serial",
        port: "serial:/dev/ttyUSB0@115200",
        dynamics: ", dynamics = \"robot.dynamics\", setpoint = \"robot.setpoint\"",
    },
    Driver {
        name: "p2os/pioneer",
        port: "serial:/dev/ttyUSB0@9600",
        dynamics: ", dynamics = \"robot.dynamics\"",
    },
];
/// The drivers of lidars.
pub(crate) const LASERS: [Driver; 2] = [
    Driver {
        name: "lidar/ld",
        port: "serial:/dev/ttyUSB1@230400",
        dynamics: "",
    },
    Driver {
        name: "lidar/rplidar",
        port: "serial:/dev/ttyUSB1@115200",
        dynamics: "",
    },
];

/// The files of a project.
const FILES: [(&str, &str); 2] = [
    ("app.toml", include_str!("../../templates/real-robot/app.toml")),
    ("README.md", include_str!("../../templates/real-robot/README.md")),
];

/// The schemas of a gamepad.
const GAMEPAD_SCHEMAS: &str = r#"
# It is ready only while a person holds the left shoulder button of a gamepad that is plugged into the robot.
[schemas.gamepad]
type      = "teleop/gamepad"
imports   = { joy = "pad.joy" }
actuators = { base = "robot.velocity" }
scale_linear  = 0.25                       # no more than `velocity_limits`
scale_angular = 0.8

[schemas.pad]
type = "gamepad"
# device_name = "..."                      # of several gamepads, this one
"#;

/// The program of a board that `base/serial` drives.
macro_rules! sketch {
    ($($file:literal),+) => {
        [$((concat!("sketch/", $file), include_str!(concat!("../../../../drivers/base/sketch/", $file)))),+]
    };
}
const SKETCH: [(&str, &str); 5] = sketch!("sketch.ino", "board.h", "command.h", "drive.h", "line.h");

/// Writes a folder of the name with an application of these drivers, and of a gamepad if asked for, and prints what to do
/// next.
///
/// # Errors
/// The name is invalid, the folder exists already, or the files cannot be written.
pub(crate) fn write_real_robot(
    name: &str,
    base: &Driver,
    laser: &Driver,
    has_gamepad: bool,
    folder: &Path,
) -> Result<(), Failure> {
    let name = checked(name, |word| {
        FILES.iter().any(|(file, text)| is_taken(file, text, word))
    })?
    .kebab;
    let folder = folder.join(&name);
    create_folder(&folder)?;
    let jde = program();
    let has_sketch = base.name == "base/serial";
    let sketch = SKETCH.iter().filter(|_| has_sketch);
    let serial_number = if has_sketch {
        format!("serial_number = \"{name}\"    # it must be this board: `serial` in its sketch\n")
    } else {
        String::new()
    };
    let (first_root, gamepad) = if has_gamepad {
        ("\"gamepad\", ", GAMEPAD_SCHEMAS)
    } else {
        ("", "")
    };
    for (file, text) in FILES.iter().chain(sketch) {
        let path = folder.join(file);
        let text = text
            .replace("\"my-robot\"", &format!("\"{name}\""))
            .replace("__serial_number__", &serial_number)
            .replace("__name__", &name)
            .replace("__driver__", base.name)
            .replace("__driver_port__", base.port)
            .replace("__laser__", laser.name)
            .replace("__laser_port__", laser.port)
            .replace("__dynamics__", base.dynamics)
            .replace("__first_root__", first_root)
            .replace("__gamepad__", gamepad)
            .replace("__jde__", &jde);
        let written = path
            .parent()
            .map_or(Ok(()), fs::create_dir_all)
            .and_then(|()| fs::write(&path, text));
        written.map_err(Failure::file(&path))?;
    }
    let mut out = terminal::out();
    let shown = failure::display_path(&folder);
    writeln!(
        out,
        "{TITLE}{shown}{TITLE:#} is created {FAINT}(measure what is marked MEASURE in its app.toml){FAINT:#}; next:"
    )?;
    writeln!(out)?;
    if has_sketch {
        writeln!(
            out,
            "  {FAINT}fill in the head of{FAINT:#} {shown}/sketch/sketch.ino{FAINT}, and load it into the board{FAINT:#}"
        )?;
    }
    writeln!(out, "  cd {shown}")?;
    writeln!(out, "  {jde} check app.toml")?;
    writeln!(out, "  {jde} run app.toml --view")?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_files_have_no_other_placeholders() {
        for (file, text) in FILES {
            let marks = [
                "__name__",
                "__serial_number__",
                "__driver__",
                "__driver_port__",
                "__laser__",
                "__laser_port__",
                "__dynamics__",
                "__first_root__",
                "__gamepad__",
                "__jde__",
            ];
            let filled = marks
                .iter()
                .fold(text.to_owned(), |text, mark| text.replace(mark, ""));
            assert!(!filled.contains("__"), "{file}");
        }
    }
}
