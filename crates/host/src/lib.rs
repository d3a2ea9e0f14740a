//! Runs applications of plugin schemas: loads and checks them, wires their variables, and applies the rules
//! of `jde-core` in real time or in lockstep. It prints nothing and never ends the process; both are left to
//! the executable.

pub mod apart;
pub mod app;
mod build;
pub mod chatter;
mod clock;
pub mod decisions;
mod engine;
pub mod event;
mod exec;
mod footprint;
mod history;
mod inbox;
mod instance;
mod meter;
mod mission;
mod operating;
mod order;
mod panels;
pub mod period;
pub mod plugin;
pub mod reload;
pub mod replay;
mod runner;
mod running;
pub mod snapshot;
pub mod story;
pub mod turn;
pub mod witness;

pub use build::BuildName;
pub use engine::{decider_name, policy_name};
pub use footprint::Footprint;
pub use operating::Operating;
pub use panels::{Drawn, Look, MOST_RATE, Refusal};
pub use running::{BeforeStart, Handle, Hindrance, Lockstep, Options, Running, StartError};
