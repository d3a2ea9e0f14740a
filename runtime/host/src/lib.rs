//! Runs applications of plugin schemas: loads and checks them, wires their variables, and applies the rules
//! of `jde-core` in real time or in lockstep. It prints nothing and never ends the process; the
//! executable does.

mod clock;
mod engine;
mod exec;
mod history;
mod inbox;
mod instance;
mod journal;
mod metrics;
mod mission;
mod mock;
mod operator_handle;
mod panels;
mod prepare;
pub mod reload;
pub mod replay;
mod runner;
mod running;
mod sensor_fault;
mod stalls;
mod standstill;
pub mod transaction_observer;
mod turn_order;

pub use mock::{LiveValue, Mock, MockCatalogue};
pub use operator_handle::OperatorHandle;
pub use panels::{PanelError, PanelViewGuard};
pub use running::{Handle, Lockstep, Options, Running, StartError, StartHook, StartHookError};
pub use sensor_fault::SensorFault;
