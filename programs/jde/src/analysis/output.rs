//! Where a picture or a page is written: a file named after the recording, another file, or standard output.
//! Refuses to overwrite the recording itself.

use std::io::Write;
use std::path::{Path, PathBuf};

use jde_log::Recording;
use jde_terminal::{self as terminal, TITLE};

use crate::failure::{Failure, display_path};

/// The most letters of names in the name of a file.
const MAX_NAMES: usize = 120;

/// The destination of a picture or a page.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Output {
    /// A file, which is overwritten if it exists.
    File(PathBuf),
    /// Standard output.
    Standard,
}

impl Output {
    /// Returns the requested destination, where `-` is standard output. The default is the recording's path
    /// with `names` behind it and another extension. `what` names the output in error messages.
    ///
    /// # Errors
    /// The destination is a file of the recording, or standard output is a terminal.
    pub(crate) fn resolve(
        requested: Option<PathBuf>,
        recording: &Recording,
        names: &[String],
        extension: &str,
        what: &str,
    ) -> Result<Self, Failure> {
        let path = match requested {
            Some(path) if path == Path::new("-") => {
                if terminal::out_is_terminal() {
                    return Err(Failure::usage(
                        format!("a {what} cannot be printed on a terminal"),
                        format!("give -o FILE.{extension}, or send it to another program: -o - | ..."),
                    ));
                }
                return Ok(Self::Standard);
            }
            Some(path) => path,
            None => default_path(recording.path(), names, extension),
        };
        let real = |path: &Path| path.canonicalize().ok();
        let written = real(&path);
        if written.is_some() && recording.files().any(|file| real(file) == written) {
            return Err(Failure::usage(
                format!("{} is the recording itself", display_path(&path)),
                format!("give -o FILE.{extension}"),
            ));
        }
        Ok(Self::File(path))
    }

    /// Writes the bytes. For a file it then prints the path, and whether another file was there.
    ///
    /// # Errors
    /// The destination cannot be written.
    pub(crate) fn write(&self, bytes: &[u8]) -> Result<(), Failure> {
        match self {
            Self::Standard => {
                let mut out = terminal::raw_out();
                out.write_all(bytes)?;
                out.flush()?;
            }
            Self::File(path) => {
                let did = if path.exists() { "replaced" } else { "wrote" };
                jde_files::replace(path, |file| file.write_all(bytes)).map_err(Failure::file(path))?;
                let mut out = terminal::out();
                writeln!(out, "{did} {TITLE}{}{TITLE:#}", display_path(path))?;
                out.flush()?;
            }
        }
        Ok(())
    }
}

/// Returns the path of a recording with names behind it, of which the letters that files may have remain, and another
/// extension: a picture of some numbers does not replace that of the path.
fn default_path(recording: &Path, names: &[String], extension: &str) -> PathBuf {
    if names.is_empty() {
        return recording.with_extension(extension);
    }
    let stem = recording.file_stem().unwrap_or_default().to_string_lossy();
    let plain = |letter: char| letter.is_ascii_alphanumeric() || "._-".contains(letter);
    let names = names.join("-");
    let shown = names
        .chars()
        .map(|letter| if plain(letter) { letter } else { '_' });
    let names: String = shown.take(MAX_NAMES).collect();
    recording.with_file_name(format!("{stem}-{names}.{extension}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_of_numbers_has_their_names() {
        let path = |names: &[&str]| {
            let names: Vec<_> = names.iter().map(|name| (*name).to_owned()).collect();
            default_path(Path::new("runs/drive.mcap"), &names, "png")
        };
        assert_eq!(path(&[]), Path::new("runs/drive.png"));
        assert_eq!(path(&["goon.fast"]), Path::new("runs/drive-goon.fast.png"));
        let two = path(&["laser.ranges[3]", "/base/odom.x"]);
        assert_eq!(two, Path::new("runs/drive-laser.ranges_3_-_base_odom.x.png"));
    }
}
