//! When a wish counts, and how it is executed.

mod base;
mod gamepad;
mod head;
mod pilot;

use core::time::Duration;

pub(crate) fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}
