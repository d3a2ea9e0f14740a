//! What the page is told: where it listens, under which names it is reached, and what its visitors may do. Data only.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// The port unless a file states another one.
pub(crate) const USUAL_PORT: u16 = 7480;

/// The settings of a page.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Settings {
    /// Where it listens; without it on port 7480 of this machine alone, or on a free port if that one is taken.
    pub listen: Option<SocketAddr>,
    /// The names by which browsers reach it, beside the address itself: `robot.local`, or `robot.local:8443` if they reach
    /// it by another port.
    pub hosts: Vec<String>,
    /// The origins of other pages that may connect as Foxglove does: `https://app.foxglove.dev`.
    pub origins: Vec<String>,
    /// The most that its visitors may do.
    pub access: Right,
    /// The certificate of TLS.
    pub tls: Option<Identity>,
}

/// A certificate and its key, as PEM files.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// The certificate, with those between it and the authority.
    pub certificate: PathBuf,
    /// Its private key.
    pub key: PathBuf,
}

/// What a visitor may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Right {
    /// Look.
    Read,
    /// Look, and act as an operator (R14).
    Operate,
}

impl Settings {
    /// Returns the addresses to try in turn.
    pub(crate) fn candidates(&self) -> Vec<SocketAddr> {
        let local = |port| SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port);
        self.listen
            .map_or_else(|| vec![local(USUAL_PORT), local(0)], |stated| vec![stated])
    }
}
