//! The link over real sockets, between real processes and across network namespaces. No test waits for a
//! fixed time.

mod checks;
mod common;
mod cut;
mod driving;
mod everything;
mod hostile;
mod imports;
mod kept;
mod local;
mod network;
mod panels;
mod processes;
mod rogues;
