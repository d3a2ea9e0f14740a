//! The page from the robot: a client of the link that shows a running application in browsers, in Foxglove and in
//! Lichtblick, and passes on what people do there as operators (R14).
//!
//! It is a process of its own beside the run, so that no byte from a browser reaches the robot's process: it has no right
//! that a client of the link has not, and holds nothing that the link's leases do not end. Nothing here waits for a
//! browser: each has the newest state, and what it does not read in time is left out.
//!
//! **Refuses:** to be reached under names that nobody listed, by pages of other sites, and by sockets that have not shown
//! a token. It sets no cookie and stores nothing.

mod drive;
mod feeds;
mod files;
mod floor;
mod foxglove;
mod http;
mod log;
mod model;
mod newcomers;
mod order;
mod origin;
mod panel;
mod server;
mod settings;
mod socket;
mod state;
mod tls;
mod token;
mod values;

pub use server::{Addresses, serve};
pub use settings::{Identity, Right, Settings};

/// Why the page cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The address cannot be used.
    #[error("the page cannot listen on {address}: {reason}")]
    Listen {
        /// The address.
        address: String,
        /// The system's reason.
        reason: std::io::Error,
    },
    /// The certificate or its key cannot be used.
    #[error("{file}: {reason}")]
    Certificate {
        /// The file.
        file: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The application gives no answer.
    #[error(transparent)]
    Link(#[from] jde_link::Error),
    /// The system gives no randomness, threads or sockets.
    #[error("the page cannot be served: {0}")]
    System(#[from] std::io::Error),
}
