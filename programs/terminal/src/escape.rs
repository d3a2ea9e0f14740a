//! Text of others on a terminal: it forges neither a line nor a colour.
//!
//! Whatever is written by `write!` and `writeln!` is at most one line: a new line at its end is the program's own, and every
//! other one came with a text of others and is escaped. Colours of the program are [`Style`](crate::Style)s, which
//! write a mark that nobody else knows; escape sequences of anybody are shown as code points. So a verb may print any text
//! and needs no care.
//!
//! Whatever is written by `write_all` may have several lines: texts of others in it have been escaped before.

use std::fmt;
use std::io::{self, Write};

use jde_files::{escape_except, is_control};

use crate::style_mark;

pub use jde_files::escape;

/// A writer that escapes such characters and turns marks into colours.
pub struct EscapingWriter<W> {
    inner: W,
}

impl<W: Write> EscapingWriter<W> {
    /// Writes to `inner`.
    pub fn new(inner: W) -> Self {
        Self { inner }
    }
}

/// Returns JSON of the same meaning, with the characters escaped that JSON does not escape and that control a terminal.
pub fn escape_json(json: &str) -> String {
    let mut shown = String::with_capacity(json.len());
    for letter in json.chars() {
        if letter < ' ' || !is_control(letter) {
            shown.push(letter);
        } else {
            for unit in letter.encode_utf16(&mut [0; 2]) {
                shown += &format!("\\u{unit:04x}");
            }
        }
    }
    shown
}

/// Returns a text of others that may have several lines, such as a compiler's output, with a mark before every line after
/// the first: none can be taken for one of this program.
pub fn escape_lines(text: &str) -> String {
    let lines: Vec<_> = text.trim_end().lines().map(escape).collect();
    lines.join("\n    | ")
}

/// Escapes what controls a terminal, apart from the characters that `pass`, and turns marks into colours.
fn show(text: &str, pass: &[char]) -> String {
    let mark = style_mark();
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(letter) = rest.chars().next() {
        if let Some(style) = rest.strip_prefix(mark)
            && let Some(end) = style.find(|c: char| !matches!(c, '0'..='9' | ';' | ':'))
            && style[end..].starts_with('m')
        {
            shown += "\x1b[";
            shown += &style[..=end];
            rest = &style[end + 1..];
            continue;
        }
        let (next, others) = rest.split_at(letter.len_utf8());
        shown += &escape_except(next, pass);
        rest = others;
    }
    shown
}

impl<W: Write> Write for EscapingWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // Bytes that are not UTF-8 have no characters to escape, and pass unchanged.
        for chunk in bytes.utf8_chunks() {
            let shown = show(chunk.valid(), &['\n', '\r', '\t']);
            self.inner.write_all(shown.as_bytes())?;
            self.inner.write_all(chunk.invalid())?;
        }
        Ok(bytes.len())
    }

    fn write_fmt(&mut self, line: fmt::Arguments<'_>) -> io::Result<()> {
        let line = line.to_string();
        let (text, end) = match line.strip_suffix('\n') {
            Some(text) => (text, "\n"),
            None => (&*line, ""),
        };
        self.inner.write_all((show(text, &['\t']) + end).as_bytes())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

/// Returns the text that is left of a text for a terminal without colours.
pub fn without_styles(text: &str) -> String {
    anstream::adapter::strip_str(&show(text, &['\n', '\r', '\t'])).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BAD, own_styles};

    fn written(write: impl FnOnce(&mut dyn Write)) -> String {
        let mut out = EscapingWriter::new(Vec::new());
        write(&mut out);
        String::from_utf8(out.inner).unwrap()
    }

    fn line(text: &str) -> String {
        written(|out| writeln!(out, "{text}").unwrap())
    }

    #[test]
    fn text_of_others_forges_neither_a_line_nor_a_colour() {
        assert_eq!(line("robot\u{202e}txt.exe"), "robot\\u{202e}txt.exe\n");
        assert_eq!(line("a\nerror: b\rc"), "a\\nerror: b\\rc\n");
        assert_eq!(line("\nx\n"), "\\nx\\n\n");
        assert_eq!(line("\x1b[31mred\x1b[0m"), "\\u{1b}[31mred\\u{1b}[0m\n");
        assert_eq!(
            line("\u{2066}x\u{2069}\u{200f}\u{9b}1m"),
            "\\u{2066}x\\u{2069}\\u{200f}\\u{9b}1m\n"
        );
        assert_eq!(line("año 1 µs → 2\tµs"), "año 1 µs → 2\tµs\n");
    }

    #[test]
    fn the_programs_own_styles_become_colours_and_nobody_elses_do() {
        let foreign = "x\x1b[1my";
        let shown = written(|out| writeln!(out, "{BAD}{foreign}{BAD:#}").unwrap());
        let plain = anstream::adapter::strip_str(&shown).to_string();
        assert!(
            shown.starts_with("\x1b[") && shown.ends_with("\x1b[0m\n"),
            "{shown:?}"
        );
        assert_eq!(plain, "x\\u{1b}[1my\n");
        // Somebody who knows the program, and not the number of this process.
        assert_eq!(
            line("\u{fdd0}0000000000000000;31m"),
            "\\u{fdd0}0000000000000000;31m\n"
        );
        assert_eq!(without_styles(&format!("{BAD}x{BAD:#}")), "x");
        assert_eq!(
            written(|out| out.write_all(own_styles("\x1b[1mx").as_bytes()).unwrap()),
            "\x1b[1mx"
        );
    }

    #[test]
    fn blocks_keep_their_lines() {
        assert_eq!(
            written(|out| out.write_all(b"a\n\x1b[2Jb\n").unwrap()),
            "a\n\\u{1b}[2Jb\n"
        );
        assert_eq!(escape_lines("a\nerror: b\x1b\n"), "a\n    | error: b\\u{1b}");
    }

    #[test]
    fn escaped_json_has_the_same_meaning() {
        let text = "a\u{202e}b\u{85}\u{e0041}\n";
        let json = escape_json(&serde_json::to_string(text).unwrap());
        assert!(json.is_ascii(), "{json}");
        assert_eq!(serde_json::from_str::<String>(&json).unwrap(), text);
    }
}
