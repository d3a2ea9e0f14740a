//! Reads the files of maps and worlds. Each kind of file has a size limit. Only regular files are read, no
//! devices.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Greatest world file or map YAML, in bytes: enough for thousands of things.
const MAX_TEXT: u64 = 4 << 20;
/// Greatest image of a map, in bytes: the most pixels, in plain text.
pub(crate) const MAX_IMAGE: u64 = 512 << 20;

/// Returns the text of a file of at most 4 MiB.
///
/// # Errors
/// If it cannot be read, is no regular file, is larger, or is no UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read_limited(path, MAX_TEXT)?)
        .map_err(|_| Error::new(ErrorKind::InvalidData, "it is no UTF-8"))
}

/// Returns the bytes of a file of at most `most` bytes.
pub(crate) fn read_limited(path: &Path, most: u64) -> Result<Vec<u8>> {
    let about = std::fs::metadata(path)?;
    if !about.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, "it is no regular file"));
    }
    let mut bytes = Vec::new();
    // The file may grow while it is read.
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let message = format!("it has more than {} MiB", most >> 20);
        return Err(Error::new(ErrorKind::InvalidData, message));
    }
    Ok(bytes)
}
