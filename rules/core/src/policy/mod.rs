//! The ready-made policies (R4): how a group settles a collision. Each is one file with one [`PolicyKind`],
//! from which the keys of application files, the numbers of the ABI, the checks, the contract and the
//! documentation follow.

mod father;
mod input;
mod priority;
mod round_robin;
mod sticky;
mod urgency;

use std::fmt;

pub(crate) use self::input::{Choice, PolicyInput};
use crate::spec::Nanos;

/// All policies.
pub static POLICIES: &[&PolicyKind] = &[
    &priority::KIND,
    &urgency::KIND,
    &sticky::KIND,
    &round_robin::KIND,
    &father::KIND,
];

/// The fixed properties of a policy.
pub struct PolicyKind {
    /// Its number in the ABI, where 0 to 4 are those of version 1.0.
    pub code: u32,
    /// Its name in application files and in records.
    pub name: &'static str,
    /// How it decides, for users.
    pub summary: &'static str,
    /// The time for which a choice stays.
    pub time: Option<TimeParameter>,
    /// A number that the policy uses: finite, not negative, 0 if it is not stated.
    pub number: Option<NumberParameter>,
    /// Whether it compares more than readiness. A change of that value alone takes effect after the winner's
    /// iteration (R2).
    pub compares_urgency: bool,
    /// Whether it changes the winner regularly, which is not chattering.
    pub rotates: bool,
    /// The longest wait of a READY member before it is chosen, from the time and the number of other members.
    wait: Option<Wait>,
    choose: fn(&PolicyInput<'_>, Policy) -> Choice,
}

/// Returns a description of the wait, and its length.
type Wait = fn(Nanos, Nanos) -> (&'static str, Nanos);

/// The time of a policy.
pub struct TimeParameter {
    /// Its key in application files.
    pub key: &'static str,
    /// A usual value, as application files state it.
    pub example: &'static str,
    /// Whether it may be 0.
    pub may_be_zero: bool,
}

/// The number of a policy.
pub struct NumberParameter {
    /// Its key in application files.
    pub key: &'static str,
    /// What it states, for users.
    pub meaning: &'static str,
}

/// How a group settles a collision (R4): a kind and its parameters.
#[derive(Copy, Clone)]
pub struct Policy {
    kind: &'static PolicyKind,
    time: Nanos,
    number: f64,
}

impl PolicyKind {
    /// Returns the policy of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        POLICIES.iter().copied().find(|kind| kind.name == name)
    }
}

impl Policy {
    /// Returns a policy of a kind. A parameter that the kind does not have is ignored.
    #[must_use]
    pub const fn new(kind: &'static PolicyKind, time: Nanos, number: f64) -> Self {
        Self {
            kind,
            time: if kind.time.is_some() { time } else { 0 },
            number: if kind.number.is_some() { number } else { 0.0 },
        }
    }

    /// Returns the policy of a number of the ABI. `None` if no policy has this number, or if it refuses a
    /// parameter.
    #[must_use]
    pub fn from_code(code: u32, time: Nanos, number: f64) -> Option<Self> {
        let kind = POLICIES.iter().find(|kind| kind.code == code)?;
        Some(Self::new(kind, time, number)).filter(|policy| policy.refused_parameter().is_none())
    }

    /// Returns its fixed properties.
    #[must_use]
    pub fn kind(self) -> &'static PolicyKind {
        self.kind
    }

    /// Returns its name in application files and in records.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.kind.name
    }

    /// Returns its time; 0 if it has none.
    #[must_use]
    pub fn time(self) -> Nanos {
        self.time
    }

    /// Returns its number; 0 if it has none.
    #[must_use]
    pub fn number(self) -> f64 {
        self.number
    }

    /// Returns the key of a parameter with a value that the policy refuses, and what it must be.
    pub(crate) fn refused_parameter(self) -> Option<(&'static str, &'static str)> {
        let time = self.kind.time.as_ref();
        let time = time.filter(|time| self.time == 0 && !time.may_be_zero);
        let is_refused = !(self.number.is_finite() && self.number >= 0.0);
        let number = self.kind.number.as_ref().filter(|_| is_refused);
        let time = time.map(|time| (time.key, "a time above 0"));
        time.or(number.map(|number| (number.key, "a finite number, 0 or more")))
    }

    /// Returns the longest wait of a READY member before it is chosen, in a group with `others` other
    /// members.
    pub(crate) fn wait(self, others: Nanos) -> Option<(&'static str, Nanos)> {
        self.kind.wait.map(|wait| wait(self.time, others))
    }

    /// Chooses one of the READY candidates.
    pub(crate) fn choose(self, input: &PolicyInput<'_>) -> Choice {
        (self.kind.choose)(input, self)
    }

    /// Returns when the choice could change without an event: when its time is over, if another candidate
    /// would be chosen then.
    pub(crate) fn turn_end(self, input: &PolicyInput<'_>) -> Option<Nanos> {
        self.kind.time.as_ref()?;
        let end = input.since.saturating_add(self.time);
        let next = self.choose(&PolicyInput { now: end, ..*input }).map(|(id, _)| id);
        (end > input.now && input.chosen.is_some() && next != input.chosen).then_some(end)
    }
}

/// Equal when all parameters are equal to the bit, which makes the relation total.
impl PartialEq for Policy {
    fn eq(&self, other: &Self) -> bool {
        let key = |policy: &Self| (policy.kind.code, policy.time, policy.number.to_bits());
        key(self) == key(other)
    }
}

impl Eq for Policy {}

impl fmt::Debug for Policy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}({} ns, {})", self.name(), self.time, self.number)
    }
}
