//! Requests to misbehave: the name of a fault, and the name of the call that causes it.
//!
//! Unknown names cause no fault.

use jde_schema::prelude::*;

/// A name from the application file or from an operator.
pub(crate) type RequestText = Text<16>;

/// The call that causes the fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Call {
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
pub(crate) enum FaultKind {
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
    /// The process starts another that lives on, and dies.
    Fork,
    /// The process starts another that goes on in its place, and dies.
    Leave,
    /// The process starts another, and both go on.
    Double,
    /// A motor schema commands nothing, an eye publishes nothing, and a device retracts its export.
    Silence,
    Nan,
    Infinity,
    /// Commands a speed that no actuator reaches.
    Beyond,
    /// Commands random parts of its speed and its turn rate, ahead and back, whatever is in the way.
    Reckless,
    Flood,
    /// Commands and wakes children without authority.
    Trespass,
    /// The precondition changes with every check.
    Chatter,
    /// Wakes children, puts them to sleep and sets their policy, in an order that changes with each
    /// iteration.
    Meddle,
}

const CALLS: [(&str, Call); 8] = [
    ("awake", Call::Awake),
    ("check", Call::Check),
    ("iterate", Call::Iterate),
    ("sleep", Call::Sleep),
    ("arbitrate", Call::Arbitrate),
    ("save", Call::Save),
    ("restore", Call::Restore),
    ("end", Call::End),
];

const FAULTS: [(&str, FaultKind); 22] = [
    ("panic", FaultKind::Panic),
    ("error", FaultKind::Error),
    ("hang", FaultKind::Hang),
    ("dawdle", FaultKind::Dawdle),
    ("slow", FaultKind::Slow),
    ("segfault", FaultKind::Segfault),
    ("abort", FaultKind::Abort),
    ("exit", FaultKind::Exit),
    ("overflow", FaultKind::Overflow),
    ("eat", FaultKind::Eat),
    ("fork", FaultKind::Fork),
    ("leave", FaultKind::Leave),
    ("double", FaultKind::Double),
    ("silence", FaultKind::Silence),
    ("nan", FaultKind::Nan),
    ("infinity", FaultKind::Infinity),
    ("beyond", FaultKind::Beyond),
    ("reckless", FaultKind::Reckless),
    ("flood", FaultKind::Flood),
    ("trespass", FaultKind::Trespass),
    ("chatter", FaultKind::Chatter),
    ("meddle", FaultKind::Meddle),
];

/// The fault that `current` must cause, or `None`.
pub(crate) fn requested(fault: &RequestText, call: &RequestText, current: Call) -> Option<FaultKind> {
    lookup(&CALLS, call).filter(|call| *call == current)?;
    lookup(&FAULTS, fault)
}

fn lookup<T: Copy>(entries: &[(&str, T)], name: &RequestText) -> Option<T> {
    let found = entries.iter().find(|(known, _)| *known == name.as_str());
    found.map(|(_, value)| *value)
}
