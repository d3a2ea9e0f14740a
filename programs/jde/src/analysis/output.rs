//! Where a picture or a page is written: a file named after the recording, another file, or standard output.
//! Refuses to overwrite the recording itself.

use std::io::Write;
use std::path::{Path, PathBuf};

use jde_log::Recording;
use jde_terminal::{self as terminal, TITLE};

use crate::failure::{Failure, display_path};

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
    /// with another extension. `what` names the output in error messages.
    ///
    /// # Errors
    /// The destination is a file of the recording, or standard output is a terminal.
    pub(crate) fn resolve(
        requested: Option<PathBuf>,
        recording: &Recording,
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
            None => recording.path().with_extension(extension),
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

    /// Writes the bytes. For a file it then prints the path.
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
                jde_files::replace(path, |file| file.write_all(bytes)).map_err(Failure::file(path))?;
                let mut out = terminal::out();
                writeln!(out, "wrote {TITLE}{}{TITLE:#}", display_path(path))?;
                out.flush()?;
            }
        }
        Ok(())
    }
}
