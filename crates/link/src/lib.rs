//! The one way out of the process: a running application announces itself, and tools on this machine or across the network look
//! into it and steer it, over Zenoh. [`Link`] is the application's end, [`Client`] the tools'.
//!
//! Nothing is open unless the application says so, and nothing that a client does delays an iteration. No Zenoh type and nothing
//! asynchronous leaves this crate; `docs/protocol.md` describes the keys and messages for clients in other languages.

mod attachment;
mod client;
mod error;
mod folder;
mod keys;
pub mod message;
mod server;
mod session;
pub mod value;
mod whoami;

pub use client::{Client, Happened, Heard, Hold, PanelSample, Reach, Remote, Sample, Watching, everything};
pub use error::Error;
pub use folder::Folders;
pub use jde_board::nearest;
pub use keys::{PROTOCOL, Rate, as_name, is_name};
pub use server::{Access, Events, Link, Looking, News, Running, Settings, Subject, Title, schemas};
pub use session::{Login, Tls};
pub use whoami::operator;
