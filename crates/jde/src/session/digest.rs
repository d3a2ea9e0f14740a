//! Lines on their way to a file, and their SHA-256.

use std::fs::File;
use std::io::{self, BufWriter, Write};

use sha2::{Digest, Sha256};

/// Writes to a file, if there is one, and adds up the digest of what it is given.
pub(crate) struct Digested {
    file: Option<BufWriter<File>>,
    hasher: Sha256,
}

impl Digested {
    /// Nothing so far.
    pub(crate) fn new(file: Option<File>) -> Self {
        Self {
            file: file.map(BufWriter::new),
            hasher: Sha256::new(),
        }
    }

    /// The digest, in hexadecimal digits.
    pub(crate) fn hex(self) -> String {
        self.hasher
            .finalize()
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect()
    }
}

impl Write for Digested {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = match &mut self.file {
            Some(file) => file.write(bytes)?,
            None => bytes.len(),
        };
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), BufWriter::flush)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_that_of_the_standard() {
        // FIPS 180-2, appendix B.1.
        let mut digested = Digested::new(None);
        digested.write_all(b"a").unwrap();
        digested.write_all(b"bc").unwrap();
        assert_eq!(
            digested.hex(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }
}
