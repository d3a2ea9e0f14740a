//! Each READY member wins in turn, in the father's order.

use std::time::Duration;

use super::{Choice, Policy, PolicyInput, PolicyKind, TimeParameter};
use crate::spec::nanos;

pub(super) static KIND: PolicyKind = PolicyKind {
    code: 3,
    name: "round-robin",
    summary: "each READY child in turn, for `turn` each",
    time: Some(TimeParameter {
        key: "turn",
        example: "5s",
        may_be_zero: false,
    }),
    number: None,
    compares_urgency: false,
    rotates: true,
    wait: Some(|turn, others| ("turns of the others", turn.saturating_mul(others))),
    choose,
};

impl Policy {
    /// Each READY member wins in turn, in the father's order. A turn is longer than 0.
    #[must_use]
    pub const fn round_robin(turn: Duration) -> Self {
        Self::new(&KIND, nanos(turn), 0.0)
    }
}

fn choose(input: &PolicyInput<'_>, policy: Policy) -> Choice {
    if let Some(incumbent) = input.incumbent()
        && input.elapsed() < policy.time
    {
        return Some((incumbent.id, "its turn is not over"));
    }
    let members = input.members;
    let last = input
        .last
        .and_then(|last| members.iter().position(|&m| m == last));
    let order = members
        .iter()
        .cycle()
        .skip(last.map_or(0, |position| position + 1));
    order
        .take(members.len())
        .filter_map(|&m| input.ready().find(|c| c.id == m))
        .map(|c| (c.id, "its turn has come"))
        .next()
}
