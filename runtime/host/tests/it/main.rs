//! Plugins that are accepted, or refused with a reason; and delivered applications.

mod chunks;
mod delivered;
mod edits;
mod exceptions;
mod failing_sensors;
mod follow_ball;
mod limits;
mod loader;
mod many_sensors;
mod safe_navigation;
mod shared_value;
mod standing_still;
mod turns;
mod two_robots;
mod versions;
