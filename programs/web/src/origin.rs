//! Under which names the page may be reached, and from which pages. A name that an attacker's server resolves to this
//! machine is none of them, and a page of another site is refused even on this machine: that a request comes from here
//! proves nothing, since every site that a person visits can make the browser send one.

use std::net::{IpAddr, SocketAddr};

/// The places under which browsers may reach the page.
#[derive(Clone, Debug)]
pub(crate) struct Places {
    /// `http` or `https`.
    scheme: &'static str,
    port: u16,
    /// In small letters, with the port.
    hosts: Vec<String>,
    /// In small letters.
    origins: Vec<String>,
}

/// Why a request is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refused {
    /// It was sent to a name that is not listed.
    Host,
    /// It comes from another site, or does not say from where.
    Origin,
    /// It comes from a site that is not listed.
    Unlisted,
}

impl Places {
    /// The places of a server at this port, with the listed names.
    pub(crate) fn new(is_tls: bool, port: u16, hosts: &[String]) -> Self {
        let with_port = |host: &String| {
            let host = host.to_ascii_lowercase();
            let has_port = host.rsplit_once(':').is_some_and(|(name, port)| {
                !port.is_empty()
                    && port.bytes().all(|byte| byte.is_ascii_digit())
                    && is_name_or_brackets(name)
            });
            if has_port { host } else { format!("{host}:{port}") }
        };
        Self {
            scheme: if is_tls { "https" } else { "http" },
            port,
            hosts: hosts.iter().map(with_port).collect(),
            origins: Vec::new(),
        }
    }

    /// Adds the origins of pages that may connect as Foxglove does.
    pub(crate) fn with_origins(mut self, origins: &[String]) -> Self {
        self.origins = origins.iter().map(|origin| origin.to_ascii_lowercase()).collect();
        self
    }

    /// Returns the origin of the place.
    pub(crate) fn origin(&self, host: &str) -> String {
        format!("{}://{host}", self.scheme)
    }

    /// Checks the header `Host` of a request that arrived at this address. Returns it in the form of an origin: in small
    /// letters, and without the usual port of the scheme.
    pub(crate) fn check_host(&self, host: Option<&str>, arrived_at: SocketAddr) -> Result<String, Refused> {
        let host = host.ok_or(Refused::Host)?.to_ascii_lowercase();
        let usual_port = if self.scheme == "https" { ":443" } else { ":80" };
        // Browsers leave the usual port out.
        let full = if has_port(&host) {
            host.clone()
        } else {
            format!("{host}{usual_port}")
        };
        let is_listed = self.hosts.contains(&full);
        let is_known = is_listed || self.is_own_address(&full, arrived_at.ip());
        let origin = full.strip_suffix(usual_port).unwrap_or(&full).to_owned();
        is_known.then_some(origin).ok_or(Refused::Host)
    }

    /// Checks the header `Origin` of a request to open a WebSocket, beside the `Host` that was checked.
    pub(crate) fn check_origin(&self, origin: Option<&str>, host: &str) -> Result<(), Refused> {
        let origin = origin.ok_or(Refused::Origin)?;
        let is_own = origin.eq_ignore_ascii_case(&self.origin(host));
        is_own.then_some(()).ok_or(Refused::Origin)
    }

    /// Checks the header `Origin` of a request to connect as Foxglove does. A program that is no browser sends none; what lets
    /// it in is the token alone.
    pub(crate) fn check_client(&self, origin: Option<&str>, host: &str) -> Result<(), Refused> {
        let Some(origin) = origin else { return Ok(()) };
        let is_listed = self
            .origins
            .iter()
            .any(|listed| origin.eq_ignore_ascii_case(listed));
        let is_known = is_listed || self.check_origin(Some(origin), host).is_ok();
        is_known.then_some(()).ok_or(Refused::Unlisted)
    }

    /// Whether a host with its port is the very address at which a request arrived. No name server can make a number mean
    /// another machine. `localhost` is one for connections of this machine.
    fn is_own_address(&self, host: &str, arrived_at: IpAddr) -> bool {
        let Some(name) = host.strip_suffix(&format!(":{}", self.port)) else {
            return false;
        };
        let arrived_at = arrived_at.to_canonical();
        if name == "localhost" {
            return arrived_at.is_loopback();
        }
        let number = match name.strip_prefix('[').and_then(|name| name.strip_suffix(']')) {
            Some(number) => number.parse().map(IpAddr::V6),
            None => name.parse().map(IpAddr::V4),
        };
        number.is_ok_and(|number| number.to_canonical() == arrived_at)
    }
}

fn has_port(host: &str) -> bool {
    host.rsplit_once(':')
        .is_some_and(|(name, _)| is_name_or_brackets(name))
}

