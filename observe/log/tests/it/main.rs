//! Recordings that other programs have written, and files that harm their reader.

mod bags;
mod foreign;
mod hostile;
