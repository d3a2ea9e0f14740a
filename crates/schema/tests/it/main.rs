//! Schemas as authors write them: what the host reads of them, and what their calls may do.

mod calls;
mod describe;
mod father;
mod memory;
mod panel;
mod plugin;
mod ports;
mod sdk_page;
mod strangers;
mod values;
