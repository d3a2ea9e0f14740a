//! Tests of schemas as authors write them: their description and their calls.

mod calls;
mod describe;
mod father;
mod foreign_ports;
mod memory;
mod panel;
mod plugin;
mod ports;
mod sdk_page;
mod values;
