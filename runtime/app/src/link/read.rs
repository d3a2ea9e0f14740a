//! Reads the section `[link]`. Opens no connection.

use std::path::Path;

use super::address::{Address, AddressError, PROTOCOLS};
use super::authentication;
use super::{Access, Link};
use crate::drafts::refuse_bad_name;
use crate::time;
use jde_document::section::{Section, Text};
use jde_document::{FaultReport, quote};

const KEYS: &[&str] = &[
    "name",
    "listen",
    "connect",
    "discover",
    "access",
    "user",
    "password-file",
    "tls",
    "stale",
    "insecure",
    "off",
];

/// An address with its text in the file.
pub(super) struct WrittenAddress<'a> {
    pub(super) text: Text<'a>,
    pub(super) address: Address<'a>,
}

/// Reads the section of the application `application`; `folder` is the folder of its file.
pub(crate) fn read(report: &mut FaultReport, top: &Section, application: &str, folder: &Path) -> Link {
    let mut link = Link::local(application);
    let Some(section) = top.section(report, "link", "`link`") else {
        return link;
    };
    section.refuse_unknown(report, KEYS);
    if let Some(name) = name(report, &section) {
        link.name = name;
    }
    let listen = addresses(report, &section, "listen");
    let connect = addresses(report, &section, "connect");
    for peer in connect.iter().filter(|peer| peer.address.port() == Some(0)) {
        let what = section.key("connect");
        report
            .fault(&peer.text.span, format!("{what} has no port to connect to"))
            .advise("give the port at which the other listens, such as 7447");
    }
    link.discover = section.flag(report, "discover").unwrap_or_default();
    link.access = access(report, &section);
    link.login = authentication::login(report, &section, folder);
    link.tls = authentication::tls(report, &section, folder);
    link.stale_ns = time::of(report, &section, "stale").unwrap_or(link.stale_ns);
    link.insecure = section.flag(report, "insecure").unwrap_or_default();
    link.off = section.flag(report, "off").unwrap_or_default();
    authentication::refuse_without_certificate(report, &link, &section, &listen);
    authentication::refuse_unauthenticated(report, &link, &section, &listen, &connect);
    if link.discover && !listen.iter().any(|written| written.address.is_network()) {
        let what = section.key("discover");
        report
            .fault(
                &section.key_span("discover"),
                format!("{what} discovers only on the networks where it listens, and it listens on none"),
            )
            .advise("add listen = [\"tls/0.0.0.0:7447\"], or name the others in `connect`");
    }
    let absolute = |written: &WrittenAddress| written.address.absolute(written.text.text, folder);
    link.listen = listen.iter().map(absolute).collect();
    link.connect = connect.iter().map(absolute).collect();
    link
}

fn name(report: &mut FaultReport, section: &Section) -> Option<String> {
    let name = section.text(report, "name")?;
    refuse_bad_name(report, &name, "a link").then(|| name.text.to_owned())
}

fn addresses<'a>(report: &mut FaultReport, section: &Section<'a>, key: &str) -> Vec<WrittenAddress<'a>> {
    const ADVICE: &str = "write an address such as \"tls/0.0.0.0:7447\" or \"tcp/robot.local:7447\"";
    let what = section.key(key);
    let mut read = Vec::new();
    for text in section.texts(report, key).unwrap_or_default() {
        match Address::parse(text.text) {
            Ok(address) => read.push(WrittenAddress { text, address }),
            Err(AddressError::Shape) => {
                let message = format!("{what} has {}, which is not an address", quote(text.text));
                report.fault(&text.span, message).advise(ADVICE);
            }
            Err(AddressError::Port) => {
                let message = format!("{what} has {}, which has no port up to 65535", quote(text.text));
                report.fault(&text.span, message).advise(ADVICE);
            }
            Err(AddressError::Protocol(protocol)) => report
                .fault(
                    &text.span,
                    format!(
                        "{what} has {}, and there is no protocol {}",
                        quote(text.text),
                        quote(protocol)
                    ),
                )
                .suggest(protocol, "protocols", PROTOCOLS),
        }
    }
    read
}

pub(crate) fn access(report: &mut FaultReport, section: &Section) -> Access {
    match section.text(report, "access") {
        None => Access::default(),
        Some(text) => match text.text {
            "operate" => Access::Operate,
            "read" => Access::Read,
            other => {
                report
                    .fault(
                        &text.span,
                        format!(
                            "{} is {}, which is not an access",
                            section.key("access"),
                            quote(other)
                        ),
                    )
                    .suggest(other, "accesses", ["operate", "read"]);
                Access::Read
            }
        },
    }
}
