//! Addresses, each a protocol and an endpoint, in the notation of the link's library. Resolves no name and opens
//! nothing.

use std::net::IpAddr;
use std::path::Path;

/// The protocols that the link supports.
pub(super) const PROTOCOLS: [&str; 3] = ["tcp", "tls", UNIX];
/// The protocol that never leaves the machine.
const UNIX: &str = "unixsock-stream";

/// An address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Address<'a> {
    pub(super) protocol: &'a str,
    endpoint: Endpoint<'a>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Endpoint<'a> {
    File(&'a str),
    Host { host: &'a str, port: u16 },
}

/// Why a text is no address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AddressError<'a> {
    /// It does not have the form of one.
    Shape,
    /// There is no such protocol.
    Protocol(&'a str),
    /// The port is no number up to 65535.
    Port,
}

impl<'a> Address<'a> {
    pub(super) fn parse(text: &'a str) -> Result<Self, AddressError<'a>> {
        let (protocol, place) = text.split_once('/').ok_or(AddressError::Shape)?;
        if !PROTOCOLS.contains(&protocol) {
            return Err(AddressError::Protocol(protocol));
        }
        // The library would parse metadata and options after these characters.
        if place.is_empty() || place.contains(['?', '#', ';']) || place.contains(char::is_whitespace) {
            return Err(AddressError::Shape);
        }
        if protocol == UNIX {
            let place = Endpoint::File(place);
            return Ok(Self {
                protocol,
                endpoint: place,
            });
        }
        let (host, port) = place.rsplit_once(':').ok_or(AddressError::Shape)?;
        let bare = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
        // An IPv6 address without brackets would be split at the wrong colon.
        if host.is_empty() || bare.unwrap_or(host).is_empty() || (bare.is_none() && host.contains(':')) {
            return Err(AddressError::Shape);
        }
        let port = port.parse().map_err(|_| AddressError::Port)?;
        let host = bare.unwrap_or(host);
        let place = Endpoint::Host { host, port };
        Ok(Self {
            protocol,
            endpoint: place,
        })
    }

    /// Returns the port of a TCP or TLS address; `None` for a socket file.
    pub(super) fn port(&self) -> Option<u16> {
        match self.endpoint {
            Endpoint::File(_) => None,
            Endpoint::Host { port, .. } => Some(port),
        }
    }

    /// Whether the address is on the network, beyond this machine.
    pub(super) fn is_network(&self) -> bool {
        let Endpoint::Host { host, .. } = self.endpoint else {
            return false;
        };
        match host.parse::<IpAddr>() {
            Ok(address) => !address.to_canonical().is_loopback(),
            Err(_) => !host.eq_ignore_ascii_case("localhost"),
        }
    }

    /// Returns the address, with a socket's path made absolute.
    pub(super) fn absolute(&self, text: &str, folder: &Path) -> String {
        match self.endpoint {
            Endpoint::File(path) => format!("{UNIX}/{}", folder.join(path).display()),
            Endpoint::Host { .. } => text.to_owned(),
        }
    }
}

/// Whether a text is an address on the network; true for an invalid one.
pub(super) fn is_network(text: &str) -> bool {
    Address::parse(text).map_or(true, |address| address.is_network())
}

#[cfg(test)]
mod tests {
    use super::{Address, AddressError, is_network};

    #[test]
    fn loopback_and_socket_files_are_not_on_the_network() {
        for local in [
            "tcp/127.0.0.1:7447",
            "tcp/127.8.9.10:1",
            "tls/[::1]:7447",
            "tcp/[::ffff:127.0.0.1]:7447",
            "tcp/localhost:7447",
            "tcp/LocalHost:7447",
            "unixsock-stream/run/robot",
        ] {
            assert!(!is_network(local), "{local}");
        }
    }

    #[test]
    fn other_and_invalid_addresses_are_on_the_network() {
        for open in [
            "tcp/0.0.0.0:7447",
            "tls/[::]:7447",
            "tcp/10.0.0.2:7447",
            "tcp/robot.local:7447",
            "tcp/localhost.example.org:7447",
            "tcp/128.0.0.1:7447",
            "tcp/127.1:7447",
            "nonsense",
        ] {
            assert!(is_network(open), "{open}");
        }
    }

    #[test]
    fn an_invalid_address_is_refused_with_the_reason() {
        for (text, error) in [
            ("0.0.0.0:7447", AddressError::Shape),
            ("tcp/", AddressError::Shape),
            ("tcp/:7447", AddressError::Shape),
            ("tcp/::1:7447", AddressError::Shape),
            ("tcp/[]:7447", AddressError::Shape),
            ("tcp/robot", AddressError::Shape),
            ("tcp/robot:7447#iface=eth0", AddressError::Shape),
            ("tcp/robot:70000", AddressError::Port),
            ("tcp/robot:", AddressError::Port),
            ("udp/robot:7447", AddressError::Protocol("udp")),
        ] {
            assert_eq!(Address::parse(text), Err(error), "{text}");
        }
    }
}
