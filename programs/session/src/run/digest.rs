//! Writes lines to a file and computes their SHA-256.

use std::io::{self, Write};

use jde_terminal::{self as terminal, Printer};
use sha2::{Digest, Sha256};

use super::pending_file::PendingFile;

/// Writes to a file or pipe, if there is one, and updates the digest with all bytes. Lines that the file's reader does not
/// read in time still count, and so do those that the disk does not accept: the run has a result without its file.
pub(crate) struct DigestWriter {
    /// The file before the first line.
    pending: Option<PendingFile>,
    file: Option<Printer>,
    /// Why nothing more is written to the file.
    failed: Option<io::Error>,
    hasher: Sha256,
}

impl DigestWriter {
    /// Creates an empty digest; `pending` is the file to write.
    pub(crate) fn new(pending: Option<PendingFile>) -> Self {
        Self {
            pending,
            file: None,
            failed: None,
            hasher: Sha256::new(),
        }
    }

    /// Performs an operation on the file, if there is one and it has not failed.
    fn with_file(&mut self, operation: impl FnOnce(&mut Printer) -> io::Result<()>) {
        let opened = self.pending.take().map(|pending| {
            pending
                .into_truncated()
                .and_then(terminal::lines_to)
                .map(|file| self.file = Some(file))
        });
        let done = opened
            .unwrap_or(Ok(()))
            .and_then(|()| self.file.as_mut().map_or(Ok(()), operation));
        if let Err(error) = done {
            self.file = None;
            self.failed.get_or_insert(error);
        }
    }

    /// Returns the number of lines that were dropped because they were not read in time.
    pub(crate) fn lost(&self) -> u64 {
        self.file.as_ref().map_or(0, Printer::lost)
    }

    /// Returns the digest in hexadecimal digits, and why the file is not complete.
    pub(crate) fn finish(self) -> (String, Option<io::Error>) {
        let digest = self.hasher.finalize();
        let digits = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        (digits, self.failed)
    }
}

impl Write for DigestWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.with_file(|file| file.write_all(bytes));
        self.hasher.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.with_file(Printer::drain);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_equals_the_example_of_the_standard() {
        // FIPS 180-2, appendix B.1.
        let mut writer = DigestWriter::new(None);
        writer.write_all(b"a").unwrap();
        writer.write_all(b"bc").unwrap();
        assert_eq!(
            writer.finish().0,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }

    #[test]
    fn the_digest_does_not_need_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let full = folder.path().join("decisions.jsonl");
        std::os::unix::fs::symlink("/dev/full", &full).unwrap();
        let mut writer = DigestWriter::new(Some(PendingFile::prepare(&full).unwrap()));
        writer.write_all(b"abc").unwrap();
        writer.flush().unwrap();
        let (digest, failed) = writer.finish();
        assert!(digest.starts_with("ba7816bf"), "{digest}");
        assert_eq!(failed.unwrap().kind(), io::ErrorKind::StorageFull);
    }
}
