//! The styles of this program's own output. A style writes a mark instead of an escape sequence. The mark has a number that
//! differs in each process, so that no text of others can contain it; the writer of a stream turns it into the sequence.

use std::fmt;
use std::hash::{BuildHasher as _, RandomState};
use std::sync::OnceLock;

use anstyle::AnsiColor;

/// What escape sequences of styles begin with.
const SEQUENCE: &str = "\x1b[";

/// A style of text: `{TITLE}` begins it, `{TITLE:#}` ends it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Style(anstyle::Style);

/// For titles.
pub const TITLE: Style = Style(anstyle::Style::new().bold());
/// For less important text.
pub const FAINT: Style = Style(anstyle::Style::new().dimmed());
/// For success.
pub const GOOD: Style = Style(AnsiColor::Green.on_default().bold());
/// For failures.
pub const BAD: Style = Style(AnsiColor::Red.on_default().bold());
/// For warnings.
pub const WARN: Style = Style(AnsiColor::Yellow.on_default().bold());

impl Style {
    /// Plain text.
    pub const fn new() -> Self {
        Self(anstyle::Style::new())
    }

    /// Returns the style as escape sequences, for a library that takes these.
    pub const fn ansi(self) -> anstyle::Style {
        self.0
    }
}

impl fmt::Display for Style {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sequences = if f.alternate() {
            format!("{:#}", self.0)
        } else {
            self.0.to_string()
        };
        f.write_str(&own_styles(&sequences))
    }
}

/// Returns what a mark begins with; the numbers of the style and an `m` follow.
pub fn style_mark() -> &'static str {
    static MARK: OnceLock<String> = OnceLock::new();
    MARK.get_or_init(|| format!("\u{fdd0}{:016x};", RandomState::new().hash_one(0)))
}

/// Returns a text of a library in whose escape sequences none is of others, with marks instead.
pub fn own_styles(text: &str) -> String {
    text.replace(SEQUENCE, style_mark())
}
