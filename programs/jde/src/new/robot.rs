//! New robots of the simulator: a small one, or a copy of a shipped one.

use std::io::Write;
use std::path::Path;

use jde_sim::SHIPPED_ROBOTS;
use jde_terminal::{self as terminal, FAINT, TITLE};

use super::{checked, write_file};
use crate::failure::{self, Failure};

/// The name and the file of the robot to start from.
const TEMPLATE: (&str, &str) = ("robot", include_str!("../../templates/robot/robot.toml"));

/// Writes a robot as `NAME.toml`: the shipped one of the name `from`, or else the small one.
///
/// # Errors
/// The name is invalid, or the file exists already or cannot be written.
pub(crate) fn write_robot(name: &str, from: Option<&str>, folder: &Path) -> Result<(), Failure> {
    let name = checked(name, |_| false)?.kebab;
    let shipped = SHIPPED_ROBOTS.into_iter().find(|(known, _)| Some(*known) == from);
    let (known, text) = shipped.unwrap_or(TEMPLATE);
    jde_files::create_folder(folder).map_err(Failure::file(folder))?;
    let created = folder.join(&name).with_extension("toml");
    let text = text.replacen(&format!("{known:?}"), &format!("{name:?}"), 1);
    write_file(&created, &text)?;
    let shown = failure::display_path(&created);
    writeln!(
        terminal::out(),
        "{TITLE}{shown}{TITLE:#} is created {FAINT}(an application names it: model = \"{name}.toml\"){FAINT:#}"
    )?;
    Ok(())
}
