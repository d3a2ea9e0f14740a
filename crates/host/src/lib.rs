//! Runs applications of plugin schemas: loads and checks them, wires their variables, and applies the rules
//! of `jde-core` in real time or in lockstep. It prints nothing and never ends the process; both are left to
//! the executable.

mod build;
pub mod chattering;
mod clock;
pub mod decision_writer;
mod engine;
pub mod event;
mod exec;
mod history;
mod inbox;
mod instance;
pub mod isolated;
mod metrics;
mod mission;
mod operator_handle;
mod panels;
pub mod plugin;
pub mod records;
pub mod reload;
pub mod replay;
mod resource_usage;
mod runner;
mod running;
pub mod snapshot;
pub mod transaction_observer;
pub mod turn;
mod turn_order;

pub use build::BuildName;
pub use engine::{decider_name, policy_name};
pub use operator_handle::OperatorHandle;
pub use panels::{MAX_PANEL_RATE, PanelError, PanelFrame, PanelViewGuard};
pub use resource_usage::ResourceUsage;
pub use running::{Handle, Lockstep, Options, Running, StartError, StartHook, StartHookError};
