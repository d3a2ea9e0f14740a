//! What a schema of this plugin is told to do wrong: a word for the trouble, and a word for the call in which to make it.
//!
//! A word that nobody knows is no trouble.

use jde_schema::prelude::*;

/// A word out of the application's file or of an operator.
pub(crate) type Word = Text<16>;

/// The call in which trouble is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    Awake,
    Check,
    Iterate,
    Sleep,
    Arbitrate,
    Save,
    Restore,
    /// The instance ends.
    End,
}

/// What is done wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trouble {
    Panic,
    Error,
    /// It never returns.
    Hang,
    /// It returns when everybody has given it up.
    Dawdle,
    /// It takes some of its budgets, and returns.
    Slow,
    Segfault,
    Abort,
    Exit,
    Overflow,
    Eat,
    /// It wins and commands nothing.
    Silence,
    Nan,
    Infinity,
    /// It commands what no actuator can do.
    Beyond,
    Flood,
    /// It commands and wakes although it has no authority.
    Trespass,
    /// Its precondition flips with every look.
    Chatter,
    /// It wakes its children, lays them down and changes their policy as it comes.
    Meddle,
}

const PLACES: [(&str, Place); 8] = [
    ("awake", Place::Awake),
    ("check", Place::Check),
    ("iterate", Place::Iterate),
    ("sleep", Place::Sleep),
    ("arbitrate", Place::Arbitrate),
    ("save", Place::Save),
    ("restore", Place::Restore),
    ("end", Place::End),
];

const TROUBLES: [(&str, Trouble); 18] = [
    ("panic", Trouble::Panic),
    ("error", Trouble::Error),
    ("hang", Trouble::Hang),
    ("dawdle", Trouble::Dawdle),
    ("slow", Trouble::Slow),
    ("segfault", Trouble::Segfault),
    ("abort", Trouble::Abort),
    ("exit", Trouble::Exit),
    ("overflow", Trouble::Overflow),
    ("eat", Trouble::Eat),
    ("silence", Trouble::Silence),
    ("nan", Trouble::Nan),
    ("infinity", Trouble::Infinity),
    ("beyond", Trouble::Beyond),
    ("flood", Trouble::Flood),
    ("trespass", Trouble::Trespass),
    ("chatter", Trouble::Chatter),
    ("meddle", Trouble::Meddle),
];

/// The trouble that is to be made in this place, if any is.
pub(crate) fn due(trouble: &Word, place: &Word, here: Place) -> Option<Trouble> {
    known(&PLACES, place).filter(|place| *place == here)?;
    known(&TROUBLES, trouble)
}

fn known<T: Copy>(words: &[(&str, T)], word: &Word) -> Option<T> {
    let found = words.iter().find(|(known, _)| *known == word.as_str());
    found.map(|(_, meaning)| *meaning)
}
