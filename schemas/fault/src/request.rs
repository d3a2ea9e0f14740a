//! Requests to misbehave: one word for the fault, and one for the call that causes it.
//!
//! Unknown words cause no fault.

use jde_schema::prelude::*;

/// A word from the application file or from an operator.
pub(crate) type Word = Text<16>;

/// The call that causes the fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    Awake,
    Check,
    Iterate,
    Sleep,
    Arbitrate,
    Save,
    Restore,
    /// The drop of the instance.
    End,
}

/// The fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trouble {
    Panic,
    Error,
    /// The call never returns.
    Hang,
    /// The call returns after it counts as hung.
    Dawdle,
    /// The call takes several times its budget, and returns.
    Slow,
    Segfault,
    Abort,
    Exit,
    Overflow,
    Eat,
    /// A motor schema commands nothing, an eye publishes nothing, and a device retracts its export.
    Silence,
    Nan,
    Infinity,
    /// Commands a speed that no actuator reaches.
    Beyond,
    Flood,
    /// Commands and wakes children without authority.
    Trespass,
    /// The precondition changes with every check.
    Chatter,
    /// Wakes children, puts them to sleep and sets their policy, in an order that changes with each
    /// iteration.
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

/// Returns the fault that `call` must cause, or `None`.
pub(crate) fn requested(trouble: &Word, place: &Word, call: Place) -> Option<Trouble> {
    lookup(&PLACES, place).filter(|place| *place == call)?;
    lookup(&TROUBLES, trouble)
}

fn lookup<T: Copy>(table: &[(&str, T)], word: &Word) -> Option<T> {
    let found = table.iter().find(|(known, _)| *known == word.as_str());
    found.map(|(_, meaning)| *meaning)
}
