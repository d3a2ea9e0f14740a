//! Where the page for browsers listens, under which names, and what its visitors may do: the section `[web]`, and files of the
//! same keys. It refuses to open the network by accident, as the link does, and opens nothing.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use jde_document::section::Section;
use jde_document::{FaultReport, Faults, quote};

use crate::link::{Access, Identity, access, existing_file, refuse_without};

const KEYS: &[&str] = &["listen", "hosts", "origins", "access", "tls", "insecure"];

/// The settings of a page for browsers. Paths are absolute.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Web {
    /// Where it listens; `None` for this machine alone.
    pub listen: Option<SocketAddr>,
    /// The names by which browsers reach it, with a port if that is another one.
    pub hosts: Vec<String>,
    /// The origins of other pages that may connect as Foxglove does: `https://app.foxglove.dev`.
    pub origins: Vec<String>,
    /// The most that its visitors may do.
    pub access: Access,
    /// The certificate of TLS.
    pub tls: Option<Identity>,
}

impl Web {
    /// Reads a file of the keys of `[web]`.
    ///
    /// # Errors
    /// All faults of the file.
    pub fn read_file(file: &Path) -> Result<Self, Faults> {
        let text = jde_document::read(file, "a file with the settings of a page")?;
        let mut report = FaultReport::new(file, &text);
        let document = jde_document::parse(&mut report, &text);
        let file = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
        let web = document.map(|document| {
            let section = Section::new("the page", 0..0, document.get_ref());
            of(&mut report, &section, folder_of(&file), true)
        });
        report.finish()?;
        Ok(web.unwrap_or_default())
    }
}

fn folder_of(file: &Path) -> &Path {
    file.parent().unwrap_or(Path::new("/"))
}

/// Reads the section of an application in `folder`; `None` if there is none. With `check_files`, files must exist.
pub(crate) fn read(report: &mut FaultReport, top: &Section, folder: &Path, check_files: bool) -> Option<Web> {
    let section = top.section(report, "web", "`web`")?;
    Some(of(report, &section, folder, check_files))
}

fn of(report: &mut FaultReport, section: &Section, folder: &Path, check_files: bool) -> Web {
    section.refuse_unknown(report, KEYS);
    let web = Web {
        listen: listen(report, section),
        hosts: hosts(report, section),
        origins: origins(report, section),
        access: access(report, section),
        tls: tls(report, section, folder, check_files),
    };
    let is_insecure = section.flag(report, "insecure").unwrap_or_default();
    let is_network = web.listen.is_some_and(|at| !at.ip().to_canonical().is_loopback());
    if is_network && section.get("tls").is_none() && !is_insecure {
        let what = section.key("listen");
        report
            .fault(
                &section.key_span("listen"),
                format!("{what} puts the page on the network without TLS, where others can read its token"),
            )
            .advise("add tls = { certificate = \"robot.pem\", key = \"robot.key\" }, or write insecure = true on a network of your own");
    }
    web
}

fn listen(report: &mut FaultReport, section: &Section) -> Option<SocketAddr> {
    let written = section.text(report, "listen")?;
    let address = written.text.parse();
    if address.is_err() {
        let message = format!(
            "{} is {}, which is no number with a port",
            section.key("listen"),
            quote(written.text)
        );
        report
            .fault(&written.span, message)
            .advise("write \"0.0.0.0:7480\" for every network of the machine, or the number of one of them; names belong to `hosts`");
    }
    address.ok()
}

fn hosts(report: &mut FaultReport, section: &Section) -> Vec<String> {
    let written = section.texts(report, "hosts").unwrap_or_default();
    for host in written.iter().filter(|host| !is_host(host.text)) {
        let message = format!(
            "{} has {}, which is no name of a host",
            section.key("hosts"),
            quote(host.text)
        );
        report.fault(&host.span, message).advise(
            "write names such as \"robot.local\", or \"robot.local:8443\" if browsers use another port",
        );
    }
    written.into_iter().map(|host| host.text.to_owned()).collect()
}

fn origins(report: &mut FaultReport, section: &Section) -> Vec<String> {
    let written = section.texts(report, "origins").unwrap_or_default();
    for origin in written.iter().filter(|origin| !is_origin(origin.text)) {
        let message = format!(
            "{} has {}, which is no origin of a page",
            section.key("origins"),
            quote(origin.text)
        );
        report.fault(&origin.span, message).advise(
            "write origins such as \"https://app.foxglove.dev\", without a path, or \"file://\" for programs of a desktop",
        );
    }
    written.into_iter().map(|origin| origin.text.to_owned()).collect()
}

/// Whether a text is the origin of a page; no pattern is one.
fn is_origin(text: &str) -> bool {
    let (scheme, host) = text.split_once("://").unwrap_or_default();
    match scheme {
        "http" | "https" => is_host(host),
        "file" => host.is_empty(),
        _ => false,
    }
}

/// Whether a text is a name with or without a port; no pattern is one.
fn is_host(text: &str) -> bool {
    let (name, port) = text.split_once(':').unwrap_or((text, "1"));
    let is_letter = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'.' | b'_');
    !name.is_empty() && name.bytes().all(is_letter) && port.parse::<u16>().is_ok_and(|port| port > 0)
}

fn tls(report: &mut FaultReport, section: &Section, folder: &Path, check_files: bool) -> Option<Identity> {
    let section = section.nested(report, "tls", &["certificate", "key"])?;
    let mut file = |key: &str, other: &str| -> Option<PathBuf> {
        refuse_without(report, &section, key, other);
        if check_files {
            existing_file(report, &section, key, folder)
        } else {
            section.text(report, key).map(|written| folder.join(written.text))
        }
    };
    let certificate = file("certificate", "key");
    let key = file("key", "certificate");
    if section.get("certificate").is_none() && section.get("key").is_none() {
        section.fault(report, &section.span, "needs `certificate` and `key`");
    }
    certificate
        .zip(key)
        .map(|(certificate, key)| Identity { certificate, key })
}
