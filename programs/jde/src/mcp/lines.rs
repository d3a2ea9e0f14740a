//! Lines of a stream that anybody may write: each within a limit of bytes, however long it is. It keeps no more than
//! that, and goes on behind a line that is too long.

use std::io::{self, BufRead, BufReader, Read};

/// A line, without its end.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Line {
    /// A text.
    Text(String),
    /// More bytes than the limit; they are gone.
    TooLong,
    /// Bytes that are not UTF-8.
    NotText,
}

/// Reads lines.
pub(super) struct Lines<R> {
    input: BufReader<R>,
    limit: usize,
}

impl<R: Read> Lines<R> {
    /// Reads lines of at most `limit` bytes.
    pub(super) fn new(input: R, limit: usize) -> Self {
        Self {
            input: BufReader::new(input),
            limit,
        }
    }

    /// Returns the next line; `None` at the end. What is behind the last line end is a line too.
    ///
    /// # Errors
    /// The stream cannot be read.
    pub(super) fn next(&mut self) -> io::Result<Option<Line>> {
        let (mut line, mut is_too_long) = (Vec::new(), false);
        loop {
            let available = match self.input.fill_buf() {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                available => available?,
            };
            if available.is_empty() && line.is_empty() && !is_too_long {
                return Ok(None);
            }
            let end = available.iter().position(|byte| *byte == b'\n');
            let part = &available[..end.unwrap_or(available.len())];
            is_too_long |= line.len() + part.len() > self.limit;
            if is_too_long {
                line.clear();
            } else {
                line.extend_from_slice(part);
            }
            let is_last = available.is_empty();
            let taken = part.len() + usize::from(end.is_some());
            self.input.consume(taken);
            if end.is_none() && !is_last {
                continue;
            }
            if is_too_long {
                return Ok(Some(Line::TooLong));
            }
            return Ok(Some(String::from_utf8(line).map_or(Line::NotText, Line::Text)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(input: &[u8]) -> Vec<Line> {
        let mut lines = Lines::new(input, 5);
        std::iter::from_fn(|| lines.next().unwrap()).collect()
    }

    fn text(text: &str) -> Line {
        Line::Text(text.to_owned())
    }

    #[test]
    fn the_line_behind_one_that_is_too_long_or_no_text_is_read() {
        let found = lines(b"12345\n123456\n\nabc\xff\nlast");
        let expected = [
            text("12345"),
            Line::TooLong,
            text(""),
            Line::NotText,
            text("last"),
        ];
        assert_eq!(found, expected);
        assert_eq!(lines(b""), []);
    }

    #[test]
    fn a_line_that_never_ends_takes_no_memory() {
        let mut lines = Lines::new(io::repeat(b'x').take(10 << 20), 5);
        assert_eq!(lines.next().unwrap(), Some(Line::TooLong));
        assert_eq!(lines.next().unwrap(), None);
    }
}
