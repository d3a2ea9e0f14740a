//! A campaign of faults: hundreds of faults of every kind, injected at random times into running
//! applications, and an observer that reports violated rules. The same seed gives the same campaign. It
//! repairs nothing and excuses nothing.

pub mod campaign;
pub mod case;
pub mod chance;
pub mod observer;
mod outside;
pub mod plan;
pub mod run;
pub mod stage;
pub mod table;
