//! Separate thresholds to enter and to leave, so that a precondition near its limit does not chatter (R4).

/// A condition that begins and ends to hold at different values.
///
/// ```
/// let mut near = jde_schema::Hysteresis::default();
/// assert!(!near.below(0.7, 0.6, 0.8), "not yet near");
/// assert!(near.below(0.6, 0.6, 0.8), "near enough to begin");
/// assert!(near.below(0.7, 0.6, 0.8), "not far enough to end");
/// assert!(!near.below(0.9, 0.6, 0.8), "far enough to end");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hysteresis {
    holds: bool,
}

impl Hysteresis {
    /// Begins to hold when `value` falls to `enter` or below, and ends when it rises above `leave`, the
    /// greater of the two. A NaN ends it. Returns whether it holds.
    pub fn below(&mut self, value: f64, enter: f64, leave: f64) -> bool {
        self.holds = value <= if self.holds { leave.max(enter) } else { enter };
        self.holds
    }

    /// Begins to hold when `value` rises to `enter` or above, and ends when it falls below `leave`, the
    /// lesser of the two. A NaN ends it. Returns whether it holds.
    pub fn above(&mut self, value: f64, enter: f64, leave: f64) -> bool {
        self.holds = value >= if self.holds { leave.min(enter) } else { enter };
        self.holds
    }

    /// Returns whether it holds.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.holds
    }

    /// Makes it not hold, for example after a sleep.
    pub fn reset(&mut self) {
        self.holds = false;
    }
}
