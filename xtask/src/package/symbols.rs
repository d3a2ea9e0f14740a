//! The symbols of programs and libraries, in files of their own. Debuggers and the backtraces of Rust look for them below
//! `/usr/lib/debug/.build-id`, by the identifier that the linker has written into the program.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, Result};

use crate::shell;

/// The folder of all symbols, from the root of a system.
const FOLDER: &str = "usr/lib/debug/.build-id";

/// Copies a program or a library without its symbols to `to`, and its symbols into the tree `symbols`.
pub(super) fn install_stripped(from: &Path, to: &Path, symbols: &Path) -> Result<()> {
    fs::create_dir_all(to.parent().unwrap_or(to))?;
    let mut strip = Command::new("strip");
    strip.args(["--strip-unneeded", "-o"]).arg(to).arg(from);
    shell::read(&mut strip)?;
    let notes = shell::read(Command::new("readelf").arg("--notes").arg(from))?;
    let apart =
        symbols.join(place(&notes).with_context(|| format!("{} has no build identifier", from.display()))?);
    fs::create_dir_all(apart.parent().unwrap_or(&apart))?;
    let mut copy = Command::new("objcopy");
    copy.args(["--only-keep-debug", "--compress-debug-sections"])
        .arg(from)
        .arg(&apart);
    shell::read(&mut copy).map(drop)
}

/// Returns where the symbols of a file belong, by what `readelf --notes` prints of it.
fn place(notes: &str) -> Option<PathBuf> {
    let (_, rest) = notes.split_once("Build ID: ")?;
    let (first, rest) = rest.split_whitespace().next()?.split_at_checked(2)?;
    Some(Path::new(FOLDER).join(first).join(format!("{rest}.debug")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_lie_where_the_identifier_says() {
        let notes = "  GNU   0x14  NT_GNU_BUILD_ID (unique build ID bitstring)\n    Build ID: bcec3ab4609f\n";
        assert_eq!(
            place(notes),
            Some(PathBuf::from("usr/lib/debug/.build-id/bc/ec3ab4609f.debug"))
        );
        assert_eq!(place("no notes"), None);
    }
}
