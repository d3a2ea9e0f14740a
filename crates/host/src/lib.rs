//! Runs applications of plugin schemas: loads and checks them, wires their variables, and drives the rules of `jde-core`
//! in real time or in lockstep. It prints nothing and never ends the process; that is the executable's.

pub mod app;
pub mod plugin;
