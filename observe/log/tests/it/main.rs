//! Recordings: split, triggered by conditions, damaged, written by other programs, and replayed.

mod bags;
mod checks;
mod damaged;
mod foreign;
mod hindered;
mod hostile;
mod killed;
mod replay;
mod split;
mod support;
mod survey;
mod triggered;
