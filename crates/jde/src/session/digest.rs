//! Writes lines to a file and computes their SHA-256.

use std::io::{self, Write};

use sha2::{Digest, Sha256};

use super::pending_file::PendingFile;
use crate::terminal::{self, Printer};

/// Writes to a file or pipe, if there is one, and updates the digest with the bytes accepted. Lines that the
/// file's reader does not read in time still count.
pub(crate) struct DigestWriter {
    /// The file before the first line.
    pending: Option<PendingFile>,
    file: Option<Printer>,
    hasher: Sha256,
}

impl DigestWriter {
    /// Creates an empty digest; `pending` is the file to write.
    pub(crate) fn new(pending: Option<PendingFile>) -> Self {
        Self {
            pending,
            file: None,
            hasher: Sha256::new(),
        }
    }

    fn file(&mut self) -> io::Result<Option<&mut Printer>> {
        if let Some(pending) = self.pending.take() {
            self.file = Some(terminal::lines_to(pending.into_truncated()?)?);
        }
        Ok(self.file.as_mut())
    }

    /// Returns the number of lines that were dropped because they were not read in time.
    pub(crate) fn lost(&self) -> u64 {
        self.file.as_ref().map_or(0, Printer::lost)
    }

    /// Returns the digest in hexadecimal digits.
    pub(crate) fn hex(self) -> String {
        self.hasher
            .finalize()
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect()
    }
}

impl Write for DigestWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = match self.file()? {
            Some(file) => file.write(bytes)?,
            None => bytes.len(),
        };
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file()?.map_or(Ok(()), Printer::drain)
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
            writer.hex(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }
}
