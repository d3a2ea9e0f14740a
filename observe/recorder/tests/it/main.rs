//! Recordings as the recorder writes and the log reads them: in parts, triggered by conditions, damaged, interrupted.

mod damaged;
mod hindered;
mod killed;
mod split;
mod support;
mod survey;
mod triggered;
