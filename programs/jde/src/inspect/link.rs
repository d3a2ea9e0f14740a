//! Describes whether an application opens the network, how, and to whom. Opens nothing.

use std::io::{self, Write};

use jde_app::Link;
use jde_app::link::Access;
use jde_terminal::{TITLE, WARN};

/// Writes the description. Writes nothing for a link that only this user on this machine can use.
///
/// # Errors
/// The output cannot be written.
pub(super) fn write(link: &Link, output: &mut dyn Write) -> io::Result<()> {
    if link.listen.is_empty() && link.connect.is_empty() && !link.discover {
        return Ok(());
    }
    let list = |what: &str, endpoints: &[String]| {
        (!endpoints.is_empty()).then(|| format!("{what} {}", endpoints.join(", ")))
    };
    let connections = [
        list("listens on", &link.listen),
        list("connects to", &link.connect),
        link.discover.then(|| "finds others by multicast".to_owned()),
    ];
    let connections: Vec<_> = connections.into_iter().flatten().collect();
    let permission = match link.access {
        Access::Read => "may read",
        Access::Operate => "may read and operate",
    };
    writeln!(output)?;
    writeln!(
        output,
        "{TITLE}the network is open{TITLE:#}: {}",
        connections.join("; ")
    )?;
    writeln!(output, "  {} {permission}", describe_clients(link))
}

fn describe_clients(link: &Link) -> String {
    let authority = link
        .tls
        .as_ref()
        .filter(|tls| tls.clients)
        .and_then(|tls| tls.authority.as_ref())
        .map(|authority| authority.display());
    let login = link.login.as_ref();
    match (authority, login) {
        (Some(authority), None) => format!("anybody with a certificate of {authority}"),
        (None, Some(login)) => format!("anybody with the password of `{}`", login.user),
        (Some(authority), Some(login)) => format!(
            "anybody with a certificate of {authority} and the password of `{}`",
            login.user
        ),
        (None, None) if link.insecure => format!("{WARN}anybody who can connect{WARN:#}"),
        (None, None) => "the connected endpoints with a certificate of the authority".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use jde_app::link::{Login, Tls};

    use super::*;

    fn described(change: impl FnOnce(&mut Link)) -> String {
        let mut link = Link::local("robot");
        change(&mut link);
        let mut output = Vec::new();
        write(&link, &mut output).unwrap();
        jde_terminal::escape::without_styles(&String::from_utf8(output).unwrap())
    }

    #[test]
    fn an_open_network_is_described_with_who_may_connect() {
        assert_eq!(described(|_| {}), "");
        let listen = || vec!["tcp/0.0.0.0:7447".to_owned()];
        let login = Some(Login {
            user: "lab".to_owned(),
            password_file: "password".into(),
        });
        let with_password = described(|link| (link.listen, link.login) = (listen(), login));
        assert_eq!(
            with_password,
            "\nthe network is open: listens on tcp/0.0.0.0:7447\n  anybody with the password of `lab` may read and operate\n"
        );
        let with_certificate = described(|link| {
            link.listen = vec!["tls/0.0.0.0:7447".to_owned()];
            link.access = Access::Read;
            link.tls = Some(Tls {
                identity: None,
                authority: Some("ca.pem".into()),
                clients: true,
            });
        });
        assert!(
            with_certificate.contains("anybody with a certificate of ca.pem may read\n"),
            "{with_certificate}"
        );
        let open = described(|link| (link.listen, link.insecure) = (listen(), true));
        assert!(
            open.contains("anybody who can connect may read and operate"),
            "{open}"
        );
        let connected = described(|link| {
            link.connect = vec!["tls/base:7447".to_owned()];
            link.tls = Some(Tls {
                identity: None,
                authority: Some("ca.pem".into()),
                clients: false,
            });
        });
        assert_eq!(
            connected,
            "\nthe network is open: connects to tls/base:7447\n  the connected endpoints with a certificate of the authority may read and operate\n"
        );
    }
}
