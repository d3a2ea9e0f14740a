//! The numbers of the ABI and their meanings, in both directions.

use jde_abi::raw;

use crate::limits::wrong;
use crate::{Broken, Button, Color, Ink, Words};

const WORDS: [(u32, Words); 7] = [
    (raw::WORDS_PLAIN, Words::Plain),
    (raw::WORDS_HEADING, Words::Heading),
    (raw::WORDS_FAINT, Words::Faint),
    (raw::WORDS_GOOD, Words::Good),
    (raw::WORDS_WARNING, Words::Warning),
    (raw::WORDS_ERROR, Words::Error),
    (raw::WORDS_CODE, Words::Code),
];

const INKS: [(u32, Ink); 8] = [
    (raw::INK_PLAIN, Ink::Plain),
    (raw::INK_FAINT, Ink::Faint),
    (raw::INK_ACCENT, Ink::Accent),
    (raw::INK_GOOD, Ink::Good),
    (raw::INK_WARN, Ink::Warn),
    (raw::INK_BAD, Ink::Bad),
    (raw::INK_GOAL, Ink::Goal),
    (raw::INK_SEEN, Ink::Seen),
];

const BUTTONS: [(u32, Button); 3] = [
    (raw::BUTTON_PRIMARY, Button::Primary),
    (raw::BUTTON_SECONDARY, Button::Secondary),
    (raw::BUTTON_MIDDLE, Button::Middle),
];

fn meaning<T: Copy>(codes: &[(u32, T)], code: u32) -> Option<T> {
    let found = codes.iter().find(|(known, _)| *known == code);
    found.map(|(_, meaning)| *meaning)
}

fn code<T: PartialEq>(codes: &[(u32, T)], meaning: &T) -> u32 {
    let found = codes.iter().find(|(_, known)| known == meaning);
    found.map_or(0, |(code, _)| *code)
}

impl Words {
    /// Returns its number in the ABI.
    #[must_use]
    pub fn code(self) -> u32 {
        code(&WORDS, &self)
    }
}

impl Color {
    /// Returns its number in the ABI. An exact color with opacity 0 gets opacity 1, because 0 marks a color
    /// of the theme.
    #[must_use]
    pub fn code(self) -> u32 {
        match self {
            Self::Ink(ink) => code(&INKS, &ink),
            Self::Exact([red, green, blue, opacity]) => {
                u32::from_be_bytes([opacity.max(1), red, green, blue])
            }
        }
    }
}

pub(super) fn words(code: u32) -> Result<Words, Broken> {
    meaning(&WORDS, code).map_or_else(|| wrong("a text", format!("there are no words {code}")), Ok)
}

pub(super) fn color(widget: &str, code: u32) -> Result<Color, Broken> {
    let [opacity, red, green, blue] = code.to_be_bytes();
    if opacity > 0 {
        return Ok(Color::Exact([red, green, blue, opacity]));
    }
    match meaning(&INKS, code) {
        Some(ink) => Ok(Color::Ink(ink)),
        None => wrong(widget, format!("there is no ink {code}")),
    }
}

pub(super) fn button(code: u32) -> Option<Button> {
    meaning(&BUTTONS, code)
}

pub(super) fn button_code(button: Button) -> u32 {
    code(&BUTTONS, &button)
}
