//! Serves a simulated world whose robots use the Pioneer protocol, like SRIsim. Each robot has one client at
//! a time, over TCP or a pseudo-terminal. The server advances the world's time, and prints nothing.
//!
//! ```no_run
//! use std::sync::atomic::AtomicBool;
//! use jde_p2os_server::{Options, Server};
//! use jde_sim::World;
//!
//! let world = World::load("worlds/office.toml", 1)?;
//! let mut server = Server::open(world, &Options { tcp: Some("127.0.0.1:8101".parse()?), ..Options::default() })?;
//! server.run(&AtomicBool::new(false), None, |event| eprintln!("{event}"))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod endpoint;
mod event;
mod quota;
mod robot_session;
mod server;
mod terminal_watch;
mod world_clock;

pub use endpoint::EndpointAddress;
pub use event::{Event, EventKind};
pub use server::{Options, RobotStats, Server, ServerError};
