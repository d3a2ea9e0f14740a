//! The first READY member in the father's order wins.

use super::{Choice, Policy, PolicyInput, PolicyKind};

pub(super) static KIND: PolicyKind = PolicyKind {
    code: 0,
    name: "priority",
    summary: "the order in which the father names its children",
    time: None,
    number: None,
    compares_urgency: false,
    rotates: false,
    wait: None,
    choose: |input, _| choose(input),
};

impl Policy {
    /// The first READY member in the father's order wins.
    pub const PRIORITY: Self = Self::new(&KIND, 0, 0.0);
}

pub(super) fn choose(input: &PolicyInput<'_>) -> Choice {
    let first = input.candidates.get(input.first?)?;
    Some((first.id, "the first of the ready in the father's order"))
}
