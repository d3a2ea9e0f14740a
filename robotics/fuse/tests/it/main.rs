//! The filter on simulated drives whose errors are those that it assumes.

mod consistency;
mod drive;
mod faults;
mod order;
