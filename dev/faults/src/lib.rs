//! A campaign of faults: hundreds of faults of every kind, injected at random times into running
//! applications, and an observer that reports violated rules. The same seed gives the same
//! campaign.

pub mod application;
pub mod campaign;
pub mod case;
pub mod observer;
pub mod plan;
mod processes;
pub mod rng;
pub mod run;
pub mod table;
