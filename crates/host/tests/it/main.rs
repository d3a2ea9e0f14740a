//! Application files and plugins: what is accepted, what is refused in words, and delivered applications.

mod app_family;
mod app_file;
mod app_good;
mod app_groups;
mod app_keys;
mod app_link;
mod app_remote;
mod app_roots;
mod app_times;
mod app_values;
mod app_wiring;
mod apps;
mod delivered;
mod exceptions;
mod follow_ball;
mod limits;
mod loader;
mod safe_navigation;
mod shared_value;
mod two_robots;
mod versions;
