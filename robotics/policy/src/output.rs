//! From numbers of a network to commands: unscaled and clipped, which exported networks do not do themselves.

use crate::file::Output;

impl Output {
    /// Returns the command that a number of the network is. NaN stays NaN.
    pub(crate) fn command(&self, number: f64) -> f64 {
        let (low, high) = self.bounds;
        let stated = match self.is_scaled {
            true => low + (number + 1.0) / 2.0 * (high - low),
            false => number,
        };
        stated.clamp(low, high)
    }

    /// Returns the number of the network that is a command, clipped: the inverse, for what others drove.
    pub(crate) fn number(&self, command: f64) -> f64 {
        let (low, high) = self.bounds;
        let clipped = command.clamp(low, high);
        match self.is_scaled {
            true => 2.0 * (clipped - low) / (high - low) - 1.0,
            false => clipped,
        }
    }

    /// Returns the least and the greatest number that changes the command.
    pub(crate) fn range(&self) -> (f32, f32) {
        match self.is_scaled {
            true => (-1.0, 1.0),
            false => (self.bounds.0 as f32, self.bounds.1 as f32),
        }
    }
}
