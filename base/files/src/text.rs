//! Text that somebody else has written, for an output in which it must not forge a line or a colour.

/// Whether a character controls how text is shown instead of being shown: it ends a line, moves the cursor, begins a
/// colour, changes the reading direction, or is invisible and can hide such a change.
#[must_use]
pub fn is_control(letter: char) -> bool {
    letter.is_control()
        || matches!(
            letter,
            '\u{ad}' | '\u{61c}' | '\u{180e}'
                | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}'
                | '\u{fdd0}'..='\u{fdef}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}'
        )
}

/// Returns a text in one line: each character of [`is_control`] as its code point, such as `\u{1b}`, and the usual ones as
/// `\n`, `\r` and `\t`.
#[must_use]
pub fn escape(text: &str) -> String {
    escape_except(text, &[])
}

/// As [`escape`], without the characters that `pass`.
#[must_use]
pub fn escape_except(text: &str, pass: &[char]) -> String {
    let mut shown = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            _ if !is_control(letter) || pass.contains(&letter) => shown.push(letter),
            '\n' | '\r' | '\t' => shown.extend(letter.escape_default()),
            _ => shown.extend(letter.escape_unicode()),
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::{escape, escape_except};

    #[test]
    fn whatever_controls_the_output_is_shown_as_its_code_point() {
        assert_eq!(escape("a\nb\rc\td"), "a\\nb\\rc\\td");
        assert_eq!(escape("a\u{1b}[31mb\u{9b}32m"), "a\\u{1b}[31mb\\u{9b}32m");
        assert_eq!(
            escape("robot\u{202e}txt.exe\u{2066}"),
            "robot\\u{202e}txt.exe\\u{2066}"
        );
        assert_eq!(escape_except("a\nb\u{1b}", &['\n']), "a\nb\\u{1b}");
        assert_eq!(escape("\u{e0041}\u{fdd0}"), "\\u{e0041}\\u{fdd0}");
        assert_eq!(escape("año 1 µs → 走行 `x`"), "año 1 µs → 走行 `x`");
    }
}
