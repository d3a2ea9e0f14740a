//! The link over real sockets, between real processes and across network namespaces. Nothing here waits for time to pass.

mod common;
mod cut;
mod driving;
mod everything;
mod hostile;
mod imports;
mod local;
mod network;
mod panels;
mod processes;
mod rogues;
