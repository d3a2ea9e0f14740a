//! The executable as a user meets it: real processes, real files, exit statuses.

mod inspecting;
mod new;
mod running;
mod support;
mod usage;
