//! The executable as a user meets it: real processes, real files, exit statuses.

mod demo;
mod inspecting;
mod new;
mod recording;
mod running;
mod screen;
mod serving;
mod support;
mod usage;
