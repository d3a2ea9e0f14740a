//! Foreign text on a terminal. Characters that would move the cursor, change the reading direction or ring
//! the bell appear as their code points. New lines, carriage returns and tabs pass. Colour sequences pass,
//! because the program's own output uses them. Only an unfinished colour sequence at the very end is lost.

use std::io::{self, Write};

/// A writer that escapes such characters and passes everything else on.
pub(crate) struct EscapingWriter<W> {
    inner: W,
    /// A prefix of what may become a colour sequence.
    pending: String,
}

impl<W: Write> EscapingWriter<W> {
    pub(crate) fn new(inner: W) -> Self {
        Self {
            inner,
            pending: String::new(),
        }
    }
}

/// Whether a character controls the terminal instead of being displayed.
pub(crate) fn is_terminal_control(letter: char) -> bool {
    letter.is_control() && !matches!(letter, '\n' | '\r' | '\t') || is_bidi_control(letter)
}

/// Whether a character changes the reading direction, or is an invisible format character that can hide such
/// a change.
fn is_bidi_control(letter: char) -> bool {
    matches!(letter, '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
}

/// Returns the text with every character for which [`is_terminal_control`] is true escaped, colour sequences
/// included.
pub(crate) fn escape(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    text.chars().for_each(|letter| push_escaped(&mut shown, letter));
    shown
}

/// Returns JSON of the same meaning, with the characters that change the reading direction and the control
/// characters U+007F to U+009F escaped.
pub(crate) fn escape_json(json: &str) -> String {
    let mut shown = String::with_capacity(json.len());
    for letter in json.chars() {
        if is_bidi_control(letter) || matches!(letter, '\u{7f}'..='\u{9f}') {
            shown += &format!("\\u{:04x}", letter as u32);
        } else {
            shown.push(letter);
        }
    }
    shown
}

fn push_escaped(shown: &mut String, letter: char) {
    if is_terminal_control(letter) {
        shown.extend(letter.escape_unicode());
    } else {
        shown.push(letter);
    }
}

impl<W> EscapingWriter<W> {
    /// Processes one character. Characters of a possible colour sequence are buffered until it is complete or
    /// broken.
    fn push(&mut self, shown: &mut String, letter: char) {
        let continues = match self.pending.len() {
            0 => letter == '\x1b',
            1 => letter == '[',
            // A longer sequence is not a colour.
            2..24 => matches!(letter, '0'..='9' | ';' | ':' | 'm'),
            _ => false,
        };
        if continues {
            self.pending.push(letter);
            if letter == 'm' {
                shown.push_str(&std::mem::take(&mut self.pending));
            }
        } else if self.pending.is_empty() {
            push_escaped(shown, letter);
        } else {
            shown.push_str(&escape(&std::mem::take(&mut self.pending)));
            self.push(shown, letter);
        }
    }
}

impl<W: Write> Write for EscapingWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // Bytes that are not UTF-8 have no characters to escape, and pass unchanged.
        for chunk in bytes.utf8_chunks() {
            let mut shown = String::with_capacity(chunk.valid().len());
            for letter in chunk.valid().chars() {
                self.push(&mut shown, letter);
            }
            self.inner.write_all(shown.as_bytes())?;
            self.inner.write_all(chunk.invalid())?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(pieces: &[&str]) -> String {
        let mut out = EscapingWriter::new(Vec::new());
        for piece in pieces {
            out.write_all(piece.as_bytes()).unwrap();
        }
        String::from_utf8(out.inner).unwrap()
    }

    #[test]
    fn control_characters_are_shown_as_code_points() {
        assert_eq!(written(&["robot\u{202e}txt.exe\n"]), "robot\\u{202e}txt.exe\n");
        assert_eq!(
            written(&["a\x1b]0;title\x07b\x1b[2Jc"]),
            "a\\u{1b}]0;title\\u{7}b\\u{1b}[2Jc"
        );
        assert_eq!(
            written(&["\u{2066}x\u{2069}\u{200f}\u{9b}"]),
            "\\u{2066}x\\u{2069}\\u{200f}\\u{9b}"
        );
        assert_eq!(written(&["año 1 µs → 2\tµs\n"]), "año 1 µs → 2\tµs\n");
    }

    #[test]
    fn colour_sequences_pass_even_in_pieces() {
        assert_eq!(written(&["\x1b[1;32mgood\x1b[0m"]), "\x1b[1;32mgood\x1b[0m");
        assert_eq!(
            written(&["\x1b[", "1", "m", "good", "\x1b", "[0m"]),
            "\x1b[1mgood\x1b[0m"
        );
        assert_eq!(written(&["\x1b[", "3", "A"]), "\\u{1b}[3A");
        assert_eq!(written(&["\x1b\x1b[1mx"]), "\\u{1b}\x1b[1mx");
    }

    #[test]
    fn escaped_json_has_the_same_meaning() {
        let text = "a\u{202e}b\u{85}";
        let json = escape_json(&serde_json::to_string(text).unwrap());
        assert!(json.is_ascii(), "{json}");
        assert_eq!(serde_json::from_str::<String>(&json).unwrap(), text);
    }
}
