//! Reads a file up to a limit. Devices, pipes and folders are refused, because they may have no end.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

use flate2::read::MultiGzDecoder;

/// The first bytes of a gzip file.
const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Returns the bytes of a file of at most `most` bytes.
///
/// # Errors
/// It cannot be read, is no regular file, or is larger.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    limited(open(path)?, most)
}

/// Returns the bytes of a file, unpacked if it is a gzip file: at most `most` bytes in both forms.
///
/// # Errors
/// It cannot be read or unpacked, is no regular file, or is larger.
pub fn read_unpacked(path: &Path, most: u64) -> Result<Vec<u8>> {
    let bytes = read(path, most)?;
    if !bytes.starts_with(&GZIP_MAGIC) {
        return Ok(bytes);
    }
    limited(MultiGzDecoder::new(bytes.as_slice()), most)
}

/// Returns the bytes of a file, unpacked if it is a gzip file, up to where a gzip file is damaged or cut short, and what is
/// wrong there: at most `most` bytes in both forms.
///
/// # Errors
/// It cannot be read, is no regular file, or is larger.
pub fn read_undamaged(path: &Path, most: u64) -> Result<(Vec<u8>, Option<Error>)> {
    let packed = read(path, most)?;
    if !packed.starts_with(&GZIP_MAGIC) {
        return Ok((packed, None));
    }
    let mut bytes = Vec::new();
    let mut unpacked = MultiGzDecoder::new(packed.as_slice()).take(most.saturating_add(1));
    let damage = unpacked.read_to_end(&mut bytes).err();
    check_size(&bytes, most)?;
    Ok((bytes, damage))
}

/// Returns the text of a file of at most `most` bytes, without the byte order mark.
///
/// # Errors
/// It cannot be read, is no regular file, is larger, or is no UTF-8.
pub fn read_text(path: &Path, most: u64) -> Result<String> {
    let mut text = String::from_utf8(read(path, most)?)
        .map_err(|error| invalid(format!("byte {} is no UTF-8", error.utf8_error().valid_up_to())))?;
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
}

/// Opens a regular file.
///
/// # Errors
/// It cannot be opened, or is no regular file.
pub fn open(path: &Path) -> Result<File> {
    // A pipe would wait for its writer.
    if !std::fs::metadata(path)?.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, "it is not a regular file"));
    }
    File::open(path)
}

/// Reads to the end. A file may grow meanwhile, and a sparse one is as long as its size says.
fn limited(source: impl Read, most: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    source.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    check_size(&bytes, most)?;
    Ok(bytes)
}

fn check_size(bytes: &[u8], most: u64) -> Result<()> {
    match bytes.len() as u64 > most {
        true => Err(invalid(format!("it has more than {}", size(most)))),
        false => Ok(()),
    }
}

fn size(bytes: u64) -> String {
    match bytes >> 20 {
        0 => format!("{} KiB", bytes >> 10),
        mebibytes => format!("{mebibytes} MiB"),
    }
}

fn invalid(message: String) -> Error {
    Error::new(ErrorKind::InvalidData, message)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::{Compression, write::GzEncoder};

    use super::*;

    fn message<T: std::fmt::Debug>(result: Result<T>) -> String {
        result.unwrap_err().to_string()
    }

    #[test]
    fn what_is_endless_or_too_large_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, [0; 2049]).unwrap();
        assert_eq!(read(&path, 2049).unwrap().len(), 2049);
        assert_eq!(message(read(&path, 2048)), "it has more than 2 KiB");
        assert_eq!(
            message(read(Path::new("/dev/zero"), 10)),
            "it is not a regular file"
        );
        assert_eq!(message(read(folder.path(), 10)), "it is not a regular file");
    }

    #[test]
    fn a_small_file_that_unpacks_to_a_large_one_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("zeros.gz");
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        packed.write_all(&vec![0; 3 << 20]).unwrap();
        std::fs::write(&path, packed.finish().unwrap()).unwrap();
        assert_eq!(read_unpacked(&path, 3 << 20).unwrap().len(), 3 << 20);
        assert_eq!(message(read_unpacked(&path, 2 << 20)), "it has more than 2 MiB");
    }

    #[test]
    fn a_packed_file_that_is_cut_short_is_read_up_to_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lines.gz");
        let text: String = (0..20_000).map(|line| format!("{line}\n")).collect();
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        packed.write_all(text.as_bytes()).unwrap();
        let packed = packed.finish().unwrap();
        for (end, is_damaged) in [(packed.len(), false), (packed.len() / 2, true)] {
            std::fs::write(&path, &packed[..end]).unwrap();
            let (bytes, damage) = read_undamaged(&path, 1 << 20).unwrap();
            assert!(text.as_bytes().starts_with(&bytes) && bytes.len() > text.len() / 4);
            assert_eq!(
                (damage.is_some(), bytes.len() < text.len()),
                (is_damaged, is_damaged)
            );
        }
        assert_eq!(
            message(read_undamaged(&path, 10 << 10)),
            "it has more than 10 KiB"
        );
    }

    #[test]
    fn a_byte_order_mark_is_no_text() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, "\u{feff}a: 1").unwrap();
        assert_eq!(read_text(&path, 100).unwrap(), "a: 1");
        std::fs::write(&path, b"ab\xe9").unwrap();
        assert_eq!(message(read_text(&path, 100)), "byte 2 is no UTF-8");
    }
}
