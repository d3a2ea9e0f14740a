//! The father's own function decides, on a collision and on an absence. The hierarchy calls it; this file
//! decides only while the father sleeps.

use super::{Policy, PolicyKind, priority};

pub(super) static KIND: PolicyKind = PolicyKind {
    code: 4,
    name: "father",
    summary: "the father's own function",
    time: None,
    number: None,
    compares_urgency: true,
    rotates: false,
    wait: None,
    choose: |input, _| priority::choose(input),
};

impl Policy {
    /// The father's own function decides, on a collision and on an absence.
    pub const FATHER: Self = Self::new(&KIND, 0, 0.0);
}
