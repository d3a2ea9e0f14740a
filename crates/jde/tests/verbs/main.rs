//! The executable as a user meets it: real processes, real files, exit statuses.

mod demo;
mod inspecting;
mod new;
mod running;
mod screen;
mod serving;
mod support;
mod usage;
