//! Lines of the protocol: a text, `*`, four hexadecimal digits of a CRC, a line feed. It knows no line's meaning.

use core::str::FromStr;

/// Longest line, bytes. What is longer is no line of the protocol.
const MAX_SIZE: usize = 512;

/// A line that has arrived.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Line {
    /// Its text, without the checksum, which is right.
    Good(String),
    /// It ends as a line does, and its checksum is missing or wrong.
    Corrupt,
}

/// Collects bytes until a line is whole.
#[derive(Debug, Default)]
pub(crate) struct Receiver {
    /// What has arrived of the present line.
    partial: Vec<u8>,
    is_too_long: bool,
}

impl Receiver {
    /// Takes bytes, split anywhere, and returns the lines that they end.
    pub(crate) fn receive(&mut self, bytes: &[u8]) -> Vec<Line> {
        let mut lines = Vec::new();
        for &byte in bytes {
            match byte {
                b'\n' | b'\r' => lines.extend(self.end()),
                _ if self.partial.len() == MAX_SIZE => self.is_too_long = true,
                _ => self.partial.push(byte),
            }
        }
        lines
    }

    fn end(&mut self) -> Option<Line> {
        let partial = core::mem::take(&mut self.partial);
        let is_too_long = core::mem::take(&mut self.is_too_long);
        let text = || {
            let (text, sum) = partial.split_at_checked(partial.len().checked_sub(5)?)?;
            let is_right = !is_too_long && sum == format!("*{:04X}", checksum(text)).as_bytes();
            is_right.then(|| String::from_utf8(text.to_vec()).ok())?
        };
        (!partial.is_empty()).then(|| text().map_or(Line::Corrupt, Line::Good))
    }
}

/// Returns the bytes of a line with this text.
pub(crate) fn line(text: &str) -> Vec<u8> {
    format!("{text}*{:04X}\n", checksum(text.as_bytes())).into_bytes()
}

/// CRC-16/IBM-3740: polynomial 0x1021, from 0xFFFF.
fn checksum(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xffff, |crc, byte| {
        (0..8).fold(crc ^ (u16::from(*byte) << 8), |crc, _| {
            (crc << 1) ^ if crc & 0x8000 == 0 { 0 } else { 0x1021 }
        })
    })
}

/// The fields of a line, ` key=value` each. What a reader does not ask for is ignored.
#[derive(Debug)]
pub(crate) struct Fields<'a>(Vec<(&'a str, &'a str)>);

impl<'a> Fields<'a> {
    /// Reads the words behind the first of a line. `None` if one has no `=`, or a key occurs twice.
    pub(crate) fn read(words: impl Iterator<Item = &'a str>) -> Option<Self> {
        let mut fields: Vec<(&str, &str)> = Vec::new();
        for word in words {
            let (key, value) = word.split_once('=')?;
            if fields.iter().any(|(other, _)| *other == key) {
                return None;
            }
            fields.push((key, value));
        }
        Some(Self(fields))
    }

    /// Returns a field's text.
    pub(crate) fn text(&self, key: &str) -> Option<&'a str> {
        let field = self.0.iter().find(|(other, _)| *other == key);
        field.map(|(_, value)| *value)
    }

    /// Returns a field's number, `Ok(None)` if the line has no such field.
    ///
    /// # Errors
    /// What is wrong with the field, in words.
    pub(crate) fn number<T: FromStr>(&self, key: &str) -> Result<Option<T>, String> {
        let parse = |text: &str| {
            text.parse()
                .map_err(|_| format!("`{key}={text}` is no number that it can be"))
        };
        self.text(key).map(parse).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_the_published_one() {
        assert_eq!(checksum(b"123456789"), 0x29b1);
    }

    #[test]
    fn lines_are_found_among_garbage_however_they_are_split() {
        let good = [line("s 1 t=20"), line("s 2 t=40")];
        let bytes = [b"ge*0000\n", &good[0][..], b"\xff\x00*\r\n", &good[1], b"s 3 t"].concat();
        let text = |text: &str| Line::Good(text.to_owned());
        let expected = [Line::Corrupt, text("s 1 t=20"), Line::Corrupt, text("s 2 t=40")];
        for size in 1..bytes.len() {
            let mut receiver = Receiver::default();
            let found: Vec<_> = bytes
                .chunks(size)
                .flat_map(|piece| receiver.receive(piece))
                .collect();
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn what_never_ends_takes_no_memory_and_is_no_line() {
        let mut receiver = Receiver::default();
        assert_eq!(receiver.receive(&vec![b'x'; 1 << 16]), []);
        assert_eq!(receiver.receive(b"\n"), [Line::Corrupt]);
        assert_eq!(receiver.receive(&line("?")), [Line::Good("?".to_owned())]);
    }

    #[test]
    fn a_field_twice_or_without_a_value_is_refused() {
        let read = |text: &'static str| Fields::read(text.split(' '));
        assert!(read("a=1 a=2").is_none() && read("a").is_none());
        let fields = read("a=-3 b=x").expect("it has fields");
        assert_eq!(fields.number("a"), Ok(Some(-3)));
        assert_eq!(fields.number::<u8>("c"), Ok(None));
        let wrong = fields.number::<u8>("b").expect_err("x is no number");
        assert_eq!(wrong, "`b=x` is no number that it can be");
    }
}
