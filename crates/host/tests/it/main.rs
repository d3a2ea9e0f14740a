//! Plugins that are accepted, or refused with a reason; and delivered applications.

mod delivered;
mod exceptions;
mod follow_ball;
mod limits;
mod loader;
#[path = "../common/plugins.rs"]
mod plugin_builds;
mod safe_navigation;
mod shared_value;
mod two_robots;
mod versions;