/// Whether what precedes a colon is a whole name, and not the beginning of a number of IPv6.
fn is_name_or_brackets(name: &str) -> bool {
    !name.contains(':') || name.ends_with(']')
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(is_tls: bool, hosts: &[&str]) -> Places {
        let hosts: Vec<String> = hosts.iter().map(|host| (*host).to_owned()).collect();
        Places::new(is_tls, 7480, &hosts)
    }

    fn host(places: &Places, host: &str, at: &str) -> Result<String, Refused> {
        places.check_host(Some(host), at.parse().unwrap())
    }

    const HERE: &str = "127.0.0.1:7480";
    const THERE: &str = "10.0.0.2:7480";

    #[test]
    fn the_address_itself_is_known_and_names_only_if_listed() {
        let places = places(false, &["Robot.local", "tunnel.example:9000"]);
        for (name, at, origin) in [
            ("127.0.0.1:7480", HERE, "127.0.0.1:7480"),
            ("LocalHost:7480", HERE, "localhost:7480"),
            ("[::1]:7480", "[::1]:7480", "[::1]:7480"),
            ("10.0.0.2:7480", THERE, "10.0.0.2:7480"),
            ("10.0.0.2:7480", "[::ffff:10.0.0.2]:7480", "10.0.0.2:7480"),
            ("robot.local:7480", THERE, "robot.local:7480"),
            ("tunnel.example:9000", HERE, "tunnel.example:9000"),
        ] {
            assert_eq!(host(&places, name, at).as_deref(), Ok(origin), "{name} at {at}");
        }
    }

    #[test]
    fn a_name_that_is_resolved_to_this_machine_by_others_is_refused() {
        let places = places(false, &["robot.local"]);
        for (name, at) in [
            ("rebound.example:7480", HERE),
            ("rebound.example", HERE),
            ("127.0.0.1.nip.io:7480", HERE),
            ("localhost.rebound.example:7480", HERE),
            // Another number than the one at which it arrived, and one that a browser would have written otherwise.
            ("127.0.0.1:7480", THERE),
            ("10.0.0.3:7480", THERE),
            ("localhost:7480", THERE),
            ("127.1:7480", HERE),
            ("2130706433:7480", HERE),
            ("0.0.0.0:7480", HERE),
            // Another port.
            ("127.0.0.1:80", HERE),
            ("127.0.0.1", HERE),
            ("robot.local", THERE),
            ("robot.local:8080", THERE),
            ("robot.local.:7480", THERE),
            ("", HERE),
            (":7480", HERE),
            ("[::1]", "[::1]:7480"),
            ("::1:7480", "[::1]:7480"),
            ("user@127.0.0.1:7480", HERE),
        ] {
            assert_eq!(host(&places, name, at), Err(Refused::Host), "{name} at {at}");
        }
        assert_eq!(places.check_host(None, HERE.parse().unwrap()), Err(Refused::Host));
    }

    #[test]
    fn the_usual_port_is_the_one_that_browsers_leave_out() {
        let places = Places::new(true, 443, &["robot.local".to_owned()]);
        let at = "10.0.0.2:443";
        assert_eq!(host(&places, "robot.local", at).as_deref(), Ok("robot.local"));
        assert_eq!(host(&places, "robot.local:443", at).as_deref(), Ok("robot.local"));
        assert_eq!(host(&places, "10.0.0.2", at).as_deref(), Ok("10.0.0.2"));
        assert_eq!(
            places.check_origin(Some("https://robot.local"), "robot.local"),
            Ok(())
        );
    }

    #[test]
    fn clients_are_programs_the_page_itself_and_listed_pages() {
        let own = "127.0.0.1:7480";
        let listed = places(false, &[]).with_origins(&["https://app.foxglove.dev".to_owned()]);
        for origin in [
            None,
            Some("http://127.0.0.1:7480"),
            Some("https://App.foxglove.dev"),
        ] {
            assert_eq!(listed.check_client(origin, own), Ok(()), "{origin:?}");
        }
        for origin in [
            "",
            "null",
            "file://",
            "http://app.foxglove.dev",
            "https://app.foxglove.dev.example",
        ] {
            assert_eq!(
                listed.check_client(Some(origin), own),
                Err(Refused::Unlisted),
                "{origin}"
            );
        }
        assert!(
            listed
                .check_origin(Some("https://app.foxglove.dev"), own)
                .is_err(),
            "the page's socket is the page's"
        );
    }

    #[test]
    fn only_the_page_itself_opens_a_socket() {
        let plain = places(false, &[]);
        let own = "127.0.0.1:7480";
        assert_eq!(plain.check_origin(Some("http://127.0.0.1:7480"), own), Ok(()));
        for origin in [
            None,
            Some("null"),
            Some(""),
            Some("http://127.0.0.1"),
            Some("http://127.0.0.1:7481"),
            Some("http://localhost:7480"),
            Some("https://127.0.0.1:7480"),
            Some("http://127.0.0.1:7480.example.org"),
            Some("http://evil.example"),
            Some("file://"),
        ] {
            assert_eq!(
                plain.check_origin(origin, own),
                Err(Refused::Origin),
                "{origin:?}"
            );
        }
        let encrypted = places(true, &[]);
        assert_eq!(
            encrypted.check_origin(Some("https://127.0.0.1:7480"), own),
            Ok(())
        );
        assert!(
            encrypted
                .check_origin(Some("http://127.0.0.1:7480"), own)
                .is_err()
        );
    }
}
