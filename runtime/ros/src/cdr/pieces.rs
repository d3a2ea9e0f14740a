//! Copies the parts of a message that came in several pieces, without joining the pieces.

use super::{CDR_LITTLE_ENDIAN, Error};

/// The rest of a message. Each function names the field that it reads, for the error message.
pub(super) struct Pieces<'a> {
    current: &'a [u8],
    further: &'a [&'a [u8]],
    /// Bytes since the header.
    position: usize,
    /// Bytes to the end of the message.
    left: usize,
    /// Told of each text that is cut to its capacity; without it such a text is an error.
    pub(super) on_cut: Option<&'a mut OnCut<'a>>,
}

/// Told of a text that is longer than its capacity: the name of the field, and the capacity in bytes.
pub type OnCut<'a> = dyn FnMut(&str, usize) + 'a;

impl<'a> Pieces<'a> {
    /// Begins with the first field of a message.
    ///
    /// # Errors
    /// [`Error::Encapsulation`].
    pub(super) fn new(pieces: &'a [&'a [u8]]) -> Result<Self, Error> {
        let mut this = Self {
            current: &[],
            further: pieces,
            position: 0,
            left: pieces.iter().map(|piece| piece.len()).sum(),
            on_cut: None,
        };
        let mut head = CDR_LITTLE_ENDIAN;
        let length = head.len().min(this.left);
        this.copy(&mut head[..length]);
        Error::check_encapsulation(&head[..length])?;
        this.position = 0;
        Ok(this)
    }

    /// Copies bytes from the next multiple of `align` on.
    ///
    /// # Errors
    /// [`Error::Truncated`].
    pub(super) fn fill(&mut self, align: usize, target: &mut [u8], field: &str) -> Result<(), Error> {
        let gap = self.position.next_multiple_of(align) - self.position;
        self.expect(gap + target.len(), field)?;
        // An alignment is at most eight bytes.
        self.copy(&mut [0; 8][..gap]);
        self.copy(target);
        Ok(())
    }

    /// Returns the number of elements of a sequence, which may exceed the rest of the message.
    ///
    /// # Errors
    /// [`Error::Truncated`].
    pub(super) fn length(&mut self, field: &str) -> Result<usize, Error> {
        let mut bytes = [0; 4];
        self.fill(4, &mut bytes, field)?;
        Ok(u32::from_le_bytes(bytes) as usize)
    }

    /// Checks that there are as many bytes.
    ///
    /// # Errors
    /// [`Error::Truncated`].
    pub(super) fn expect(&self, bytes: usize, field: &str) -> Result<(), Error> {
        match bytes <= self.left {
            true => Ok(()),
            false => Err(Error::Truncated(field.to_owned())),
        }
    }

    /// Ends after the last field.
    ///
    /// # Errors
    /// [`Error::Long`].
    pub(super) fn finish(self) -> Result<(), Error> {
        Error::check_surplus(self.left)
    }

    /// Passes over bytes.
    ///
    /// # Errors
    /// [`Error::Truncated`].
    pub(super) fn skip(&mut self, mut bytes: usize, field: &str) -> Result<(), Error> {
        self.expect(bytes, field)?;
        let mut passed = [0; 64];
        while bytes > 0 {
            let count = bytes.min(passed.len());
            self.copy(&mut passed[..count]);
            bytes -= count;
        }
        Ok(())
    }

    /// Copies the next bytes, which exist.
    fn copy(&mut self, mut target: &mut [u8]) {
        self.position += target.len();
        self.left -= target.len();
        while !target.is_empty() {
            if self.current.is_empty()
                && let Some((next, further)) = self.further.split_first()
            {
                (self.current, self.further) = (next, further);
                continue;
            }
            let count = self.current.len().min(target.len());
            let (taken, rest) = self.current.split_at(count);
            let (filled, open) = target.split_at_mut(count);
            filled.copy_from_slice(taken);
            (self.current, target) = (rest, open);
        }
    }
}
