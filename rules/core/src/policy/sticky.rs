//! The current choice stays until its dwell time has ended and a challenger exceeds its urgency by the
//! margin.

use std::time::Duration;

use super::{Choice, NumberParameter, Policy, PolicyInput, PolicyKind, TimeParameter};
use crate::spec::nanos;

pub(super) static KIND: PolicyKind = PolicyKind {
    code: 2,
    name: "sticky",
    summary: "the winner stays for `dwell`, and until a rival is `hysteresis` more urgent",
    time: Some(TimeParameter {
        key: "dwell",
        example: "500ms",
        may_be_zero: true,
    }),
    number: Some(NumberParameter {
        key: "hysteresis",
        meaning: "the urgency by which a rival must exceed the winner",
    }),
    compares_urgency: true,
    rotates: false,
    wait: Some(|dwell, _| ("dwell of the winner", dwell)),
    choose,
};

impl Policy {
    /// The winner stays for at least `dwell`, and until the urgency of a rival exceeds its own by
    /// `hysteresis`, which is finite and not negative.
    #[must_use]
    pub const fn sticky(dwell: Duration, hysteresis: f64) -> Self {
        Self::new(&KIND, nanos(dwell), hysteresis)
    }
}

fn choose(input: &PolicyInput<'_>, policy: Policy) -> Choice {
    let top = input.most_urgent()?;
    let Some(incumbent) = input.incumbent() else {
        return Some((
            top.id,
            "the most urgent of the ready; the one before is not ready",
        ));
    };
    let margin = top.urgency - incumbent.urgency;
    if input.elapsed() < policy.time {
        Some((incumbent.id, "already chosen, and its dwell time is not over"))
    } else if margin > 0.0 && margin >= policy.number {
        Some((top.id, "more urgent by the margin than the one before"))
    } else {
        Some((
            incumbent.id,
            "already chosen, and nobody is more urgent by the margin",
        ))
    }
}
