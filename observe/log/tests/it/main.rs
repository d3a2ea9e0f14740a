//! Recordings that other programs have written, and files that harm their reader.

mod bags;
mod checks;
mod foreign;
mod hostile;
