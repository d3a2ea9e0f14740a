//! Zenoh link between an application and its tools. An application announces itself; tools on this machine or
//! on the network inspect and control it. [`Link`] is the application's end, [`Client`] the end of the tools.
//!
//! The link opens nothing unless the application's configuration requires it, and no client can delay an
//! iteration. No Zenoh type and nothing asynchronous is part of this crate's interface. `docs/protocol.md`
//! describes the keys and messages for clients in other languages.

mod attachment;
mod client;
pub mod decode;
mod error;
mod folder;
mod keys;
pub mod message;
mod server;
mod session;
pub mod tuned;
pub mod value;
mod whoami;

pub use client::{
    Broadcast, BroadcastOutcome, Client, Hold, PanelSample, Reach, ReceivedEvent, Remote, Sample,
    Subscription, Unanswered, ValueBytes, broadcast, complete_endpoint,
};
pub use error::Error;
pub use folder::Folders;
pub use keys::{PROTOCOL, Rate, as_name, is_name};
pub use server::{
    Access, Events, Link, OnDrawn, PanelViewer, Settings, Subject, SubjectInfo, TokenBucket, schemas,
};
pub use session::{Login, Tls};
pub use whoami::operator;
