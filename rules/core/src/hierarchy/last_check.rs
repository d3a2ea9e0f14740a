//! The last check of a schema: its precondition and its urgency.
//!
//! Data with its transitions; it refuses to decide what follows from a change.

use std::hash::{Hash, Hasher};

/// The last check since the schema woke, if any.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub(super) struct LastCheck {
    precondition: Precondition,
    /// Of the last check ever.
    urgency: Urgency,
}

#[derive(Copy, Clone, PartialEq, Eq, Hash, Debug)]
enum Precondition {
    /// The schema sleeps, or has not checked since it woke.
    Unchecked,
    /// Also of a schema that was READY when its iteration was abandoned or found an input without a value.
    False,
    True,
}

/// What a check changed.
#[derive(Copy, Clone, PartialEq, Eq, Debug)]
pub(super) enum CheckChange {
    Nothing,
    Urgency,
    /// The readiness changed or became known, and possibly the urgency changed too.
    Readiness,
}

/// A number without NaN and without negative zero, so it can be compared and hashed to the bit.
#[derive(Copy, Clone, Debug)]
pub(super) struct Urgency(f64);

impl LastCheck {
    pub(super) const NONE: Self = Self {
        precondition: Precondition::Unchecked,
        urgency: Urgency(0.0),
    };

    pub(super) fn is_ready(&self) -> bool {
        self.precondition == Precondition::True
    }

    pub(super) fn is_checked(&self) -> bool {
        self.precondition != Precondition::Unchecked
    }

    pub(super) fn urgency(&self) -> f64 {
        self.urgency.0
    }

    #[inline]
    pub(super) fn update(&mut self, ready: bool, urgency: Urgency) -> CheckChange {
        let precondition = if ready {
            Precondition::True
        } else {
            Precondition::False
        };
        let change = if self.precondition != precondition {
            CheckChange::Readiness
        } else if self.urgency != urgency {
            CheckChange::Urgency
        } else {
            return CheckChange::Nothing;
        };
        *self = Self {
            precondition,
            urgency,
        };
        change
    }

    /// Ends the readiness of a schema that cannot check; returns whether it was READY.
    pub(super) fn end_readiness(&mut self) -> bool {
        let was_ready = self.is_ready();
        if was_ready {
            self.precondition = Precondition::False;
        }
        was_ready
    }

    pub(super) fn forget(&mut self) {
        self.precondition = Precondition::Unchecked;
    }
}

impl Urgency {
    pub(super) fn new(value: f64) -> Self {
        // Adding 0 turns negative zero into positive zero.
        Self(if value.is_nan() {
            f64::NEG_INFINITY
        } else {
            value + 0.0
        })
    }
}

impl PartialEq for Urgency {
    fn eq(&self, other: &Self) -> bool {
        self.0.to_bits() == other.0.to_bits()
    }
}

impl Eq for Urgency {}

impl Hash for Urgency {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.to_bits().hash(state);
    }
}

#[cfg(test)]
mod tests {
    use super::{CheckChange, LastCheck, Urgency};

    #[test]
    fn a_first_check_changes_the_readiness_even_if_the_precondition_is_false() {
        let mut check = LastCheck::NONE;
        assert_eq!(check.update(false, Urgency::new(-0.0)), CheckChange::Readiness);
        assert_eq!(check.update(false, Urgency::new(0.0)), CheckChange::Nothing);
        assert_eq!(check.update(false, Urgency::new(f64::NAN)), CheckChange::Urgency);
        assert_eq!(check.update(true, Urgency::new(1.0)), CheckChange::Readiness);
        check.forget();
        assert!(!check.is_checked() && !check.is_ready());
    }
}
