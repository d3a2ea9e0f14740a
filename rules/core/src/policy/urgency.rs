//! The READY member with the highest urgency wins. On a tie the current choice wins, then the father's order.

use super::{Choice, Policy, PolicyInput, PolicyKind};

pub(super) static KIND: PolicyKind = PolicyKind {
    code: 1,
    name: "urgency",
    summary: "the highest number that a candidate offers",
    time: None,
    number: None,
    compares_urgency: true,
    rotates: false,
    wait: None,
    choose: |input, _| choose(input),
};

impl Policy {
    /// The READY member with the highest urgency wins. On a tie the current choice wins, then the father's
    /// order.
    pub const URGENCY: Self = Self::new(&KIND, 0, 0.0);
}

fn choose(input: &PolicyInput<'_>) -> Choice {
    let top = input.most_urgent()?;
    match input.incumbent() {
        Some(incumbent) if incumbent.urgency >= top.urgency => {
            Some((incumbent.id, "nobody is more urgent than the one already chosen"))
        }
        Some(_) | None => Some((top.id, "the most urgent of the ready")),
    }
}
