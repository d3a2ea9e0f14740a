//! Recordings: in parts, on conditions, damaged, of other programs, and played again.

mod damaged;
mod foreign;
mod killed;
mod replay;
mod split;
mod support;
mod survey;
mod triggered;
