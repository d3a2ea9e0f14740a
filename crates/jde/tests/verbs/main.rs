//! The executable as a user sees it: real processes, real files, exit statuses.

mod applications;
mod attached;
mod breaking;
mod cable;
mod cplusplus;
mod damaged;
mod demo;
mod disk;
mod exhausted;
mod experimenting;
mod hostile;
mod inspecting;
mod inspections;
mod installed;
mod isolated;
mod naming;
mod new;
mod panels;
mod playing;
mod plot_and_report;
mod recording;
mod reloading;
mod replaying;
mod ros_limits;
mod ros_node;
mod running;
mod screen;
mod serving;
mod splitting;
mod stopping;
mod support;
mod unread;
mod usage;
mod validating;
#[cfg(feature = "view")]
mod windows;
