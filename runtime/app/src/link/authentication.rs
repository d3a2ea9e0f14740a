//! Admission to the link: users, passwords and certificates. Refuses settings that would open the application
//! by accident. Reads no contents of files.

use std::path::{Path, PathBuf};

use super::read::WrittenAddress;
use super::{Identity, Link, Login, Tls};
use jde_document::section::Section;
use jde_document::{FaultReport, quote};

pub(super) fn login(report: &mut FaultReport, section: &Section, folder: &Path) -> Option<Login> {
    let user = section.text(report, "user");
    let password_file = existing_file(report, section, "password-file", folder);
    for (key, other) in [("user", "password-file"), ("password-file", "user")] {
        refuse_without(report, section, key, other);
    }
    let user = user?;
    // The link's library stores users as `user:password`, one per line.
    if user.text.is_empty() || user.text.contains([':', '\n', '\r']) {
        report
            .fault(
                &user.span,
                format!("{} cannot be the name of a user", quote(user.text)),
            )
            .advise("give at least one character, and no colon or line break");
        return None;
    }
    Some(Login {
        user: user.text.to_owned(),
        password_file: password_file?,
    })
}

pub(super) fn tls(report: &mut FaultReport, section: &Section, folder: &Path) -> Option<Tls> {
    let section = section.section(report, "tls", section.key("tls"))?;
    section.refuse_unknown(report, &["certificate", "key", "authority", "clients"]);
    let certificate = existing_file(report, &section, "certificate", folder);
    let key = existing_file(report, &section, "key", folder);
    for (key, other) in [("certificate", "key"), ("key", "certificate")] {
        refuse_without(report, &section, key, other);
    }
    let authority = existing_file(report, &section, "authority", folder);
    let clients = section
        .get("clients")
        .map(|_| section.flag(report, "clients").unwrap_or_default());
    if clients == Some(true) {
        refuse_without(report, &section, "clients", "authority");
    }
    Some(Tls {
        identity: certificate
            .zip(key)
            .map(|(certificate, key)| Identity { certificate, key }),
        // An authority that is named but missing is a fault of its own.
        clients: clients.unwrap_or(section.get("authority").is_some()),
        authority,
    })
}

/// Reports a key that has no meaning without another.
pub(crate) fn refuse_without(report: &mut FaultReport, section: &Section, key: &str, other: &str) {
    if section.get(key).is_some() && section.get(other).is_none() {
        let message = format!("{} requires `{other}`", section.key(key));
        report
            .fault(&section.key_span(key), message)
            .advise(format!("add `{other}`, or remove `{key}`"));
    }
}

pub(super) fn refuse_without_certificate(
    report: &mut FaultReport,
    link: &Link,
    section: &Section,
    listen: &[WrittenAddress],
) {
    // Faults in the named files have been reported already.
    let named = section
        .get("tls")
        .is_some_and(|tls| tls.get_ref().get("certificate").is_some());
    let has_certificate = named || link.tls.as_ref().is_some_and(|tls| tls.identity.is_some());
    for written in listen.iter().filter(|written| written.address.protocol == "tls") {
        if !has_certificate {
            let what = section.key("listen");
            report
                .fault(
                    &written.text.span,
                    format!(
                        "{what} has {}, and the link has no certificate to present there",
                        quote(written.text.text)
                    ),
                )
                .advise(
                    "add tls = { certificate = \"robot.pem\", key = \"robot.key\", authority = \"ca.pem\" }",
                );
        }
    }
}

/// Reports every address where an unauthenticated peer could connect or answer. The link cannot distinguish
/// connections, so all of them must meet the same requirements.
pub(super) fn refuse_unauthenticated(
    report: &mut FaultReport,
    link: &Link,
    section: &Section,
    listen: &[WrittenAddress],
    connect: &[WrittenAddress],
) {
    // A setting with a fault, or with a missing file, still counts as set.
    let user = section.get("user").is_some();
    let authority = section
        .get("tls")
        .is_some_and(|tls| tls.get_ref().get("authority").is_some());
    let authenticates_clients = user || link.tls.as_ref().is_some_and(|tls| tls.clients);
    let authenticates_peer = |written: &WrittenAddress| written.address.protocol == "tls" && authority;
    let addresses = [("listen", listen), ("connect", connect)];
    for (key, written) in addresses
        .into_iter()
        .flat_map(|(key, all)| all.iter().map(move |written| (key, written)))
    {
        let (what, text) = (section.key(key), &written.text);
        let shown = quote(text.text);
        let mut fault = |message: String, advice: &str| {
            report.fault(&text.span, message).advise(advice);
        };
        if user && !authenticates_peer(written) {
            fault(
                format!(
                    "{what} has {shown}, where the password could reach an unauthenticated peer or be intercepted"
                ),
                "use \"tls/...\" with an `authority` in `tls`, or remove `user` and `password-file`",
            );
        } else if link.insecure {
        } else if key == "connect" && !authenticates_peer(written) {
            fault(
                format!("{what} has {shown}, and its peer is not authenticated"),
                "connect by \"tls/...\" with an `authority` in `tls`; or write insecure = true",
            );
        } else if key == "listen" && !(authenticates_peer(written) && authenticates_clients) {
            let clients = if written.address.is_network() {
                "any machine on the network"
            } else {
                "every user of this machine"
            };
            fault(
                format!("{what} has {shown}, where {clients} may connect"),
                if written.address.protocol == "tls" {
                    "add an `authority` to `tls`, which then requires certificates of clients; or write insecure = true"
                } else {
                    "listen by \"tls/...\" with an `authority` in `tls`; or write insecure = true"
                },
            );
        }
    }
}

/// Returns an existing file, relative to the application's folder; reports a missing one.
pub(crate) fn existing_file(
    report: &mut FaultReport,
    section: &Section,
    key: &str,
    folder: &Path,
) -> Option<PathBuf> {
    let written = section.text(report, key)?;
    let path = folder.join(written.text);
    if path.is_file() {
        return Some(path);
    }
    let shown = quote(&path.display().to_string());
    let message = if path.exists() {
        format!("{} is {shown}, which is not a file", section.key(key))
    } else {
        format!("{} is {shown}, and there is no such file", section.key(key))
    };
    report
        .fault(&written.span, message)
        .advise("give a path relative to the application file, or an absolute one");
    None
}
