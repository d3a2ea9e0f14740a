//! Describes whether an application opens the network, how, and to whom. Opens nothing.

use std::io::{self, Write};

use jde_link::{Access, Settings};

use crate::terminal::{TITLE, WARN};

/// Writes the description. Writes nothing for a link that only this user on this machine can use.
///
/// # Errors
/// The output cannot be written.
pub(super) fn write(settings: &Settings, words: &mut dyn Write) -> io::Result<()> {
    if !settings.is_networked() {
        return Ok(());
    }
    let list = |what: &str, endpoints: &[String]| {
        (!endpoints.is_empty()).then(|| format!("{what} {}", endpoints.join(", ")))
    };
    let ways = [
        list("listens on", &settings.listen),
        list("connects to", &settings.connect),
        settings.discover.then(|| "finds others by multicast".to_owned()),
    ];
    let ways: Vec<_> = ways.into_iter().flatten().collect();
    let may = match settings.access {
        Access::Read => "may look",
        Access::Operate => "may look and operate",
    };
    writeln!(
        words,
        "\n{TITLE}the network is open{TITLE:#}: {}\n  {} {may}",
        ways.join("; "),
        describe_clients(settings)
    )
}

fn describe_clients(settings: &Settings) -> String {
    let authority = settings
        .tls
        .as_ref()
        .filter(|tls| tls.clients)
        .and_then(|tls| tls.authority.as_deref());
    let login = settings.login.as_ref();
    match (authority, login) {
        (Some(authority), None) => format!("whoever has a certificate of {authority}"),
        (None, Some(login)) => format!("whoever knows the password of `{}`", login.user),
        (Some(authority), Some(login)) => format!(
            "whoever has a certificate of {authority} and knows the password of `{}`",
            login.user
        ),
        (None, None) if settings.insecure => format!("{WARN}anybody who gets there{WARN:#}"),
        (None, None) => "whoever has a certificate of the authority and is connected to".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use jde_link::{Login, Tls};

    use super::*;

    fn told(change: impl FnOnce(&mut Settings)) -> String {
        let mut settings = Settings::local("robot");
        change(&mut settings);
        let mut words = Vec::new();
        write(&settings, &mut words).unwrap();
        anstream::adapter::strip_str(&String::from_utf8(words).unwrap()).to_string()
    }

    #[test]
    fn an_open_network_is_described_with_who_may_connect() {
        assert_eq!(told(|_| {}), "");
        let listen = || vec!["tcp/0.0.0.0:7447".to_owned()];
        let login = Some(Login {
            user: "lab".to_owned(),
            password: "secret".to_owned(),
        });
        let known = told(|settings| (settings.listen, settings.login) = (listen(), login));
        assert_eq!(
            known,
            "\nthe network is open: listens on tcp/0.0.0.0:7447\n  whoever knows the password of `lab` may look and operate\n"
        );
        let certified = told(|settings| {
            settings.listen = vec!["tls/0.0.0.0:7447".to_owned()];
            settings.access = Access::Read;
            settings.tls = Some(Tls {
                identity: None,
                authority: Some("ca.pem".to_owned()),
                clients: true,
            });
        });
        assert!(
            certified.contains("whoever has a certificate of ca.pem may look\n"),
            "{certified}"
        );
        let open = told(|settings| (settings.listen, settings.insecure) = (listen(), true));
        assert!(
            open.contains("anybody who gets there may look and operate"),
            "{open}"
        );
        let met = told(|settings| {
            settings.connect = vec!["tls/base:7447".to_owned()];
            settings.tls = Some(Tls {
                identity: None,
                authority: Some("ca.pem".to_owned()),
                clients: false,
            });
        });
        assert_eq!(
            met,
            "\nthe network is open: connects to tls/base:7447\n  whoever has a certificate of the authority and is connected to may look and operate\n"
        );
    }
}
